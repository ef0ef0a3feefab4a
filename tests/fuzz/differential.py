"""Random Hamiltonians: generated C against the witness, to what round-off of the data allows.

    python -m fuzz.differential [--count 500 | --seconds 60] [--seed 0]

Compared at random states and times: energy, each effect, field, observables, momentum, Casimirs;
then some steps of a modest h by a random method and solver. A mismatch prints the spec.
"""
import argparse
import contextlib
import random
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

import numpy as np
from support.random_specs import random_spec

import smidgen
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS
from smidgen.run.step.evaluated import casimir_matrices, kappas, parameter_values, radii, sizes
from smidgen.check.witness import Witness, extrapolation

from .invent import put_files

EPSILON = np.finfo(float).eps
UNIT = 2.0**-30             # of the changes that show how data carry their last bit
JUMP = 1e-3          # of a value, by which no smooth one changes then
STATES, STEPS = 3, 4
ALLOWED = 8                 # units in the last place of what a number is made of, and of what data carry
COMPILER = import_module("smidgen.build.binary")


@contextlib.contextmanager
def quick_builds():
    """-O1 in place of -O3: the same bits, in half the time."""
    flags = COMPILER.FLAGS
    COMPILER.FLAGS = tuple("-O1" if f == "-O3" else f for f in flags)
    try:
        yield
    finally:
        COMPILER.FLAGS = flags


class Mismatch(AssertionError):
    """Two numbers that should agree do not."""


def read(text, files):
    with tempfile.TemporaryDirectory() as where:
        put_files(Path(where), files | {"model.toml": text})
        return smidgen.load(Path(where) / "model.toml")


def random_state(spec, values, dice):
    """On the spheres; of lengths from 0.7 to 1.3 elsewhere."""
    radius = radii(spec, values)
    w = dice.standard_normal((len(radius), 3))
    length = np.where(np.isnan(radius), dice.uniform(0.7, 1.3, len(radius)), radius)
    return w * (length / np.linalg.norm(w, axis=1))[:, None]


def carried(function, w, t, dice):
    """What a unit in the last place of w and t does to the value: the largest of some tries, shape as the value; infinite
    where it jumps, as floor does at what cancels to 0."""
    here = np.asarray(function(w, t))
    tries = [np.abs(np.asarray(function(w * (1 + UNIT * dice.uniform(-1, 1, w.shape)), t * (1 + UNIT * s))) - here)
             for s in (-1, 0, 1) * 4]
    most = np.max(tries, axis=0)
    return np.where(most > JUMP * (1 + np.abs(here)), np.inf, EPSILON / UNIT * most)


def compare(what, mine, other, allowed):
    gap = np.max(np.abs(np.asarray(mine) - other) / allowed)
    if not gap <= 1:
        raise Mismatch(f"{what}: {np.asarray(mine)} against {np.asarray(other)}, {gap:.3g} times what is allowed")


class Pair:
    """One spec compiled, and its witness."""

    def __init__(self, text, files, dice):
        self.spec, self.dice = read(text, files), dice
        self.values = parameter_values(self.spec, None)
        self.witness = Witness(self.spec, self.values)
        self.model = self.build()

    def build(self):
        """A random method and solver; those that do not exist for the spec are refused in words."""
        method = self.dice.choice(["spherical-midpoint"] * 3 + ["classical-midpoint"])
        solver = self.dice.choice(["auto", "auto", "newton", "rotation", "plain"])
        try:
            return smidgen.build(self.spec, method=method, solver=solver)
        except UsageError:
            return smidgen.build(self.spec, method=method)

    def numbers(self, w, t):
        """Energy, effects, observables, field; momentum and Casimirs by plain sums."""
        self.model.start(w.copy(), t0=t, h=0.1)
        found = dict(zip(self.model.columns, self.model.values()))
        scale = max(1, np.abs(self.witness.field(w, t) * w).sum())
        for name, function in self.scalars():
            allowed = ALLOWED * (EPSILON * (scale + abs(function(w, t))) + carried(function, w, t, self.dice))
            compare(name, found[name], function(w, t), allowed)
        field = self.witness.field(w, t)
        allowed = ALLOWED * (EPSILON * max(1, np.abs(field).max()) + carried(self.witness.field, w, t, self.dice).max())
        compare("field", self.model.field(w, t), field, allowed)
        self.integrals(w, found)

    def scalars(self):
        for effect in self.spec.energies:
            yield f"energy.{effect.name}", lambda w, t, n=effect.name: self.witness.energies(w, t)[n]
        yield "energy", self.witness.energy
        for term in self.spec.observables:
            yield term.name, lambda w, t, n=term.name: self.witness.observables(w, t)[n]

    def integrals(self, w, found):
        kappa, k = np.where(self.witness.absent, 0, kappas(self.spec, self.values)), 0
        for name, (_, count) in sizes(self.spec, self.values).items():
            parts = kappa[k:k + count, None] * w[k:k + count]
            mine = [found[f"momentum.{name}.{axis}"] for axis in "xyz"]
            compare("momentum", mine, parts.sum(0), ALLOWED * EPSILON * (1e-3 + np.abs(parts).sum()))
            k += count
        compare("casimirs", self.model.casimirs(), self.casimirs(w), ALLOWED * EPSILON * (w * w).sum())

    def casimirs(self, w):
        """|w|^2, or C = w.(A w)/2 of a Nambu factor: the field's own matrices, whose A is 1 on spheres."""
        nambu = np.concatenate([[f.kind == "nambu"] * n for f, n in zip(
            self.spec.families, (n for _, n in sizes(self.spec, self.values).values()))])
        form = np.einsum("sa,sab,sb->s", w, casimir_matrices(self.spec, self.values), w)
        return np.where(self.witness.absent, 0, np.where(nambu, form / 2, form))

    def step_size(self, w, t):
        """h of a fifth of the inverse rate: the largest of |DX|, and what moves w by a fifth of itself."""
        dx, _ = self.witness.jacobian(w, t)
        speed = np.abs(self.witness.vector_field(w, t)).max()
        return 0.2 / max(np.abs(dx).sum(1).max(), speed, 0.5)

    def allowed(self, w, t, h, count):
        """The round-off of some steps: of the state, and what a unit in the last place of it does to h X."""
        dx, _ = self.witness.jacobian(w, t)
        size = np.abs(w).max() * (1 + np.abs(h * dx).sum(1).max())
        x = carried(lambda v, s: h * self.witness.vector_field(v, s), w, t, self.dice).max()
        return ALLOWED * count * (EPSILON * size + x)

    def steps(self, w, t, h=None, count=STEPS):
        """Steps of both, by default of a modest h; None when the witness finds no solution."""
        h = float(self.step_size(w, t) * self.dice.choice((-1, 1))) if h is None else h
        try:
            mine = self.witness.steps(w, t, h, count, self.model.method)
        except RunError:
            return
        allowed = self.allowed(w, t, h, count) + self.beside_the_sphere(mine, t, h)
        self.model.start(w.copy(), t0=t, h=h)
        before = self.casimirs(w)
        for k in range(1, count + 1):
            compare(f"state after {k} steps of {h!r} from {t!r}", self.model.step().w, mine[k], allowed)
        if METHODS[self.model.method].keeps_leaf:
            compare("Casimirs kept", self.casimirs(self.model.w), before, allowed * (1 + np.abs(w).max()) * 3)


    def beside_the_sphere(self, states, t, h) -> float:
        """Extrapolation evaluates beside the spheres, where damping that acts on torques is written in several ways that agree on them alone: what the
        steps have of that is within what a row less changes, next to nothing but across a jump."""
        if not self.model.method.startswith("extrapolation") or not (self.witness.torques and self.witness.dampings):
            return 0.0
        fewer = [extrapolation.step(self.witness, w, t + k * h, h, rows=5) for k, w in enumerate(states[:-1])]
        return sum(np.inf if f is None else np.abs(f - after).max() for f, after in zip(fewer, states[1:]))


def check(text, files, seed=0):
    """Raises Mismatch where compiled and witness differ by more than round-off."""
    dice = np.random.default_rng(seed)
    with quick_builds():
        pair = Pair(text, files, dice)
    for _ in range(STATES):
        w, t = random_state(pair.spec, pair.values, dice), float(dice.uniform(0, 3))
        pair.numbers(w, t)
        pair.steps(w, t)
    return pair


def tried(seed):
    """Is the random Hamiltonian of this seed the same in C and in the witness? Says what is not."""
    text, files = random_spec(random.Random(seed))
    try:
        check(text, files, seed)
    except Exception as problem:        # the fuzzer goes on; whatever it met is shown
        print(f"seed {seed}: {type(problem).__name__}: {problem}\n{text}", flush=True)
        return False
    return True


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seconds", type=float, help="in place of a count")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(words)
    begin, count, bad = time.monotonic(), 0, 0
    while time.monotonic() - begin < args.seconds if args.seconds else count < args.count:
        bad += not tried(args.seed + count)
        count += 1
    print(f"{count} random Hamiltonians in {time.monotonic() - begin:.0f} s, {bad} mismatches")
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
