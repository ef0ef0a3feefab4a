"""The state that a start describes, as an array of shape (sites, 3)."""
from __future__ import annotations

import numpy as np

from ..expr import Expr
from ..spec import Family, FamilyStart, Spec
from .arithmetic import evaluate
from .values import integer


def site_values(e: Expr, count: int, values: dict) -> np.ndarray:
    """A formula in i at the sites 0..count-1, as floats. IndexError: an array is too short."""
    i = np.arange(count)
    return np.broadcast_to(np.asarray(evaluate(e, values, {"i": i}), float), (count,)).copy()


def family_start(part: FamilyStart, family: Family, values: dict, seed=None) -> np.ndarray:
    """Shape (count, 3). `seed` replaces that of a random start."""
    count = integer(family.count, values)
    if part.kind == "vectors":
        w = np.array(part.value, float)
    elif part.kind == "formula":
        w = np.stack([site_values(c, count, values) for c in part.value], axis=1)
    else:
        w = random_vectors(count, part.value if seed is None else seed)
        if family.radius is not None:
            w *= site_values(family.radius, count, values)[:, None]
    return normalised(w, family, values) if part.normalise else w


def normalised(w: np.ndarray, family: Family, values: dict) -> np.ndarray:
    """Each vector scaled to its sphere's radius."""
    r = site_values(family.radius, len(w), values)
    with np.errstate(all="ignore"):
        return w * (r / np.sqrt((w * w).sum(axis=1)))[:, None]


def random_vectors(count: int, seed: int) -> np.ndarray:
    """Uniform on the unit sphere: PCG64 normal deviates, divided by their length."""
    w = np.random.Generator(np.random.PCG64(seed)).standard_normal((count, 3))
    return w / np.sqrt((w * w).sum(axis=1))[:, None]


def initial_state(spec: Spec, start: str, values: dict, seed=None) -> np.ndarray:
    """The start named `start` of all families, shape (sites, 3), in the order of [space].

    values: parameter and table name -> value, as from `read.values.defaults`.
    """
    found = next(s for s in spec.starts if s.name == start)
    parts = {p.family: p for p in found.families}
    return np.concatenate([family_start(parts[f.name], f, values, seed)
                           for f in spec.families])
