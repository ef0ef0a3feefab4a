"""Faults of the runtime in one layout only: a certificate says no by the row that looks there, or says that it did not look."""
import shutil
from types import SimpleNamespace

import pytest
from support.runtime_faults import FAULTS, Fault, examined, plant, planted, spec_of

from smidgen.check.verify.along import along
from smidgen.check.verify.contraction import contraction
from smidgen.check.verify.effort import effort
from smidgen.check.verify.members import members
from smidgen.check.verify.noise import noise
from smidgen.check.verify.refusals import refusals
from smidgen.check.verify.restore import restore
from smidgen.check.verify.row import NO, NOT_APPLICABLE, YES
from smidgen.check.verify.shared import broken, shared
from smidgen.check.verify.whole_space import whole_space
from smidgen.check.verify.witness_check import step


def one_step(case, subject):
    case.find_states(subject)
    return [step(case, subject)]


CHECKS = {"ensemble": members, "run": along, "step": one_step, "by rows": contraction, "tolerance": effort, "refusals": refusals, "settled": effort, "predictor": effort,
          "iterations": effort, "restore": restore, "whole space": whole_space, "threads": shared, "wavefronts": shared, "ranks": shared}
LAYOUTS = ("threads", "wavefronts", "ranks")
USUAL = ("increments in the last lane", "a sign after a restore", "a save without compensation", "a weight of degree 3 of a single sphere", "after t = 9.9",
         "the bound of rows", "the tolerance of rows", "the second thread")      # as others, but for their time


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


GROWING = '[effects.more]\nover = "bond(i, j) of square(n, n, periodic)"\nenergy = "-0.3*t*dot(w[i], w[j])"\n'


@pytest.mark.long
def test_couplings_that_grow_are_held_to_the_time_of_their_steps(monkeypatch, tmp_path):
    """At the end of the run they are a hundred times as strong as at the start, and steps that go by rows there are shorter."""
    plant(monkeypatch, tmp_path, None)
    text, values = planted(GROWING)
    case, subject = examined(Fault("by rows", "", "", "", (text.replace("steps = 30", "steps = 2000"), values)), False)
    (row,) = contraction(case, subject)
    assert row.verdict == YES and row.measured < 1


def test_what_is_not_known_of_stages_by_rows_is_said():
    case = SimpleNamespace(settings=SimpleNamespace(method="spherical-midpoint-4"), unseen=[])
    (row,) = contraction(case, SimpleNamespace(double=SimpleNamespace(notes={"threads": True})))
    assert "no equation for a stage" in row.note and case.unseen == ["by rows: whether the sweeps of every stage contract"]


@pytest.mark.parametrize("files, said, verdict, note", [
    ({}, "----\nmpirun has detected an attempt to run as root.\n----\n", NOT_APPLICABLE, "mpirun: mpirun has detected"),
    ({"began-0": "", "began-1": ""}, "----\nPrimary job\n----\nrank 1 exited on signal 11 (Segmentation fault).\n", NO, "exited on signal 11"),
    ({"began-0": "", "began-1": "", "found-0": ""}, "", NO, "exit code 3"),
    ({"began-0": "", "failed-0": "RunError: no step"}, "Traceback\n", NO, "RunError: no step")])
def test_ranks_that_began_and_did_not_finish_are_a_no(tmp_path, files, said, verdict, note):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    case = SimpleNamespace(unseen=[])
    row = broken(case, tmp_path, SimpleNamespace(stderr=said, returncode=3))
    assert row.verdict == verdict and note in row.note and bool(case.unseen) == (verdict == NOT_APPLICABLE)
