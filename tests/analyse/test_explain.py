"""`smidgen explain`: every claim is checked in numbers, and what is planted is found."""
import json

import numpy as np
import pytest
from support.pages import blocks, python, sh
from support.explain_specs import planted, text
from support.systems import SPECS, load, tiers

import smidgen
from smidgen.errors import RunError
from smidgen.read import load_text
from smidgen.run.step.evaluated import casimir_matrices, radii
from smidgen.analyse.symmetry import bounds, explain
from smidgen.analyse.symmetry.energy import Energy
from smidgen.check.witness import Witness

CHAIN = '''[model]
name = "chain"
[space]
w = { sphere = "n" }
[parameters]
n = 10
K = 0.3
B = { default = [0.0, 0.0, 0.0], vector = true }
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-dot(w[i], w[j])"
'''
AXIS = '[effects.axis]\nover = "site(i) of w"\nenergy = "-K*w[i].z^2"\n'
TILTED = '[effects.axis]\nover = "site(i) of w"\nenergy = "-K*(cos(pi/3)*w[i].x + sin(pi/3)*w[i].y)^4 - 0.1*dot(B, w[i])"\n'
KITAEV = '''[model]
name = "kitaev"
[space]
w = { sphere = "2*nx*ny" }
[parameters]
nx = 4
ny = 4
[lattices.honey]
size = ["nx", "ny"]
boundary = "periodic"
sites = 2
bonds.x = [{ from = 0, to = 1, offset = [0, 0] }]
bonds.y = [{ from = 0, to = 1, offset = [-1, 0] }]
bonds.z = [{ from = 0, to = 1, offset = [0, -1] }]
''' + "".join(f'[effects.{c}{c}]\nover = "bond(i, j) of honey.{c}"\nenergy = "w[i].{c}*w[j].{c}"\n' for c in "xyz")
THREE = CHAIN[:CHAIN.index("[effects")] + "".join(
    f'[effects.{c}{c}]\nover = "bond({o}) of chain(n, periodic)"\nenergy = "w[i].{c}*w[j].{c}"\n'
    for c, o in (("x", "i, j"), ("y", "j, i"), ("z", "i, j")))


def kinds(report, kind):
    return [i for i in report.integrals if i.kind == kind]


def said(report):
    return "\n".join(report.words())


# What must be found

@pytest.mark.quick
def test_the_chain_keeps_total_spin():
    report = explain(load("heisenberg_chain"))
    assert "H is unchanged by every rotation of all vectors." in said(report)
    assert [i.formula for i in kinds(report, "linear")] == ["sum w.x", "sum w.y", "sum w.z"]
    assert all(i.kept and i.always for i in kinds(report, "linear"))
    assert not kinds(report, "energy")[0].kept


@pytest.mark.quick
def test_with_easy_axis_only_its_z_component():
    report = explain(load_text(CHAIN + AXIS))
    assert [i.formula for i in kinds(report, "linear")] == ["sum w.z"]
    assert [(names, axes.tolist()) for names, axes in report.rotations] == [(("w",), [[0, 0, 1]])]


@pytest.mark.quick
def test_a_value_may_restore_a_symmetry():
    report = explain(load_text(CHAIN + AXIS), parameters={"K": 0.0})
    assert len(kinds(report, "linear")) == 3 and "K = 0" in said(report)
    assert [i.always for i in kinds(report, "linear")] == [False, False, True]


@pytest.mark.quick
def test_the_free_body_keeps_its_energy():
    report = explain(load("free_rigid_body"))
    assert kinds(report, "energy")[0].kept and not report.rotations
    assert not kinds(explain(load("irreversible_rigid_body")), "energy")[0].kept


@pytest.mark.quick
def test_kitaev_has_none():
    report = explain(load_text(KITAEV))
    assert not report.rotations and not report.mixed and not kinds(report, "linear") and not report.undecided


@pytest.mark.quick
def test_a_tilted_axis_is_found():
    report = explain(load_text(CHAIN + TILTED))
    (names, axes), = report.rotations
    assert np.allclose(axes, [[0.5, 0.75 ** 0.5, 0]], atol=1e-15, rtol=0)
    assert "(0.5, 0.866025, 0)" in said(report)
    assert not explain(load_text(CHAIN + TILTED), parameters={"B": [0, 0, 1]}).rotations


@pytest.mark.quick
def test_three_effects_together_are_heisenbergs():
    for values in ({}, {"n": 30_000}):
        report = explain(load_text(THREE), parameters=values)
        assert len(kinds(report, "linear")) == 3
        assert [i.formula for i in kinds(explain(load_text(THREE), parameters=values, effects=("xx", "yy")), "linear")] == ["sum w.z"]


@pytest.mark.quick
def test_a_sum_that_only_vanishes_as_a_whole_is_found_in_small_systems():
    spec = load_text(CHAIN.replace("-dot(w[i], w[j])", "-dot(w[i], w[j]) + w[i].x - w[j].x"))
    assert len(kinds(explain(spec), "linear")) == 3
    assert [i.formula for i in kinds(explain(spec, parameters={"n": 30_000}), "linear")] == ["sum w.x"]


@pytest.mark.quick
def test_families_alone_and_together():
    text_ = ('[model]\nname = "m"\n[space]\nw = { sphere = 2 }\nv = { sphere = 1 }\nu = { nambu = 1, C = '
             '"(u.x^2 + u.y^2 - u.z^2)/2" }\n[effects.a]\nenergy = "dot(w[0], w[1]) + dot(w[0], v) + u.z^2"\n')
    report = explain(load_text(text_))
    assert [names for names, _ in report.rotations] == [("u",), ("w", "v")]
    assert len(report.rotations[1][1]) == 3 and report.rotations[0][1].tolist() == [[0, 0, 1]]
    assert "SO(2,1)" in said(report)


@pytest.mark.quick
def test_each_family_about_its_own_axis():
    text_ = '[model]\nname = "m"\n[space]\nw = { sphere = 1 }\nv = { sphere = 1 }\n[effects.a]\nenergy = "w.x*v.y + w.y*v.z"\n'
    report = explain(load_text(text_))
    assert not report.rotations and {n: list(a) for n, a in report.mixed[0].items()} == {"w": [0, 0, 1], "v": [1, 0, 0]}


@pytest.mark.quick
def test_tracers_move_in_a_flow_and_have_no_momentum():
    report = explain(load("vortex_tracers"))
    assert report.rotations[0][0] == ("w", "p")
    assert [i.formula for i in kinds(report, "linear")] == ["sum kappa w.x", "sum kappa w.y", "sum kappa w.z"]
    assert kinds(report, "energy")[0].name == "energy of interaction"


@pytest.mark.quick
def test_what_the_methods_keep_differs():
    pair = load("heisenberg_chain")
    assert kinds(explain(pair, method="classical-midpoint"), "energy")[0].kept
    assert kinds(explain(load("free_rigid_body"), method="moser-veselov"), "energy")[0].kept
    assert not kinds(explain(load("irreversible_rigid_body"), method="classical-midpoint"), "energy")[0].kept


@pytest.mark.quick
@pytest.mark.parametrize("name, even", [("free_rigid_body", True), ("irreversible_rigid_body", False)])
def test_time_reversal(name, even):
    assert ((-1, -1, -1) in explain(load(name)).signs) == even


@pytest.mark.parametrize("seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(4, 25))])
def test_a_planted_axis_is_found(seed):
    spec, axis = planted(seed)
    report = explain(load_text(spec))
    axis = np.array(axis) / np.linalg.norm(axis)
    (names, axes), = report.rotations
    assert axes.shape == (1, 3) and abs(abs(axes[0] @ axis) - 1) < 1e-14


# Quadratic forms of several sites together

PAIR = '''[model]
name = "pair"
[space]
w = { sphere = 2 }
[parameters]
A = { default = [0, 0, 0], vector = true }
J = { default = [1.0, 0.7, -0.4], vector = true }
[effects.exchange]
energy = "J.x*w[0].x*w[1].x + J.y*w[0].y*w[1].y + J.z*w[0].z*w[1].z"
[effects.axis]
over = "site(i) of w"
energy = "(A.x*w[i].x^2 + A.y*w[i].y^2 + A.z*w[i].z^2)/2"
'''


def joint(report):
    return [i for i in kinds(report, "quadratic") if i.count == 1 and "w[1]" in i.formula]


@pytest.mark.quick
@pytest.mark.parametrize("values, count", [({}, 1), ({"A": [1.0, 2.0, 4.0], "J": [2.0, 1.0, 1.0]}, 1), ({"A": [1.0, 2.0, 4.0], "J": [2.0, 1.0, 1.1]}, 0)])
def test_two_coupled_vectors_have_manakovs_integral_where_they_are_integrable(values, count):
    """J_x^2 (A_y - A_z) + .. + (A_x - A_y)(A_y - A_z)(A_z - A_x) = 0 (Magyari, Thomas and Weber 1987)."""
    spec = load_text(PAIR)
    for method, kept in (("spherical-midpoint", not values), ("classical-midpoint", True), ("gauss-4", False)):
        found = joint(explain(spec, parameters=values, method=method))
        assert len(found) == count and all(i.kept == kept and not i.always for i in found)


@pytest.mark.quick
@pytest.mark.parametrize("A, J", [([0, 0, 0], [1.0, 0.7, -0.4]), ([1.0, 2.0, 4.0], [2.0, 1.0, 1.0])])
def test_a_joint_integral_is_one_and_what_the_methods_do_to_it_is_what_is_said(A, J):
    """The spherical midpoint keeps that of an XYZ pair, where the terms of both sites vanish by themselves, and not Manakov's."""
    spec = load_text(PAIR.replace("[0, 0, 0]", str(A)).replace("[1.0, 0.7, -0.4]", str(J)))
    w = state(np.random.default_rng(2), spec)
    for method in ("spherical-midpoint", "classical-midpoint"):
        report = explain(spec, method=method)
        one, = joint(report)
        check_flow(report, spec, w)
        change = abs(one.evaluate(Witness(spec).step(w, 0.0, 0.2, method)) - one.evaluate(w))
        assert change < 1e-14 * (1 + abs(one.evaluate(w))) if one.kept else change > 1e-6


@pytest.mark.quick
@pytest.mark.parametrize("n, count", [(3, 2), (4, 1), (5, 0)])
def test_spins_of_a_ring_of_three_or_four_keep_their_products(n, count):
    """H = S^2/2 with n = 3, and (w_0 + w_2).(w_1 + w_3) with 4; one product less is new, since S^2 and H have the sum of all.

    They are shown for all values of the parameters only where n is none of them."""
    spec = load_text(CHAIN.replace("n = 10", f"n = {n}"))
    report = explain(spec)
    found = kinds(report, "quadratic")
    assert len(found) == count and not report.undecided and not any(i.always for i in found) and (f"shown for these values: n = {n}" in said(report)) == (count > 0)
    fixed = kinds(explain(load_text(CHAIN.replace('"n"', f"{n}").replace("chain(n", f"chain({n}"))), "quadratic")
    assert len(fixed) == count and all(i.always for i in fixed)
    check_flow(report, spec, state(np.random.default_rng(n), spec))


@pytest.mark.quick
def test_what_was_looked_for_is_said():
    """Four vortices have no such form, which is decided though the formula is too long to multiply out."""
    chain, vortices = explain(load_text(CHAIN)), explain(load("point_vortices"))
    assert "not searched: quadratic forms that couple sites (10 sites; the limit is 6)" in said(chain)
    assert "quadratic forms of all sites together" in said(vortices) and not vortices.undecided and not kinds(vortices, "quadratic")
    assert "join" not in said(explain(load("free_rigid_body"))) and chain.as_dict()["searched"][0] == "linear ones"


# Constants that are no simple numbers

ONE = '[model]\nname = "one"\n[space]\nw = {{ {} = {} }}\n[effects.a]\nover = "site(i) of w"\nenergy = "{}"\n'


@pytest.mark.quick
@pytest.mark.parametrize("energy, axis", [
    ("cos(0.3)*w[i].x + sin(0.3)*w[i].y", [np.cos(0.3), np.sin(0.3), 0]),
    ("exp(0.5)*w[i].x + 2*w[i].y + log(3)*w[i].z", [np.exp(0.5), 2, np.log(3)]),
    ("sqrt(2)*w[i].x + 2^0.3*w[i].y + pi*w[i].z", [2 ** 0.5, 2 ** 0.3, np.pi])])
@pytest.mark.parametrize("count", [1, pytest.param(2, marks=pytest.mark.long)])
def test_axes_with_constants_are_found(energy, axis, count):
    spec = load_text(ONE.format("sphere", count, energy))
    report = explain(spec)
    (_, axes), = report.rotations
    np.testing.assert_allclose(axes, [np.array(axis) / np.linalg.norm(axis)], rtol=1e-14)
    check_flow(report, spec, state(np.random.default_rng(1), spec))


@pytest.mark.quick
def test_quadratic_integrals_with_constants_are_found():
    spec = load_text(ONE.format("sphere", 1, "exp(0.5)*w[i].x^2 + 2*w[i].y^2 + log(3)*w[i].z^2 + 0*t"))
    report = explain(spec)
    assert kinds(report, "quadratic")
    check_flow(report, spec, state(np.random.default_rng(1), spec))


# Absent sites, torques, flows

@pytest.mark.quick
def test_sums_leave_absent_sites_out():
    spec = load_text(CHAIN.replace("n = 10", "n = 4") + '[effects.gone]\nover = "site(i) of w"\nabsent = "i == 1"\n')
    report, w = explain(spec), state(np.random.default_rng(1), spec)
    for i in kinds(report, "linear"):
        assert i.evaluate(w) == pytest.approx(w[[0, 2, 3], "xyz".index(i.formula[-1])].sum())


@pytest.mark.quick
def test_the_energy_is_not_said_to_fall_where_torques_act_or_h_may_depend_on_time():
    spec = load_text(CHAIN + AXIS + '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\n[effects.push]\nover = "site(i) of w"\ntorque = "cross(w[i], vec(0, 0, 1))"\n')
    assert "the energy decreases" not in said(explain(spec))
    assert "the energy decreases" in said(explain(spec, effects=("exchange", "axis", "bath")))


@pytest.mark.quick
@pytest.mark.parametrize("factor, count", [("2", 1), ("exp(-t)", 0)])
def test_a_flow_that_changes_with_time_is_not_said_to_be_reversed(factor, count):
    """Tracers have no energy, so that none changes with time."""
    report = explain(load_text('[model]\nname = "m"\n[space]\np = { sphere = 3, tracer = true }\n[effects.flow]\nover = "site(i) of p"\nenergy = "FACTOR*p[i].z^2"\n'.replace("FACTOR", factor)))
    assert report.energy_changes is False and said(report).count("w -> -w reverses") == count


# No false claim

def state(random, spec):
    """A random point; on spheres, or anywhere."""
    matrices, r = casimir_matrices(spec), radii(spec)
    w = random.standard_normal((len(matrices), 3))
    return w * np.where(np.isnan(r), 1.0, r / np.linalg.norm(w, axis=1))[:, None]


def turned(spec, w, families, axis, angle):
    """w' = grad C x axis for a time `angle`, on the sites of the families."""
    out, cross = w.copy(), np.array([[0, axis[2], -axis[1]], [-axis[2], 0, axis[0]], [axis[1], -axis[0], 0]])
    matrices, places = casimir_matrices(spec), Energy(spec).places
    for name in families:
        for site in range(places[name][0], sum(places[name])):
            term = out[site].copy()
            for k in range(1, 30):
                term = angle / k * cross @ matrices[site] @ term
                out[site] = out[site] + term
    return out


def check_rotations(report, spec, w):
    """H of the turned state is H, to round-off."""
    energy = Energy(spec)
    for families, axes in report.rotations:
        for axis in axes:
            before, after = energy(w, 0.7), energy(turned(spec, w, families, axis, 0.4), 0.7)
            assert abs(after - before) <= 1e-12 * (1 + abs(before)), (families, axis)


def check_flow(report, spec, w):
    """The derivative of each linear and quadratic integral along X; differences of a parabola are exact."""
    x = Witness(spec).vector_field(w, 0.7)
    x /= max(1, np.max(np.abs(x)))
    for i in report.integrals:
        if i.kind in ("linear", "quadratic", "casimir"):
            up, down = i.evaluate(w + x), i.evaluate(w - x)
            assert abs(up - down) <= 1e-12 * (1 + abs(up) + abs(down)), i.formula


def check_step(report, spec, w):
    """What the method is said to keep, after a step of the witness."""
    after, h = None, 0.2
    while after is None and h > 1e-4:
        try:
            after = Witness(spec).step(w, 0.7, h, report.method)
        except RunError:
            h /= 4
    for i in report.integrals if after is not None else ():
        if i.kept:
            size = 1 + np.sum(np.abs(w)) + np.sum(w * w) + abs(i.evaluate(w))
            assert abs(i.evaluate(after) - i.evaluate(w)) <= 1e-12 * size, (i.formula, h)
    return after is not None


def claims(seed):
    """Check one random Hamiltonian; returns how many claims there were beside the Casimirs."""
    spec, random = load_text(text(seed)), np.random.default_rng(seed)
    method = ("spherical-midpoint", "spherical-midpoint", "classical-midpoint")[seed % 3]
    report = explain(spec, method=method)
    for _ in range(2):
        w = state(random, spec)
        check_rotations(report, spec, w)
        check_flow(report, spec, w)
        check_step(report, spec, w)
    return len(report.rotations) + sum(i.kind != "casimir" for i in report.integrals), report


@pytest.mark.parametrize("tens", [0, *(pytest.param(tens, marks=pytest.mark.long) for tens in range(1, 10))])
def test_no_false_claim_on_random_hamiltonians(tens):
    found = [claims(seed) for seed in range(10 * tens, 10 * tens + 10)]
    assert sum(n for n, _ in found) > 10        # there was something to be wrong about


@pytest.mark.parametrize("count", [10, pytest.param(60, marks=pytest.mark.long)])
def test_little_is_left_undecided(count):
    reports = [explain(load_text(text(seed))) for seed in range(count)]
    assert sum(bool(r.undecided) for r in reports) <= 1 + count / 30


@pytest.mark.quick
def test_the_checks_can_say_no():
    spec, random = load_text(CHAIN + AXIS), np.random.default_rng(1)
    wrong = explain(load_text(CHAIN))
    w = state(random, spec)
    for check in (check_rotations, check_flow, check_step):
        with pytest.raises(AssertionError):
            check(wrong, spec, w)


@pytest.mark.quick
def test_energy_that_the_method_does_not_keep_is_not_said_to_be_kept():
    for name in ("heisenberg_chain", "two_bodies", "product"):
        assert not kinds(explain(load(name), parameters={"n": 6} if "chain" in name else {}), "energy")[0].kept


@pytest.mark.quick
@pytest.mark.parametrize("name", ["free_rigid_body", "lagrange"])
def test_kept_energies_stay_on_the_compiled_code(name):
    spec = load(name)
    energy, = kinds(explain(spec), "energy")
    model = smidgen.build(spec).start(h=0.02)
    before = energy.evaluate(model.w)
    assert energy.kept and abs(energy.evaluate(model.steps(50).w) - before) < 1e-14


# Hostile formulas: bounded work, no claim

@pytest.mark.quick
@pytest.mark.parametrize("energy", [
    "(w.x + 2*w.y + 3*w.z + exp(w.x) + sin(w.y) + 1)^64", "1/(" * 30 + "w.x + 2" + ")" * 30,
    " + ".join(f"(w.x + {k}*w.y + w.z)^20" for k in range(2, 40)), "(w.x + w.y + 1e149*w.z + 1e-300)^50",
    "*".join(["(1 + w.x + w.y + exp(w.z))"] * 40)])
def test_hostile_formulas_end(energy):
    spec = load_text(f'[model]\nname = "m"\n[space]\nw = {{ sphere = 1 }}\n[effects.a]\nenergy = "{energy}"\n')
    report, w = explain(spec), np.array([[0.36, 0.48, 0.8]])
    assert report.undecided or len(report.rotations) < 2
    check_rotations(report, spec, w)


@pytest.mark.quick
def test_too_much_work_is_said(monkeypatch):
    monkeypatch.setattr(bounds, "PRODUCTS", 20)
    report = explain(load_text(CHAIN + AXIS))
    assert report.undecided and not report.rotations and "Not decided: which rotations" in said(report)


@pytest.mark.quick
def test_what_was_missed_is_said():
    # exp(a) exp(-a) = 1 is a relation between functions that the algebra does not use
    text_ = ('[model]\nname = "m"\n[space]\nw = { sphere = 1 }\n[effects.a]\nenergy = '
             '"w.z + w.x*(exp(w.y)*exp(-w.y) - 1)"\n')
    report = explain(load_text(text_))
    assert any("seem to leave H unchanged" in u for u in report.undecided)


# Time and lists

BUSY = CHAIN.replace('over = "bond(i, j) of chain(n, periodic)"\nenergy = "-dot(w[i], w[j])"', 'over = "bond(i, j) of l.b"\nenergy = "-dot(w[i], w[j])"') \
    + AXIS + '[lattices.l]\nsize = [1]\nboundary = "open"\nsites = 10\nbonds.b = [%s]\n' % ", ".join(
        f"{{ from = {i}, to = {j}, offset = [0] }}" for i in range(10) for j in range(i))


@pytest.mark.quick
@pytest.mark.parametrize("work", [1, 20, 100_000])
def test_whether_h_depends_on_time_is_decided_where_no_formula_holds_t(work, monkeypatch):
    monkeypatch.setattr(bounds, "PRODUCTS", work)
    for spec in (CHAIN, BUSY):
        report = explain(load_text(spec))
        assert report.energy_changes is False and kinds(report, "energy")
    timed = explain(load_text(BUSY.replace("-dot(", "-exp(t)*dot(")))
    assert timed.energy_changes or "whether H depends on time" in timed.undecided


ARRAYS = {"strength": ("K[i]", "1", "dot(w[i], w[j])"), "radius": ("1", "K[i]", "dot(w[i], w[j])"),
          "coupling": ("1", "1", "K[i]*dot(w[i], w[j])"), "coupling along z": ("1", "1", "K[i]*w[i].z*w[j].z"),
          "coupling and strength": ("K[i]", "1", "K[j]*w[i].z*w[j].z + K[i]*K[j]*dot(w[i], w[j])")}


@pytest.mark.quick
@pytest.mark.parametrize("place", ARRAYS)
@pytest.mark.parametrize("entries", [[1.0, 3.0, 0.5], [2.0, 2.0, 2.0], [7.0]])
def test_a_list_in_place_of_one_number_is_that_list(place, entries):
    kappa, radius, energy = ARRAYS[place]
    spec = ('[model]\nname = "m"\n[parameters]\nn = 3\nK = {{ default = {}, size = "n" }}\n[space]\n'
            'w = {{ sphere = "n", kappa = "{}", radius = "{}" }}\n[effects.e]\nover = "pair(i, j)"\nenergy = "{}"\n')
    whole = entries * (3 if len(entries) == 1 else 1)
    given = explain(load_text(spec.format(1.0, kappa, radius, energy)), parameters={"K": entries})
    written = explain(load_text(spec.format(whole, kappa, radius, energy)))
    w = np.random.default_rng(3).standard_normal((3, 3))
    assert given.words() == written.words() and given.parameters == written.parameters
    assert [i.evaluate(w) for i in given.integrals] == [i.evaluate(w) for i in written.integrals]


@pytest.mark.quick
def test_what_holds_for_equal_entries_only_says_so():
    text_ = CHAIN.replace("K = 0.3", 'K = { default = 0.0, size = "n" }') + AXIS.replace("-K*", "-K[i]*")
    report = explain(load_text(text_))
    assert not report.always[0] and "K = 0 for all 10 entries" in said(report)
    listed = explain(load_text(text_), parameters={"K": [0.5] + 9*[1.0]})
    assert listed.rotations[0][1].shape == (1, 3) and listed.parameters["K"] == "a list of 10 entries"


# The command

@pytest.mark.parametrize("name", tiers(SPECS))
def test_every_shipped_spec_is_explained(name):
    report = explain(load(name))
    assert len(report.words()) >= 3 and not report.undecided
    assert all(line.endswith(".") for line in report.words())


@pytest.mark.quick
def test_command(command):
    out = command("explain", "heisenberg_chain")
    assert out.returncode == 0 and "every rotation" in out.stdout and not out.stderr
    data = json.loads(command("explain", "free_rigid_body", "moser_veselov", "--json").stdout)
    assert data["method"] == "moser-veselov" and data["integrals"][0]["kept"]
    assert command("explain", "free_rigid_body", "--effects", "no").returncode == 2


@pytest.mark.long
def test_the_page(tmp_path):
    sh("smidgen new spins\n" + "".join(blocks("explain.md", "sh")), tmp_path)
    said = [python(program, tmp_path) for program in blocks("explain.md", "python")]
    assert "linear sum w.x True" in said[0] and "('w',)" in said[0]


BATH = """
[model]
name = "bath"
[space]
w = {{ sphere = 2 }}
[effects.pair]
energy = "-dot(w[0], w[1]) - 0.3*w[0].x"
[effects.bath]
over = "site(i) of w"
damping = 0.1
{}
"""


@pytest.mark.parametrize("more, said_", [("", "until every damped site is parallel"),
                                        ('[effects.pin]\nover = "site(i) of w"\npinned = "i == 1"', "until every damped site that is free to move is parallel")])
def test_pinned_sites_do_not_become_parallel_to_their_field(more, said_):
    report = explain(load_text(BATH.format(more)))
    assert said_ in " ".join(report.words())
