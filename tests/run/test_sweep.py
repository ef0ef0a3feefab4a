"""Sweeps: every cell is the run that it names; what has ended stays, whatever stops the rest."""
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import smidgen
from smidgen.language import limits
from smidgen.run import interrupts
from smidgen.run.many import sweep as module
from smidgen.run.files.checkpoint import Folder
from smidgen.run.many.sweep import sweep
from support import crash

SPEC = """
[model]
name = "swept"
[space]
w = { sphere = 1 }
[parameters]
a = 0.3
b = 1.0
n = 1.0
[effects.only]
energy = "b*w.x^2 + a*w.y^3 + sin(t)*w.z"
[starts.any]
random = 1
[starts.one]
vectors = [[0.6, 0, 0.8]]
[runs.demo]
start = "any"
h = 0.1
steps = 20
output = { every = 10, what = ["states", "energy"] }
[runs.wide]
start = "any"
h = 1.2
steps = 60
output = { every = 20, what = ["states"] }
[runs.one]
start = "one"
h = 0.1
steps = 4
"""


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "swept.toml"
    file.write_text(SPEC)
    return file


def lines(folder: Path) -> list:
    return [json.loads(line) for line in (folder / "cells.jsonl").read_text().splitlines() if line]


def test_every_cell_is_its_run(command, path):
    said = command("sweep", path, "--set", "a=0:0.6:3", "--set", "b=2", "--starts", 2, "--seed", 5, "--out", path.parent / "cells", "--processes", 2)
    assert said.returncode == 0 and said.stdout.startswith("6 cells in ")
    spec, k = smidgen.load(path), 0
    for a in (0, 0.3, 0.6):
        for seed in (5, 6):
            found = smidgen.load_result(path.parent / "cells" / f"cell-{k}.npz")
            wanted = smidgen.run(spec, parameters={"a": a, "b": 2}, seed=seed)
            assert np.array_equal(found.final, wanted.final) and found.meta["parameters"] == {"a": a, "b": 2} and found.meta["seed"] == seed
            k += 1


def test_the_command_takes_the_choices_of_a_run(command, path):
    folder = path.parent / "cells"
    words = ["sweep", path, "one", "--set", "a=0.3:0.3:1", "--steps", 6, "--period", 0.3, "--tolerance", 1e-3, "--substeps", "--real", "long double", "--estimate", "--out", folder]
    said = command(*words)
    assert said.returncode == 0, said.stderr
    wanted = smidgen.run(path, "one", parameters={"a": 0.3}, steps=6, period=0.3, tolerance=1e-3, substeps=True, real="long double", estimate=True)
    found = smidgen.load_result(folder / "cell-0.npz")
    assert found.step.tolist() == [0, 3, 6] and np.array_equal(found.final, wanted.final) and found.meta == json.loads(json.dumps(wanted.meta))
    assert command(*words, "--every", 2).returncode == 2


def test_names_may_come_from_a_generator(path, tmp_path):
    found = sweep(path, out=tmp_path / "out", axes={"b": np.array([0.5, 1.0])}, what=(name for name in ["energy"]), effects=iter(["only"]), processes=1)
    assert [cell["status"] for cell in found] == ["complete"] * 2
    assert smidgen.load_result(tmp_path / "out/cell-1.npz").w is None
    found = sweep(path, out=tmp_path / "kinds", axes={"b": np.arange(1, 3), "a": [np.float32(0.5), np.longdouble(1)]}, steps=2, processes=1)
    assert [cell["parameters"] for cell in found] == [{"b": b, "a": a} for b in (1, 2) for a in (0.5, 1)]
    assert sweep(path, out=tmp_path / "kinds", axes={"b": [1, 2], "a": [0.5, 1.0]}, steps=2, processes=1) == found
    for values in (0.5, "0.5", np.array(0.5), iter([0.5]), {"b": 1}):
        with pytest.raises(smidgen.UsageError, match="the axis 'b' of a sweep must be a list of values"):
            sweep(path, out=tmp_path / "other", axes={"b": values})


def test_failed_cells_are_kept_and_named(command, path):
    folder = path.parent / "cells"
    said = command("sweep", path, "wide", "--set", "a=0:0.9:3", "--starts", 6, "--out", folder)
    found = {line["cell"]: line for line in lines(folder)}
    failed = [line for line in found.values() if line["status"] == "failed"]
    assert said.returncode == 4 and len(found) == 18 and 0 < len(failed) < 18
    for line in failed:
        assert f"cell {line['cell']} (a = {line['parameters']['a']}, seed {line['seed']}): {line['error']}" in said.stdout
        result = smidgen.load_result(folder / line["file"])
        assert result.meta["status"].startswith("failed: step") and result.meta["done"] < 60
    before = (folder / "cells.jsonl").read_text()
    again = command("sweep", path, "wide", "--set", "a=0:0.9:3", "--starts", 6, "--out", folder, "--json")
    assert again.returncode == 4 and (folder / "cells.jsonl").read_text() == before
    assert sorted(cell["cell"] for cell in json.loads(again.stdout)["cells"]) == list(range(18))


def test_a_sweep_that_is_killed_goes_on(path):
    """SIGKILL of it and its processes at any moment; what had ended is not done again, and the end is the same."""
    folder = path.parent / "cells"
    words = [sys.executable, "-m", "smidgen", "sweep", str(path), "--set", "a=0:0.5:40", "--steps", "20000", "--every", "20000", "--out", str(folder), "--processes", "2"]
    child = subprocess.Popen(words, start_new_session=True)
    while child.poll() is None and not ((folder / "cells.jsonl").exists() and len((folder / "cells.jsonl").read_text().splitlines()) > 4):
        time.sleep(0.05)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    with open(folder / "cells.jsonl", "a") as out:
        out.write('{"cell": 39, "val')        # a line that was cut
    done = {cell: os.stat(folder / f"cell-{cell}.npz").st_mtime_ns for cell in (json.loads(x)["cell"] for x in (folder / "cells.jsonl").read_text().splitlines()[1:-1] if x)}
    assert 0 < len(done) < 40
    assert subprocess.run(words).returncode == 0
    assert all(os.stat(folder / f"cell-{cell}.npz").st_mtime_ns == when for cell, when in done.items())
    whole = sweep(smidgen.load(path), None, axes={"a": [0.5 * k / 39 for k in range(39)] + [0.5]}, out=path.parent / "whole", steps=20000, every=20000)
    assert len(whole) == 40
    for k in (0, 20, 39):
        assert np.array_equal(*(smidgen.load_result(path.parent / place / f"cell-{k}.npz").final for place in ("cells", "whole")))


def test_cells_with_checkpoints_go_on_from_them(path):
    """Of a run with checkpoints in its spec: a sweep that was killed has left some."""
    spec, axes = smidgen.load_text(SPEC.replace("[runs.demo]", "[runs.demo]\ncheckpoint = 5")), {"b": [1.0, 2.0]}
    whole, folder = path.parent / "whole", path.parent / "cells"
    told = sweep(spec, out=whole, axes=axes, processes=1)
    folder.mkdir()
    (folder / "manifest.json").write_bytes((whole / "manifest.json").read_bytes())
    crash.forked(lambda: crash.Deadly(25) and smidgen.run(spec, parameters={"b": 2.0}, out=folder / "cell-1.npz"))
    assert Folder(folder / "cell-1.npz").parts("state")[-1].number in (5, 10, 15)
    assert sweep(spec, out=folder, axes=axes, processes=1) == told
    for file in ("cell-0.npz", "cell-1.npz"):
        assert (folder / file).read_bytes() == (whole / file).read_bytes()
    assert sorted(os.listdir(folder)) == sorted(os.listdir(whole))


def test_two_sweeps_at_a_time_in_one_folder_are_refused(path, tmp_path):
    given, said = dict(out=tmp_path / "out", axes={"a": [0.1, 0.2]}, steps=2, processes=1), []

    def again(outcome):
        with pytest.raises(smidgen.errors.OutputError, match="another sweep is writing to .*out: wait"):
            sweep(path, **given)
        said.append(outcome["cell"])

    found = sweep(path, **given, tell=again)
    assert said == [0, 1] and sweep(path, **given) == found


def test_a_process_that_is_killed_is_told(path, monkeypatch):
    monkeypatch.setattr(module, "run", lambda *args, **more: os.kill(os.getpid(), signal.SIGKILL))
    with pytest.raises(smidgen.RunError, match="was killed; the same command continues"):
        sweep(smidgen.load(path), None, axes={"a": [0.1, 0.2]}, out=path.parent / "cells")


def test_another_sweep_and_another_folder_are_refused(command, path):
    folder = path.parent / "cells"
    assert command("sweep", path, "one", "--set", "a=0:1:2", "--out", folder).returncode == 0
    for words in (["--set", "a=0:1:3"], ["--set", "a=0:1:2", "--set", "b=2"], ["--set", "a=0:1:2", "--h", "0.2"]):
        said = command("sweep", path, "one", *words, "--out", folder)
        assert said.returncode == 2 and "contains a sweep with different settings" in said.stderr
    other = path.parent / "other"
    other.mkdir()
    (other / "mine.txt").write_text("mine")
    said = command("sweep", path, "one", "--out", other)
    assert said.returncode == 2 and "does not contain a sweep" in said.stderr and [p.name for p in other.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("words, said", [
    (["--set", "a=0:1"], "FIRST:LAST:COUNT"), (["--set", "a=0:1:0"], "from 1 to"), (["--set", "a=0:x:3"], "x"), (["--set", "a=0:__import__('os'):3"], "--set a"),
    (["--set", "c=0:1:2"], "c"), (["--starts", "0"], "from 1 to"), (["--method", "none"], "no method"), (["--processes", "0"], "at least 1"),
    (["--set", "a=0:1:2.5"], "integer")])
def test_what_does_not_fit_is_refused(command, path, words, said):
    if words == ["--starts", "0"]:
        words = ["--set", f"a=0:1:{limits.CELLS + 1}"]
    found = command("sweep", path, *words, "--out", path.parent / "cells")
    assert found.returncode == 2 and said in found.stderr and "Traceback" not in found.stderr


def test_random_starts_need_a_random_start(command, path):
    found = command("sweep", path, "one", "--starts", 3, "--out", path.parent / "cells")
    assert found.returncode == 2 and "nothing in start 'one' is random" in found.stderr


def test_the_start_of_a_sweep_may_be_another_than_that_of_its_run(command, path, tmp_path):
    """By its name or from a file, as of a run."""
    (tmp_path / "w.csv").write_text("0.0,0.6,0.8\n")
    for start, w in ((tmp_path / "w.csv", [0, 0.6, 0.8]), ("one", [0.6, 0, 0.8])):
        folder = tmp_path / f"from {Path(start).stem}"
        said = command("sweep", path, "demo", "--start", start, "--set", "a=0:1:2", "--out", folder, "--json")
        assert said.returncode == 0, said.stderr
        for cell in json.loads(said.stdout)["cells"]:
            assert np.array_equal(smidgen.load_result(folder / cell["file"]).w["w"][0, 0], w)
        assert command("sweep", path, "demo", "--start", start, "--set", "a=0:1:2", "--out", folder).returncode == 0        # there is nothing left to do
    assert "no start 'nowhere'" in command("sweep", path, "--start", "nowhere", "--out", tmp_path / "other").stderr
    with pytest.raises(smidgen.UsageError, match="nothing in start 'one' is random"):
        sweep(smidgen.load(path), start="one", starts=2, out=tmp_path / "more")


def test_a_seed_without_starts_is_that_of_all_cells(path):
    """Of a random start or of noise; no silent 0."""
    spec, folder = smidgen.load(path), path.parent / "cells"
    found = sweep(spec, "demo", axes={"a": [0.0, 0.3]}, seed=7, out=folder, processes=1)
    assert [outcome["seed"] for outcome in found] == [7, 7]
    for outcome in found:
        wanted = smidgen.run(spec, "demo", parameters=outcome["parameters"], seed=7)
        assert np.array_equal(smidgen.load_result(folder / outcome["file"]).final, wanted.final)
    with pytest.raises(smidgen.UsageError, match="nothing in start 'one' is random"):
        sweep(spec, "one", axes={"a": [0.0]}, seed=7, out=path.parent / "others", processes=1)
    with pytest.raises(smidgen.UsageError, match="the start is an array"):
        sweep(spec, "demo", start=np.array([[0.6, 0.0, 0.8]]), starts=2, out=path.parent / "others", processes=1)


def test_the_limit_of_cells(path, monkeypatch):
    monkeypatch.setattr(limits, "CELLS", 4)
    assert len(module.cells_of({"a": [1, 2]}, 2, 0)) == 4
    with pytest.raises(smidgen.UsageError, match="from 1 to 4 cells, not 5"):
        module.cells_of({"a": [1, 2, 3, 4, 5]}, None, 0)


def test_values_are_even_and_their_ends_exact():
    from smidgen.cli.sweep import axis
    assert axis("n=2:10:5") == ("n", [2, 4, 6, 8, 10], True) and axis("J=0:1:3")[1] == [0, 0.5, 1]
    assert axis("J=pi:0.1:7")[1][-1] == 0.1 and axis("J=pi:0.1:7")[1][0] == np.pi and len(axis("J=0:2:50")[1]) == 50
    assert axis("J=3:4:1")[1] == [3] and axis("g=1,2") == ("g", [1, 2], False)


def test_lines_that_are_no_outcomes_count_for_nothing(path):
    """Their cells are computed again, and no other file is taken for one."""
    spec, folder = smidgen.load(path), path.parent / "cells"
    wanted = [outcome["cell"] for outcome in sweep(spec, "demo", axes={"a": [0.0, 0.3]}, out=folder, processes=1)]
    good = (folder / "cells.jsonl").read_bytes()
    assert good.splitlines()[0].startswith(b"{")
    for wrong in (b"[1]", b"7", b'{"cell": 0}', b'{"cell": 0, "file": 5, "status": "complete"}', b"\xff\xfe",
                  b'{"cell": 0, "file": "/etc/hostname", "status": "complete"}', b'{"cell": 0, "file": "cell-1.npz", "status": "complete"}'):
        (folder / "cells.jsonl").write_bytes(wrong + b"\n" + good.splitlines()[1] + b"\n")
        (folder / "cell-0.npz").unlink()
        assert [outcome["cell"] for outcome in sweep(spec, "demo", axes={"a": [0.0, 0.3]}, out=folder, processes=1)] == wanted
        assert (folder / "cell-0.npz").exists()


def test_ctrl_c_says_how_to_go_on(monkeypatch, capsys, tmp_path):
    """An interrupt after one cell: what has ended is counted, and the exit code is that of an interrupt."""
    from smidgen.cli import main
    from smidgen.run.many import sweep as module

    def stopped(*_, tell, **__):
        tell({"error": None})
        raise KeyboardInterrupt
    monkeypatch.setattr(module, "sweep", stopped)
    assert main(["sweep", "free_rigid_body", "--set", "I3=3:4:2", "--out", str(tmp_path / "bodies")]) == 130
    assert "interrupted after 1 cells;" in capsys.readouterr().err


# The first cell is a run of 100 steps. By Ctrl-C every process hears of it, and runs end where they are: the other cells would take days. By kill
# the parent alone does, and cells under way come to their end: the others do not begin to step before it has told them.
ENDLESS = ["--time", "10 + 1e12*(n - 1)", "--every", "100"]
UNTIL_TOLD = """
import sys, time
from smidgen.cli import main
from smidgen.run.many import cluster, sweep
run = sweep.run
def waiting(*args, **more):
    while more["parameters"]["n"] > 1 and not cluster.stopped(""):
        time.sleep(0.01)
    return run(*args, **more)
sweep.run = waiting
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def listens():
    """Ctrl-C raises KeyboardInterrupt here and in what is started from here, in the background too, where it may be ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("listens")
@pytest.mark.parametrize("whom", ["group", pytest.param("parent", marks=pytest.mark.long)])
def test_an_interrupt_begins_no_more_cells_and_keeps_what_ends(path, whom):
    """Sent once the first cell has ended; none of the others can have ended by then."""
    folder = path.parent / "cells"
    words = ["sweep", path, "--set", "n=1:40:40", "--out", folder, "--processes", "2", *(ENDLESS if whom == "group" else [])]
    begin = ["-m", "smidgen"] if whom == "group" else ["-c", UNTIL_TOLD]
    run = subprocess.Popen([sys.executable, *begin, *map(str, words)], stderr=subprocess.PIPE, text=True, start_new_session=True)
    while not (folder / "cells.jsonl").exists() or not lines(folder):
        assert run.poll() is None
        time.sleep(0.02)
    (os.killpg if whom == "group" else os.kill)(run.pid, signal.SIGINT)
    try:
        said = run.communicate(timeout=240)[1]
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)          # whatever was not interrupted
    ended = lines(folder)
    assert run.returncode == 130 and "interrupted" in said and [line["cell"] for line in ended][0] == 0
    assert len(ended) == 1 if whom == "group" else 1 <= len(ended) < 10         # the parent's: beside the first, those under way
    files, written = set(folder.glob("cell-*.npz")), {folder / line["file"] for line in ended}
    assert written <= files and len(files - written) <= 2       # those that were interrupted on their way


@pytest.mark.usefixtures("listens")
def test_an_interrupt_is_raised_between_outcomes(path):
    """Not from within whatever goes on when it comes, as a pool that holds a lock; it is none of the processes' either."""
    folder, after = path.parent / "cells", []

    def tell(outcome):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        after.append(outcome["cell"])
    with pytest.raises(KeyboardInterrupt):
        sweep(smidgen.load(path), "demo", axes={"a": [k / 60 for k in range(40)]}, out=folder, processes=2, tell=tell)
    assert 1 <= len(after) < 10 and sorted(after) == sorted(line["cell"] for line in lines(folder))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("listens")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_a_callback_drops_ends_the_run(path):
    class Dropping:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)                            # Python drops the exception: it comes from __del__
    with pytest.raises(KeyboardInterrupt), interrupts.raised():
        Dropping()
        smidgen.run(path, "demo", time=1e12, every=100, keep=False)
    assert smidgen.run(path, "demo").meta["status"] == "complete"        # nothing of it is left


@pytest.mark.usefixtures("listens")
def test_an_interrupt_of_the_last_outcome_is_raised(path):
    with pytest.raises(KeyboardInterrupt):
        sweep(smidgen.load(path), "demo", axes={"a": [0.0]}, out=path.parent / "cells", tell=lambda outcome: os.kill(os.getpid(), signal.SIGINT))
    assert len(lines(path.parent / "cells")) == 1


def test_no_process_outlives_a_sweep_that_is_killed(path):
    """SIGKILL of the sweep alone: its processes end, nobody holds its files, and what they had begun to write goes with the end of the sweep."""
    folder = path.parent / "cells"
    words = [sys.executable, "-m", "smidgen", "sweep", str(path), "--set", "a=0:0.5:4", "--steps", "2000000", "--every", "1000000", "--out", str(folder), "--processes", "2"]
    run = subprocess.Popen(words, stdout=subprocess.PIPE, start_new_session=True)
    try:
        while not list(folder.glob(".cell-*")):
            assert run.poll() is None
            time.sleep(0.02)
        os.kill(run.pid, signal.SIGKILL)
        run.communicate(timeout=60)             # ends when nobody has its output open any more
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)
    assert list(folder.glob(".cell-*"))
    subprocess.run(words, check=True)
    assert sorted(p.name for p in folder.iterdir()) == [*(f"cell-{k}.npz" for k in range(4)), "cells.jsonl", "manifest.json"]


@pytest.mark.long
def test_an_interrupted_sweep_on_a_cluster_keeps_what_ends(path, tmp_path):
    """Cells under way have their lines; no others begin."""
    from distributed import LocalCluster
    folder = tmp_path / "cells"

    def interrupt(outcome):
        if len(lines(folder)) == 1:
            raise KeyboardInterrupt
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as several:
        with pytest.raises(KeyboardInterrupt):
            sweep(smidgen.load(path), "demo", axes={"a": [k / 60 for k in range(40)]}, out=folder, cluster=several.scheduler_address, steps=500_000, every=500_000, tell=interrupt)
        time.sleep(2)       # what would still be written, would be by now
    assert 2 <= len(lines(folder)) < 20 and {line["file"] for line in lines(folder)} == {p.name for p in folder.glob("cell-*.npz")}


def test_no_line_is_empty(path, tmp_path):
    """However often a sweep goes on; a line that was cut is ended."""
    spec, folder = smidgen.load(str(path)), tmp_path / "cells"
    for _ in range(3):
        sweep(spec, "demo", axes={"a": [0.0, 0.3]}, out=folder, processes=1)
        (folder / "cell-0.npz").unlink()
    assert len((folder / "cells.jsonl").read_text().splitlines()) == 4 == len(lines(folder))
    (folder / "cells.jsonl").write_bytes((folder / "cells.jsonl").read_bytes()[:-3])
    sweep(spec, "demo", axes={"a": [0.0, 0.3]}, out=folder, processes=1)
    assert (folder / "cells.jsonl").read_bytes().count(b"\n") == 5     # the end of the one that was cut, and cell 0 once more


@pytest.mark.long
def test_a_cluster_computes_the_same_cells(path, tmp_path):
    """Two workers of a Dask cluster, each a process of its own."""
    from distributed import LocalCluster
    given = dict(axes={"a": [0.0, 0.3]}, starts=2)
    here = sweep(smidgen.load(str(path)), "demo", out=tmp_path / "here", processes=1, **given)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as several:
        there = sweep(smidgen.load(str(path)), "demo", out=tmp_path / "there", cluster=several.scheduler_address, **given)
    assert here == there and len(there) == 4
    for outcome in here:
        one, other = (smidgen.load_result(tmp_path / place / outcome["file"]) for place in ("here", "there"))
        assert np.array_equal(one.final, other.final)


@pytest.mark.parametrize("address, said", [("tcp://127.0.0.1:9", "no Dask scheduler answers"), ("", "is not the address"), ("nohost", "is not the address"),
                                           ("foo://bar:1", "is not the address"), ("tcp://127.0.0.1:99999", "no Dask scheduler answers")])
def test_no_cluster_is_a_clear_error(command, path, address, said):
    found = command("sweep", path, "--set", "a=0:0.6:3", "--out", path.parent / "cells", "--cluster", address)
    assert found.returncode == 2 and said in found.stderr and not (path.parent / "cells").exists()


@pytest.mark.long
def test_a_cluster_that_ends_is_a_clear_error(path, tmp_path):
    """The scheduler goes after the first cell: what has ended stays, and the same call goes on."""
    from distributed import LocalCluster
    given, spec = dict(axes={"a": [k / 8 for k in range(6)]}, steps=200_000), smidgen.load(str(path))
    with LocalCluster(n_workers=1, threads_per_worker=4, dashboard_address=None) as several:
        with pytest.raises(smidgen.RunError, match="was killed"):
            sweep(spec, "demo", out=tmp_path / "cells", cluster=several.scheduler_address, tell=lambda outcome: several.close(), **given)
    assert 1 <= len(lines(tmp_path / "cells")) < 6
    assert len(sweep(spec, "demo", out=tmp_path / "cells", processes=1, **given)) == 6


def test_a_result_that_went_elsewhere_is_no_cell(path, tmp_path):
    with pytest.raises(smidgen.OutputError, match="must share one folder"):
        module.there({"file": "cell-0.npz"}, tmp_path)


def test_a_worker_of_another_version_is_refused(path):
    with pytest.raises(smidgen.UsageError, match="another version of smidgen"):
        module.one(smidgen.load(str(path)), "demo", module.Cell(0, {}, None), path.parent, {}, "smidgen 0")


def test_processes_or_a_cluster(path, tmp_path):
    with pytest.raises(smidgen.UsageError, match="not both"):
        sweep(smidgen.load(str(path)), "demo", axes={"a": [0.0]}, out=tmp_path / "cells", processes=1, cluster="tcp://127.0.0.1:9")
