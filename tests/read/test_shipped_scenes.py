"""The scenes that come with smidgen: short, of pieces, and each does what it is there to show."""
import numpy as np
import pytest

import smidgen
from smidgen.check.validate import validate
from smidgen.cli.effects import is_spec
from smidgen.compile.select import select
from smidgen.resources import scenes, shipped

quick = pytest.mark.quick


@quick
@pytest.mark.parametrize("name", scenes())
def test_scenes_are_short_and_by_name(name):
    text = scenes()[name].read_text()
    assert len(text.splitlines()) <= 40 and 'use = "' in text and name not in shipped() and is_spec(name)
    spec = smidgen.load(name)
    assert spec.runs[0].name == "demo" and spec.title and spec.name == name and all(p.meaning for p in spec.parameters)
    assert len({select(spec, run.effects).effect_names for run in spec.runs}) == len(spec.runs)


SMALL = {"chiral_film": {"n": 4}, "pyrochlore": {"n": 2}, "film_in_units": {"n": 4}, "film_pulse": {"n": 4}, "stirred_sphere": {"m": 5}}


@pytest.mark.long
@pytest.mark.parametrize("name, run", [(name, run) for name, runs in (("chiral_film", ["demo"]), ("pyrochlore", ["demo"]), ("film_in_units", ["demo"]), ("film_pulse", ["demo"]), ("stirred_sphere", ["demo"]), ("tumbling_satellite", ["demo", "without_sloshing"])) for run in runs])
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_scenes_agree_with_the_witness_and_have_a_certificate(name, run):
    spec, values = smidgen.load(name), SMALL.get(name, {})
    assert {r.name for r in spec.runs} <= {"demo", "without_sloshing"}
    validate(spec, run, parameters=values).check()
    smidgen.verify(spec, run, parameters=values, tier="quick").check()


@quick
def test_there_are_six():
    assert list(scenes()) == ["chiral_film", "film_in_units", "film_pulse", "pyrochlore", "stirred_sphere", "tumbling_satellite"]


@quick
def test_the_satellite_comes_to_rest_as_a_gyrostat():
    """Where w is along the angular velocity, at the least energy; without sloshing it tumbles on."""
    end = smidgen.run(smidgen.load("tumbling_satellite"), time=2000, every=20_000, what=["states", "energy"])
    inertia = np.array([[1, 0.1, 0], [0.1, 2, 0], [0, 0, 4]])
    w = end.final[0]
    omega = np.linalg.solve(inertia, w - [0.3, 0, 0])
    assert np.linalg.norm(np.cross(w, omega)) < 1e-6 and abs(np.linalg.norm(w) - np.linalg.norm(end.w["w"][0, 0])) < 1e-14
    sphere = np.random.default_rng(0).standard_normal((2000, 3))
    others = np.linalg.norm(w) * sphere / np.linalg.norm(sphere, axis=1)[:, None] - [0.3, 0, 0]
    assert end.values["energy"][-1] <= (others * np.linalg.solve(inertia, others.T).T).sum(1).min() / 2
    free = smidgen.run(smidgen.load("tumbling_satellite"), "without_sloshing", what=["states", "energy"])
    assert np.ptp(free.values["energy"]) < 1e-3 and np.ptp(free.w["w"][-500:, 0], axis=0).max() > 1


@quick
def test_the_film_is_hit_and_calms_down():
    found = smidgen.run(smidgen.load("film_pulse"), what=["magnetisation"])
    mz = found.values["magnetisation.w"][:, 2]
    assert mz[0] == 1 and mz.min() < 0.8 and mz[-1] > 0.9
    cold = smidgen.run(smidgen.load("film_pulse"), parameters={"kT": 0.0, "D": 0.0}, time=0.2, every=4, what=["states"])
    assert found.values["magnetisation.w"][1, 2] < 1 - 1e-4 and np.isfinite(cold.final).all()


@quick
def test_the_sphere_is_stirred_and_what_is_small_is_validated():
    few = {"m": 20}
    spec = smidgen.load("stirred_sphere")
    assert all(line.passed for line in validate(spec, parameters=few).lines)
    found = smidgen.run(spec, parameters={"m": 200}, what=["states", "energy", "momentum"])
    z = found.w["p"][:, :, 2]
    assert z[0].min() > 0.69 and np.ptp(z[-1]) > 1 and np.ptp(found.values["momentum.w"][:, 2]) < 1e-13


@quick
def test_the_film_in_units_is_tilted_and_comes_back():
    """A spin of it precesses about a field of 1 T by 0.1759 rad/ps."""
    spec = smidgen.load("film_in_units")
    alone = smidgen.run(spec, effects=["pulse"], parameters={"n": 1, "B0": "1 T", "tau": "1 us"}, time="1 ps", what=["states"])
    turned = np.arctan2(alone.w["w"][-1, 0, 0], alone.w["w"][-1, 0, 2])
    assert turned - np.radians(0.5) == pytest.approx(0.175882000838, abs=1e-9)
    found = smidgen.run(spec, what=["magnetisation"], parameters={"n": 8})
    mz = found.values["magnetisation.w"][:, 2]
    assert mz[0] > 0.99 and mz.min() < 0.9 < mz[-20:].mean() + 0.1


@quick
def test_skyrmions_stay():
    """One in each 16 x 16 sites, while the film loses energy."""
    found = smidgen.run(smidgen.load("chiral_film"), parameters={"n": 32}, time=5)
    assert np.allclose(found["charge.w"], -4) and found["energy"][-1] < found["energy"][0]


@quick
def test_spins_of_a_tetrahedron_nearly_add_up_to_nothing():
    found = smidgen.run(smidgen.load("pyrochlore"))
    assert abs(found["correlation"][0]) < 0.1 and -1 / 3 < found["correlation"][-1] < -0.3
