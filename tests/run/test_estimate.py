"""The estimate of a run's error is withheld where step sizes disagree about it, and metadata say why."""
import math
from importlib import import_module

import numpy as np
import pytest
import smidgen
from smidgen.cli import main
from smidgen.language.spec import LOOSEST
from smidgen.methods import METHODS
from smidgen.run.estimate import Other, judged

EPS = float(np.finfo(float).eps)
module = import_module("smidgen.run.run")
ROTATING = """
[model]
name = "stirred"

[space]
w = { sphere = 3, kappa = "gamma[i]" }
p = { sphere = 100, tracer = true }

[parameters]
gamma = { default = [1.0, -0.6, 0.8], size = 3 }
omega = 0.5

[effects.interaction]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"

[effects.transport]
over = "each(i of p, j of w)"
energy = "-gamma[j]*log(2 - 2*dot(p[i], w[j]))/(4*pi)"

[effects.rotation]
over = "site(i) of p"
energy = "-omega*p[i].z"

[starts.spread.w]
theta = [1.0, 1.4, 2.0]
phi = [0.0, 2.1, 4.0]

[starts.spread.p]
theta = "acos(1 - (2*i + 1)/100)"
phi = "2.399963229728653*i"
"""


def distance(a, b):
    return np.linalg.norm(a - b, axis=1).max() / np.linalg.norm(a, axis=1).max()


def test_no_estimate_of_tracers_near_vortices_is_far_off():
    """Half as many steps alone would say .03 where the error is .12; at a tenth of the time the estimate is right."""
    spec = smidgen.load_text(ROTATING)
    start = np.random.default_rng(1).normal(size=(12, 103, 3))[8]
    start /= np.linalg.norm(start, axis=1)[:, None]
    far = smidgen.run(spec, start=start, h=0.01, steps=500, estimate=True)
    assert far.meta["end_error"] is None and "order 2 predicts a ratio of 4" in far.meta["end_error_withheld"]
    near = smidgen.run(spec, start=start, h=0.01, steps=50, estimate=True)
    error = distance(near.final, smidgen.run(spec, start=start, h=0.01 / 16, steps=800).final)
    assert error / 1.5 < near.meta["end_error"] < 1.5 * error and near.meta["end_error_withheld"] is None


def test_sites_that_are_not_there_do_not_make_the_error_smaller():
    """States have them as unit vectors, a thousand times as long as these; a state of zeros has no error."""
    spec = smidgen.load_text('''[model]
name = "small_vectors"
[space]
w = { r3 = 4 }
[effects.twist]
over = "site(i) of w"
energy = "1e3*w[i].z^2*w[i].x"
[effects.gone]
over = "site(i) of w"
absent = "i == 2"
[starts.a]
w = { x = "1e-3*(1 + i)", y = "2e-3", z = "1e-3" }
[runs.demo]
start = "a"
h = 0.1
steps = 100
''')
    found = smidgen.run(spec, estimate=True)
    error = distance(found.final, smidgen.run(spec, h=0.1 / 16, steps=1600).final)
    assert error / 1.5 < found.meta["end_error"] < 1.5 * error
    assert smidgen.run(spec, start=np.zeros((4, 3)), estimate=True).meta["end_error"] < 1e-14


@pytest.mark.quick
def test_what_two_step_sizes_say():
    """Distances of the ends with half and twice as many steps: 3 and 3/4 of the error by order 2."""
    pair = [Other(50, None, 4.0), Other(200, None, 0.25)]
    method = METHODS["spherical-midpoint"]

    def said(coarse, fine):
        return judged(method, 100, pair, [coarse, fine], EPS)
    assert math.isclose(said(0.03, 0.0075)[0], 0.01, rel_tol=1e-9) and said(0.03, 0.0075)[1] is None
    assert said(0.03, 0.0149)[0] and said(0.03, 0.0038)[0]
    error, why = said(0.03, 0.016)
    assert error is None and "50 steps changed it by 0.03 and 200 steps changed it by 0.016, but order 2 predicts a ratio of 4" in why
    assert said(0.03, 0.0037)[0] is None
    assert said(0.0, 0.0)[0] == EPS * 10                     # exact, but for round-off
    assert said(3e-14, 3e-14)[0] < 1e-13                    # round-off on both sides says nothing about the order


@pytest.mark.quick
def test_step_control_may_do_better_than_the_tolerance_not_worse():
    pair = [Other(70, 8e-6, 8.0), Other(130, 1e-6 / 32, 0.125)]

    def said(coarse, fine):
        return judged(METHODS["dop853"], 100, pair, [coarse, fine], EPS)[0]
    assert said(0.07, 0.000875) and said(0.0, 0.000875) and said(0.007, 0.000875)
    assert said(0.001, 0.000875) is None


@pytest.mark.quick
def test_the_reason_is_in_the_metadata_and_is_repeated(tmp_path, command):
    spec = smidgen.load("irreversible_rigid_body")
    for end in "csv", "npz", "h5":
        meta = smidgen.run(spec, h=1, steps=10, estimate=True, out=tmp_path / f"a.{end}").meta
        assert meta["end_error"] is None and meta["end_error_withheld"]
        assert smidgen.load_result(tmp_path / f"a.{end}").meta["end_error_withheld"] == meta["end_error_withheld"]
    said = command("run", "irreversible_rigid_body", "--h", "1", "--steps", "10", "--json").stdout
    assert '"end_error_withheld": "' in said and '"end_error": null' in said
    said = command("run", "irreversible_rigid_body", "--h", "1", "--steps", "10").stdout
    assert "error of the final state: no estimate: " in said and "estimated error" not in said


@pytest.mark.quick
def test_the_loosest_tolerance_has_an_estimate_or_a_reason():
    meta = smidgen.run(smidgen.load("free_rigid_body"), method="dop853", h=1, steps=4, tolerance=LOOSEST, estimate=True).meta
    assert (meta["end_error"] is None) != (meta["end_error_withheld"] is None)


@pytest.mark.quick
@pytest.mark.parametrize("longest, words, taken, said", [(0.0, [], False, "use --estimate"), (np.inf, [], True, "estimated error of the final state: "),
                                                         (0.0, ["--estimate"], True, "estimated error of the final state: "), (np.inf, ["--no-estimate"], False, None)])
def test_a_long_run_is_repeated_where_that_is_asked_for(monkeypatch, capsys, tmp_path, longest, words, taken, said):
    """`longest`: the seconds up to which a run is short. The file says what was done, and its repetition, on a machine of any speed, has its bytes."""
    monkeypatch.setattr(module, "SHORT", longest)
    one, two = tmp_path / "one.npz", tmp_path / "two.npz"
    assert main(["run", "free_rigid_body", "--steps", "80", "--out", str(one), *words]) == 0
    told = capsys.readouterr().out
    assert said in told if said else "estimate" not in told
    meta = smidgen.load_result(one).meta
    assert meta["estimate"] is taken and (meta["end_error"] is not None) is taken and meta["end_error_withheld"] is None
    monkeypatch.setattr(module, "SHORT", np.inf if longest == 0 else 0.0)
    assert main(["run", "--repeat", str(one), "--out", str(two)]) == 0 and one.read_bytes() == two.read_bytes()
    assert main(["run", "--repeat", str(one), "--estimate"]) == 2


@pytest.mark.quick
def test_a_run_that_goes_on_decides_at_its_end(monkeypatch, tmp_path, capsys):
    """Its time is that of all its parts; what it was begun with is what it is asked to go on with."""
    monkeypatch.setattr(module, "SHORT", 0.0)
    spec, out = smidgen.load("free_rigid_body"), tmp_path / "a.npz"

    def stop(done):
        if done >= 40:
            raise KeyError
    with pytest.raises(KeyError):
        smidgen.run(spec, steps=80, checkpoint=20, estimate=None, out=out, progress=stop)
    assert main(["run", "--resume", str(out), "--json"]) == 0
    assert '"estimate_left_out": true' in capsys.readouterr().out and smidgen.load_result(out).meta["estimate"] is False
