"""A run warns when the midpoint of a site nears the centre of its sphere: exact distances of a spin in a field."""
import json
from pathlib import Path

import numpy as np
import pytest
import smidgen
from smidgen import cli
from smidgen.run.step.block import NEAR, Block
from support.systems import begin

FIELD = """
[model]
name = "field"
[space]
w = {{ {kind} = {n} }}
[effects.field]
over = "site(i) of w"
energy = "w[i].z"
[starts.across]
x = "{size}*if(i == {n} - 1, 1, 0)"
y = "0"
z = "{size}*if(i == {n} - 1, 0, 1)"
[runs.demo]
start = "across"
h = {h}
steps = 10
output = {{ every = {every}, what = ["energy"] }}
"""


def nearest(h, kind="sphere", n=1, every=1, size="1", **more):
    """What a run says of a spin across a field, the last of n; the others lie along it."""
    spec = smidgen.load_text(FIELD.format(kind=kind, n=n, h=h, every=every, size=size))
    return smidgen.run(spec, **more).summary["nearest"]


@pytest.mark.quick
def test_the_distance_is_exact():
    """Across the field sin(phi/2) = h/2 and rho = cos(phi/2)."""
    found = nearest(1.9975)
    assert found["rho"] == pytest.approx(np.sqrt(1 - 1.9975**2 / 4), rel=1e-12) and found["rho"] < NEAR
    assert found["site"] == 0 and found["step"] in range(1, 11) and found["t"] == found["step"] * 1.9975
    assert nearest(1.98) is None


@pytest.mark.parametrize("kind, size", [("sphere", "1"), ("r3", "3")])
def test_among_others_and_on_factors_r3(kind, size):
    """The site is named; the distance is in units of |w|."""
    found = nearest(1.9975, kind, 5, size=size)
    assert found["site"] == 4 and found["rho"] == pytest.approx(np.sqrt(1 - 1.9975**2 / 4), rel=1e-10)


@pytest.mark.parametrize("name, h", [("spins_in_field", 1.9), ("two_spins", 2.2)])
def test_the_distance_of_a_step_is_that_of_its_midpoint(name, h):
    """|w + W|/2 of single steps, one of closed forms, one of increments that are remembered."""
    one = smidgen.build(smidgen.load(Path(__file__).parents[1] / "hard" / "specs" / f"{name}.toml"))
    w = np.random.default_rng(4).normal(size=(one.sites, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    for _ in range(5):
        block = Block(one, states=True)
        one.start(w.copy(), h=h).outputs(1, 1, block, 0, 1)
        rho = np.linalg.norm(w + block.states[0], axis=1) / 2
        assert [block.nearest[0]] * 2 == pytest.approx([rho.min()**2, rho[block.where[0]]**2], rel=1e-12) and block.where[1] == 1
        w = block.states[0].copy()


def test_only_of_the_method_that_projects():
    """The classical midpoint has no such centre; Nambu factors have none of this kind."""
    assert nearest(1.9975, method="classical-midpoint") is None
    case = begin("nambu_a34")
    assert smidgen.run(case.spec).summary["nearest"] is None


def test_the_steps_to_outputs_are_looked_at():
    """Of many sites too; of steps between two outputs the last."""
    assert nearest(1.9975, n=5000, steps=1)["step"] == 1
    assert nearest(1.9975, every=5, steps=10)["step"] in (5, 10)
    assert nearest(1.9975, every=5, steps=4) is None


def test_a_run_that_goes_on_knows_what_was_near_before(tmp_path):
    """The field is strong in the first two steps alone."""
    spec, calls = smidgen.load_text(FIELD.format(kind="sphere", n=1, h=1.9975, every=1, size=1).replace('"w[i].z"', '"w[i].z*if(t < 3, 1, 0.1)"')), []

    def stop(done):
        calls.append(done)
        if len(calls) == 4:
            raise RuntimeError

    whole = smidgen.run(spec, steps=40).summary["nearest"]
    with pytest.raises(RuntimeError):
        smidgen.run(spec, steps=40, out=tmp_path / "a.npz", checkpoint=5, progress=stop)
    assert whole["step"] in (1, 2) and smidgen.resume(tmp_path / "a.npz").summary["nearest"] == whole


def test_the_command_warns(tmp_path, capsys):
    path = tmp_path / "field.toml"
    path.write_text(FIELD.format(kind="sphere", n=1, h=1.9975, every=1, size="1"))
    assert cli.main(["run", str(path)]) == 0
    said = capsys.readouterr()
    assert "warning: in step" in said.err + said.out and "site 0 came within 0.05 radii" in said.err + said.out
    assert cli.main(["run", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nearest"]["site"] == 0
