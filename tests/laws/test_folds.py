"""Steps of lattices by rows around the end of their branch (tests/fuzz/folds.py): none beyond it is accepted, none before it is refused."""
import pytest
from fuzz.folds import run
from support.runtime_faults import Fault, plant

pytestmark = pytest.mark.long
REFUSED = Fault("", "smg_step.h", "  s->report.status = smg_solve_step(s, h);", "  s->report.status = smg_solve_step(s, h);\n  if (s->report.status == SMG_NO_SOLUTION) s->report.status = SMG_OK;", ())


@pytest.mark.parametrize("name", ["odd_ring", "open_chain", "square", "cubic", "joined"])
def test_steps_exist_up_to_the_end_of_their_branch(name, tmp_path):
    numbers, violations = run(name, tmp_path, 1, 0, 24)
    assert not violations and numbers["before"] > 40 and numbers["beyond"] > 0


def test_a_step_beyond_the_end_is_seen(monkeypatch, tmp_path):
    plant(monkeypatch, tmp_path, REFUSED)
    (tmp_path / "program").mkdir()
    numbers, violations = run("odd_ring", tmp_path / "program", 1, 0, 24)
    assert numbers["accepted"] > 0 and any("accepted" in line for line in violations)


NOT_OFF = Fault("", "smg_follow.h", "smg_max(pace * SMG_STRAIGHT, f->left)", "pace * SMG_STRAIGHT + 0 * f->left", ())


@pytest.mark.parametrize("fault, refused", [(None, 0), (NOT_OFF, 1)])
def test_the_end_may_be_nearer_than_the_last_point_is_to_the_curve(fault, refused, monkeypatch, tmp_path):
    """A midpoint is near the centre of its sphere there, and a correction leaves as much as the pace is long."""
    if fault:
        plant(monkeypatch, tmp_path, fault)
    (tmp_path / "program").mkdir()
    assert run("odd_ring", tmp_path / "program", 11, 103, 1)[0]["refused"] == refused
