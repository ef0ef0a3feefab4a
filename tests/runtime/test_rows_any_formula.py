"""Lattices by rows whose energies are no quadratic forms: the step that the equation has, and bounds of the Hessian that hold at all states."""
import numpy as np
import pytest
import smidgen
import sympy as sp
from smidgen.compile.assemble.model import Model
from smidgen.compile.assemble.row_bounds import bounds_of_term
from smidgen.compile.derive.derivatives import greater
from smidgen.compile.emit.emit import generate
from smidgen.compile.plan.plan import choose
from support.widths import same_in_lanes
from test_rows import DM, EXCHANGE, HONEY, SKEW, lattice
from test_rows_by_site import close
from test_rows_in_time import MIDPOINT, by_rows, field

CUBIC = "0.1*(w[i].x^4 + w[i].y^4 + w[i].z^4)"
SQUARED = EXCHANGE.replace("-0.7*dot(w[i], w[j])", "-0.5*dot(w[i], w[j]) - 0.1*dot(w[i], w[j])^2").replace("exchange", "squared")
RING = '[effects.ring]\nover = "bond(i, j, k, l) of plaquettes.all"\nenergy = "0.1*(dot(w[i], w[j])*dot(w[k], w[l]) + dot(w[j], w[k])*dot(w[i], w[l]))"\n'
PLAQUETTES = '[lattices.plaquettes]\nsize = ["n", "6"]\nboundary = "periodic"\nbonds.all = [{ at = [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]] }]\n'
SPECS = {
    "cubic": lattice("cubic_axes", "chain(n, periodic)", 17, "n", EXCHANGE + field(CUBIC)),
    "blocks": lattice("squared", "cubic(n, n, 4, periodic)", 8, "4*n*n", SQUARED + field(CUBIC)),
    "three colours": lattice("skew", "skew.near", 13, "4*n", SQUARED + DM, SKEW),
    "honeycomb": lattice("honeycomb", "honey.all", 5, "6*n", SQUARED + field("exp(-w[i].z^2)*cos(t)/5"), HONEY),
    "by site": lattice("by_site", "square(n, 5, open)", 9, "5*n", EXCHANGE + field("-0.3*normal(1, i)*w[i].z^3 + 0.2*sin(w[i].x)")),
    "ring exchange": lattice("ring_exchange", "plaquettes.all", 10, "6*n", RING, PLAQUETTES),
    "other spheres": lattice("spheres", "chain(n, periodic)", 20, "n", SQUARED + field(CUBIC), more=", radius = 1.7, kappa = -0.6"),
}
QUICK = ("cubic",)


@pytest.mark.parametrize("name, method", [pytest.param(n, m, marks=() if n in QUICK and m == MIDPOINT else pytest.mark.long) for n in SPECS for m in (MIDPOINT, "gauss-4")])
def test_rows_solve_the_step(name, method):
    """Against the witness, which knows no rows."""
    assert by_rows(SPECS[name], method) and close(SPECS[name], method, steps=3) <= 2e-14


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS["blocks"])
    assert same_in_lanes(built, (2, 4, 8))


@pytest.mark.parametrize("energy, why", [("1/w[i].z", "`field`"), ("abs(w[i].z)", "`field` has branches")])
def test_the_term_without_a_bound_is_named(energy, why):
    spec = lattice("unbounded", "chain(n, periodic)", 16, "n", EXCHANGE + field(energy))
    assert f"site by site, because {why}" in generate(spec).notes["reason"].replace("the field of ", "") and not by_rows(spec)


# Bounds

EAST, NORTH = "(w[i].x*cos(K*t) + w[i].y*sin(K*t))", "(w[i].y*cos(K*t) - w[i].x*sin(K*t))"
FORMULAS = {"-0.2*dot(w[i], w[j])^2": 1, "K*dot(w[i], w[j])^3 + dot(w[i], w[j])": 1, "0.3*w[i].z^2*w[j].z^2": 1, "exp(K*w[i].x)*w[j].y": 2, "K*(w[i].x^4 + w[i].y^4 + w[i].z^4) + dot(w[i], w[j])": 1,
            "w[i].x^2*w[i].y^2*w[i].z^2 - K*w[j].z^4": 1.5, "sin(w[i].z)*w[j].x + cos(K*t)*triple(w[i], w[j], vec(1, 0, 2))": 2, "K*dot(w[i], w[j])*dot(w[i], vec(0, 1, 1))^2": 2,
            f"K*w[j].z*({EAST}^4 - 6*{EAST}^2*{NORTH}^2 + {NORTH}^4)": 7, "sin(2*t)*cos(t)*w[i].x^2*w[j].y + K*cos(t)^3*sin(w[i].y)": 1.5}
NUMBERS = {"p.R": 1.3, "p.K": -0.7}
TEXT = """[model]
name = "one"
[space]
w = {{ sphere = "n*n", radius = "R" }}
[parameters]
n = 6
R = 1.3
K = -0.7
[effects.all]
over = "bond(i, j) of square(n, n, periodic)"
energy = "{}"
[starts.up]
random = 1
"""


def number(e) -> float:
    return float(sp.sympify(e).replace(greater, sp.Max).xreplace({s: sp.Float(NUMBERS[s.name]) for s in sp.sympify(e).free_symbols}).evalf())


@pytest.mark.parametrize("formula", [pytest.param(f, marks=() if n < 2 else pytest.mark.long) for n, f in enumerate(FORMULAS)])
def test_bounds_hold_at_all_states(formula):
    """Of the field of no spins and of the Hessian, where spins are no longer than the radius; and they are no larger than so many times what is found."""
    spec = smidgen.load_text(TEXT.format(formula))
    model, dice = Model(spec, choose(spec, MIDPOINT, "auto")), np.random.default_rng(1)
    t, components = model.energies[0], [x for v in model.energies[0].derived.vectors for x in v]
    for k in (0, 1):
        rest, norm = map(number, bounds_of_term(model.low, t, k, {f.name: f.family.radius for f in model.families}))
        blocks = [sp.lambdify([*components, sp.Symbol("t", real=True)], b.xreplace({s: sp.Float(NUMBERS[s.name]) for s in b.free_symbols if s.name in NUMBERS})) for (a, _), b in t.derived.hessian.items() if a == k]
        most = 0.0
        for n in range(1000):
            w = dice.standard_normal((2, 3))
            w[1] = w[0] if n % 3 == 0 else w[1]
            w = np.eye(3)[[n // 7 % 3, n // 21 % 3]] if n % 7 == 0 else w / np.linalg.norm(w, axis=1)[:, None]
            most = max(most, sum(np.linalg.norm(np.array(b(*(1.3 * w * (1 if n % 2 else dice.uniform())).ravel(), n), float), 2) for b in blocks))
        assert most <= norm * (1 + 1e-12) <= FORMULAS[formula] * most * (1 + 1e-9) and rest >= 0
