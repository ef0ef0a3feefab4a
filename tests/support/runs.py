"""A run to stop and go on with, and the same run never stopped."""
import os

import pytest
import smidgen

from .systems import begin

FORMATS = [".h5", ".npz", ".csv"]


@pytest.fixture
def patient_disk(monkeypatch):
    """A kill, unlike a power cut, does not lose what the kernel has: fsync may be left out."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def chain_run(path, **more):
    """A ring of 20 spins whose outputs do not fall on the checkpoints."""
    spec = begin("heisenberg_chain").spec
    given = dict(parameters={"n": 20}, steps=130, every=7, checkpoint=40, what=["states", "energy", "casimirs"])
    return smidgen.run(spec, out=path, **{**given, **more})


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    """suffix -> (path, summary) of the same run, never stopped and without checkpoints."""
    folder, found = tmp_path_factory.mktemp("unbroken"), {}
    for suffix in FORMATS:
        result = chain_run(folder / f"a{suffix}", checkpoint=None)
        found[suffix] = folder / f"a{suffix}", result.summary
    return found


def same_as_unbroken(path, unbroken):
    """The same file to the last byte, and nothing beside it."""
    assert path.read_bytes() == unbroken[path.suffix][0].read_bytes()
    assert [p.name for p in path.parent.iterdir()] == [path.name]
