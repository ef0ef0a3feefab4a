"""Effects on one sublattice, by its name, and bonds between two families: against the witness, against the same system in other words, and by rows."""
import numpy as np
import pytest

import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.by_sites import by_sites
from support.strict import MODES, compile_all
from test_rows_in_time import by_rows

HONEY = """[model]
name = "honey"
[space]
w = {{ sphere = "2*nx*ny" }}
[parameters]
nx = {n}
ny = 4
K = {{ default = {K}, size = "2*nx*ny" }}
[lattices.honey]
size = ["nx", "ny"]
boundary = "periodic"
sites = {sites}
bonds.all = [{{ from = 0, to = 1, offset = [0, 0] }}, {{ from = 0, to = 1, offset = [-1, 0] }}, {{ from = 1, to = 0, offset = [0, 1] }}]
[effects.exchange]
over = "bond(i, j) of honey"
energy = "-dot(w[i], w[j])"
{effects}
[starts.random]
random = 1
[runs.demo]
start = "random"
h = 0.05
steps = 20
"""
NAMED, ON, BY_NUMBER = '["iron", "oxygen"]', "site(i) of honey.oxygen", "if(mod(i, 2) == 1, {}, {})"
KINDS = {   # what an effect on a sublattice is, and the same for all sites with 0 elsewhere
    "energy": ("energy", "-0.7*w[i].z^2", "0"), "by site": ("energy", "-K[i]*w[i].z", "0"), "damping": ("damping", "0.1", "0"), "in time": ("energy", "cos(t)*w[i].x", "0"),
    "torque": ("torque", "0.2*cross(w[i], vec(0.3, 0, 1))", "vec(0, 0, 0)"), "bent": ("torque", "0.2*w[i].z*cross(w[i], vec(0.3, 0, 1))", "vec(0, 0, 0)"),
}
HELD = {"pinned": "mod(i, 3) < 2", "absent": "uniform(1, i) < 0.2"}


def honey(effects, n=6, sites=NAMED):
    K = np.random.default_rng(1).normal(size=8 * n).round(3).tolist()
    return smidgen.load_text(HONEY.format(n=n, K=K, sites=sites, effects=effects))


def effect(over, key, value) -> str:
    return f'[effects.it]\nover = "{over}"\n{key} = "{value}"\n'


def both(kind):
    """The scene with a sublattice by its name, and by the numbers of its sites."""
    if kind in HELD:
        return honey(effect(ON, kind, HELD[kind])), honey(effect("site(i) of w", kind, f"mod(i, 2) == 1 and {HELD[kind]}"))
    key, value, nothing = KINDS[kind]
    return honey(effect(ON, key, value)), honey(effect("site(i) of w", key, BY_NUMBER.format(value, nothing)))


def after(spec, method="spherical-midpoint", steps=8, build=smidgen.build):
    return build(spec, method=method).start("random", h=0.05).steps(steps).w.copy()


def far(spec, method="spherical-midpoint", **given) -> float:
    """From the witness after five steps."""
    model = smidgen.build(spec, method=method).start("random", h=0.05)
    found = Witness(spec).steps(model.w.copy(), 0.0, 0.05, 5, method)[-1]
    return np.abs(model.steps(5).w - found).max()


@pytest.mark.parametrize("kind", [*KINDS, *HELD])
def test_a_sublattice_by_its_name_is_that_by_its_numbers(kind):
    one, other = both(kind)
    assert np.abs(after(one) - after(other)).max() <= 1e-13
    assert far(one) <= 2e-14


@pytest.mark.parametrize("kind", ["energy", "by site", "in time", "pinned", "absent"])
def test_they_go_by_rows(kind):
    spec = both(kind)[0]
    assert by_rows(spec)
    assert np.abs(after(spec) - after(spec, build=by_sites)).max() <= 1e-13


@pytest.mark.parametrize("method", ["gauss-4", "cf4", pytest.param("classical-midpoint", marks=pytest.mark.long), pytest.param("spherical-midpoint-4", marks=pytest.mark.long)])
def test_other_methods_have_them(method):
    assert far(both("by site")[0], method) <= 2e-14


def test_an_observable_of_a_sublattice():
    spec = honey('[observables.mz]\nover = "site(i) of honey.oxygen"\nvalue = "w[i].z"\n')
    model = smidgen.build(spec).start("random", h=0.05)
    assert abs(model.values()[-1] - model.w[1::2, 2].sum()) <= 1e-14 and model.columns[-1] == "mz"


@pytest.mark.parametrize("over, sites, said", [
    ("site(i) of honey.oxigen", NAMED, "no site in a cell of `honey` is called `oxigen`.*\n.*\n.*\n.*did you mean `oxygen`"),
    ("site(i) of honey.oxygen", "2", "give the sites of a cell names"), ("site(i) of honey.oxygen", '["a", "a"]', "have different names"),
    ("site(i) of honey", NAMED, "there is no family `honey`"), ("pair(i, j) of honey.iron", NAMED, "`pair` runs over a family")])
def test_what_is_no_sublattice_is_told(over, sites, said):
    with pytest.raises(smidgen.SpecError, match=said):
        honey(effect(over, "energy", "w[i].z" if "j" not in over else "dot(w[i], w[j])"), sites=sites)


LAYERS = """[model]
name = "layers"
[space]
a = {{ sphere = "nx*ny", kappa = 1.3 }}
b = {{ {b} = "nx*ny"{radius} }}
[parameters]
nx = {n}
ny = 5
J = {{ default = 1.0, size = "nx*ny + (nx - 1)*ny" }}
[lattices.film]
size = ["nx", "ny"]
boundary = ["open", "periodic"]
bonds.up = [{{ offset = [0, 0] }}, {{ offset = [1, 0] }}]
[effects.inner]
over = "bond(i, j) of square(nx, ny, open, periodic) on a"
energy = "-dot(a[i], a[j])"
[effects.joint]
over = "{over}"
energy = "{energy}"
[effects.axis]
over = "site(i) of b"
energy = "-0.3*b[i].z"
{more}
[starts.random]
a = {{ random = 1 }}
b = {{ random = 2 }}
[runs.demo]
start = "random"
h = 0.05
steps = 20
"""
JOINT = "-(J[n] + 0.1*n)*a[i].x*b[j].z + 0.3*triple(vec(0, 0, 1), a[i], b[j])"


def layers(n=4, over="bond(i of a, j of b, n) of film", energy=JOINT, b="sphere", more=""):
    return smidgen.load_text(LAYERS.format(n=n, over=over, energy=energy, b=b, radius=", radius = 2" if b == "sphere" else "", more=more))


def test_the_energy_is_the_sum_over_the_bonds():
    spec, J = layers(), np.random.default_rng(3).normal(size=35)
    model = smidgen.build(spec, parameters={"J": J}, effects=["joint"]).start("random", h=0.05)
    a, b = model.w[:20], model.w[20:]
    ends = [(x + 4 * y, x + dx + 4 * y) for dx in (0, 1) for y in range(5) for x in range(4) if x + dx < 4]
    assert len(ends) == 35
    expected = sum(-(J[n] + 0.1 * n) * a[i, 0] * b[j, 2] + 0.3 * np.cross(a[i], b[j])[2] for n, (i, j) in enumerate(ends))
    assert abs(model.energy() - expected) <= 1e-13 and abs(Witness(spec, parameters={"J": J}).energies(model.w)["joint"] - expected) <= 1e-13


PUSH = '[effects.push]\nover = "bond(i of a, j of b) of film"\ntorque = "0.2*cross(b[j], a[i])"\non = "b[j]"\n'
HOLES = '[effects.holes]\nover = "site(i) of a"\nabsent = "mod(i, 4) == 1"\n'
CASES = {"small": dict(n=3), "large": dict(n=30), "in R^3": dict(b="r3"), "pushed": dict(more=PUSH), "with holes": dict(more=HOLES), "of equal cells": dict(over="bond(i of a, j of b) of square(nx, ny, open, periodic)", energy="dot(a[i], b[j])")}


@pytest.mark.parametrize("case, method", [(c, "spherical-midpoint") for c in CASES] + [("small", m) for m in ("gauss-4", "cf4", "sublattice-rotations", "spherical-midpoint-4")] + [("of equal cells", "gauss-2")])
def test_steps_are_those_of_the_witness(case, method):
    spec = layers(**CASES[case])
    if case == "large":
        model = smidgen.build(spec, method=method).start("random", h=0.02)
        states = [model.w.copy(), model.steps(1).w.copy()]
        assert Witness(spec).residual(*states, 0.0, 0.02) <= 1e-14
    else:
        assert far(spec, method) <= 2e-14


def test_pairs_of_two_families_turn():
    spec, called = layers(energy="J[n]*dot(a[i], b[j])"), ["inner", "joint"]
    model = smidgen.build(spec, method="pair-rotations", effects=called).start("random", h=0.05)
    found = Witness(spec, effects=called).steps(model.w.copy(), 0.0, 0.05, 5, "pair-rotations")[-1]
    assert np.abs(model.steps(5).w - found).max() <= 2e-14


@pytest.mark.parametrize("compiler, how", MODES)
def test_no_compiler_warns(tmp_path, compiler, how):
    for spec in (layers(30, more=PUSH + HOLES), both("by site")[0], layers(over="bond(i of a, j of b) of cubic(nx, ny, 1, open)", energy="dot(a[i], b[j])")):
        files = generate(spec)
        for name, text in files.items():
            (tmp_path / name).write_text(text)
        assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, how=how)


@pytest.mark.parametrize("over, said", [
    ("bond(i of a, j) of film", "either every site of the bond has a family, or none has"), ("bond(i of a, j of b) of film on a", "already name their families"),
    ("bond(i of a, j of a) of film", "a bond must join different sites"), ("bond(i, j) of film on a", "a bond must join different sites"),
    ("bond(i of a, j of c) of film", "there is no family `c`"), ("edge(i of a, j of b) of g", "only `each` and `bond`"), ("bond(i of a, j of b) of square(nx, nx, open)", "`a` has 20")])
def test_what_joins_no_families_is_told(over, said):
    with pytest.raises(smidgen.SpecError, match=said):
        layers(over=over, energy="dot(a[i], b[j])")


def test_what_is_conserved_is_found():
    """a[i].x b[j].z turns a about x and b about z, a . b all of them together."""
    assert "total sum kappa a.x, total sum b.z, energy" in str(smidgen.explain(layers(energy="a[i].x*b[j].z")))
    assert "sum kappa a.z + b.z" in str(smidgen.explain(layers(energy="J[n]*dot(a[i], b[j])"))).replace("sum b.z", "b.z")
    assert "sum" not in str(smidgen.explain(layers()))
