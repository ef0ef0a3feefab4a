"""Fixtures that tests share."""
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import traceback
import warnings
from pathlib import Path

import pytest

import smidgen
from smidgen.build import binary, cache
from smidgen.build.binary import build_library
from smidgen.check.verify import branch, certificate, order
from smidgen.check.verify.case import Case
from smidgen.cli import main
from smidgen.run.step import integrator

HERE = Path(__file__).parent
sys.path[:0] = map(str, (HERE, *sorted({path.parent for path in HERE.rglob("test_*.py")} - {HERE})))      # tests import from each other
from support.strict import CALLS     # noqa: E402

ROOT = Path(__file__).parent.parent
SLOW = frozenset(line for line in (ROOT / "tests/slow.txt").read_text().splitlines() if not line.startswith("#"))
FLAGS = binary.FLAGS


def pytest_configure(config):
    """What is marked long or slow is not quick, in a quick file either."""
    if config.option.markexpr == "quick":
        config.option.markexpr = "quick and not long and not slow"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests by the names of slow.txt are slow."""
    for item in items:
        if item.nodeid in SLOW:
            item.add_marker("slow")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Builds of the tests leave the user's cache alone, and all processes of one run share them: none is made twice."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    os.environ["SMIDGEN_CACHE"] = str(place)
    cache.KEPT = 10_000     # more models than a user keeps


@pytest.fixture(scope="session", autouse=True)
def cheaper_builds():
    """-O0 in place of -O3, and calls in place of inlined text, here and in what is forked: the same bits, compiled in a quarter of
    the time. Programs that tests start anew use -O3, and files whose runs are long ask for `optimised`."""
    with built_at("-O0", CALLS):
        yield


@pytest.fixture(scope="module")
def optimised():
    """-O1: a step takes a fifth of the time, and compiling it twice."""
    with built_at("-O1"):
        yield


@pytest.fixture
def as_shipped():
    """The flags of a user's build, for runs of minutes."""
    with built_at("-O3"):
        yield


@pytest.fixture
def optimised_here():
    """The same for one test."""
    with built_at("-O1"):
        yield


@contextlib.contextmanager
def built_at(*level):
    before = binary.FLAGS
    binary.FLAGS = (*(f for f in FLAGS if not f.startswith("-O")), *level)
    yield
    binary.FLAGS = before


@pytest.fixture
def few_states(monkeypatch):
    """A certificate looks at as few states as that of `--quick`, and at fewer branches, however long its orbits are."""
    monkeypatch.setattr(Case, "of_tier", lambda self, table: table["quick"])
    monkeypatch.setitem(certificate.STATES, "normal", certificate.STATES["quick"])
    monkeypatch.setattr(branch, "STATES", (2, 6, 6))
    monkeypatch.setattr(order, "FLOW_HALVINGS", 7)


@pytest.fixture
def root():
    """The checkout."""
    return ROOT


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """The spec of tests/support/toy.py, with its hand-written C in place of the compiler's."""
    from support import toy as model
    monkeypatch.setattr(integrator, "build_library",
                        lambda *args, **more: build_library(*args, generate=model.generate, **more))
    path = tmp_path / "toy.toml"
    path.write_text(model.SPEC)
    return smidgen.load(str(path))


@pytest.fixture
def command(tmp_path):
    """Run `smidgen ...` in a folder of its own; returns the finished process.

    The process is a fork of this one, which has imported everything: a new interpreter would need half a second for that.
    """
    def call(*words, cwd=tmp_path, env=None):
        words = [*map(str, words)]
        said = [tempfile.TemporaryFile() for _ in range(2)]
        child = os.fork()
        if not child:
            in_a_fork(words, cwd, env, said)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        return subprocess.CompletedProcess(words, code, *map(text_of, said))
    return call


def in_a_fork(words, cwd, env, said):
    """What `python -m smidgen` does with these words; never returns."""
    code = 1
    try:
        for number, file in enumerate([open(os.devnull, "rb"), *said]):
            os.dup2(file.fileno(), number)
        sys.stdin, sys.stdout, sys.stderr = (open(k, "w" if k else "r", closefd=False, encoding="utf-8") for k in range(3))
        signal.signal(signal.SIGINT, signal.default_int_handler)
        warnings.showwarning = lambda *args: sys.stderr.write(warnings.formatwarning(*args[:4]))     # pytest would keep them
        warnings.resetwarnings()
        for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", kind)
        os.chdir(cwd)
        if env is not None:
            os.environ.clear()
            os.environ.update(env)
        code = main(words)
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def text_of(file):
    """All that was written to it."""
    with file:
        file.seek(0)
        return file.read().decode()
