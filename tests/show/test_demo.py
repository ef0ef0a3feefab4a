"""The demo: its parts by themselves, and one small demo from end to end."""
import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import mpmath
import numpy as np
import pytest
from support.pages import blocks, python, sh

import smidgen
from smidgen.show.demo import exact, experiments, moving, paths, stages, systems
from smidgen.run.record.conserved import conserved_axes, of_time, with_tracers
from smidgen.show.plot import facts, gallery, portraits
from smidgen.show.plot.text import in_script
from smidgen.show.plot.equilibria import equilibria
from smidgen.show.plot.figures import FIGURES
from smidgen.read.shipped import load_spec
from smidgen.resources import scenes, shipped

FREE_BODY = {(1, 2, 4): (-0.45036353307, -0.09362899306, 0.88792246270),
             (1, 4 / 3, 2): (-0.44165602784, 0.14621487230, 0.88518990289)}


# -- the exact solution ----------------------------------------------------------------------

@pytest.mark.parametrize("m", [0.0, 0.26, 0.52, 0.999])
def test_jacobi_functions_are_those_of_mpmath(m):
    u = np.linspace(-9, 9, 37)
    for name, values in zip(("sn", "cn", "dn"), exact.jacobi(u, m)):
        known = [float(mpmath.ellipfun(name, x, m=m)) for x in u]
        assert np.allclose(values, known, atol=2e-14, rtol=0)


@pytest.mark.parametrize("moments", FREE_BODY)
def test_free_body_at_ten(moments):
    assert np.allclose(exact.free_body(moments, 1.1, [10.0])[0], FREE_BODY[moments], atol=1e-11)


def test_free_body_has_another_form_elsewhere():
    with pytest.raises(ValueError):
        exact.free_body((1, 2, 4), 0.3, [0.0])


# -- paths -----------------------------------------------------------------------------------

def test_covering_leaves_no_gap():
    def parallel(w):
        t = np.linspace(0, 2 * np.pi, 200)
        r = np.hypot(w[0], w[1])
        return np.stack([r * np.cos(t), r * np.sin(t), np.full(200, w[2])], axis=1)

    curves = paths.covering(parallel, 0.3)
    rest = np.min([paths.gaps(paths.spiral(500), c) for c in curves], axis=0)
    assert rest.max() <= 0.3 and len(curves) < 30


def test_closed_stops_after_one_turn():
    t = np.linspace(0, 7 * np.pi, 5000)
    circle = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    once = paths.closed(circle)
    assert np.array_equal(once[0], once[-1])
    assert abs(len(once) - 2 / 7 * 5000) < 5
    assert len(paths.closed(circle[:700])) == 700


# -- what the table says ---------------------------------------------------------------------

@pytest.mark.parametrize("name, axes", [("heisenberg_chain", "xyz"), ("point_vortices", "xyz"),
                                        ("free_rigid_body", ""), ("nambu_a36", ""),
                                        ("vortex_tracers", "xyz")])
def test_conserved_momentum_is_found_from_the_field(name, axes):
    spec = load_spec(name)
    model = smidgen.build(spec).start(spec.starts[0].name, h=0.1)
    found = conserved_axes(model)
    kept = np.linalg.norm(np.eye(3) @ found.T, axis=1) if len(found) else np.zeros(3)
    assert "".join(x for x, size in zip("xyz", kept) if abs(size - 1) < 1e-9) == axes and len(found) == len(axes)


def test_energies_that_are_not_conserved_are_known():
    forced = load_spec("forced_rigid_body")
    assert of_time(forced) and not of_time(forced, {"rotation"})
    assert not of_time(load_spec("free_rigid_body"))
    assert with_tracers(load_spec("vortex_tracers")) == {"transport"}


def test_energy_of_tracers_is_left_out():
    result = facts.with_facts(smidgen.run(load_spec("vortex_tracers"), steps=10, every=1))
    energy, note = facts.conserved_energy(result)
    assert np.array_equal(energy, result.values["energy.interaction"]) and "tracers" in note


def test_a_failed_line_fails_the_demo(monkeypatch, tmp_path, capsys):
    broken = systems.Outcome("free_rigid_body", note="</td><script>")
    monkeypatch.setattr(stages, "perform", lambda tasks, out, jobs: {tasks[0]: broken})
    assert stages.demo(tmp_path, 1, [("system", "free_rigid_body")]) == smidgen.errors.Exit.VALIDATION
    assert "FAILED" in capsys.readouterr().out
    page = (tmp_path / "index.html").read_text()
    assert "</td><script>" not in page and "0 of 1 runs passed" in page and "FAILED" in page


def test_lost_momentum_is_a_fault():
    spec = load_spec("heisenberg_chain")
    result = facts.with_facts(smidgen.run(spec, "demo", steps=10, every=1,
                                          what=["states", "energy", "momentum", "casimirs"]))
    model = systems.started(smidgen.build(spec), result)
    assert systems.losses(model, spec, result) == ([], [])
    result.values["momentum.w"][3, 1] += 1e-6
    result.values["casimirs"][3, 1] += 1e-6
    faults, _ = systems.losses(model, spec, result)
    assert len(faults) == 2 and "momentum" in faults[1]


def test_a_spec_that_cannot_be_read_is_a_failed_line(tmp_path):
    outcome = systems.system("no_such_spec", tmp_path)
    assert not outcome.passed and "UsageError" in outcome.note


def test_tasks():
    everything = stages.chosen("")
    assert {n for k, n in everything if k == "figure"} == set(FIGURES) == set(experiments.EXPERIMENTS)
    assert {n.split(":")[0] for k, n in everything if k == "system"} == {*shipped(), *scenes()}
    assert stages.chosen("lagrange") == [("system", "lagrange")]
    assert stages.main(["--only", "lagrangian"]) == smidgen.errors.Exit.USAGE


def test_small_demo(tmp_path, capsys):
    """One system and two figures, in two processes: a table, a page, no failure."""
    code = stages.main(["--out", str(tmp_path), "--only", "nambu_a38,irreversible_energy,moving_body"])
    said = capsys.readouterr()
    assert code == 0, said.out + said.err
    assert "1 of 1 systems and 2 of 2 figures" in said.out and "nambu_a38" in said.out
    page = (tmp_path / "index.html").read_text()
    assert page.count('href="player_nambu_a38.html"') == 1 and page.count("<img") == 3 and page.count("<canvas") == 1
    assert "doi.org/10.1090/mcom/3153" in page and f"smidgen {smidgen.__version__}" in page and "Figure 4(c)" in page
    assert "1 of 1 runs passed every check" in page and "\u2264 1e-11" in page and len(page) < 200_000


@pytest.mark.long
def test_the_spheres_that_move_are_light():
    """All three together: what is left of 1 MB is for the table and the words."""
    made = [gallery.Picture(name, None, "", moving={**experiments.EXPERIMENTS[name]()[0], "seconds": 1}) for name in ("moving_body", "moving_section", "moving_vortices")]
    assert len(in_script([gallery.numbers(p) for p in made])) < 600_000


def test_chaotic_orbits_are_cut_into_parts_of_equal_length():
    """No point is lost or drawn twice."""
    points = lambda w, periods: w + np.arange(periods + 1.0)[:, None]
    regular, chaotic = moving.section_layers(points, [np.zeros(3), np.full(3, 0.5)], lambda orbit, found: found[0, 0] > 0)
    assert regular["w"].shape == (moving.PERIODS + 1, 1, 3) and chaotic["w"].shape == (moving.PERIODS + 1, moving.PART, 3)
    assert np.array_equal(np.sort(chaotic["w"][..., 0].ravel()), 0.5 + np.arange(moving.PART * (moving.PERIODS + 1)))


# -- figures ---------------------------------------------------------------------------------

def test_figure_data_fits_its_function():
    """Both rigid-body energies to three digits, and the figure drawn from them."""
    data, caption = experiments.irreversible_energy()
    assert "+3.950e-03" in caption and "+1.1979e-02" in caption
    assert "-2.441e-03" in caption and "+1.091e-03" in caption
    assert len(FIGURES["irreversible_energy"].draw(**data).axes) == 2


def test_irreversible_body_has_more_equilibria_than_poles():
    """grad H = mu w with w_k(1 + w_k)/I_k = mu w_k: each w_k is 0 or mu I_k - 1, here solved."""
    model = smidgen.build(load_spec("irreversible_rigid_body")).start(h=0.1)
    found = equilibria(lambda w: model.field(w[None], 0.0)[0])
    expected = []
    for free in ([0], [1], [2], [0, 1], [0, 2], [1, 2], [0, 1, 2]):
        inertia = np.array([1.0, 2.0, 4.0])[free]
        for mu in np.roots([inertia @ inertia, -2 * inertia.sum(), len(free) - 1]):
            w = np.zeros(3)
            w[free] = mu * inertia - 1
            if np.all(np.abs(w[free]) > 1e-9):
                expected.append(w)
    assert len(found) == len(expected) == 12
    assert all(min(np.linalg.norm(w - v) for v, _ in found) < 1e-5 for w in expected)


def test_starts_on_a_leaf_stay_on_it():
    A = np.diag([1.0, -1.0, 0.5])
    starts = experiments.starts_on_leaf(A, np.array([1.0, 0.4, -0.6]))
    level = [w @ A @ w for w in starts]
    assert len(starts) == 4 and np.allclose(level, level[0])


def test_singular_points_of_the_manifold_are_those_where_vortices_meet():
    for w, kind in experiments.manifold_marks():
        four = portraits.on_manifold(np.arccos(w[2]), np.arctan2(w[1], w[0]))
        gaps = [np.linalg.norm(four[i] - four[j]) for i in range(4) for j in range(i)]
        assert (min(gaps) < 1e-7) == (kind == "singular")


@pytest.mark.long
@pytest.mark.parametrize("name", FIGURES)
def test_every_figure(name):
    data, caption = experiments.EXPERIMENTS[name]()
    figure = FIGURES[name].draw(**stages.posed(data))
    assert figure.axes and (caption or not data)
    for ax in figure.axes:
        assert len(ax.lines) + len(ax.collections) + len(ax.images) > 0


@pytest.mark.long
def test_the_page_of_figures(tmp_path):
    for script in blocks("figures.md", "sh"):
        sh(script, tmp_path)
    for program in blocks("figures.md", "python"):
        python(program, tmp_path)


DEMO = """import sys
from pathlib import Path
from smidgen.show.demo.stages import perform
if __name__ == "__main__":
    perform([("system", "free_rigid_body")] * 2, Path(sys.argv[1]), 2)
"""


@pytest.mark.long
def test_no_process_outlives_a_demo_that_is_killed(tmp_path):
    (tmp_path / "demo.py").write_text(DEMO)
    run = subprocess.Popen([sys.executable, str(tmp_path / "demo.py"), str(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    try:
        while len(Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()) < 3:       # both workers, and what multiprocessing keeps
            assert run.poll() is None
            time.sleep(0.02)
        os.kill(run.pid, signal.SIGKILL)
        run.communicate(timeout=240)            # ends when nobody has its output open any more
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)
