"""The numbers of a spec: parameter values, sizes, strengths, radii, Casimirs."""
from __future__ import annotations

import functools
import math

import numpy as np

from ...errors import UsageError
from ...language import limits
from ...language.evaluate import evaluate, integer
from ...language.held import absent, still
from ...language.spec import Family, Parameter, Spec
from ...read.given import scaled
from ...read.problems import meant


class Evaluated:
    """All numbers of a spec with given parameter values, each computed once, when it is first asked for.

    values: name -> number or array, as `parameter_values` gives them. Raises UsageError where they do not fit.
    """

    def __init__(self, spec: Spec, values: dict | None = None):
        self.spec, self.values = spec, parameter_values(spec, values)

    def of(self, scene: Spec) -> Evaluated:
        """The same values for a scene of the spec, which may have fewer parameters."""
        found = object.__new__(Evaluated)
        kept = {p.name for p in scene.parameters} | {name for name, _ in scene.tables}
        found.spec, found.values = scene, {name: value for name, value in self.values.items() if name in kept}
        return found

    @property
    def parameters(self) -> dict:
        """The values of the parameters alone, without tables."""
        return {p.name: self.values[p.name] for p in self.spec.parameters}

    @functools.cached_property
    def places(self) -> dict:
        """family name -> (number of its first site, number of its sites)."""
        offset, found = 0, {}
        for family in self.spec.families:
            count = integer(family.count, self.values, f"the number of sites of '{family.name}'")
            if count < 1:
                raise UsageError(f"'{family.name}' must have at least one site, not {count}")
            if offset + count > limits.SITES:
                raise UsageError(f"more than {limits.SITES} sites")
            found[family.name] = (offset, count)
            offset += count
        return found

    @functools.cached_property
    def kappas(self) -> np.ndarray:
        """The strength kappa of every site, shape (sites,). Zero or not finite is refused."""
        kappa = self._of_sites(lambda f, count: per_site(f.kappa, self.values, count))
        bad = np.flatnonzero(~np.isfinite(kappa) | (kappa == 0))
        if bad.size:
            raise UsageError(f"kappa of site {bad[0]} is {kappa[bad[0]]:g}; "
                             "it must be finite and not zero")
        return kappa

    @functools.cached_property
    def radii(self) -> np.ndarray:
        """The radius of every site that lies on a sphere, nan for the others; shape (sites,)."""
        return self._of_sites(lambda f, count: radius(f, self.values, count))

    @functools.cached_property
    def casimir_matrices(self) -> np.ndarray:
        """Symmetric A with C(w) = w.(A w)/2 of every site, shape (sites, 3, 3).

        The identity on spheres and in R^3: grad C = w there, as the bracket says.
        """
        return self._of_sites(lambda f, count: _matrix(f, self.values, count))

    @functools.cached_property
    def present(self) -> np.ndarray:
        """Is each site there? Shape (sites,). That none is, is refused."""
        found = self._of_sites(lambda f, count: ~self._where(absent(self.spec, f.name), count))
        if not found.any():
            raise UsageError("every site is absent: no site is left to move")
        return found

    @functools.cached_property
    def moving(self) -> np.ndarray:
        """Does each site move, being neither absent nor pinned nor of a fixed family? Shape (sites,)."""
        return self._of_sites(lambda f, count: ~self._where(still(self.spec, f.name), count))

    def _where(self, condition, count) -> np.ndarray:
        return np.zeros(count, bool) if condition is None else per_site(condition, self.values, count).astype(bool)

    def _of_sites(self, one) -> np.ndarray:
        """one(family, count) of all families, one after the other; read-only, since it is shared."""
        found = np.concatenate([one(f, self.places[f.name][1]) for f in self.spec.families])
        found.flags.writeable = False
        return found


def parameter_values(spec: Spec, values: dict | None = None) -> dict:
    """All numbers of the spec by name: defaults, overridden by `values`, and tables.

    int parameters become int, real ones float, arrays and tables float64 arrays. Feeding a
    result back in gives it again. Raises UsageError for a name that the spec has not and
    for a value that does not fit.
    """
    values = scaled(spec, values or {})
    tables = {name: np.array(entries, dtype=float) for name, entries in spec.tables}
    known = {p.name for p in spec.parameters} | set(tables)
    for name in values:
        if name not in known:
            raise UsageError(f"{spec.name} has no parameter '{name}'{_nearest(name, known)}")
    scalars = {p.name: _scalar(p, values.get(p.name, p.default))
               for p in spec.parameters if p.kind != "array"}
    env = {**tables, **scalars}
    arrays = {p.name: _array(p, values.get(p.name, p.default), p.name not in values, env)
              for p in spec.parameters if p.kind == "array"}
    return {**env, **arrays}


def sizes(spec: Spec, values: dict | None = None) -> dict:
    """As `Evaluated.places`, for who asks once: family name -> (number of its first site, number of its sites)."""
    return Evaluated(spec, values).places


def kappas(spec: Spec, values: dict | None = None) -> np.ndarray:
    """As `Evaluated.kappas`, for who asks once."""
    return Evaluated(spec, values).kappas


def radii(spec: Spec, values: dict | None = None) -> np.ndarray:
    """As `Evaluated.radii`."""
    return Evaluated(spec, values).radii


def casimir_matrices(spec: Spec, values: dict | None = None) -> np.ndarray:
    """As `Evaluated.casimir_matrices`."""
    return Evaluated(spec, values).casimir_matrices


def _nearest(name, known):
    close = meant(name, known)
    return f"; did you mean '{close}'?" if close else ""


def _scalar(p: Parameter, value):
    try:
        number = float(real(value))
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


def real(value):
    """The value. Raises TypeError for complex ones, whose imaginary parts numpy would drop."""
    if np.iscomplexobj(value):
        raise TypeError
    return value


def _array(p: Parameter, value, is_default, env):
    """A list of the right size; one number stands for that many equal ones."""
    try:
        array = np.array(real(value), dtype=float)
        array = array.ravel() if array.ndim == 2 and array.shape[1] == 3 else array     # a list of vectors
    except (TypeError, ValueError):
        raise UsageError(f"'{p.name}' must be a list of numbers") from None
    size = integer(p.size, env, f"the size of '{p.name}'") if p.size is not None else array.size
    if size > limits.ARRAY:
        raise UsageError(f"'{p.name}' would have {size} entries; at most {limits.ARRAY} are allowed")
    if p.vector and array.size == 1:
        raise UsageError(p.too_few)
    if (is_default and p.fill and array.size) or (not is_default and array.size == 1):
        array = np.full(size, array.flat[0])
    if array.shape != (size,):
        raise UsageError(f"'{p.name}' must be a list of {size} numbers, "
                             f"not {array.size if array.ndim == 1 else array.shape}")
    if not np.all(np.isfinite(array)):
        raise UsageError(f"'{p.name}' must be finite")
    return array


def per_site(expr, env, count, first=0):
    """A formula in the site's index i, at `count` sites from the first on."""
    value = evaluate(expr, {**env, "i": np.arange(first, first + count)})
    return np.array(np.broadcast_to(value, (count,)))


def radius(family: Family, env, count, first=0):
    """Of `count` sites of a family, shape (count,); nan where it is no sphere."""
    if family.kind != "sphere":
        return np.full(count, np.nan)
    r = np.ones(count) if family.radius is None else per_site(family.radius, env, count, first)
    if not np.all(np.isfinite(r) & (r > 0)):
        raise UsageError(f"the radius of '{family.name}' must be positive and finite")
    return r


def _matrix(family: Family, env, count):
    if family.kind != "nambu":
        return np.broadcast_to(np.eye(3), (count, 3, 3))
    rows = [[per_site(entry, env, count) for entry in row] for row in family.casimir]
    matrix = np.moveaxis(np.array(rows), -1, 0)
    if not np.all(np.isfinite(matrix)):
        raise UsageError(f"C of '{family.name}' must have finite coefficients")
    return matrix
