"""Lattices by rows with absent sites: effects on the same bonds of which some are sums and products alone, and formulas that have no finite value at such a site."""
import numpy as np
import pytest
import smidgen
from smidgen.check.verify.contraction import HISTORY, KEPT
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.by_sites import by_sites
from test_rows import lattice
from test_rows_by_site import MIDPOINT
from test_rows_families import CLOSED, layers
from test_rows_in_time import by_rows

METHODS = (MIDPOINT, "gauss-4", "dormand-prince-8")
EXCHANGE, TWIST, IN_TIME, SHARED = "-0.5*dot({0}[i], {0}[j])", "0.2*triple(vec(0, 0, 1), {0}[i], {0}[j])", "0.1*cos(3*t)*{0}[i].x*{0}[j].x", "0.2*{0}[i].y*{0}[j].y/n"


def effect(name, over, value, word="energy") -> str:
    return f'[effects.{name}]\nover = "{over}"\n{word} = "{value}"\n'


def square(*effects, hole="mod(i, 7) == 3"):
    """6 x 6 sites, some absent; effects: (name, over, value, word), over "bonds" and "sites" of it."""
    over = {"bonds": "bond(i, j) of square(n, 6, periodic)", "sites": "site(i) of w", "row": "bond(i, j) of line.near"}
    return lattice("square", "", 6, "6*n", "".join(effect(name, over[where], value, *word) for name, where, value, *word in (*effects, ("hole", "sites", hole, "absent"))), LINE)


LINE = '[lattices.line]\nsize = ["n", 6]\nboundary = ["periodic", "periodic"]\nbonds.near = [{ offset = [1, 0] }]\n'


def on_bonds(*energies, over="bonds") -> list:
    return [(f"e{n}", over, e.format("w")) for n, e in enumerate(energies)]


def distance(spec, method, features=(), **how) -> float:
    """From the witness, which knows no rows."""
    model = smidgen.build(spec, method=method, features=features, **how).start("random", h=0.05, t0=0.37)
    w = model.w.copy()
    found = Witness(spec).steps(w, 0.37, 0.05, 3, method)
    return np.abs(model.steps(3).w - (found if np.ndim(found) == 2 else found[-1])).max()


JOINED = {"the last in time": square(*on_bonds(EXCHANGE, TWIST, IN_TIME)), "the first in time, one a quotient": square(*on_bonds(IN_TIME, EXCHANGE, SHARED, TWIST)),
          "on some of the bonds": square(*on_bonds(EXCHANGE, TWIST, IN_TIME), ("more", "row", IN_TIME.format("w")), ("twist", "row", TWIST.format("w"))),
          "of two families": layers(*(("bond(i, j) of within.near on " + f, e.format(f)) for f in "ab" for e in (EXCHANGE, TWIST, IN_TIME.replace("j].x", "j].z"))),
                                    ("bond(i of a, j of b) of between.near", "0.3*dot(a[i], b[j])"), ("bond(i of a, j of b) of between.near", "0.1*cos(t)*a[i].x*b[j].y"), ("site(i) of b", "mod(i, 7) == 3", "absent"), boundary=CLOSED)}


@pytest.mark.parametrize("name, method", [*((n, MIDPOINT) for n in JOINED), *(("the last in time", m) for m in METHODS[1:]), *(pytest.param(n, m, marks=pytest.mark.long) for n in [*JOINED][1:] for m in METHODS[1:])])
def test_effects_on_the_same_bonds(name, method):
    assert by_rows(JOINED[name], method) and distance(JOINED[name], method) <= 2e-14


# Terms with several ends that differ from bond to bond, and such that do not vanish where one of their spins is 0

SHAPES = ('[lattices.line]\nsize = ["n", 6]\nboundary = ["periodic", "open"]\nbonds.near = [{ at = [[0, -1, 0], [0, 0, 0], [0, 1, 0]] }]\n'
          '[lattices.plaquettes]\nsize = ["n", 6]\nboundary = ["periodic", "open"]\nbonds.all = [{ at = [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]] }]\n')
THREE, FOUR, PAIRS = "bond(i, j, k) of line.near", "bond(i, j, k, l) of plaquettes.all", "bond(i, j) of square(n, 6, periodic, open)"
CURRENT = "cross(w[j], cross(w[j], w[k] - w[i]))"
HOLES = ("holes", "site(i) of w", "uniform(4, i) < 0.2", "absent")
ENDED = {
    "three ends": (("chiral", THREE, "0.3*normal(1, j)*triple(w[i], w[j], w[k])"),), "numbers of bonds": (("chiral", THREE.replace("k)", "k, b)"), "0.3*normal(1, b)*triple(w[i], w[j], w[k])"),),
    "ring exchange": (("ring", FOUR, "0.1*uniform(2, i, k)*(dot(w[i], w[j])*dot(w[k], w[l]) + dot(w[j], w[k])*dot(w[i], w[l]))"), HOLES),
    "a current": (("current", THREE, f"0.2*(1 + mod(j, 3))*{CURRENT}", "torque", "w[j]"),), "a current around holes": (("current", THREE, f"0.3*cos(t)*{CURRENT}", "torque", "w[j]"), HOLES),
    "squares": (("stretched", PAIRS, "0.2*dot(w[i] - w[j], w[i] - w[j])"), HOLES), "squares in time": (("stretched", PAIRS, "0.2*cos(t)*uniform(1, i, j)*dot(w[i] - w[j], w[i] - w[j])"), HOLES)}


def of_ends(name):
    """With exchange; `on` a vector where a torque says which."""
    effects = "".join(effect(called, over, value, *word) if len(word) < 2 else effect(called, over, value, "torque") + f'on = "{word[1]}"\n' for called, over, value, *word in ENDED[name])
    return lattice("ends", "", 8, "6*n", effect("exchange", PAIRS, "-0.5*dot(w[i], w[j])") + effects, SHAPES)


@pytest.mark.parametrize("name, method", [*((n, MIDPOINT) for n in ("a current around holes", "squares in time")), ("three ends", "gauss-4"),
                                          *(pytest.param(n, m, marks=pytest.mark.long) for n in ENDED for m in METHODS if (n, m) not in (("a current around holes", MIDPOINT), ("squares in time", MIDPOINT), ("three ends", "gauss-4")))])
def test_terms_with_several_ends(name, method):
    assert by_rows(of_ends(name), method) and distance(of_ends(name), method) <= 2e-14


TWO_FAMILIES = """
[model]
name = "two"
[space]
a = { sphere = "n" }
b = { sphere = "n", kappa = 2 }
[parameters]
n = 12
[lattices.line]
size = ["n"]
boundary = "open"
bonds.three = [{ at = [[0, -1], [0, 0], [0, 1]] }]
bonds.near = [{ offset = [1] }]
bonds.up = [{ offset = [0] }, { offset = [1] }]
[effects.within_a]
over = "bond(i, j) of line.near on a"
energy = "-dot(a[i], a[j])"
[effects.within_b]
over = "bond(i, j) of line.near on b"
energy = "-0.5*dot(b[i] - b[j], b[i] - b[j])*(1 + 0.2*uniform(2, i, j))"
[effects.mixed]
over = "bond(i of a, j of b, k of a) of line.three"
energy = "0.3*normal(1, j)*(1 + mod(i, 3))*triple(a[i], b[j], a[k])"
[effects.push]
over = "bond(i of a, j of b) of line.up"
on = "b[j]"
torque = "0.2*cos(t)*(1 + mod(i, 2))*cross(b[j], cross(b[j], a[i]))"
[effects.holes]
over = "site(i) of a"
absent = "uniform(4, i) < 0.2"
[starts.random.a]
random = 1
[starts.random.b]
random = 2
"""


@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m == MIDPOINT else pytest.mark.long) for m in METHODS])
@pytest.mark.parametrize("edge", ["open", pytest.param("periodic", marks=pytest.mark.long)])
def test_ends_of_two_families(edge, method):
    spec = smidgen.load_text(TWO_FAMILIES.replace('"open"', f'"{edge}"'))
    assert by_rows(spec, method) and distance(spec, method) <= 2e-14


# Formulas that are infinite at site 3, which is absent

BETWEEN = ("bond(i of a, j of b) of between.near", "(0.3 + 0.1/abs(i - 3))*dot(a[i], b[j])")
INFINITE = {
    "a field": square(*on_bonds(EXCHANGE), ("field", "sites", "0.5/(i - 3)*w[i].z"), hole="i == 3"), "bonds": square(*on_bonds("-0.5*(1 + 0.1/abs(i - 3) + 0.1/abs(j - 3))*dot(w[i], w[j])"), hole="i == 3"),
    "in time": square(*on_bonds(EXCHANGE, "0.1*cos(t*log(abs(i - 3)))*w[i].x*w[j].z"), ("axis", "sites", "0.2*cos(t/(i - 3))*w[i].z^2"), hole="i == 3"),
    "damped": square(*on_bonds(EXCHANGE), ("axis", "sites", "0.3*log(abs(i - 3))*w[i].x^2"), ("damping", "sites", "0.1*(1 + mod(i, 2))", "damping"), hole="i == 3"),
    "two families": layers(BETWEEN, ("bond(i, j) of within.near on b", "-0.5*dot(b[i], b[j])"), ("site(i) of a", "0.5/(i - 3)*a[i].z"), ("site(i) of b", "0.1*mod(i, 3)*b[i].x"), ("site(i) of a", "i == 3", "absent"), a=', radius = "1 + mod(i, 2)"')}


@pytest.mark.parametrize("name, method", [*((n, MIDPOINT) for n in INFINITE), ("a field", "gauss-4"), ("bonds", "dormand-prince-8"),
                                          *(pytest.param(n, m, marks=pytest.mark.long) for n in INFINITE for m in METHODS[1:] if (n, m) not in (("a field", "gauss-4"), ("bonds", "dormand-prince-8"), ("two families", "gauss-4")))])
def test_formulas_that_are_infinite_at_an_absent_site(name, method):
    assert by_rows(INFINITE[name], method) and distance(INFINITE[name], method) <= 2e-14


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n == "bonds" else pytest.mark.long) for n in INFINITE])
def test_steps_of_any_such_state_go_by_rows(name):
    """The bounds are those of the sites that are there. Steps by rows keep less of their history."""
    model = smidgen.build(INFINITE[name]).start("random", h=0.02).steps(KEPT + 1)
    assert model.save()[HISTORY] < KEPT


@pytest.mark.parametrize("name", ["in time", pytest.param("two families", marks=pytest.mark.long)])
def test_the_tangent_map(name):
    ends = []
    for build in (smidgen.build, by_sites):
        model = build(INFINITE[name], features=("tangent",)).start("random", h=0.05, t0=0.37).steps(2)
        ends.append(model.tangent(np.random.default_rng(2).standard_normal((1, *model.w.shape))))
    assert np.abs(ends[0] - ends[1]).max() <= 1e-14


@pytest.mark.long
def test_states_in_parts_have_the_same_bits():
    ends = [smidgen.build(INFINITE["bonds"], features=some).start("random", h=0.05).steps(4).w.copy() for some in ((), ("distributed",))]
    assert np.array_equal(*ends)


ROOTS = {"in time": ("0.3*sqrt(i - 3 + 0.1*t)*w[i].z", "i <= 3"), "of vectors": ("0.2*sqrt(w[i].x^2 + w[i].y^2)", "i == 3"), "a remainder": ("0.2*mod(t, i - 3)*w[i].z", "i == 3"), "a logarithm": ("0.2*(2 + log(i - 3 + 0.1*t)/5)*w[i].z", "i <= 3")}


@pytest.mark.parametrize("name, method", [("in time", MIDPOINT), ("of vectors", "gauss-4"), pytest.param("a remainder", "dormand-prince-8", marks=pytest.mark.long), pytest.param("a logarithm", "dormand-prince-8", marks=pytest.mark.long)])
def test_where_0_has_no_value_steps_go_site_by_site(name, method):
    """At negative times no number in the place of an absent site gives a root."""
    energy, hole = ROOTS[name]
    spec = square(*on_bonds(EXCHANGE), ("root", "sites", energy), hole=hole)
    assert not by_rows(spec, method) and generate(spec, method=method).notes["reason"].endswith("because the field of `root` may be infinite where one of its spins is 0, but some sites are absent")
    model = smidgen.build(spec, method=method).start("random", h=0.05, t0=-0.5)
    w = model.w.copy()
    found = Witness(spec).steps(w, -0.5, 0.05, 3, method)
    assert np.abs(model.steps(3).w - (found if np.ndim(found) == 2 else found[-1])).max() <= 2e-14


@pytest.mark.parametrize("energy", ["0.2*log(2 + w[i].z)", "0.2*w[i].z/(1 + exp(t*i))", "0.1*cos(i*t + 1)*w[i].z^2", "0.1*mod(i + t, 3)*w[i].z"])
def test_other_formulas_go_by_rows(energy):
    assert by_rows(square(*on_bonds(EXCHANGE), ("more", "sites", energy)), "gauss-4")
