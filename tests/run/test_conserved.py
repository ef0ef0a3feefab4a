"""The energy that is reported, and what is called an error: one rule for run, plot, player and demo."""
import json

import numpy as np
import pytest
from support.systems import tiers

import smidgen
from smidgen import cli
from smidgen.run.record.conserved import conserved_axes, driven
from smidgen.show.demo import systems
from smidgen.show.plot import facts, page, player
from smidgen.read.shipped import shipped

TEXT = """[model]
name = "m"
[space]
w = {{ sphere = 3 }}
p = {{ sphere = 2, tracer = true }}
[effects.inner]
over = "pair(i, j) of w"
energy = "{inner}"
[effects.outer]
over = "each(i of w, j of p)"
energy = "{outer}"
[starts.a.w]
random = 1
[starts.a.p]
random = 2
[runs.demo]
start = "a"
h = 0.05
steps = 40
output = {{ what = ["states", "energy", "momentum", "casimirs"] }}
"""
PAIR, FIELD = "dot(w[i], w[j])", "dot(w[i], w[j]) + w[i].x + w[i].y"
FILM = """
[model]
name = "film"
[space]
w = { sphere = 64 }
[effects.exchange]
over = "bond(i, j) of square(8, 8)"
energy = "-dot(w[i], w[j])"
[starts.one]
theta = "0.3*cos(i)"
phi = "i"
[runs.film]
start = "one"
h = 0.1
steps = 10
"""
CASES = {       # inner, outer: is the energy conserved, in how many directions the momentum
    "neither": (PAIR, "3*dot(w[i], p[j])", True, 3),
    "tracers feel time": (PAIR, "3*cos(t)*dot(w[i], p[j])", True, 3),
    "H depends on time": ("(1 + cos(t))*" + PAIR, "3*dot(w[i], p[j])", False, 3),
    "a tilted field": (FIELD, "3*dot(w[i], p[j])", True, 1),
    "no symmetry": (FIELD + " + w[i].z^2*w[j].x", "3*dot(w[i], p[j])", True, 0),
}

cases = pytest.mark.parametrize("case", tiers(CASES, (), ("tracers feel time", "H depends on time", "a tilted field")))


@cases
def test_one_energy_in_run_plot_player_and_demo(case, monkeypatch):
    inner, outer, conserved, _ = CASES[case]
    result = smidgen.run(smidgen.load_text(TEXT.format(inner=inner, outer=outer)))
    own = result.values["energy.inner"]
    change = np.abs(own - own[0]).max()
    told = result.summary
    assert told["errors" if conserved else "changes"]["energy"] == change and told["without"] == ["outer"]
    assert "energy" not in told["changes" if conserved else "errors"]
    result = facts.with_facts(result)
    energy, note = facts.conserved_energy(result)
    assert np.array_equal(energy, own) and ("time" in note) == (not conserved) and "tracers" in note
    played = []
    monkeypatch.setattr(player, "player_page", lambda t, states, energy, *more, **words: played.append(energy) or "")
    page(result)
    assert np.array_equal(played[0], own)
    error = systems.energy_error(result)
    assert error == change if conserved else np.isnan(error)


@cases
def test_momentum_is_an_error_where_it_is_conserved_and_a_change_elsewhere(case):
    inner, outer, _, count = CASES[case]
    spec = smidgen.load_text(TEXT.format(inner=inner, outer=outer))
    result = smidgen.run(spec)
    errors, changes = result.summary["errors"], result.summary["changes"]
    assert len(conserved_axes(smidgen.build(spec).start("a", h=0.1))) == count
    assert ("momentum" in errors) == (count > 0) and ("momentum" in changes) == (count < 3)
    assert errors.get("momentum", 0) < 1e-13 and changes.get("momentum", 1) > 1e-3 and errors["casimirs"] < 1e-14


def test_no_digits_below_the_round_off_of_the_momentum(capsys, tmp_path):
    """Spins 1e-10 off the axis that they turn about: the direction that is kept is known to 1e-16, and the change along it would read 1e-25."""
    text = TEXT.format(inner="0.7*(w[i].z + w[j].z) - dot(w[i], w[j])/3", outer="0")
    text = text.replace("[starts.a.w]\nrandom = 1", '[starts.a.w]\ntheta = "1e-10*(i + 1)"\nphi = "0.2"')
    result = smidgen.run(smidgen.load_text(text))
    assert result.summary["errors"]["momentum"] == 0 and 1e-11 < result.summary["changes"]["momentum"] < 1e-8
    (tmp_path / "m.toml").write_text(text)
    assert cli.main(["run", str(tmp_path / "m.toml"), "--no-estimate"]) == 0 and "momentum along z 0, " in (said := capsys.readouterr().out) and "momentum along x, y 1.1e-09" in said


@pytest.mark.parametrize("h, said", [("0.05", "by rows"), ("0.9", "site by site")])
def test_a_run_tells_whether_it_went_by_rows(h, said, capsys, tmp_path):
    """A film of 8 x 8 spins with four bonds each: 0.9 is beyond the bound, where sweeps need not converge. A run with the name of its model is told apart."""
    (tmp_path / "m.toml").write_text(FILM)
    assert cli.main(["run", str(tmp_path / "m.toml"), "--h", h, "--steps", "12", "--no-estimate"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("model film, run film: spherical") and f"this run was solved {said}" in told


@pytest.mark.long
@pytest.mark.parametrize("name", shipped())
def test_what_the_field_says_is_what_the_formulas_prove(name):
    """The directions of the momentum by numbers, and the proofs of `explain`."""
    spec = smidgen.load(name)
    run = spec.runs[0]
    report = smidgen.explain(spec, parameters=dict(run.parameters), effects=run.effects)
    own = {f.name for f in spec.families if not f.tracer}
    proved = sum(len(axes) for names, axes in report.rotations if own <= set(names))
    model = smidgen.build(spec, parameters=dict(run.parameters), effects=run.effects).start(run.start, h=0.01)
    if any(f.kind == "nambu" for f in spec.families):
        assert len(conserved_axes(model)) == 0
    else:
        assert len(conserved_axes(model)) == proved
    assert driven(spec, run.effects) == report.energy_changes


FAST = """[model]
name = "m"
[space]
w = { sphere = 1 }
[effects.field]
energy = "8*w.x"
[starts.a]
vectors = [[0, 0, 1]]
[runs.demo]
start = "a"
h = 0.1
steps = 20
"""


@pytest.mark.parametrize("words, code", [(["--h", "0.5"], 4), (["--steps", "0"], 0), (["--every", "1000"], 0)])
def test_a_run_without_a_second_output_says_nothing_of_errors(tmp_path, capsys, words, code):
    """A step of h |b| = 4 across the field does not exist."""
    path = tmp_path / "m.toml"
    path.write_text(FAST)
    assert cli.main(["run", str(path), *words]) == code
    said = capsys.readouterr().out
    assert "m demo" in said and "energy" not in said and "casimirs" not in said
    assert cli.main(["run", str(path), *words, "--json"]) == code
    told = json.loads(capsys.readouterr().out)
    assert told["errors"] == told["changes"] == {}


def test_a_run_that_fails_later_tells_the_errors_up_to_there(tmp_path, capsys):
    path = tmp_path / "m.toml"
    path.write_text(FAST.replace('"8*w.x"', '"if(t < 0.5, 8, 80)*w.x"'))
    assert cli.main(["run", str(path)]) == 4
    said = capsys.readouterr().out
    assert "\nerror of the last state (absolute): momentum" in said and "status: failed" in said
    assert "not conserved, largest change over the outputs (absolute): energy" in said


def test_the_summary_of_a_command_calls_no_change_an_error(capsys):
    assert cli.main(["run", "forced_rigid_body", "--steps", "20", "--every", "1"]) == 0
    said = capsys.readouterr().out
    error, change, last = (next(line for line in said.splitlines() if line.startswith(word)) for word in ("largest error", "not conserved, largest", "not conserved, change of the last state"))
    assert "energy" in change and "momentum" in last and "casimirs" in error and "energy" not in error
