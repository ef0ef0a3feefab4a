"""Kernels in lanes (runtime/core/smg_lanes.h): however many states a vector holds, the same bits; clean C for every compiler."""
import random

import numpy as np
import pytest
import smidgen
from smidgen.run.step.evaluated import parameter_values
from smidgen.compile.emit.emit import generate
from fuzz.differential import random_state, read
from support.random_specs import random_spec
from support.strict import COMPILERS, MODES, compile_all

FUNCTIONS = """
[model]
name = "functions"
[space]
w = { sphere = 3 }
v = { r3 = 2 }
[parameters]
a = 0.75
b = { default = 0.3, size = 3 }
[effects.smooth]
over = "site(i) of w"
energy = "exp(a*w[i].x) + (1 + 0.1*w[i].z)*log(2 + w[i].y) + sin(w[i].z)*cos(w[i].x) + tan(w[i].y/2) + b[i]*sqrt(2 + w[i].z) + (2 + w[i].x)^1.3 + i*w[i].z"
[effects.pieces]
over = "each(i of w, j of v)"
energy = "0.1*abs(dot(w[i], v[j])) + max(w[i].x, v[j].y) + min(w[i].z*v[j].z, a) + if(w[i].x > v[j].x and not w[i].y == 2, w[i].x*v[j].y, -w[i].y^3)"
[effects.logic]
over = "site(i) of v"
energy = "if(a > 0.5 or v[i].x < v[i].y, floor(v[i].x)*v[i].y, v[i].z^2) + if(a > 1, v[i].x, 2)*v[i].z^3"
[effects.more]
over = "site(i) of v"
energy = "v[i].x^2/2 + v[i].y^2*(1 + atan(v[i].z)) + (1 + 0.1*v[i].y)*asin(v[i].x/4) + (1 + 0.1*v[i].z)*acos(v[i].y/9) + cosh(v[i].y) + tanh(v[i].z)*sinh(v[i].x) + (1 + v[i].x^2)^(3/2) + (1 + 0.1*v[i].z)*atan2(v[i].y, 3 + v[i].x)"
[effects.constant]
over = "site(i) of w"
energy = "b[i]*w[i].x"
[starts.a.w]
theta = "1 + i/2"
phi = "i"
[starts.a.v]
vectors = [[0.3, 0.4, -0.5], [0.9, -0.1, 0.2]]
"""
SPECS = {"functions": (smidgen.load_text(FUNCTIONS), "a", 0.05), "free body": (smidgen.load("free_rigid_body"), "paper", 1.0),
         "vortices": (smidgen.load("point_vortices"), "four", 0.5), "tracers": (smidgen.load("vortex_tracers"), "ring", 0.3),
         "chain": (smidgen.load("heisenberg_chain"), None, 0.1), "lattice": (smidgen.load("cubic_lattice"), None, 0.1)}


def built(monkeypatch, spec, method, lanes, compiler="gcc"):
    monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
    return smidgen.build(spec, method=method)


def saved(model, start, h, steps=12):
    """All that decides later bits, after some steps; and how many iterations the last took."""
    state = model.start(start, h=h).steps(steps)
    return state.save(), state.report()["iterations"]


@pytest.mark.parametrize("method, widths", [pytest.param("gauss-4", (2,), marks=pytest.mark.long), ("gauss-6", (2, 4)),
                                             pytest.param("gauss-12", (2, 4, 8), marks=pytest.mark.long), ("gauss-16", (2, 8))])
@pytest.mark.parametrize("name", ["functions", "vortices", *(pytest.param(n, marks=pytest.mark.long) for n in SPECS if n not in ("functions", "vortices"))])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, method, widths):
    spec, start, h = SPECS[name]
    start = start or spec.runs[0].start
    wanted = saved(built(monkeypatch, spec, method, 1), start, h)
    for lanes in widths:
        found = saved(built(monkeypatch, spec, method, lanes), start, h)
        assert found[1] == wanted[1] and np.array_equal(found[0], wanted[0])


@pytest.mark.parametrize("method, widths", [("gauss-6", (4,)), pytest.param("gauss-16", (2, 4, 8), marks=pytest.mark.long)])
def test_few_sites_in_registers_have_the_bits_of_one_lane(monkeypatch, method, widths):
    """Of one to four sites, whose number is known at run time alone, and of five, which are in memory; to round-off and to a tolerance."""
    spec, given = smidgen.load("point_vortices"), {n: {"n": n, "gamma": np.linspace(1, 0.5, n)} for n in (1, 2, 3, 4, 5)}

    def states(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        for values in given.values():
            model = smidgen.build(spec, method=method, parameters=values)
            yield from (model.start("spiral", h=0.4, tolerance=tolerance).steps(9).save() for tolerance in (None, 1e-9))

    wanted = list(states(1))
    assert len(wanted) == 10 and all(np.array_equal(*both) for lanes in widths for both in zip(wanted, states(lanes), strict=True))


UNREAL = """
[model]
name = "unreal"
[space]
w = {{ sphere = {n} }}
[effects.root]
energy = "sqrt(-2 - w[1].x)^3"
[effects.coupling]
energy = "dot(w[0], w[2])"
[starts.a]
theta = "1 + i/2"
phi = "i"
"""


@pytest.mark.parametrize("tolerance", [None, 1e-8])
@pytest.mark.parametrize("n", [3, 6])
def test_one_field_among_others_that_is_no_number_is_told(n, tolerance):
    """That of a site that is neither the first nor the last: in registers and in memory."""
    model = smidgen.build(smidgen.load_text(UNREAL.format(n=n)), method="gauss-6").start("a", h=0.1, tolerance=tolerance)
    before = model.state()
    assert model.advance(1) == 0 and model.report()["site"] == 1 and np.array_equal(model.state(), before)


@pytest.mark.parametrize("compiler", [pytest.param("clang", marks=pytest.mark.skipif("clang" not in COMPILERS, reason="no clang"))])
def test_another_compiler_has_them_too(monkeypatch, compiler):
    """Where no function of the C library is called."""
    spec, start, h = SPECS["free body"]
    wanted = saved(built(monkeypatch, spec, "gauss-12", 1), start, h)
    assert np.array_equal(saved(built(monkeypatch, spec, "gauss-12", 8, compiler), start, h)[0], wanted[0])


@pytest.mark.parametrize("seed", [8, *(pytest.param(seed, marks=pytest.mark.long) for seed in (4, 10, 18, 22, 24))])
def test_random_hamiltonians_have_the_same_bits(monkeypatch, seed):
    """Of those seeds whose H does not depend on time, on spheres and R^3; where a step is refused, it is the same step."""
    spec = read(*random_spec(random.Random(seed)))
    assert "SMG_HAS_LANES" in generate(spec, method="gauss-6")[f"{spec.name}.c"]
    models = [built(monkeypatch, spec, "gauss-6", lanes) for lanes in (1, 4)]
    values = parameter_values(spec, None)
    found = [taken(model, random_state(spec, values, np.random.default_rng(seed))) for model in models]
    assert found[0][0] == found[1][0] and np.array_equal(found[0][1], found[1][1])


def taken(model, w):
    """(number of steps that were taken, all that decides later bits)."""
    model.start(w, h=0.02)
    return model.advance(8), model.save()


@pytest.mark.parametrize("lanes", [1, 2, pytest.param(8, marks=pytest.mark.long)])
@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode, lanes):
    for name, text in generate(SPECS["functions"][0], method="gauss-12", amalgamate=True).items():
        (tmp_path / name).write_text(text)
    assert not compile_all(tmp_path, ["functions.c"], compiler, "-Wno-psabi", f"-DSMG_LANES={lanes}", how=mode)
