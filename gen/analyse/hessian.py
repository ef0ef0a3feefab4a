"""The energy of a scene at a state, its gradient and its Hessian, in numpy, from the derivatives of one representative term of each effect.

    energy = Energy(numbers)            # of a scene
    energy.gradient(w)                  # (sites, 3)
    i, j, blocks = energy.hessian(w)    # d2H/dw_i dw_j: each pair of sites once, blocks (pairs, 3, 3)
"""
from __future__ import annotations

import numpy as np
import sympy as sp

from ..compile.derive.derivatives import Derived, derive
from ..compile.derive.values import value
from ..compile.plan.held import present
from ..errors import UsageError
from ..language.evaluate import evaluate
from ..language.expr import Time
from ..language.instances import instances_of
from ..run.step.evaluated import Evaluated


class Energy:
    """H of a scene, without its absent sites. Raises UsageError for an energy that depends on time."""

    def __init__(self, numbers: Evaluated):
        self.sites = sum(count for _, count in numbers.places.values())
        self.sums = [Sum(derive(term), numbers) for term in present(numbers.spec).energies]

    def at(self, w) -> float:
        """H(w)."""
        return float(sum(one.energy(w) for one in self.sums))

    def gradient(self, w) -> np.ndarray:
        """dH/dw, (sites, 3)."""
        found = np.zeros((self.sites, 3))
        for one in self.sums:
            one.add_gradient(w, found)
        return found

    def strength(self, w) -> np.ndarray:
        """The field of each site, where no two terms cancel, (sites,)."""
        found = np.zeros((self.sites, 3))
        for one in self.sums:
            one.add_gradient(w, found, np.abs)
        return np.linalg.norm(found, axis=1)

    def hessian(self, w) -> tuple:
        """(i, j, blocks): the pairs of sites, in their order, each once."""
        parts = [part for one in self.sums for part in one.blocks(w)]
        if not parts:
            return np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3, 3))
        i, j, blocks = (np.concatenate([part[k] for part in parts]) for k in range(3))
        pairs, place = np.unique(i * self.sites + j, return_inverse=True)
        summed = np.zeros((len(pairs), 3, 3))
        np.add.at(summed, place, blocks)
        return pairs // self.sites, pairs % self.sites, summed


class Sum:
    """One effect: the sum of its terms."""

    def __init__(self, derived: Derived, numbers: Evaluated):
        indices, columns = instances_of(derived.term.over, numbers.values, numbers.places)
        self.derived, self.count = derived, len(next(iter(indices.values()), [0]))
        self.sites = [np.full(self.count, numbers.places[family][0]) + (indices[slot] if isinstance(slot, str) else slot)
                      for family, slot in derived.slots]
        for leaf in derived.leaves.values():
            if isinstance(leaf, Time):
                raise UsageError(f"the energy `{derived.term.name}` depends on time, so no state is an equilibrium: leave it out with "
                                 "effects=.. (--effects), or, in Python, compute the spin-wave lines from the other effects: spectrum(theory=spin_waves(effects=..))")
        env = {**numbers.values, **indices, **columns}
        self.leaves = {sp.Symbol(name, real=True): evaluate(leaf, env) for name, leaf in derived.leaves.items()}

    def known(self, w) -> dict:
        """Symbol -> its value in every term; those of parts too."""
        found = dict(self.leaves)
        for names, sites in zip(self.derived.vectors, self.sites):
            found.update(zip(names, np.asarray(w, float)[sites].T))
        for name, part in self.derived.parts.items():
            found[name] = value(part, found)
        return found

    def energy(self, w) -> float:
        return float(np.sum(np.broadcast_to(value(self.derived.value, self.known(w)), self.count)))

    def add_gradient(self, w, total, of=np.positive) -> None:
        known = self.known(w)
        for row, sites in zip(self.derived.gradient, self.sites):
            np.add.at(total, sites, of(self.filled(row, known)))

    def blocks(self, w):
        """(i, j, blocks) of each pair of slots."""
        known = self.known(w)
        for (k, l), block in self.derived.hessian.items():
            yield self.sites[k], self.sites[l], self.filled(list(block), known).reshape(-1, 3, 3)

    def filled(self, entries, known) -> np.ndarray:
        """(terms, entries)."""
        return np.stack([np.broadcast_to(np.asarray(value(e, known), float), self.count) for e in entries], axis=1)
