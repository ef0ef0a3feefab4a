"""Numbers of a spec: parameter values, sizes, strengths, and where a run starts."""
from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...language import limits
from ...language.evaluate import evaluate, integer
from ...read.problems import meant
from ...language.spec import Family, FamilyStart, Lattice, Parameter, Spec, Start


def parameter_values(spec: Spec, values: dict | None = None) -> dict:
    """All numbers of the spec by name: defaults, overridden by `values`, and tables.

    int parameters become int, real ones float, arrays and tables float64 arrays. Feeding a
    result back in gives it again. Raises UsageError for a name that the spec has not and
    for a value that does not fit.
    """
    values = dict(values or {})
    tables = {name: np.array(entries, dtype=float) for name, entries in spec.tables}
    known = {p.name for p in spec.parameters} | set(tables)
    for name in values:
        if name not in known:
            raise UsageError(f"no parameter '{name}' in {spec.name}{_nearest(name, known)}")
    scalars = {p.name: _scalar(p, values.get(p.name, p.default))
               for p in spec.parameters if p.kind != "array"}
    env = {**tables, **scalars}
    arrays = {p.name: _array(p, values.get(p.name, p.default), p.name not in values, env)
              for p in spec.parameters if p.kind == "array"}
    return {**env, **arrays}


def sizes(spec: Spec, values: dict | None = None) -> dict:
    """family name -> (number of its first site, number of its sites)."""
    env = parameter_values(spec, values)
    offset, found = 0, {}
    for family in spec.families:
        count = integer(family.count, env, f"the number of sites of '{family.name}'")
        if count < 1:
            raise UsageError(f"'{family.name}' must have at least one site, not {count}")
        if offset + count > limits.SITES:
            raise UsageError(f"more than {limits.SITES} sites")
        found[family.name] = (offset, count)
        offset += count
    return found


def kappas(spec: Spec, values: dict | None = None) -> np.ndarray:
    """The strength kappa of every site, shape (sites,). Zero or not finite is refused."""
    env, places = parameter_values(spec, values), sizes(spec, values)
    parts = [_per_site(f.kappa, env, places[f.name][1]) for f in spec.families]
    kappa = np.concatenate(parts)
    bad = np.flatnonzero(~np.isfinite(kappa) | (kappa == 0))
    if bad.size:
        raise UsageError(f"kappa of site {bad[0]} is {kappa[bad[0]]:g}; "
                             "it must be finite and not zero")
    return kappa


def radii(spec: Spec, values: dict | None = None) -> np.ndarray:
    """The radius of every site that lies on a sphere, nan for the others; shape (sites,)."""
    env, places = parameter_values(spec, values), sizes(spec, values)
    return np.concatenate([_radius(f, env, places[f.name][1]) for f in spec.families])


def casimir_matrices(spec: Spec, values: dict | None = None) -> np.ndarray:
    """Symmetric A with C(w) = w.(A w)/2 of every site, shape (sites, 3, 3).

    The identity on spheres and in R^3: grad C = w there, as the bracket says.
    """
    env, places = parameter_values(spec, values), sizes(spec, values)
    return np.concatenate([_matrix(f, env, places[f.name][1]) for f in spec.families])


def find_start(spec: Spec, start: str | Start | None) -> Start:
    """The start of that name; None means the only one. Raises UsageError."""
    if isinstance(start, Start):
        return start
    names = [s.name for s in spec.starts]
    if start is None and len(names) == 1:
        return spec.starts[0]
    if start not in names:
        said = f"no start '{start}'" if start is not None else "no start is named"
        raise UsageError(f"{said} in {spec.name}; it has: {', '.join(names) or 'none'}")
    return spec.starts[names.index(start)]


def initial_state(spec: Spec, start: str | Start | None = None, values: dict | None = None,
                  seed: int | None = None) -> np.ndarray:
    """The state at the start of a run, shape (sites, 3).

    `seed` replaces the seed of every random family. The first family of [space] takes
    numpy's PCG64(seed), family k PCG64([seed, k]): with one seed they are independent. Raises UsageError
    when the shape is wrong, a number is not finite or a point is off its sphere by more
    than 1e-12 of the radius (unless the start says normalise).
    """
    env, places = parameter_values(spec, values), sizes(spec, values)
    start = find_start(spec, start)
    given = {s.family: s for s in start.families}
    if seed is not None and all(s.kind != "random" for s in start.families):
        raise UsageError(f"a seed is for random starts, and nothing of start '{start.name}' is random")
    parts = []
    for number, family in enumerate(spec.families):
        if family.name not in given:
            raise UsageError(f"start '{start.name}' says nothing of '{family.name}'")
        one, count = given[family.name], places[family.name][1]
        w = _vectors(spec, family, number, one, env, count, seed)
        parts.append(_on_manifold(family, one, w, _radius(family, env, count)))
    return np.concatenate(parts)


def wrong_start(spec: Spec, values: dict, w: np.ndarray) -> str:
    """In brackets, which strength is wrong, or which site of the state `w` cannot be where it is, and by how much; "" where none is seen."""
    try:
        kappas(spec, values)
    except UsageError as refusal:
        return f" ({refusal})"
    said = wrong_lattice(spec, values) or wrong_site(w, radii(spec, values))
    return f" ({said})" if said else ""


def wrong_lattice(spec: Spec, values: dict) -> str:
    """The lattice whose bonds reach farther than it goes, or whose cells hold another number of sites than there are."""
    env, places = parameter_values(spec, values), sizes(spec, values)
    for term in (*spec.effects, *spec.observables):
        if not isinstance(term.over, Lattice):
            continue
        size = [integer(e, env, "the size of a lattice") for e in term.over.size]
        for d, n in enumerate(size):
            far = max((abs(offset[d]) for bond in term.over.bonds for _, offset in bond), default=0)
            if n < max(1, far):
                return f"effect '{term.name}': a bond reaches {far} cells along direction {d + 1} of its lattice, which has {n}"
        count, cells = places[term.over.family][1] if term.over.family in places else None, math.prod(size) * term.over.sites
        if count is not None and count != cells:
            return f"effect '{term.name}': its lattice has {cells} sites, '{term.over.family}' has {count}"
    return ""


def wrong_site(w, radius) -> str:
    """The site that is not finite, that has a size that cannot be squared, or that lies farthest off its sphere, and what it is."""
    largest = np.abs(w).max(axis=1)
    wild, wide = ~np.isfinite(largest), np.isnan(radius) & (largest > 0) & ~((largest >= limits.SHORTEST) & (largest <= limits.LARGEST))
    if np.any(wild):
        return f"site {int(np.argmax(wild))} of the start"
    if np.any(wide):
        site = int(np.argmax(wide))
        return (f"site {site} of the start: its largest component is {largest[site]:.3g}; a vector is 0 or has "
                f"one between {limits.SHORTEST:g} and {limits.LARGEST:g}")
    with np.errstate(over="ignore"):
        length = np.linalg.norm(w, axis=1)
    off = np.abs(length - radius) / radius
    if not np.any(off > limits.SPHERE):
        return ""
    site = int(np.nanargmax(off))
    return f"site {site}: |w| = {length[site]:.15g}, its sphere has radius {radius[site]:.15g}"


def _nearest(name, known):
    close = meant(name, known)
    return f"; did you mean '{close}'?" if close else ""


def _scalar(p: Parameter, value):
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise UsageError(f"'{p.name}' must be one number, not {value!r}") from None
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UsageError(f"'{p.name}' must be finite, not {number}")
    if p.kind == "real":
        return number
    if number != math.floor(number) or abs(number) > limits.INTEGER:
        raise UsageError(f"'{p.name}' must be an integer, not {number:.17g}")
    return int(number)


def _array(p: Parameter, value, is_default, env):
    """A list of the right size; one number stands for that many equal ones."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise UsageError(f"'{p.name}' must be a list of numbers") from None
    size = integer(p.size, env, f"the size of '{p.name}'") if p.size is not None else array.size
    if size > limits.ARRAY:
        raise UsageError(f"'{p.name}' would have {size} entries; at most {limits.ARRAY} are allowed")
    if (is_default and p.fill and array.size) or (not is_default and array.size == 1):
        array = np.full(size, array.flat[0])
    if array.shape != (size,):
        raise UsageError(f"'{p.name}' must be a list of {size} numbers, "
                             f"not {array.size if array.ndim == 1 else array.shape}")
    if not np.all(np.isfinite(array)):
        raise UsageError(f"'{p.name}' must be finite")
    return array


def _per_site(expr, env, count):
    """A formula in the site's index i, at i = 0 .. count-1."""
    value = evaluate(expr, {**env, "i": np.arange(count)})
    return np.array(np.broadcast_to(value, (count,)))


def _radius(family: Family, env, count):
    if family.kind != "sphere":
        return np.full(count, np.nan)
    r = np.ones(count) if family.radius is None else _per_site(family.radius, env, count)
    if not np.all(np.isfinite(r) & (r > 0)):
        raise UsageError(f"the radius of '{family.name}' must be positive and finite")
    return r


def _matrix(family: Family, env, count):
    if family.kind != "nambu":
        return np.broadcast_to(np.eye(3), (count, 3, 3))
    rows = [[_per_site(entry, env, count) for entry in row] for row in family.casimir]
    matrix = np.moveaxis(np.array(rows), -1, 0)
    if not np.all(np.isfinite(matrix)):
        raise UsageError(f"C of '{family.name}' must have finite coefficients")
    return matrix


def _vectors(spec, family, number, one: FamilyStart, env, count, seed):
    if one.kind == "vectors":
        w = np.array(one.value, dtype=float)
    elif one.kind == "formula":
        w = np.stack([_per_site(e, env, count) for e in one.value], axis=-1)
    elif one.kind == "random":
        chosen = one.value if seed is None else seed
        w = _random_directions(chosen, number, count) * _scale(family, env, count)
    else:
        w = _table(spec, str(one.value))
    if w.shape != (count, 3):
        raise UsageError(f"the start of '{family.name}' has shape {w.shape}, "
                             f"but its {count} sites need ({count}, 3)")
    if not np.all(np.isfinite(w)):
        site = np.flatnonzero(~np.isfinite(w).all(axis=1))[0]
        raise UsageError(f"the start of '{family.name}' is not finite at site {site}")
    return w


def _random_directions(seed, number, count):
    """Uniform on the unit sphere: normal vectors, normalised."""
    if not isinstance(seed, (int, np.integer)) or seed < 0:
        raise UsageError(f"a seed must be an integer from 0 up, not {seed!r}")
    bits = np.random.PCG64([int(seed), number] if number else int(seed))
    x = np.random.Generator(bits).standard_normal((count, 3))
    return x / np.linalg.norm(x, axis=1)[:, None]


def _scale(family, env, count):
    return _radius(family, env, count)[:, None] if family.kind == "sphere" else 1.0


def _table(spec, name):
    """Rows x, y, z of a .npy or .csv file that lies in the folder of the spec."""
    folder = Path(spec.path).resolve().parent
    path = (folder / name).resolve()
    if not path.is_relative_to(folder):
        raise UsageError(f"start file '{name}' is outside the folder of the spec")
    return state_table(path, name)


def state_table(path: Path, name: str) -> np.ndarray:
    """The array of a .npy file, or the rows of a .csv file; `name` is what errors call it."""
    try:
        if not path.is_file():
            raise ValueError("it is not a file" if path.exists() else "No such file or directory")
        if path.stat().st_size > limits.TABLE_BYTES:
            raise ValueError(f"it has more than {limits.TABLE_BYTES} bytes")
        if path.suffix == ".npy":
            return _loaded(path)
        return np.loadtxt(path, delimiter=",", ndmin=2, skiprows=_header_lines(path))
    except (OSError, ValueError, EOFError, TypeError) as problem:
        said = getattr(problem, "strerror", None) or problem
        raise UsageError(f"cannot read the start file '{name}': {said}") from None


def _loaded(path):
    """The numbers of a .npy file. It is mapped: a head that promises more than the file holds costs nothing."""
    try:
        with np.errstate(over="ignore"):        # a shape beyond all integers
            found = np.load(path, mmap_mode="r", allow_pickle=False)
        if found.dtype.kind not in "fiu":
            raise TypeError
        return np.array(found, dtype=float)
    except OSError:
        raise
    except Exception:       # of what a damaged head is taken for, numpy gives no list
        raise ValueError("it is no .npy file of real numbers") from None


def _header_lines(path):
    """How many lines to skip: up to the first row, when that holds column names instead of numbers."""
    with open(path, encoding="utf-8") as text:
        for number, line in enumerate(text, 1):
            if cells := line.split("#")[0].strip():
                return 0 if _are_numbers(cells.split(",")) else number
    return 0


def _are_numbers(cells) -> bool:
    try:
        return bool([float(cell) for cell in cells])
    except ValueError:
        return False


def _on_manifold(family, one, w, radius):
    """w on its spheres: scaled there when the start says so or when it is off by a few digits, otherwise refused."""
    if family.kind != "sphere":
        if one.normalise:
            raise UsageError(f"'{family.name}' is no sphere: nothing to normalise to")
        return w
    length = np.linalg.norm(w, axis=1)
    if one.normalise:
        if np.any(length == 0):
            raise UsageError(f"the start of '{family.name}' holds a zero vector")
        return w * (radius / length)[:, None]
    off = np.abs(length - radius) / radius
    if np.any(off > limits.SPHERE):
        site = int(np.argmax(off))
        raise UsageError(f"site {site} of '{family.name}' starts at |w| = {length[site]:.17g}, "
                             f"off its sphere of radius {radius[site]:.17g}; correct it or "
                             "write normalise = true")
    return np.where((off > 8 * np.finfo(float).eps)[:, None], w * (radius / length)[:, None], w)
