"""One build serves all values that lead to one plan: sizes, steps, lists of any length, texts; and its bits are those of
a build for that size alone."""
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
import smidgen
from smidgen.build.binary import build_library, split_notes
from smidgen.compile.emit.emit import generate
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import scene_of
from smidgen.run.step.evaluated import Evaluated
from smidgen.run.step.start import initial_state

BUILD = import_module("smidgen.build.binary")
HEAD = '[model]\nname = "many"\n[space]\n'
CHAIN = HEAD + """w = { sphere = "n" }
[parameters]
n = 8
J = { default = 1.0, unit = "meV", meaning = "exchange" }
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j])"
[observables.mz]
over = "site(i) of w"
value = "w[i].z/n"
[starts.any]
random = 1
"""
VORTICES = HEAD + """w = { sphere = "n", kappa = "gamma[i]" }
[parameters]
n = 3
gamma = { default = 1.0, size = "n" }
[effects.interaction]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]*log(3 - 2*dot(w[i], w[j]))"
[starts.any]
random = 2
"""
LATTICE = HEAD + """w = { sphere = "nx*ny" }
[parameters]
nx = 4
ny = 5
K = { default = 0.2, size = "nx" }
[effects.exchange]
over = "bond(i, j) of square(nx, ny, periodic)"
energy = "-dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-K[0]*w[i].z^2*mod(floor(i/nx), 2)"
[starts.any]
random = 3
"""
TRACERS = HEAD + """w = { sphere = "n" }
p = { sphere = "m", tracer = true, kappa = "1 + i/m" }
[parameters]
n = 3
m = 4
A = { default = 0.5, size = "n*m + 1" }
[effects.vortices]
over = "pair(i, j) of w"
energy = "-log(3 - 2*dot(w[i], w[j]))"
[effects.transport]
over = "each(i of p, j of w)"
energy = "-A[i + m*j]*dot(p[i], w[j])"
[starts.any.w]
random = 4
[starts.any.p]
random = 4
"""
ALONE = HEAD + """w = { r3 = "n", kappa = "2 - i/n" }
[parameters]
n = 3
A = { default = [0.3, 0.5, 0.7], size = "n" }
[effects.own]
over = "site(i) of w"
energy = "A[i]*w[i].x^2 + w[i].z"
[starts.any]
random = 5
"""
GLASS = HEAD + """w = { sphere = "n" }
[parameters]
n = 14
[graphs.g]
file = "edges.csv"
[effects.glass]
over = "edge(i, j, K) of g"
energy = "-K*dot(w[i], w[j])"
[starts.any]
random = 6
"""


def list_of(n):
    return [0.5 + 0.1*k for k in range(n)]


# text, values that one plan serves, values that call for another plan
FAMILIES = {
    "chain": (CHAIN, [{"n": n, "J": 1 + n/10} for n in (8, 3, 5, 50, 9)], [{"n": 2}]),
    "all pairs": (VORTICES, [*({"n": n} for n in (3, 4, 20)), {"n": 5, "gamma": list_of(5)}], [{"n": 301}]),
    "lattice": (LATTICE, [{"nx": 4, "ny": 5}, {"nx": 7, "ny": 3, "K": list_of(7)}, {"nx": 3, "ny": 9}], [{"nx": 3, "ny": 3}]),
    "tracers": (TRACERS, [{"n": 3, "m": 4}, {"n": 6, "m": 1}, {"n": 2, "m": 5, "A": list_of(11)}], [{"n": 301, "m": 1}]),
    "alone": (ALONE, [{"n": n, "A": list_of(n)} for n in (3, 1, 30)], []),
    "graph": (GLASS, [{"n": 14}], [{"n": 15}, {"n": 16}]),
}


@pytest.fixture(autouse=True)
def compilations(tmp_path, monkeypatch):
    """An empty cache, a graph, and the list of what the compiler was called for; it does not optimise, for speed."""
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(BUILD, "FLAGS", ("-std=c11", "-O0", "-ffp-contract=off"))
    made, compile_shared = [], BUILD.compile_shared

    def counted(work, *more):
        made.append(work)
        compile_shared(work, *more)

    monkeypatch.setattr(BUILD, "compile_shared", counted)
    (tmp_path / "edges.csv").write_text("".join(f"{k}, {(k + 1) % 14}, {k + 1}\n{k}, {(k + 5) % 14}, 0.5\n" for k in range(14)))
    return made


@pytest.fixture
def read(tmp_path):
    def load(text):
        (tmp_path / "many.toml").write_text(text)
        return smidgen.load(tmp_path / "many.toml")
    return load


def trivial(*_):
    """In place of the generator."""
    return {"many_abi.c": "int nothing;\n"}, {}


@pytest.mark.quick
@pytest.mark.parametrize("name", FAMILIES)
def test_one_build_for_one_plan(name, read, compilations):
    text, values, others = FAMILIES[name]
    spec = read(text)
    for given in values:
        build_library(scene_of(spec, None, given), generate=trivial)
        assert len(compilations) == 1
    for k, given in enumerate(others):
        build_library(scene_of(spec, None, given), generate=trivial)
        assert len(compilations) == 2 + k


def test_runs_of_any_size_and_step_share_a_build(read, compilations):
    spec = read(VORTICES + '[runs.r]\nstart = "any"\nh = 0.1\nsteps = 4\n')
    for n, h in ((3, 0.1), (4, 0.1), (4, -0.02), (9, 0.05)):
        result = smidgen.run(spec, h=h, steps=2, parameters={"n": n, "gamma": list_of(n)})
        assert result.w["w"].shape == (3, n, 3)
    assert len(compilations) == 1


@pytest.mark.parametrize("name", FAMILIES)
def test_the_bits_are_those_of_a_build_of_its_own(name, read, compilations, tmp_path, monkeypatch):
    """The library made for the first size, used for the last; against the C that `smidgen gen` writes for the last."""
    text, values, _ = FAMILIES[name]
    spec = read(text)
    shared = [smidgen.build(spec, parameters=given) for given in values][-1]
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "own"))
    scene = scene_of(spec, None, values[-1])
    own = build_library(scene, generate=lambda *given: split_notes(generate(*given[:3], features=given[3])))
    assert own.binary != shared.built.binary and len(compilations) == 2
    own = Integrator(shared.prepared, own)
    assert own.notes == shared.notes
    assert np.array_equal(*(model.start("any", h=0.05).steps(20).w for model in (shared, own))) and np.array_equal(shared.values(), own.values())


CHANGES = {"a comment": ("[parameters]", "# one more\n[parameters]"), "a title": ("[space]", 'title = "T"\n[space]'),
           "a meaning": ('"exchange"', '"coupling"'), "a unit": ('"meV"', '"K"'), "a default": ("default = 1.0", "default = 2.0"),
           "a start": ("[starts.any]", "[starts.up]\ntheta = 0.1\nphi = 0\n[starts.any]"), "a size": ("n = 8", "n = 80"),
           "a run": ("[starts.any]", '[runs.r]\nstart = "any"\nh = 0.1\nsteps = 3\n[starts.any]')}


@pytest.mark.quick
@pytest.mark.parametrize("change", CHANGES)
def test_a_change_of_the_text_that_no_step_sees_is_no_build(change, read, compilations):
    build_library(scene_of(read(CHAIN)), generate=trivial)
    assert CHAIN.replace(*CHANGES[change]) != CHAIN
    build_library(scene_of(read(CHAIN.replace(*CHANGES[change]))), generate=trivial)
    assert len(compilations) == 1


REAL_CHANGES = {"an energy": ("-J*dot", "-2*J*dot"), "a compiled value": ("default = 1.0", "default = 1.0, fixed = true"),
                "an observable": ("w[i].z/n", "w[i].x/n"), "ends": ("periodic", "open"), "a strength": ('"n" }', '"n", kappa = 2 }')}


@pytest.mark.quick
@pytest.mark.parametrize("change", REAL_CHANGES)
def test_a_change_that_a_step_sees_is_another_build(change, read, compilations):
    build_library(scene_of(read(CHAIN)), generate=trivial)
    build_library(scene_of(read(CHAIN.replace(*REAL_CHANGES[change]))), generate=trivial)
    assert len(compilations) == 2


@pytest.mark.parametrize("name, given", [("chain", {"n": 2}), ("graph", {"n": 15}), ("graph", {"n": 13})])
def test_a_size_that_the_plan_does_not_serve_is_refused(name, given, read):
    """By the C itself: the library of the default size, called with another one."""
    spec = read(FAMILIES[name][0])
    model = smidgen.build(spec)
    wrong = Integrator(replace(model.prepared, numbers=Evaluated(spec, given)), model.built)
    with pytest.raises(smidgen.RunError, match="bad parameter"):
        wrong.start(initial_state(spec, "any", given), h=0.1)
