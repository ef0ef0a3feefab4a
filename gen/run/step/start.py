"""Where a run starts, and why it cannot."""
from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...language import draws, limits
from ...language.evaluate import integer
from ...language.spec import FamilyStart, Lattice, Spec, Start, families_of
from .evaluated import Evaluated, per_site, radius
from .noise import SEEDS
from .real import real_array


def find_start(spec: Spec, start: str | Start | None) -> Start:
    """The start of that name; None means the only one. Raises UsageError."""
    if isinstance(start, Start):
        return start
    names = [s.name for s in spec.starts]
    if start is None and len(names) == 1:
        return spec.starts[0]
    if start not in names:
        said = f"no start '{start}'" if start is not None else "no start is given"
        raise UsageError(f"{said} in {spec.name}; it has: {', '.join(names) or 'none'}")
    return spec.starts[names.index(start)]


def initial_state(spec: Spec, start: str | Start | None = None, parameters: dict | None = None,
                  seed: int | None = None) -> np.ndarray:
    """The state at the start of a run, shape (sites, 3): as `state_at`, for who asks once."""
    return state_at(Evaluated(spec, parameters), start, seed)


def state_at(numbers: Evaluated, start: str | Start | None = None, seed: int | None = None) -> np.ndarray:
    """The state at a start of the spec of these numbers, shape (sites, 3).

    `seed` replaces the seed of every random family. The families of [space] are independent of each other, and of all else that
    is drawn with the same seed (gen/language/draws.py). Raises UsageError
    when the shape is wrong, a number is not finite or a point is off its sphere by more
    than 1e-12 of the radius (unless the start says normalise).
    """
    spec = numbers.spec
    start = find_start(spec, start)
    given = {s.family: s for s in start.families}
    if seed is not None and all(s.kind != "random" for s in start.families) and not spec.heated:
        raise UsageError(f"a seed was given, but nothing in start '{start.name}' is random")
    parts = []
    for number, family in enumerate(spec.families):
        if family.name not in given:
            raise UsageError(f"start '{start.name}' does not give '{family.name}'")
        parts.append(_of_family(numbers, number, given[family.name], (0, numbers.places[family.name][1]), seed))
    return put_away(numbers, np.concatenate(parts))


def given_or_at(numbers: Evaluated, start, seed: int | None = None) -> np.ndarray:
    """A state that is given as an array, with absent sites where all states have them; else as `state_at`."""
    if not isinstance(start, np.ndarray):
        return state_at(numbers, start, seed)
    if start.shape != (len(numbers.present), 3):
        raise UsageError(f"a state of {numbers.spec.name} has shape ({len(numbers.present)}, 3), not {start.shape}")
    return put_away(numbers, real_array(start, float, "a state").copy())


def part_of_state(numbers: Evaluated, start: str | Start | None, seed: int | None, first: int, count: int) -> np.ndarray:
    """Some sites of the state at a start of a spec with one family, shape (count, 3); absent sites stand as the start has them."""
    return _of_family(numbers, 0, find_start(numbers.spec, start).families[0], (first, count), seed)


def _of_family(numbers: Evaluated, number: int, one: FamilyStart, sites, seed):
    """The vectors of some sites of the family of this number, (the first, how many), on its spheres."""
    family, (first, count) = numbers.spec.families[number], sites
    w = _vectors(numbers, number, one, first, count, seed)
    return _on_manifold(family, one, w, radius(family, numbers.values, count, first))


def put_away(numbers: Evaluated, w: np.ndarray) -> np.ndarray:
    """The state with absent sites where all states have them, at (0, 0, r); of another number of sites, as it is."""
    gone = ~numbers.present
    if gone.any() and len(w) == len(gone):
        w[gone], w[gone, 2] = 0, np.where(np.isnan(numbers.radii[gone]), 1, numbers.radii[gone])
    return w


def wrong_start(numbers: Evaluated, w: np.ndarray) -> str:
    """In brackets, which strength is wrong, or which site of the state `w` cannot be where it is, and by how much; "" where none is seen."""
    try:
        numbers.kappas
    except UsageError as refusal:
        return f" ({refusal})"
    said = wrong_lattice(numbers) or wrong_site(w, numbers.radii)
    return f" ({said})" if said else ""


def wrong_lattice(numbers: Evaluated) -> str:
    """The lattice whose bonds reach farther than it goes, or whose cells hold another number of sites than there are."""
    env, places = numbers.values, numbers.places
    for term in (*numbers.spec.energies, *numbers.spec.observables):
        if not isinstance(term.over, Lattice):
            continue
        size = [integer(e, env, "the size of a lattice") for e in term.over.size]
        for d, n in enumerate(size):
            far = max((abs(offset[d]) for bond in term.over.bonds for _, offset in bond), default=0)
            if n < max(1, far):
                return f"effect '{term.name}': a bond reaches {far} cells along direction {d + 1} of its lattice, which has {n}"
        cells = math.prod(size) * term.over.sites
        for family in families_of(term.over).values():
            if family in places and places[family][1] != cells:
                return f"effect '{term.name}': its lattice has {cells} sites, '{family}' has {places[family][1]}"
    return ""


def wrong_site(w, radii) -> str:
    """The site that is not finite, that has a size that cannot be squared, or that lies farthest off its sphere, and what it is."""
    largest = np.abs(w).max(axis=1)
    wild, wide = ~np.isfinite(largest), np.isnan(radii) & (largest > 0) & ~((largest >= limits.SHORTEST) & (largest <= limits.LARGEST))
    if np.any(wild):
        return f"site {int(np.argmax(wild))} of the start"
    if np.any(wide):
        site = int(np.argmax(wide))
        return (f"site {site} of the start: its largest component is {largest[site]:.3g}; a vector must be 0, or have one between {limits.SHORTEST:g} and {limits.LARGEST:g}")
    with np.errstate(over="ignore"):
        length = np.linalg.norm(w, axis=1)
    off = np.abs(length - radii) / radii
    if not np.any(off > limits.SPHERE):
        return ""
    site = int(np.nanargmax(off))
    return f"site {site}: |w| = {length[site]:.15g}, but its sphere has radius {radii[site]:.15g}"


def _vectors(numbers: Evaluated, number: int, one: FamilyStart, first: int, count: int, seed):
    family, env = numbers.spec.families[number], numbers.values
    if one.kind == "formula":
        w = np.stack([per_site(e, env, count, first) for e in one.value], axis=-1)
    elif one.kind == "random":
        chosen = one.value if seed is None else seed
        w = _random_directions(chosen, number, first, count) * _scale(family, env, count, first)
    else:
        w = _listed(numbers, number, one, first, count)
    if not np.all(np.isfinite(w)):
        site = first + np.flatnonzero(~np.isfinite(w).all(axis=1))[0]
        raise UsageError(f"the start of '{family.name}' is not finite at site {site}")
    return w


def _listed(numbers: Evaluated, number: int, one: FamilyStart, first: int, count: int) -> np.ndarray:
    """Some vectors of a list, or of a table in a file."""
    name, all_ = numbers.spec.families[number].name, numbers.places[numbers.spec.families[number].name][1]
    w = np.array(one.value, dtype=float) if one.kind == "vectors" else _table(numbers.spec, str(one.value))
    if w.shape != (all_, 3):
        raise UsageError(f"the start of '{name}' has shape {w.shape}, "
                             f"but its {all_} sites need ({all_}, 3)")
    return w[first:first + count]


def _random_directions(seed, number, first, count):
    """Uniform on the unit sphere."""
    if not isinstance(seed, (int, np.integer)) or seed < 0:
        raise UsageError(f"a seed must be a non-negative integer, not {seed!r}")
    if seed >= SEEDS:
        raise UsageError(f"a seed must be at most {SEEDS - 1}, not {seed}")
    return draws.directions(np.uint64(seed), number, count, first=first)


def _scale(family, env, count, first):
    return radius(family, env, count, first)[:, None] if family.kind == "sphere" else 1.0


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
        raise ValueError("it is not a .npy file of real numbers") from None


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


def _on_manifold(family, one, w, radii):
    """w on its spheres: scaled there when the start says so or when it is off by a few digits, otherwise refused."""
    if family.kind != "sphere":
        if one.normalise:
            raise UsageError(f"'{family.name}' is not on a sphere, so there is nothing to normalise to")
        return w
    length = np.linalg.norm(w, axis=1)
    if one.normalise:
        if np.any(length == 0):
            raise UsageError(f"the start of '{family.name}' contains a zero vector")
        return w * (radii / length)[:, None]
    off = np.abs(length - radii) / radii
    if np.any(off > limits.SPHERE):
        site = int(np.argmax(off))
        raise UsageError(f"site {site} of '{family.name}' starts at |w| = {length[site]:.17g}, "
                             f"off its sphere of radius {radii[site]:.17g}; correct it, or write normalise = true")
    return np.where((off > 8 * np.finfo(float).eps)[:, None], w * (radii / length)[:, None], w)
