"""What stands below a jump (floor, mod, a comparison) is computed as it is written: i/n is 1 at i = n, i*(1/n) need not be."""
from dataclasses import replace

import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.evaluated import Evaluated

WRONG = (49, 98, 103, 107, 161, 187, 196, 197)      # n*(1/n) < 1 in double precision
SITES = 1001
TEXT = """
[model]
name = "jumps"
[space]
w = {{ sphere = {sites}, kappa = "1 + {floor} + {mod}" }}
[parameters]
n = 1
k = 1
rows = {{ default = {rows}, size = {sites} }}
places = {{ default = {places}, size = {sites} }}
[effects.field]
over = "site(i) of w"
energy = "{floor}*w[i].z + {mod}*w[i].x + if({side} < 1, 1, 2)*w[i].y"
{more}
[observables.rows]
over = "site(i) of w"
value = "{floor}"
[starts.a]
theta = "1 + 0.1*mod(i, 7)"
phi = "{floor} + {mod}"
"""
GIVEN = dict(floor="rows[i]", mod="places[i]", side="rows[i]")
BY_SITE = dict(floor="floor(i/n)", mod="mod(i, n)", side="i/n")
BY_PARAMETER = dict(floor="floor(k/n)", mod="mod(k, n)", side="k/n")
BONDS = '[effects.exchange]\nover = "bond(i, j) of chain({}, open)"\nenergy = "-0.1*dot(w[i], w[j])"'


def spec_of(formulas, sites, more=""):
    numbers = "[" + ",\n".join(["0.0"] * sites) + "]"
    return smidgen.load_text(TEXT.format(sites=sites, rows=numbers, places=numbers, more=more, **formulas))


def model(formulas, sites, method="spherical-midpoint", more="", **how):
    return smidgen.build(spec_of(formulas, sites, more), method=method, **how)


def with_values(built, **values):
    return Integrator(replace(built.prepared, numbers=Evaluated(built.spec, values)), built.built)


def pair(written, given, n, i):
    """The model of these values, and the one that is given the quotients i//n and the remainders."""
    return with_values(written, n=n, k=int(i[-1])), with_values(given, rows=[float(x) for x in i // n], places=[float(x) for x in i % n])


@pytest.mark.quick
def test_energies_fields_strengths_observables_and_starts_for_every_n():
    """To n = 1000, so that every i = n is there, and i = 2n, 3n, ..."""
    written, given, i = model(BY_SITE, SITES), model(GIVEN, SITES), np.arange(SITES)
    for n in range(1, 1001):
        one, other = (m.start(None, h=0.1) for m in pair(written, given, n, i))
        assert np.array_equal(one.w, other.w), n
        np.testing.assert_allclose(one.field(), other.field(), rtol=1e-12, err_msg=str(n))
        assert one.energy() == pytest.approx(other.energy(), rel=1e-11), n
        assert one.values()[one.columns.index("rows")] == np.sum(i // n), n


FACTORS = """
[model]
name = "factors"
[space]
w = { sphere = "n" }
[parameters]
n = 1000
[effects.field]
over = "site(i) of w"
energy = "0.1*mod(i, 3)*w[i].z + 0.7*mod(t, 0.3)*w[i].x"
[effects.absorber]
over = "site(i) of w"
damping = "0.1*mod(i, 3)"
[starts.a]
random = 1
"""


@pytest.mark.quick
def test_a_factor_of_a_remainder_brings_no_rounding_of_large_terms():
    """0.1 i - 0.3 floor(i/3) is below 0 at i = 9: no damping."""
    m, t = smidgen.build(smidgen.load_text(FACTORS)).start(h=0.1), 2e6
    field, rest = m.field(t=t), t - 0.3 * np.floor(t / 0.3)
    assert np.array_equal(field[:, 2], 0.1 * (np.arange(1000) % 3))
    assert np.array_equal(field[:, 0], np.full(1000, 0.7 * rest))
    assert m.steps(2).t == 0.2


@pytest.mark.parametrize("method, sites, more, how", [
    ("spherical-midpoint", 400, "", {}), ("spherical-midpoint", 400, BONDS.format(400), {}), ("spherical-midpoint", 400, "", dict(features=["extended"])),
    ("spherical-midpoint", 1, "", dict(features=["extended"])), ("spherical-midpoint", 1, "", {}), ("gauss-4", 400, "", {}),
    ("gauss-4", 400, BONDS.format(400), {}), ("dop853", 1, "", {}), ("extrapolation-12", 400, "", {}), ("spherical-midpoint", 400, "", dict(real="long double"))],
    ids=["alone", "rows", "wide", "wide sphere", "sphere", "lanes", "lanes in rows", "dop853", "extrapolation", "long double"])
def test_steps_by_every_printer(method, sites, more, how):
    i = np.arange(sites) if sites > 1 else np.array([0])
    written, given = model(BY_SITE if sites > 1 else BY_PARAMETER, sites, method, more, **how), model(GIVEN, sites, method, more, **how)
    for n in WRONG:
        at = i if sites > 1 else np.array([n])
        one, other = (m.start(np.full((sites, 3), 3 ** -0.5), h=1e-4).steps(3) for m in pair(written, given, n, at))
        np.testing.assert_allclose(one.w, other.w, rtol=1e-13, atol=1e-14, err_msg=str(n))


def test_members_of_ensembles_take_the_same_side():
    one, other = spec_of(BY_PARAMETER, 1), spec_of(GIVEN, 1)
    start = np.tile([0.6, 0.0, 0.8], (9, 1))
    for n in WRONG:
        found, wanted = (smidgen.ensemble(spec, start=start, parameters=values, h=0.1, steps=3)
                         for spec, values in ((one, dict(n=n, k=n)), (other, dict(rows=[1.0]))))
        np.testing.assert_allclose(found.w, wanted.w, rtol=1e-13)


RESPONDING = """
[effects.bath]
over = "site(i) of w"
damping = "0.1 + {mod}/100000"
kT = "({mod} + 1)/10000"
[effects.push]
over = "site(i) of w"
torque = "({floor} + 1)/1000*cross(w[i], cross(w[i], vec(0, 0.3, 1)))"
[effects.edge]
over = "site(i) of w"
pinned = "{floor} == 1 and i > 4"
[effects.holes]
over = "site(i) of w"
absent = "{floor} == 2 and i > 4"
"""


@pytest.mark.parametrize("method, bonds", [("spherical-midpoint", False), *(pytest.param(*case, marks=pytest.mark.long) for case in
                                           (("spherical-midpoint", True), ("spherical-midpoint-4", True), ("heun", False)))])
def test_dampings_noise_torques_radii_and_held_sites(method, bonds):
    """From site to site, and by rows."""
    specs = []
    for given in (BY_SITE, GIVEN):
        more = RESPONDING.format(**given) + BONDS.format(SITES) * bonds
        numbers = "[" + ",\n".join(["0.0"] * SITES) + "]"
        text = TEXT.format(sites=SITES, rows=numbers, places=numbers, more=more, **given)
        lines = text.replace(", kappa =", f', radius = "1 + {given["floor"]}/4", kappa =').split("[effects.field]\n")
        specs.append(smidgen.load_text(lines[0] + '[effects.field]\nover = "site(i) of w"\nenergy = "0.3*w[i].z"\n' + lines[1].split("\n", 2)[2]))
    written, given = (smidgen.build(spec, method=method) for spec in specs)
    i = np.arange(SITES)
    for n in WRONG:
        one, other = pair(written, given, n, i)
        one.start("a", h=1e-3, seed=3)
        other.start(one.w.copy(), h=1e-3, seed=3)
        np.testing.assert_allclose(one.steps(2).w, other.steps(2).w, rtol=0, atol=1e-13 * (1 + SITES / n), err_msg=str(n))


TIMES = """
[model]
name = "clocked"
[space]
w = {{ sphere = 2 }}
[parameters]
T = {{ default = {period!r}, fixed = {fixed} }}
[effects.field]
over = "site(i) of w"
energy = "floor(t/{T})*w[i].z + mod(t, {T})*w[i].x + if(t/{T}*3 >= 2, 1, 2)*w[i].y"
[starts.a]
theta = "1"
phi = "0"
"""


def clock_field(t, period):
    return [t - period * np.floor(t / period), 1.0 if t / period * 3 >= 2 else 2.0, np.floor(t / period)]


@pytest.mark.quick
@pytest.mark.parametrize("period", [0.1, 0.3, 4.9, 1 / 49])
@pytest.mark.parametrize("kind", ["number", "fixed", "parameter"])
def test_times_on_the_edge_of_a_period(kind, period):
    """t = k T/3 as a program has it, rounded: which period it is in is what t/T rounds to, in C and in the witness."""
    spec = smidgen.load_text(TIMES.format(period=period, fixed=str(kind == "fixed").lower(), T=repr(period) if kind == "number" else "T"))
    built, witness = smidgen.build(spec).start(None, h=0.1), Witness(spec)
    for t in (k * (period / 3) for k in range(500)):
        wanted = [clock_field(t, period)] * 2
        np.testing.assert_allclose(built.field(t=t), wanted, rtol=1e-12, atol=1e-12, err_msg=repr(t))
        np.testing.assert_allclose(witness.field(built.w, t), wanted, rtol=1e-12, atol=1e-12, err_msg=repr(t))


@pytest.mark.parametrize("features", [(), ("extended",)], ids=["plain", "extended"])
def test_steps_over_the_edges_of_a_period(features):
    """The middle of a step on an edge: also the evaluation in extended precision is on the side of the others."""
    spec = smidgen.load_text(TIMES.format(period=0.1, fixed="false", T="T"))
    built, witness = smidgen.build(spec, features=features).start(None, h=0.2), Witness(spec)
    for k, wanted in enumerate(witness.steps(built.w.copy(), 0.0, 0.2, 60)[1:]):
        np.testing.assert_allclose(built.step().w, wanted, rtol=1e-11, atol=1e-11, err_msg=f"step {k}")


KINKS = """
[model]
name = "kinks"
[space]
w = {{ sphere = {sites} }}
[parameters]
n = 1
[effects.field]
over = "site(i) of w"
energy = "{energy}"
[starts.a]
theta = "1"
phi = "0"
"""


def kinks(energy, sites):
    return smidgen.load_text(KINKS.format(energy=energy, sites=sites))


@pytest.mark.quick
def test_the_derivative_at_a_kink():
    """At w = i/n both sides are equal, and the first one counts; the derivative of |x| at 0 is 0."""
    energy = "abs(w[i].z - i/n) + min(w[i].x - i/n, 2*w[i].x - 2*i/n) + max(w[i].y - i/n, 2*w[i].y - 2*i/n)"
    built, i = smidgen.build(kinks(energy, SITES)), np.arange(SITES)
    for n in range(1, 1001):
        w = np.repeat((i / n)[:, None], 3, axis=1)
        model = with_values(built, n=n).start(None, h=0.1)
        assert np.array_equal(model.field(w), np.tile([1.0, 1.0, 0.0], (SITES, 1))), n
    w = np.repeat(np.array([[0.0], [1 / 49], [2 / 49]]), 3, axis=1)
    assert np.array_equal(Witness(kinks(energy, 3), {"n": 49}).field(w, 0.0), np.tile([1.0, 1.0, 0.0], (3, 1)))


@pytest.mark.quick
def test_an_angle_jumps_where_its_first_side_is_zero():
    built, i = smidgen.build(kinks("atan2(i/n - 1, -1)*w[i].z", SITES)), np.arange(SITES)
    for n in WRONG:
        found = with_values(built, n=n).start(None, h=0.1).field()[:, 2]
        np.testing.assert_allclose(found, np.arctan2(i / n - 1, -1), rtol=1e-14, err_msg=str(n))


@pytest.mark.quick
@pytest.mark.parametrize("energy", ["w[i].x^2/n + w[i].y*i/n", "min(w[i].y/n, w[i].z)", "abs(w[i].y/n)*w[i].z"])
def test_where_nothing_jumps_a_product_takes_the_place_of_the_division(energy):
    c = generate(kinks(energy, 3))["kinks.c"]
    assert c.count("1.0/(smg_real)model->p.n") == 1 and "/(smg_real)c->model->p.n" not in c.partition("effect_field_value")[2].partition("}")[0]
