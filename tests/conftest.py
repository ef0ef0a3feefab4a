"""Fixtures that tests share."""
import os
import subprocess
import sys
from pathlib import Path

import pytest

import smidgen
from smidgen.run import integrator
from smidgen.build.library import build_library

sys.path.insert(0, str(Path(__file__).parent))
ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Builds of the tests leave the user's cache alone."""
    os.environ["SMIDGEN_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def root():
    """The checkout."""
    return ROOT


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """The spec of tests/toy.py, with its hand-written C in place of the compiler's."""
    import toy as model
    monkeypatch.setattr(integrator, "build_library",
                        lambda *args: build_library(*args, generate=model.generate))
    path = tmp_path / "toy.toml"
    path.write_text(model.SPEC)
    return smidgen.load(str(path))


@pytest.fixture
def command(tmp_path):
    """Run `smidgen ...` in a folder of its own; returns the finished process."""
    def call(*words, **more):
        more = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 300, **more}
        return subprocess.run([sys.executable, "-m", "smidgen", *map(str, words)], **more)
    return call
