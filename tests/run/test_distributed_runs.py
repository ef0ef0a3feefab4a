"""`smidgen run --distributed`: the numbers of one rank in a file that all ranks write, also after a stop, and what is refused."""
import json
import os
import subprocess
import sys

import h5py
import numpy as np
import pytest
import smidgen
from smidgen import ranks
from smidgen.cli import main
from smidgen.run.distributed.run import resume_distributed
from smidgen.run.files.places import Place, finish, lay_out, write_at
from smidgen.run.step.start import initial_state, part_of_state
from smidgen.run.step.evaluated import Evaluated
from test_ranks import MPI, SMALL, mpirun, needs_mpi4py
from test_rows import EXCHANGE, FIELD, lattice

DRIVER = """
import os, sys
from smidgen import ranks
from smidgen.build import binary
from smidgen.cli import main
from smidgen.errors import UsageError
from smidgen.run.distributed import rows
binary.FLAGS = tuple("-O0" if f == "-O3" else f for f in binary.FLAGS)
fault, saves, real = os.environ.get("FAULT"), 0, rows.Rows.save
def save(*given):
    global saves
    real(*given)
    saves += 1
    if saves == 3 and (ranks.variable(ranks.RANK) or 0) == 1:
        if fault == "kill": os._exit(9)
        if fault == "error": raise UsageError("planted")
rows.Rows.save = save
sys.exit(main())
"""
MAGNET = lattice("magnet", "cubic(4, 4, n, periodic)", 24, "16*n", EXCHANGE + FIELD)
GIVEN = ("magnet.toml", "--start", "random", "--h", "0.1", "--steps", "12", "--every", "4", "--what", "states,energy,momentum",
         "--no-estimate")


@pytest.fixture
def magnet(tmp_path, monkeypatch):
    """run(count, *words): the command in a folder with a magnet of 384 spins."""
    (tmp_path / "magnet.toml").write_text(MAGNET.sources[0][1])
    (tmp_path / "driver.py").write_text(DRIVER)
    monkeypatch.setenv("CC", f"gcc -Wno-psabi {' '.join(SMALL)}")

    def run(count, *words, **environment):
        words = [sys.executable, "driver.py", "run", *map(str, words)]
        if count > 1:
            return mpirun(count, *words, cwd=tmp_path, **environment)
        return subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, **MPI, **environment})
    run.where = tmp_path
    return run


def same(a, b) -> bool:
    """Do two results hold the same numbers, to the bit?"""
    a, b = smidgen.load_result(a), smidgen.load_result(b)
    pairs = [*((a[name], b[name]) for name in a.keys()), (a.final, b.final), (a.positions, b.positions)]
    return a.keys() == b.keys() and a.meta["status"] == b.meta["status"] and all(x.tobytes() == y.tobytes() for x, y in pairs)


def test_absent_sites_are_0_in_the_file(magnet, monkeypatch):
    """As in that of any other run; window by window."""
    from smidgen.run.distributed.run import run_distributed
    from smidgen.run.step import divided
    monkeypatch.setattr(divided, "WINDOW", 100)
    spec = smidgen.load_text(MAGNET.sources[0][1] + '[effects.holes]\nover = "site(k) of w"\nabsent = "mod(k, 7) == 3"\n')
    run, given = None, dict(start="random", h=0.1, steps=4, every=2, what=("states", "energy"), estimate=False)
    smidgen.run(spec, run, out=magnet.where / "one.h5", **given)
    run_distributed(spec, run, magnet.where / "two.h5", **given)
    found = smidgen.load_result(magnet.where / "two.h5")
    assert same(magnet.where / "one.h5", magnet.where / "two.h5")
    assert not found.final[3::7].any() and not found.w["w"][:, 3::7].any() and found.final[4::7].all()


@needs_mpi4py
@pytest.mark.long
def test_ranks_write_what_one_writes(magnet):
    """Stopped at a checkpoint by a kill, the run goes on with another number of ranks."""
    assert magnet(1, *GIVEN, "--out", "one.h5").returncode == 0
    said = magnet(2, *GIVEN, "--out", "two.h5", "--distributed")
    assert said.returncode == 0, said.stderr
    assert same(magnet.where / "one.h5", magnet.where / "two.h5") and said.stdout.count("wrote two.h5") == 1
    assert magnet(2, *GIVEN, "--out", "again.h5", "--distributed", "--checkpoint", "3", FAULT="kill").returncode == 9
    folder = magnet.where / "again.h5.distributed"
    assert json.loads((folder / "newest.json").read_text())["count"] == 6 and not (magnet.where / "again.h5").exists()
    said = magnet(3, "--resume", "again.h5")
    assert said.returncode == 0, said.stderr
    assert same(magnet.where / "one.h5", magnet.where / "again.h5") and not folder.exists()


@needs_mpi4py
@pytest.mark.long
def test_a_rank_that_fails_ends_all(magnet):
    said = magnet(2, *GIVEN, "--out", "all.h5", "--distributed", "--checkpoint", "2", FAULT="error")
    assert said.returncode == 2 and "smidgen: planted" in said.stderr
    said = magnet(2, *GIVEN, "--out", "all.h5", "--distributed")
    assert said.returncode == 8 and "continue with `smidgen run --resume all.h5`" in said.stderr


@pytest.mark.long
def test_what_cannot_be_written_leaves_no_trace(magnet):
    """A folder that is missing; a limit on the size of files, which the layout of the result exceeds."""
    before = sorted(path.name for path in magnet.where.iterdir())
    said = magnet(1, *GIVEN, "--out", "nowhere/a.h5", "--distributed")
    assert said.returncode == 8 and "cannot write nowhere/a.h5" in said.stderr
    words = f"ulimit -f 20; exec {sys.executable} driver.py run {' '.join(GIVEN)} --out b.h5 --distributed"
    said = subprocess.run(["bash", "-c", words], cwd=magnet.where, capture_output=True, text=True, env={**os.environ, **MPI})
    assert said.returncode == 8 and "cannot write b.h5" in said.stderr
    assert sorted(path.name for path in magnet.where.iterdir()) == before


@pytest.mark.parametrize("given", ["{}", "[]", '{"spec": "magnet", "sources": 3}'])
def test_metadata_that_are_none_are_refused(tmp_path, given):
    (tmp_path / "a.h5.distributed").mkdir()
    newest = {"count": 2, "rows": 1, "seconds": 0.5, "first": None, "largest": 0.0, "checkpoint": 2}
    for name, text in (("run.json", given), ("newest.json", json.dumps(newest))):
        (tmp_path / "a.h5.distributed" / name).write_text(text)
    with pytest.raises(smidgen.CheckpointError, match="run.json is not a file of a smidgen run"):
        resume_distributed(tmp_path / "a.h5")


@needs_mpi4py
@pytest.mark.long
def test_a_checkpoint_that_is_another_is_refused(magnet):
    """Neither a path nor a place in a file is taken from what lies there."""
    assert magnet(2, *GIVEN, "--out", "a.h5", "--distributed", "--checkpoint", "2", FAULT="error").returncode == 2
    folder = magnet.where / "a.h5.distributed"
    good = json.loads((folder / "newest.json").read_text())
    for wrong in ({"count": "../state"}, {"count": 10**9}, {"rows": None}, {"more": 1}):
        (folder / "newest.json").write_text(json.dumps({**good, **wrong}))
        said = magnet(1, "--resume", "a.h5")
        assert said.returncode in (2, 8) and "checkpoint" in said.stderr and "Traceback" not in said.stderr
    (folder / "newest.json").write_text(json.dumps(good))
    with h5py.File(folder / "result.h5", "w") as other:
        other["final"] = 1.0
    said = magnet(1, "--resume", "a.h5")
    assert said.returncode in (2, 8) and "not those of the checkpoint" in said.stderr


REFUSED = [(("--out", "a.npz"), "writes HDF5 in parts"), ((), "writes HDF5 in parts"),
           (("--out", "a.h5", "--what", "casimirs"), "there is no output 'casimirs'"),
           (("--out", "a.h5", "--substeps"), "does not support --substeps"),
           (("--out", "a.h5", "--start", "w.npy"), "the start must be one of those in the spec")]


@pytest.mark.parametrize("words, said", REFUSED)
def test_what_needs_the_whole_state_is_refused(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "magnet.toml").write_text(MAGNET.sources[0][1])
    np.save("w.npy", initial_state(MAGNET, "random"))
    given = ["run", "magnet.toml", "--start", "random", "--h", "0.1", "--steps", "4", "--what", "states", "--distributed", *words]
    assert main(given) == 2 and said in capsys.readouterr().err


def test_starts_in_parts_are_those_of_the_whole():
    numbers = Evaluated(MAGNET)
    whole = initial_state(MAGNET, "random")
    assert len(whole) == 384
    for first, count in ((0, 7), (100, 84), (383, 1)):
        assert part_of_state(numbers, "random", None, first, count).tobytes() == whole[first:first + count].tobytes()


def test_a_file_of_places(tmp_path):
    """Parts are written in any order; of a run that ended early the rows that there are remain."""
    path = tmp_path / "a.h5"
    places = lay_out(path, {"t": ((3,), np.dtype(float)), "w": ((3, 5, 3), np.dtype(float)), "final": ((5, 3), np.dtype(float))})
    assert all(isinstance(place, Place) for place in places.values())
    w = np.arange(45.0).reshape(3, 5, 3)
    handle = os.open(path, os.O_WRONLY)
    for k in (1, 0):
        write_at(handle, w[k, 3:], places["w"].row(k) + 72)
        write_at(handle, w[k, :3], places["w"].row(k))
        write_at(handle, np.array([0.5 * k]), places["t"].row(k))
    write_at(handle, w[2], places["final"].offset)
    os.close(handle)
    finish(path, {"families": {"w": 5}}, 2, ["t", "w"])
    h5py = pytest.importorskip("h5py")
    with h5py.File(path) as h5:
        assert np.array_equal(h5["w"], w[:2]) and np.array_equal(h5["t"], [0, 0.5]) and np.array_equal(h5["final"], w[2])
        assert "longer" not in h5 and h5["w"].dims[0][0].name == "/t"


def test_an_error_of_one_is_raised_by_all(monkeypatch):
    class Comm:
        def allgather(self, mine):
            return [mine, OSError("disk full")]

    monkeypatch.setattr(ranks, "world", type("World", (), {"comm": Comm(), "rank": 0})())
    with pytest.raises(OSError, match="disk full"):
        ranks.on_all(lambda: 1)
