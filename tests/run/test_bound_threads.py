"""Threads are bound to processors where a process has one for each and none to spare, unless the user says otherwise."""
import os
import subprocess
import sys

import pytest
from smidgen import ranks
from smidgen.run.step import library

PROGRAM = """import os, smidgen
count = len(os.sched_getaffinity(0))
model = smidgen.build("cubic_lattice", parameters={"nx": 20, "ny": 20, "nz": 20}, threads=count).start("random", h=0.02).steps(3)
allowed = sorted(len(os.sched_getaffinity(int(task))) for task in os.listdir("/proc/self/task"))
print(count, len(os.sched_getaffinity(0)), allowed.count(1), "OMP_PROC_BIND" in os.environ)
"""


@pytest.fixture
def four(monkeypatch):
    """Four processors, and no wishes."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1, 2, 3}, raising=False)
    for name in library.PLACED:
        monkeypatch.delenv(name, raising=False)


@pytest.mark.quick
@pytest.mark.parametrize("threads, bound", [(None, False), (1, False), (2, False), (4, True), (8, False)])
def test_as_many_as_there_are_processors(four, threads, bound):
    assert library.binds(threads) == bound


@pytest.mark.quick
@pytest.mark.parametrize("name", library.PLACED)
def test_the_user_has_the_last_word(four, monkeypatch, name):
    monkeypatch.setenv(name, "false")
    assert not library.binds(4)


@pytest.mark.quick
def test_ranks_are_placed_by_who_starts_them(four, monkeypatch):
    monkeypatch.setattr(ranks, "count", lambda: 2)
    assert not library.binds(4)


@pytest.mark.quick
def test_the_environment_is_as_it_was(four, monkeypatch):
    seen = {}
    monkeypatch.setattr(os, "sched_setaffinity", lambda process, processors: seen.update(restored=processors), raising=False)
    monkeypatch.setattr(library, "loaded", lambda path: seen.update({name: os.environ.get(name) for name in ("OMP_PROC_BIND", "OMP_PLACES")}))
    before = dict(os.environ)
    library.loaded_with_threads("model.so", 4)
    assert seen == {"restored": {0, 1, 2, 3}, "OMP_PROC_BIND": "close", "OMP_PLACES": "threads"} and dict(os.environ) == before


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2, reason="one processor")
def test_threads_that_join_are_bound_and_the_one_that_calls_is_not():
    environment = {name: value for name, value in os.environ.items() if name not in library.PLACED}
    count, free, bound, said = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True).stdout.split()
    assert free == count and int(bound) == int(count) - 1 and said == "False"
