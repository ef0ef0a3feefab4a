"""The classical midpoint on lattices by rows: the step that the equation has, with midpoints inside the spheres."""
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_rows import SPECS as QUADRATIC
from test_rows_any_formula import SPECS as ANY
from test_rows_by_site import SOME, close
from test_rows_in_time import SPECS as IN_TIME, by_rows

CLASSICAL = "classical-midpoint"
SPECS = {"odd ring": QUADRATIC["ring of 17"], "second neighbours": QUADRATIC["further neighbours of 12"], "open cubic": QUADRATIC["open cubic"], "cubic anisotropy": ANY["cubic"],
         "any formula": ANY["blocks"], "in time": IN_TIME["open square"], "by site": SOME, "other spheres": QUADRATIC["other spheres"]}
QUICK = ("odd ring", "any formula", "in time")


@pytest.mark.parametrize("name, method", [*(pytest.param(n, CLASSICAL, marks=() if n in QUICK else pytest.mark.long) for n in SPECS), pytest.param("in time", f"{CLASSICAL}-4", marks=pytest.mark.long)])
def test_rows_solve_the_step(name, method):
    """Against the witness, which knows no rows, from a time that is not 0."""
    assert by_rows(SPECS[name], method) and close(SPECS[name], method, steps=3) <= 2e-14


@pytest.mark.parametrize("h", [0.05, 0.29])
def test_up_to_the_largest_step_of_rows(h):
    spec = QUADRATIC["plain cubic"]
    model, witness = smidgen.build(spec, method=CLASSICAL).start("random", h=h), Witness(spec)
    for _ in range(3):
        w = model.w.copy()
        assert witness.residual(w, model.steps(1).w, 0.0, h, CLASSICAL) <= 4e-15


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SOME, method=CLASSICAL)
    assert same_in_lanes(built, (2, 4, 8))


def test_one_by_one_at_once_or_restored():
    model = smidgen.build(SPECS["in time"], method=CLASSICAL)
    assert one_by_one(model) and restored(model)


def test_what_goes_site_by_site():
    """|m| is not known, which damping asks for; and a solver that is asked for is the one that solves."""
    assert "the classical midpoint has no step by rows with `loss`" in generate(IN_TIME["damped"], CLASSICAL).notes["reason"]
    assert not by_rows(IN_TIME["damped"], CLASSICAL) and "define SMG_BY_ROWS" not in generate(SPECS["odd ring"], CLASSICAL, "newton")["ring.c"]
