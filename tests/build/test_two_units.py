"""A library is compiled in two units side by side, with the bits of one."""
import numpy as np
import pytest
import smidgen

from smidgen.build import binary
from smidgen.build.binary import build_library
from smidgen.compile.select import select

SPEC = """[model]
name = "{name}"
[space]
w = {{ sphere = {sites} }}
[effects.exchange]
over = "{over}"
energy = "-dot(w[i], w[j])"
[starts.s]
random = 1
"""
# Rows at steps that sweeps solve, and at those that Newton and the curve take over; few sites in lanes.
CASES = {"lattice": (60, "bond(i, j) of square(6, 10, periodic)", (0.1, 0.6)), "few": (4, "pair(i, j) of w", (0.1, 0.6))}


def spec_of(name):
    sites, over, _ = CASES[name]
    return smidgen.load_text(SPEC.format(name=name, sites=sites, over=over))


def states(name):
    """After some steps of each size, of a library compiled with the flags of the moment."""
    model = smidgen.build(spec_of(name))
    return [model.start("s", h=h).steps(5).w.copy() for h in CASES[name][2]], model.values()


@pytest.mark.parametrize("name", CASES)
def test_two_units_have_the_bits_of_one(name, monkeypatch, tmp_path):
    commands, ran = [], binary.ran
    monkeypatch.setattr(binary, "ran", lambda command, *rest, **more: commands.append(list(command)) or ran(command, *rest, **more))
    ends = {}
    for units in (2, 1):
        monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / str(units)))
        if units == 1:
            compile_shared = binary.compile_shared
            monkeypatch.setattr(binary, "compile_shared", lambda *given: compile_shared(*given[:4], 1))
        ends[units] = states(name)
    second, = (command for command in commands if "-DSMG_UNIT=2" in command)
    assert ("-O2" in second) == (name == "lattice")
    assert all(np.array_equal(a, b) for a, b in zip(ends[1][0], ends[2][0])) and np.array_equal(ends[1][1], ends[2][1])


@pytest.mark.quick
def test_what_cannot_be_parted_is_one_unit(monkeypatch):
    asked = []
    monkeypatch.setattr(binary, "compile_shared", lambda work, sources, compiler, flags, units, second: asked.append(units) or (work / binary.LIBRARY).touch())
    spec = select(spec_of("few"))
    for how in ({}, {"features": ("tangent",)}, {"method": "gauss-4"}):
        build_library(spec, defines=("-DUNLIKE_OTHERS",), **how)
    assert asked == [2, 1, 1]
