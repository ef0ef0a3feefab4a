"""Compiled numbers against the witness (its own interpreter, derivatives, solver) and plain numpy.

Energy and field at random points; a hundred steps of the spec's own h, by every method.
"""
import numpy as np
import pytest
from support.numpy_systems import SYSTEMS, strengths
from support import texts
from support.measure import STEPS, hundred_steps
from support.systems import (CLASSICAL, FREE_BODIES, QUICK, SHORT, SPECS, SPHERICAL, VESELOV, begin,
                             tiers, model)

from smidgen.errors import UsageError
from smidgen.run.step.evaluated import radii
from smidgen.check.witness import Witness

EPSILON = np.finfo(float).eps
TEXTS = {"mixed": texts.MIXED, "pulse": texts.PULSE, "corners": texts.CORNERS, "open": texts.OPEN_CHAIN}
unusual = pytest.mark.parametrize("name", tiers(TEXTS, (), ("corners",)))


def random_states(case, count, seed=0):
    """States anywhere on the spheres, elsewhere of a random length; each with a time."""
    dice, radius = np.random.default_rng(seed), radii(case.spec, case.values)
    for _ in range(count):
        w = dice.standard_normal(case.w.shape)
        length = np.where(np.isnan(radius), dice.uniform(0.5, 2, len(w)), radius)
        yield w * (length / np.linalg.norm(w, axis=1))[:, None], float(dice.uniform(0, 10))


# -- energy and field ---------------------------------------------------------------------------

def numbers(case, w, t):
    """(energy, field) three times: compiled, witness, numpy (None for specs of texts)."""
    compiled = model(case).start(case.w, h=case.h)
    one = Witness(case.spec, case.values)
    found = [(compiled.energy(w, t), compiled.field(w, t)), (one.energy(w, t), one.field(w, t))]
    if case.spec.name in SYSTEMS:
        energy, gradient = SYSTEMS[case.spec.name](one.values, w, t)
        found.append((energy, gradient / strengths(case.spec.name, one.values)))
    return found, one


def scatter(one, w, t, seed=5):
    """What one unit in the last place of w does to energy and field: the error that data carry."""
    moved = w * (1 + 2**-30 * np.random.default_rng(seed).uniform(-1, 1, w.shape))
    apart = (abs(one.energy(moved, t) - one.energy(w, t)),
             np.abs(one.field(moved, t) - one.field(w, t)).max())
    return [EPSILON * 2**30 * d for d in apart]


def check_numbers(case):
    for w, t in random_states(case, 4):
        found, one = numbers(case, w, t)
        (energy, field), *others = found
        data = scatter(one, w, t)
        for other_energy, other_field in others:
            size = max(1, abs(energy), float(np.sum(np.abs(field * w))))
            assert abs(energy - other_energy) <= 4 * EPSILON * size + 4 * data[0]
            assert np.abs(field - other_field).max() <= 8 * EPSILON * max(1, np.abs(field).max()) + 8 * data[1]


@pytest.mark.parametrize("name", tiers(SPECS))
def test_energy_and_field(name):
    check_numbers(begin(name))


@unusual
def test_energy_and_field_of_unusual_specs(name):
    check_numbers(begin(texts.read(TEXTS[name])))


def test_energy_and_field_on_a_graph(tmp_path):
    check_numbers(begin(texts.read(texts.GLASS, tmp_path)))


@pytest.mark.quick
def test_numpy_has_every_system():
    assert sorted(SYSTEMS) == SPECS


@pytest.mark.quick
def test_a_wrong_coefficient_would_show():
    """The comparison above has teeth: the same system with one part in 1e13 more inertia fails."""
    case = begin("free_rigid_body")
    wrong = begin("free_rigid_body", I1=1.0 + 1e-13)
    w, t = next(random_states(case, 1))
    field = model(case).start(case.w, h=0.1).field(w, t)
    other = model(wrong).start(case.w, h=0.1).field(w, t)
    assert np.abs(field - other).max() > 8 * EPSILON * max(1, np.abs(field).max())


# -- a hundred steps ----------------------------------------------------------------------------

def check_steps(case, method, **more):
    apart, allowed, grown = hundred_steps(case, method, **more)
    print(f"{case.spec.name} {SHORT[method]}: {apart:.1e} <= {allowed:.1e}, tangent growth {grown:.3g}")
    assert apart <= allowed


@pytest.mark.parametrize("name", tiers(SPECS, few=("product", "two_bodies", "point_vortices")))
def test_spherical_midpoint_takes_the_steps_of_the_witness(name):
    case = begin(name)
    assert len(case.w) <= 100
    check_steps(case, SPHERICAL)


@pytest.mark.parametrize("name, values, method", [
    ("heisenberg_chain", {"n": 12}, SPHERICAL), ("cubic_lattice", {"nx": 3, "ny": 3, "nz": 3}, SPHERICAL), ("vortex_tracers", {"m": 4}, SPHERICAL),
    ("heisenberg_chain", {"n": 12}, CLASSICAL), pytest.param("cubic_lattice", {"nx": 3, "ny": 3, "nz": 3}, CLASSICAL, marks=pytest.mark.long),
    pytest.param("vortex_tracers", {"m": 4}, CLASSICAL, marks=pytest.mark.long)])
def test_systems_of_a_few_sites_take_the_steps_of_the_witness(name, values, method):
    check_steps(begin(name, **values), method)


@pytest.mark.parametrize("name", tiers(SPECS, QUICK[:2], ()))
def test_classical_midpoint_takes_the_steps_of_the_witness(name):
    check_steps(begin(name), CLASSICAL)


@pytest.mark.quick
def test_moser_veselov_takes_the_steps_of_the_witness():
    check_steps(begin("free_rigid_body"), VESELOV)


@unusual
def test_unusual_specs_take_the_steps_of_the_witness(name):
    check_steps(begin(texts.read(TEXTS[name])), SPHERICAL)


FEW_SOLVERS = [("heisenberg_chain", "rotation"), ("point_vortices", "newton"), ("two_bodies", "plain")]


@pytest.mark.parametrize("name, solver", [pytest.param(name, solver, marks=() if (name, solver) in FEW_SOLVERS else pytest.mark.long)
                                          for name in ("heisenberg_chain", "point_vortices", "product", "two_bodies", "vortex_tracers")
                                          for solver in ("newton", "rotation", "plain")])
def test_every_solver_takes_the_steps_of_the_witness(name, solver):
    check_steps(begin(name, **({"n": 20} if name == "heisenberg_chain" else {})), SPHERICAL, solver=solver)


@pytest.mark.parametrize("solver", tiers(["newton", "rotation", "plain"], (), ("newton",)))
def test_a_graph_takes_the_steps_of_the_witness(solver, tmp_path):
    check_steps(begin(texts.read(texts.GLASS, tmp_path)), SPHERICAL, solver=solver)


@pytest.mark.quick
def test_another_method_would_show():
    """The comparison sees a step of another method, and one taken at another time."""
    case = begin("forced_rigid_body")
    apart, allowed, _ = hundred_steps(case, CLASSICAL)
    other = Witness(case.spec).steps(case.w, 0.0, case.h, STEPS, SPHERICAL)[-1]
    late = Witness(case.spec).steps(case.w, 0.01, case.h, STEPS, CLASSICAL)[-1]
    end = model(case, CLASSICAL).start(case.w.copy(), h=case.h).steps(STEPS).w
    assert apart <= allowed < min(np.abs(other - end).max(), np.abs(late - end).max())


@pytest.mark.quick
def test_moser_veselov_refuses_what_is_no_free_body():
    for name in SPECS:
        if name not in FREE_BODIES:
            with pytest.raises(UsageError, match="moser-veselov needs"):
                model(begin(name), VESELOV)
