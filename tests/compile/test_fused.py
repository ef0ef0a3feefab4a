"""No product is fused with a sum: libraries are disassembled and looked through. They have the bits of every other build."""
import random
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import smidgen
from smidgen.build import binary
from smidgen.errors import UsageError
from fuzz.differential import read
from support.random_specs import random_spec
from test_set_state import LAYOUTS

FUSED = re.compile(r"\bvfn?m(?:add|sub)\w*|\bfn?m(?:add|sub|la|ls)\b")
TILTED = """
[model]
name = "tilted"
[space]
w = { sphere = 27 }
[effects.exchange]
over = "bond(i, j) of square(3, 9, periodic, open)"
energy = "-dot(w[i], w[j])"
[effects.anisotropy]
over = "site(i) of w"
energy = "(w[i].x - 0.032*w[i].y - 0.78*w[i].z)^2"
[starts.random]
random = 1
"""
METHODS = ["spherical-midpoint", "gauss-4", "dop853", "sublattice-rotations", "extrapolation-12"]
compilers = pytest.mark.parametrize("compiler", [pytest.param(name, marks=pytest.mark.skipif(not shutil.which(name), reason=f"no {name}")) for name in ("gcc", "clang")])
disassembled = pytest.mark.skipif(not shutil.which("objdump") or " fma " not in Path("/proc/cpuinfo").read_text(), reason="no objdump, or no fused instructions here")


@pytest.fixture
def as_for_users(monkeypatch):
    """Compiled with -O3."""
    monkeypatch.setattr(binary, "FLAGS", (*(f for f in binary.FLAGS if not f.startswith("-O")), "-O3"))


def fused(model) -> set:
    said = subprocess.run(["objdump", "-d", "--no-show-raw-insn", model.built.binary], capture_output=True, text=True, check=True)
    return set(FUSED.findall(said.stdout))


def built(spec, method, **how):
    """None where the method does not serve the spec."""
    try:
        return smidgen.build(spec, method=method, native=True, **how)
    except UsageError:
        return None


def spec_of(seed):
    return smidgen.load_text(TILTED) if seed is None else read(*random_spec(random.Random(seed)))


@disassembled
@compilers
@pytest.mark.usefixtures("as_for_users")
@pytest.mark.parametrize("seed, methods", [(None, METHODS[:1]), (3, ["spherical-midpoint", "dop853"]), (5, ["gauss-4"]),
                                           *(pytest.param(seed, METHODS, marks=pytest.mark.long) for seed in range(100, 130))])
def test_no_product_is_fused_with_a_sum(monkeypatch, compiler, seed, methods):
    monkeypatch.setenv("CC", compiler)
    models = [model for method in methods if (model := built(spec_of(seed), method))]
    assert models and not set().union(*map(fused, models))


@disassembled
@compilers
@pytest.mark.long
@pytest.mark.usefixtures("as_for_users")
@pytest.mark.parametrize("name", ["composed by rows", "classical by rows", "dop853 by rows", "fixed steps by rows", "extrapolation by rows", "responses by site",
                                  "torques by rows", "radii by site", "held sites", "held sites of stages", "other formulas", "growing", "several shells"])
def test_no_way_by_rows_fuses(monkeypatch, compiler, name):
    monkeypatch.setenv("CC", compiler)
    spec, method, _ = LAYOUTS[name]
    assert not fused(smidgen.build(spec, method=method, native=True))


@disassembled
@pytest.mark.usefixtures("as_for_users")
def test_a_fast_build_does_fuse():
    """So the search above finds what it looks for."""
    assert fused(smidgen.build(smidgen.load_text(TILTED), fast=True))


@pytest.mark.usefixtures("as_for_users")
def test_the_same_bits_for_this_processor_and_for_any(monkeypatch):
    ends = []
    for compiler, native in (("gcc", False), ("gcc", None), ("clang", None)):
        if shutil.which(compiler):
            monkeypatch.setenv("CC", compiler)
            ends.append(smidgen.build(smidgen.load_text(TILTED), native=native).start("random", h=0.4, seed=3).steps(10).w.copy())
    assert all(np.array_equal(end, ends[0]) for end in ends)


@pytest.mark.quick
def test_the_flag_is_for_gcc_and_for_processors_that_fuse():
    gcc, clang = ((shutil.which(name),) for name in ("gcc", "clang"))
    if gcc[0]:
        assert binary.unfused(gcc, ("-mfma",)) == binary.UNFUSED and binary.unfused(gcc, ("-mno-fma",)) == ()
        assert binary.unfused(gcc, ("-mfma", "-ffp-contract=fast")) == ()
    if clang[0]:
        assert binary.unfused(clang, ("-mfma",)) == ()
