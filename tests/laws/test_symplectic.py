"""The emitted step is a Poisson map: M K(w) M^T = K(W), with M by differences of a long-double build.

tests/support/tangent.py derives the measurement; the first part here tries it on exact flows
and on maps whose defect is known. `pytest -s` prints a table; docs/numbers.md keeps one.
"""
import numpy as np
import pytest
from support import texts
from support.exact import dilation, linear_flow, pair_flow, rotation
from support.measure import defect
from support.systems import CLASSICAL, SPECS, SPHERICAL, VESELOV, begin, tiers
from support.tangent import (Leaves, LongStep, derivative, frame, leaves_of, long_start,
                             poisson_defect)

import smidgen
from smidgen.check.witness import Witness

SYMPLECTIC, NOT_SYMPLECTIC = 1e-12, 1e-8
ROUND_OFF = 1e-15       # some ulps of extended precision over the width of a difference
NAMBU = ("nambu_a31", "nambu_a34", "nambu_a36", "nambu_a38", "nambu_a39")
FEW_SOLVERS = (("heisenberg_chain", "newton"), ("product", "rotation"), ("two_bodies", "plain"))      # of `make test`
TRACERS = "vortex_tracers"          # no Poisson map as a whole: see its own tests


def spheres(kappa, radius):
    count = len(kappa)
    return Leaves(np.array(kappa, np.longdouble), np.tile(np.eye(3), (count, 1, 1)),
                  np.array(radius, float))


def unit(*rows):
    w = np.array(rows, np.longdouble)
    return w / np.sqrt(np.sum(w * w, axis=1))[:, None]


# -- the measurement itself ---------------------------------------------------------------------

def test_exact_rotations_have_no_defect():
    w = unit([0.3, -0.5, 0.8])
    turn = rotation([1, 2, -1], 0.7)
    assert poisson_defect(lambda w: w @ turn.T, w, spheres([1], [1])) < ROUND_OFF
    assert poisson_defect(lambda w: w @ turn.T, w, spheres([1], [np.nan])) < ROUND_OFF


@pytest.mark.parametrize("kappa, radius", [((1, 1), (1, 1)), ((2, -0.7), (1, 1)),
                                           ((-3, 0.5), (1.5, 0.4)), ((2, 5), (np.nan, np.nan))])
def test_the_exact_flow_of_a_pair_has_no_defect(kappa, radius):
    w = unit([0.3, -0.5, 0.8], [-0.6, 0.1, 0.2]) * np.nan_to_num(radius, nan=1.3)[:, None]
    flow = pair_flow(np.array(kappa, np.longdouble), 0.8, 1.7)
    assert poisson_defect(flow, w, spheres(kappa, radius)) < ROUND_OFF


def test_wrong_strengths_show_as_a_defect():
    w = unit([0.3, -0.5, 0.8], [-0.6, 0.1, 0.2])
    flow = pair_flow(np.array([2, -0.7], np.longdouble), 0.8, 1.7)
    assert poisson_defect(flow, w, spheres([2, 0.7], [1, 1])) > 0.1


@pytest.mark.parametrize("name", NAMBU)
def test_the_exact_flow_on_every_casimir_has_no_defect(name):
    case = begin(name)
    leaves = leaves_of(case)
    flow = linear_flow(leaves.casimir[0], [0.4, -0.9, 0.6], 0.5)
    assert poisson_defect(flow, case.w.astype(np.longdouble), leaves) < ROUND_OFF


def test_known_defects_are_measured():
    pole = unit([0, 0, 1])
    for factor in (0.5, 1 + 1e-9, 3):
        found = poisson_defect(dilation(np.longdouble(factor)), pole, spheres([1], [1]))
        assert found == pytest.approx(abs(np.longdouble(factor)**2 - 1), rel=1e-7)
    w = np.array([[0.3, -0.4, 1.2]], np.longdouble)
    assert poisson_defect(lambda w: 2 * w, w, spheres([1], [np.nan])) == pytest.approx(2.4)


@pytest.mark.parametrize("name", ["forced_rigid_body", "point_vortices", "nambu_a38", "product"])
def test_the_flow_of_the_witness_is_poisson(name):
    """In double precision, so that differences keep about ten digits."""
    case = begin(name)
    one, leaves, h = Witness(case.spec, case.values), leaves_of(case), 5 * case.h

    def flow(w):
        return one.flow(w.astype(float), 0.3, [0.3 + h], tol=1e-14)[0].astype(np.longdouble)
    assert poisson_defect(flow, case.w.astype(np.longdouble), leaves, width=0.01) < 2e-11


def test_the_tangent_of_the_step_is_that_of_the_witness():
    """M by differences against M = (I - A P1)^-1 (I + A P1) of the witness's DX, for CM."""
    case = begin("nambu_a34")
    w = long_start(case)
    after = LongStep(case, CLASSICAL)(w)
    middle = ((w + after) / 2).astype(float)
    a = case.h / 2 * Witness(case.spec).jacobian(middle, case.h / 2)[0]
    tangent = np.linalg.solve(np.eye(3) - a, np.eye(3) + a)
    for e in frame(leaves_of(case).normal(w)[0])[:2]:
        found = derivative(LongStep(case, CLASSICAL), w, leaves_of(case), 0, e)
        assert np.abs(found - tangent @ e).max() < 1e-14


# -- the spherical midpoint ---------------------------------------------------------------------

@pytest.mark.parametrize("name", tiers([name for name in SPECS if name != TRACERS], ()))
def test_spherical_midpoint_is_symplectic(name):
    found = defect(begin(name), SPHERICAL)
    print(f"{name}: SM {found:.1e}")
    assert found < SYMPLECTIC


@pytest.mark.parametrize("text", [texts.FIELD, texts.MIXED, *(pytest.param(text, marks=pytest.mark.long) for text in (texts.PULSE, texts.OPEN_CHAIN))])
def test_spherical_midpoint_is_symplectic_beyond_the_shipped_specs(text):
    """Strengths of both signs, radii, reversed bracket, time, open ends."""
    assert defect(begin(texts.read(text)), SPHERICAL) < SYMPLECTIC


@pytest.mark.parametrize("name, solver", [
    pytest.param(name, solver, marks=() if (name, solver) in FEW_SOLVERS else pytest.mark.long)
    for name in ("heisenberg_chain", "point_vortices", "product", "two_bodies", "j1j2_chain")
    for solver in ("newton", "rotation", "plain")])
def test_every_solver_gives_the_symplectic_step(name, solver):
    assert defect(begin(name, **({"n": 12} if "chain" in name else {})), SPHERICAL,
                  solver=solver) < SYMPLECTIC


@pytest.mark.parametrize("solver", tiers(["newton", "rotation", "plain"], (), ("plain",)))
def test_a_graph_is_symplectic(solver, tmp_path):
    assert defect(begin(texts.read(texts.GLASS, tmp_path)), SPHERICAL, solver=solver) < SYMPLECTIC


@pytest.mark.parametrize("name, h", [("heisenberg_chain", 0.4), ("two_bodies", -0.5), *(
    pytest.param(name, h, marks=pytest.mark.long) for name, h in (("irreversible_rigid_body", 1.5), ("nambu_a39", 0.8), ("point_vortices", 1.5)))])
def test_symplectic_at_any_step(name, h):
    """No expansion in h: large and negative steps too; differences narrow enough for them."""
    assert defect(begin(name), SPHERICAL, h=h, steps=3, width=1e-4) < SYMPLECTIC


@pytest.mark.parametrize("name", tiers(["two_bodies", *NAMBU, "product"], ()))
def test_leaves_are_kept_off_the_started_one_too(name):
    """With the defect this makes the step a Poisson map of R^3n: W stays on the leaf of any w."""
    case = begin(name)
    step, leaves, dice = LongStep(case), leaves_of(case), np.random.default_rng(4)
    free = np.isnan(leaves.radius)
    for _ in range(5):
        w = long_start(case)
        w[free] *= 1 + 0.2 * dice.uniform(-1, 1, w[free].shape)
        before, after = (np.sum(leaves.normal(v) * v, axis=1) for v in (w, step(w)))
        assert np.abs(after - before).max() < 1e-17 * max(1, np.abs(w).max()**2)


# -- tracers ------------------------------------------------------------------------------------

def test_tracers_are_carried_by_a_symplectic_map():
    """What acts on nothing is not Hamiltonian together with what it feels.

    The vortices alone step by a Poisson map. For a given path of the vortices each tracer
    steps by an area-preserving map. The whole, with the tracers' dependence on the vortices,
    has a defect of order h: that part of M is not zero.
    """
    case = begin(TRACERS)
    vortices, tracers = np.arange(3), np.arange(3, len(case.w))
    assert defect(case, SPHERICAL, vortices) < SYMPLECTIC
    assert defect(case, SPHERICAL, tracers) < SYMPLECTIC
    assert defect(case, SPHERICAL) > 1e-3
    assert defect(case, CLASSICAL, tracers) > NOT_SYMPLECTIC


def test_tracers_leave_the_vortices_alone():
    """Bit for bit: the vortices go where they go with other tracers, or with one."""
    ends = []
    for count in (1, 7):
        case = begin(TRACERS, m=count)
        ends.append(smidgen.build(case.spec, parameters=case.values).start(case.w, h=0.1).steps(200).w[:3])
    assert np.array_equal(*ends)


# -- the comparators ----------------------------------------------------------------------------

@pytest.mark.parametrize("name", tiers([n for n in SPECS if n not in (TRACERS, "nambu_a31")], (), ("forced_rigid_body", "nambu_a34", "heisenberg_chain")))
def test_classical_midpoint_is_not_symplectic(name):
    found = defect(begin(name), CLASSICAL)
    print(f"{name}: CM {found:.1e}")
    assert found > NOT_SYMPLECTIC


def test_the_maps_coincide_on_the_heisenberg_algebra():
    """A3,1: C = w_1^2 is constant with w_1, so that C(mbar) = C(w) and m = mbar: one map."""
    case = begin("nambu_a31")
    assert defect(case, CLASSICAL) < SYMPLECTIC
    w = long_start(case)
    assert np.abs(LongStep(case, SPHERICAL)(w) - LongStep(case, CLASSICAL)(w)).max() < 1e-18


def test_classical_midpoint_is_a_rotation_in_a_linear_field():
    """H = B.w: W = R w with the Cayley matrix R of h B, a rotation and so symplectic.

    SM turns about B as well, by an angle that depends on w.B: not the same map, unless w is
    such that |mbar| = 1.
    """
    case = begin(texts.read(texts.FIELD))
    assert defect(case, CLASSICAL) < SYMPLECTIC
    w, field = long_start(case), 1.3 * np.array([0.36, 0.48, 0.8])
    angle = -2 * np.arctan(np.longdouble(case.h) * np.sqrt(field @ field) / 2)
    turned = w @ rotation(field, angle).T
    assert np.abs(LongStep(case, CLASSICAL)(w) - turned).max() < 1e-16
    assert np.abs(LongStep(case, SPHERICAL)(w) - turned).max() > 1e-4


def test_moser_veselov_is_symplectic_on_the_free_body():
    assert defect(begin("free_rigid_body"), VESELOV) < SYMPLECTIC
