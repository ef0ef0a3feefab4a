"""Faults of the runtime in one layout only: a certificate says no by the row that looks there, or says that it did not look."""
import shutil

import pytest
from support.runtime_faults import FAULTS, examined, plant, spec_of

from smidgen.check.verify.along import along
from smidgen.check.verify.contraction import contraction
from smidgen.check.verify.effort import effort
from smidgen.check.verify.members import members
from smidgen.check.verify.noise import noise
from smidgen.check.verify.refusals import refusals
from smidgen.check.verify.restore import restore
from smidgen.check.verify.row import NO, YES
from smidgen.check.verify.shared import shared
from smidgen.check.verify.whole_space import whole_space

CHECKS = {"ensemble": members, "run": along, "by rows": contraction, "tolerance": effort, "refusals": refusals, "settled": effort, "predictor": effort,
          "iterations": effort, "restore": restore, "whole space": whole_space, "threads": shared, "wavefronts": shared, "ranks": shared}
LAYOUTS = ("threads", "wavefronts", "ranks")
USUAL = ("increments in the last lane", "a sign after a restore", "a save without compensation", "a weight of degree 3 of a single sphere", "after t = 9.9",
         "the bound of rows", "the tolerance of rows")      # as others, but for their time


@pytest.fixture(autouse=True)
def as_root(monkeypatch):
    """In a container Open MPI is often root."""
    for name in ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"):
        monkeypatch.setenv(name, "1")


def looked(fault, layouts=True):
    """(verdict of the row that looks at a fault, all that was not looked at)."""
    case, subject = examined(fault, layouts)
    found = noise(spec_of(fault), case) if fault.row.startswith("noise") else CHECKS[fault.row](case, subject)
    rows = {row.name: row for row in found}
    print(*rows.values(), *case.unseen, sep="\n")
    return rows[fault.row].verdict, case.unseen


@pytest.mark.parametrize("name", [name if name in USUAL else pytest.param(name, marks=pytest.mark.long) for name in FAULTS])
def test_a_fault_in_one_layout_gets_its_no(monkeypatch, tmp_path, name):
    fault = FAULTS[name]
    if fault.row == "ranks" and not (shutil.which("mpirun") and shutil.which("mpicc")):
        pytest.skip("no MPI")
    (tmp_path / "right").mkdir()
    with monkeypatch.context() as one:
        plant(one, tmp_path / "right", None)
        assert looked(fault)[0] == YES
    plant(monkeypatch, tmp_path, fault)
    assert looked(fault)[0] == NO
