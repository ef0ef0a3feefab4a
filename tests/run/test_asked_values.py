"""Rows hold what a run asks for and nothing else is computed for them; values are added up in an order of their own, by whatever lanes."""
import itertools

import numpy as np
import pytest

import smidgen
from smidgen.check.witness import Witness
from smidgen.run.step.block import Block

PARTS = 16      # SMG_PARTS of runtime/core/smg_sum.h
CHAIN = """[model]
name = "ring"
[space]
w = { sphere = "n" }
[parameters]
n = 300
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-0.7*w[i].z"
[observables.mz]
over = "site(i) of w"
value = "w[i].z"
[starts.random]
random = 1
[runs.demo]
start = "random"
h = 0.02
steps = 30
"""


@pytest.fixture(scope="module")
def ring():
    return smidgen.load_text(CHAIN)


def test_what_rows_do_not_hold_is_compared_at_the_end(ring):
    whole, part = smidgen.run(ring, what=["energy", "momentum", "casimirs"], every=1), smidgen.run(ring, what=["energy"], every=1)
    assert np.array_equal(whole["energy"], part["energy"]) and np.array_equal(whole["energy.field"], part["energy.field"])
    assert np.array_equal(whole.final, part.final) and "casimirs" not in part.keys()
    assert whole.summary["at_end"] == [] and part.summary["at_end"] == ["momentum", "casimirs"]
    assert part.summary["errors"]["energy"] == whole.summary["errors"]["energy"]
    last = np.abs(whole["casimirs"][-1] - whole["casimirs"][0]).max()
    assert part.summary["errors"]["casimirs"] == last <= whole.summary["errors"]["casimirs"]


@pytest.mark.parametrize("asked", [("energy",), ("energy.field",), ("mz",), ("momentum.w.y",), ()])
def test_what_is_not_asked_for_is_not_computed(ring, asked):
    model = smidgen.build(ring).start("random", h=0.02)
    block = Block(model, False, asked, casimirs=False)
    block.values[:] = np.nan
    assert model.outputs(1, 1, block, 0, 2) == 2
    with_all = {"energy": ("energy", "energy.exchange", "energy.field"), "momentum.w.y": tuple(f"momentum.w.{x}" for x in "xyz")}
    found = {name for name, k in zip(model.columns, range(99)) if np.isfinite(block.values[:2, k]).all()}
    assert found == {name for one in asked for name in with_all.get(one, (one,))}


def compensated(values) -> float:
    """Kahan's sum of the k-th, (k + 16)-th, .. values, and of these sums."""
    def added(sum_, lost, u):
        y = u + lost
        new = sum_ + y
        return new, y - (new - sum_)
    sums = []
    for p in range(PARTS):
        sum_ = lost = 0.0
        for u in [*values[p::PARTS], *([0.0] if len(values) % PARTS and p >= len(values) % PARTS else [])]:
            sum_, lost = added(sum_, lost, u)
        sums += [sum_, lost]
    sum_ = lost = 0.0
    for u in sums:
        sum_, lost = added(sum_, lost, u)
    return sum_ + lost


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize("n", [3, 32, 300])
def test_the_order_of_a_sum(ring, n, native):
    """Bit for bit what Python adds up in that order: by two lanes, and by as many as this processor has."""
    model = smidgen.build(ring, parameters={"n": n}, native=native).start("random", h=0.02)
    v, w = model.w, np.roll(model.w, -1, axis=0)
    found = dict(zip(model.columns, model.values()))
    assert found["energy.exchange"] == compensated(-(v[:, 0] * w[:, 0] + v[:, 1] * w[:, 1] + v[:, 2] * w[:, 2]))
    assert found["mz"] == compensated(v[:, 2]) and found["momentum.w.x"] == compensated(v[:, 0])
    assert found["energy"] == found["energy.exchange"] + found["energy.field"] == model.energy()


BONDS = {"forward": ((1, 0), (2, 1), (3, 0)), "backward": ((-1, 0), (-2, 1)), "both": ((-1, 0), (2, -1), (1, 1)), "across": ((0, 1), (0, -1))}
LATTICE = """[model]
name = "cells"
[space]
w = {{ sphere = "2*nx*ny" }}
[parameters]
nx = 5
ny = 4
[lattices.cells]
size = ["nx", "ny"]
boundary = {boundary}
sites = 2
bonds.all = [{bonds}]
[effects.joined]
over = "bond(i, j) of cells"
energy = "-dot(w[i], w[j]) + 0.3*w[i].x*w[j].y"
[starts.random]
random = 1
[runs.demo]
start = "random"
h = 0.05
steps = 1
"""


@pytest.mark.parametrize("which, boundary", [*itertools.product(BONDS, ['["periodic", "open"]', '["open", "periodic"]'])])
def test_every_bond_is_counted_once(which, boundary):
    """Bonds over the ends of rows, forward and backward, have loops of their own."""
    listed = ", ".join(f"{{ from = 0, to = 1, offset = [{x}, {y}] }}" for x, y in BONDS[which])
    spec = smidgen.load_text(LATTICE.format(boundary=boundary, bonds=listed))
    for nx in (5, 4):
        model = smidgen.build(spec, parameters={"nx": nx}).start("random", h=0.05)
        expected = Witness(spec, parameters={"nx": nx}).energy(model.w)
        assert abs(model.energy() - expected) <= 1e-13
