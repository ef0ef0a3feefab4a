"""`smidgen doctor`: what is here, what is not, and what the exit code says of it."""
import json

import pytest
from smidgen.check import doctor
from smidgen.cli import main
from smidgen.errors import MissingTool, ValidationError


def by_name(findings):
    return {f.what: f for f in findings}


def test_this_machine_is_well(capsys):
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line.split()[1] in ("numpy", "C", "cache", "validation")] == ["ok"] * 4
    assert any("free_rigid_body: 10 steps, complete" in line for line in lines)


@pytest.mark.quick
def test_without_a_compiler(monkeypatch, capsys):
    monkeypatch.setenv("CC", "no-such-compiler")
    assert main(["doctor", "--json"]) == 6
    found = {f["what"]: f for f in json.loads(capsys.readouterr().out)}
    assert found["C compiler"]["mark"] == found["a run"]["mark"] == "BAD" and "no-such-compiler" in found["C compiler"]["found"]
    assert found["threads"]["mark"] == "-" and found["numpy"]["mark"] == "ok"


@pytest.mark.quick
def test_packages_that_are_not_there(monkeypatch):
    def version(name):
        raise doctor.importlib.metadata.PackageNotFoundError(name)
    monkeypatch.setattr(doctor.importlib.metadata, "version", version)
    assert doctor.installed("numpy") == doctor.Finding("numpy", False, "pip install numpy", True)
    assert doctor.extra("h5py", "hdf5") == doctor.Finding("h5py", False, "not installed: pip install 'smidgen[hdf5]'", False)


@pytest.mark.quick
@pytest.mark.parametrize("problem, mark", [(MissingTool("the witness needs GSL: apt-get install libgsl-dev"), "-"), (ValidationError("they disagree\nby much"), "BAD")])
def test_a_missing_library_is_no_defect_but_a_disagreement_is(monkeypatch, problem, mark):
    def validate(*args, **more):
        raise problem
    monkeypatch.setattr(doctor, "validate", validate)
    found = doctor.tried("validation", doctor.validated, False)
    assert found.mark == mark and found.found == str(problem).splitlines()[0]
