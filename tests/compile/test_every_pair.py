"""Every method with every feature, over every layout: clean C, or a refusal in a sentence."""
import itertools

import pytest
from support import texts
from support.features import ANYWHERE, DIVIDED
from support.strict import compile_all
from support.systems import load

from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.compile.features import EVERYWHERE, FEATURES
from smidgen.compile.select import select
from smidgen.errors import UsageError
from smidgen.methods import METHODS

# A single sphere; few sites in lanes; chains and lattices by rows; a graph; sites of several families, tracers, R^3 and Nambu factors.
SHIPPED = ("free_rigid_body", "point_vortices", "heisenberg_chain", "honeycomb", "cubic_lattice", "vortex_tracers", "product", "nambu_a34")
LAWS = """
[model]
name = "laws"
[space]
w = { sphere = "n*n", radius = "1 + 0.1*mod(i, 2)", kappa = "1 - 0.2*mod(i, 3)" }
[parameters]
n = 6
[effects.exchange]
over = "bond(i, j) of square(n, n, open)"
energy = "-dot(w[i], w[j])"
[effects.friction]
over = "site(i) of w"
damping = "0.1*mod(i, 3)"
{kT}
[effects.push]
over = "site(i) of w"
torque = "0.1*cross(w[i], vec(0, 0, 1 + w[i].x^2))"
[effects.rim]
over = "site(i) of w"
pinned = "i < n"
[effects.hole]
over = "site(i) of w"
absent = "i == 20"
[starts.a]
random = 1
"""
TEXTS = {"glass": texts.GLASS, "open": texts.OPEN_CHAIN, "laws": LAWS.replace("{kT}", ""), "warm": LAWS.replace("{kT}", 'kT = "0.2 + 0.1*mod(i, 2)"')}
# One method of each kind of step, where it goes in another way than elsewhere.
TELLING = [("honeycomb", "gauss-8"), ("honeycomb", "spherical-midpoint"), ("honeycomb", "sublattice-rotations"), ("honeycomb", "spherical-midpoint-4"),
           ("heisenberg_chain", "pair-rotations-4"), ("heisenberg_chain", "dop853"), ("heisenberg_chain", "isospectral-midpoint"),
           ("free_rigid_body", "moser-veselov-4"), ("free_rigid_body", "gauss-8"), ("free_rigid_body", "axis-splitting"), ("free_rigid_body", "extrapolation-12"),
           ("point_vortices", "spherical-midpoint"), ("point_vortices", "cf4"), ("vortex_tracers", "classical-midpoint"), ("vortex_tracers", "gauss-4"),
           ("free_rigid_body", "dormand-prince-8")]
RESPONDING = (("laws", "spherical-midpoint"), ("warm", "spherical-midpoint"),
              *(pytest.param(*pair, marks=pytest.mark.long) for pair in (("laws", "gauss-4"), ("laws", "classical-midpoint"), ("laws", "spherical-midpoint-4"),
                                                                        ("laws", "dop853"), ("laws", "extrapolation-12"), ("warm", "spherical-midpoint-4"), ("warm", "heun"))))


def layout(name, where):
    return load(name) if name in SHIPPED else texts.read(TEXTS[name], where)


def features_of(method, which=FEATURES) -> tuple:
    """Those among `which` that some model of the method can have: only midpoints of several spheres are divided among ranks."""
    divided = METHODS[method].midpoint and not METHODS[method].free_body
    return tuple(f for f in (*METHODS[method].features, *EVERYWHERE) if f in which and (divided or f != "distributed"))


def complaints(spec, method, features, where, compiler="gcc"):
    """What the compiler says of the C, '' when all is well; None where there is no such integrator."""
    try:
        files = generate(select(spec), method=method, features=features)
    except UsageError as refusal:
        assert str(refusal).startswith(("method", "feature", "the feature", "solver")) and "\n" not in str(refusal)
        return None
    write_files(files, where)
    return compile_all(where, sorted(name for name in files if name.endswith(".c")), compiler)


@pytest.mark.parametrize("name, method", TELLING)
def test_a_layout_with_all_features_at_once(name, method, tmp_path):
    assert complaints(layout(name, tmp_path), method, features_of(method, ANYWHERE), tmp_path) == ""


@pytest.mark.parametrize("name, method", RESPONDING)
def test_damped_pushed_and_held_sites_with_each_feature(name, method, tmp_path):
    spec = layout(name, tmp_path)
    found = [complaints(spec, method, some, tmp_path) for some in ((), *((f,) for f in features_of(method)))]
    assert found[0] == "" and set(found) <= {"", None}


@pytest.mark.parametrize("method", ["spherical-midpoint", pytest.param("classical-midpoint", marks=pytest.mark.long)])
def test_a_divided_lattice_with_all_other_features_at_once(method, tmp_path):
    assert complaints(load("honeycomb"), method, features_of(method, DIVIDED), tmp_path) == ""


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_every_feature_of_a_method_over_all_layouts(method, tmp_path):
    """None, each alone (not of compositions, which add the same loop to all), and all at once over every layout, by one compiler after the
    other; every feature is compiled somewhere."""
    compilers, compiled = itertools.cycle(("gcc", "clang", "g++", "clang++")), set()
    for name in (*SHIPPED, *TEXTS):
        spec = layout(name, tmp_path)
        alone = [(feature,) for feature in features_of(method) if METHODS[method].stages == 1]
        for features in dict.fromkeys([(), *alone, *(features_of(method, which) for which in (ANYWHERE, DIVIDED))]):
            said = complaints(spec, method, features, tmp_path, next(compilers))
            assert not said, f"{name} {features}:\n{said[:2000]}"
            compiled |= set(features) if said == "" else set()
    assert compiled == set(features_of(method))


@pytest.mark.long
def test_every_set_of_features(tmp_path):
    """Of the methods that have all of them."""
    for method in (m for m in METHODS if set(features_of(m)) == set(FEATURES) and METHODS[m].midpoint):
        for size, name in itertools.product(range(len(FEATURES) + 1), ("free_rigid_body", "honeycomb", "vortex_tracers")):
            for features in itertools.combinations(FEATURES, size):
                said = complaints(load(name), method, features, tmp_path)
                assert not said, f"{name} {method} {features}:\n{said[:2000]}"
