"""Which effects have an energy that jumps where sites move: at an edge of floor, mod or a comparison that looks at their vectors.

Where H jumps no step equation says what a step across is: the energy changes, a method has no order, and two solvers may end in different
solutions. An edge alone is no jump, `if(d < 1, (1 - d)^2, 0)` is none: so states on both sides of each are looked for between
random states, by bisection of what the edges say, and the energies compared.
"""
from __future__ import annotations

import numpy as np

from ...chance import generator
from ...language.evaluate import evaluate
from ...language.expr import Op, Spin, walk
from ...language.instances import instances_of
from ...language.spec import Spec
from ...run.step.evaluated import Evaluated

COMPARED = {"<", "<=", ">", ">="}
PATHS, PARTS, HALVINGS = 48, 16, 40     # ways for one term, four at least for many
TERMS, SITES = 256, 4096    # of an effect that are looked at; sites with a vector of their own
CLEAR = 1e-6            # of the larger energy and 1: beyond what bisection leaves of a kink


def jumps(scene: Spec, values: dict | None = None) -> dict:
    """Effect -> the largest jump of one of its terms that was seen; without those that jump nowhere."""
    numbers = Evaluated(scene, values)
    found = {effect.name: _largest(effect, numbers) for effect in scene.energies if edges(effect.value)}
    return {name: size for name, size in found.items() if size > 0}


def edges(value) -> list:
    """What changes at once where a vector crosses an edge: the floors and comparisons of a formula that look at vectors."""
    found = (Op("floor", (Op("/", e.args),)) if e.op == "mod" else e for e in walk(value)
             if isinstance(e, Op) and e.op in COMPARED | {"floor", "mod"})
    return [e for e in found if any(isinstance(node, Spin) for node in walk(e))]


def _largest(effect, numbers: Evaluated) -> float:
    dice, watched = generator("jumps"), edges(effect.value)
    indices, columns = instances_of(effect.over, numbers.values, numbers.places)
    some = {name: x[:: len(x) // TERMS + 1] for name, x in {**indices, **columns}.items()}
    given = {**numbers.values, **some}
    shape = next((np.shape(x) for x in some.values()), ())
    terms = shape[0] if shape else 1
    return max(_on_path(effect.value, watched, Path(numbers, dice, given), shape) for _ in range(max(4, PATHS // max(1, terms))))


def _on_path(energy, watched, path, shape) -> float:
    """The largest jump at the edges that the terms meet on a way from one random state to another."""
    most = 0.0
    for part in range(PARTS):
        low, high = np.full(shape, part / PARTS), np.full(shape, (part + 1) / PARTS)
        before = path.at(watched, low)
        crossed = np.any(path.at(watched, high) != before, axis=0)
        if not np.any(crossed):
            continue
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            beyond = np.any(path.at(watched, middle) != before, axis=0)
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        below, above = (path.at([energy], s)[0] for s in (low, high))
        size = np.where(crossed, np.abs(above - below), 0)
        clear = size > CLEAR * np.maximum(1, np.maximum(np.abs(above), np.abs(below)))
        most = max(most, float(np.max(size, where=clear, initial=0)))
    return most


class Path:
    """From one random state to another, on the spheres; each term of an effect may be at a part s of its own."""

    def __init__(self, numbers: Evaluated, dice, given: dict):
        self.numbers, self.given = numbers, {**given, "t": dice.uniform(0, 3)}
        self.ends = dice.standard_normal((2, min(SITES, len(numbers.radii)), 3))

    def at(self, formulas, s) -> np.ndarray:
        """Values of formulas, one row for each."""
        env = {**self.given, "spins": lambda family, slot: self._vector(family, slot, s)}
        return np.array([np.broadcast_to(evaluate(e, env), np.shape(s)) for e in formulas])

    def _vector(self, family, slot, s):
        site = self.numbers.places[family][0] + slot
        (first, last), radius = self.ends[:, site % SITES], self.numbers.radii[site]
        w = first + s[..., None] * (last - first)
        length = np.linalg.norm(w, axis=-1)
        return w * np.where(np.isnan(radius), 1, radius / length)[..., None]
