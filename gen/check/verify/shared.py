"""Lattices by rows, beyond the way that the run's own size takes: shared by threads, by ranks of MPI, and in wavefronts.

Which way a lattice goes depends on its size, so the same text is compiled once more with thresholds that are variables. So a lattice of
hundreds of sites goes every way that large ones do, and each must have the bits of the library as it is.
"""
from __future__ import annotations

import ctypes
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from ...build.binary import THREADS, build_library, find_compiler, takes
from ...errors import MissingTool
from ...run.step.integrator import Integrator
from .case import Case
from .past import another
from .row import Row, at_most, not_applicable, refused

NAMES = ("threads", "wavefronts", "ranks")
CALLS = (1, 2, 5, 30)           # steps of each call
WORK = {"quick": 10**5, "normal": 10**6}    # steps of single sites
ALL = 2**31 - 1                 # no threshold
# the thresholds of runtime/lattice/smg_row_wave.h, smg_row_blocks.h and smg_rows.h, and their values as they are
FLAGS = ("-DSMG_SHARE=8", "-DSMG_WAVE_BLOCK=8", "-DSMG_WAVE_FROM=smg_seen_wave", "-DSMG_BLOCKS_TO=smg_seen_blocks", "-DSMG_LARGE_PLANE=smg_seen_plane")
SMALL = ("-DSMG_MPI_SHARE=8", "-DSMG_MPI_LOOK=8")    # parts of a few sites
TOGETHER = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}   # two, on any machine
LIMIT = 120             # seconds: ranks that wait for each other forever are a fault
HEAD = """#include <stdint.h>
int64_t smg_seen_wave = INT64_MAX, smg_seen_blocks = INT64_MAX, smg_seen_plane = INT64_MAX;
"""
# of the model, then of the functions that Python calls
SEEN = """
int smg_seen_in_wave(const smg_state *s) {
#ifdef SMG_ROW_WAVE_H
  smg_row_wave wave;
  return s->rows && smg_wave_pays(s, &wave);
#else
  return (void)s, 0;
#endif
}
"""
CALLED = """
int smg_seen_in_wave(const {0}_state *s);
int {0}_abi_in_wave(void *s) {{ return smg_seen_in_wave(&(({0}_abi *)s)->s); }}
"""


def shared(case: Case, subject) -> list[Row]:
    """Three rows; only where they are asked for, since the text is compiled twice more."""
    one = getattr(subject, "double", None)
    if one is None or not one.notes.get("threads"):
        return neither("this model is not stepped by rows, so it has one thread")
    if not case.layouts:
        return unseen(case, "use --layouts to check them")
    if not getattr(subject, "generated", False):
        return unseen(case, "this integrator cannot be compiled again")
    places = [(case.w, 0.0, case.h), (case.nudged(0.1), case.end(), case.h)]
    calls = CALLS[:max(2, case.of_tier(WORK) // (case.sites * sum(CALLS) * 10) * len(CALLS))]
    one = another(one)
    wanted = [path(one.start(w.copy(), t0=t, h=h), calls) for w, t, h in places]
    asked = case, one, places, calls, wanted
    return [*same_bits(*asked), ranks(*asked)]


def neither(why) -> list[Row]:
    return [not_applicable(name, why) for name in NAMES]


def unseen(case: Case, why, names=NAMES) -> list[Row]:
    case.unseen.append(f"{', '.join(names)}: {why}")
    return [not_applicable(name, why) for name in names]


class Ways:
    """The library with thresholds that are variables."""

    def __init__(self, case: Case, one: Integrator):
        def seen(*wanted):
            from ...compile.emit.emit import generate_program
            made, name = generate_program(*wanted), one.name
            files = dict(made)
            files[f"{name}.c"] = HEAD + files[f"{name}.c"] + SEEN
            files[f"{name}_abi.c"] += CALLED.format(name)
            return files, {**made.notes, "units": 1}        # what SEEN defines stands once
        built = build_library(one.scene, one.method, one.solver, "double", case.settings.native, case.features, seen, threads=True, defines=FLAGS)
        self.one = Integrator(one.prepared, built, 1)

    def start(self, w, t, h, threads=1, wave=False, blocks=False) -> Integrator:
        """A trajectory that goes so."""
        library = self.one._library
        for name, value in (("wave", 0 if wave else ALL), ("blocks", ALL if blocks else 0), ("plane", 0 if wave else ALL)):
            ctypes.c_int64.in_dll(library, f"smg_seen_{name}").value = value
        self.one._now(threads=threads)
        return self.one.start(w.copy(), t0=t, h=h)

    def in_wave(self) -> bool:
        """Does the next step go in wavefronts?"""
        function = getattr(self.one._library, f"{self.one.name}_abi_in_wave")
        function.argtypes, function.restype = [ctypes.c_void_p], ctypes.c_int
        return bool(function(self.one._state))


def same_bits(case: Case, one: Integrator, places, calls, wanted) -> list[Row]:
    """Two rows: by two threads, and in wavefronts of one thread and of two."""
    if not takes(find_compiler(), THREADS):
        return unseen(case, "the compiler has no OpenMP", NAMES[:2])
    ways, teams, waves, went = Ways(case, one), [], [], False
    for place, bits in zip(places, wanted):
        teams += [path(ways.start(*place, 2, blocks=blocks), calls) == bits for blocks in (False, True)]
        for threads in (1, 2):
            waves.append(path(ways.start(*place, threads, wave=True), calls) == bits)
            went = went or ways.in_wave()
    note = f"{sum(calls)} steps by two threads, although a lattice of this size uses one"
    return [at_most("threads", teams.count(False), 0, note), wavefronts(case, waves, went)]


def wavefronts(case: Case, same, went) -> Row:
    """Where a lattice is too small for one even with the smallest blocks, nothing was seen."""
    if went:
        return at_most("wavefronts", same.count(False), 0, "forced on a lattice of this size")
    case.unseen.append("wavefronts: only lattices of at least 60 MB use them, and this one is too small")
    return not_applicable("wavefronts", "too few sites, or a method without them")


def path(one: Integrator, calls) -> list[bytes]:
    """The bits of all that is saved after each call, as far as steps are taken."""
    return [(one.advance(count), one.save().tobytes())[1] for count in calls]


def ranks(case: Case, one: Integrator, places, calls, wanted) -> Row:
    """By two ranks, in processes of their own."""
    mpirun = shutil.which("mpirun")
    if mpirun is None or not one.notes.get("ranks"):
        return unseen(case, "mpirun was not found" if mpirun is None else "this method has none", NAMES[2:])[0]
    try:
        built = build_library(one.scene, one.method, one.solver, "double", case.settings.native, case.features, ranks=True, defines=SMALL)
    except MissingTool as problem:
        return unseen(case, str(problem), NAMES[2:])[0]
    with tempfile.TemporaryDirectory(prefix="smidgen-ranks-") as place:
        folder = Path(place)
        (folder / "asked").write_bytes(pickle.dumps(((one.prepared, built), places, calls)))
        command = [mpirun, "-n", "2", sys.executable, "-m", f"{__package__}.rank", place]
        try:
            said = subprocess.run(command, capture_output=True, text=True, errors="replace", env={**os.environ, **TOGETHER}, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            return refused("ranks", f"two ranks did not finish within {LIMIT} s")
        found = [folder / f"found-{k}" for k in (0, 1)]
        if not all(file.exists() for file in found):
            return broken(case, folder, said)
        differ = sum(pickle.loads(file.read_bytes()) != wanted for file in found)
    return at_most("ranks", differ, 0, f"{sum(calls)} steps by two ranks")


def broken(case: Case, folder: Path, said) -> Row:
    """The row of ranks that ended early: no if they had begun; otherwise mpirun cannot be used here, and nothing was seen."""
    lines = [line.strip() for line in said.stderr.splitlines() if line.strip(" -")]
    if not list(folder.glob("began-*")):
        return unseen(case, f"mpirun: {next(iter(lines), f'exit code {said.returncode}')}", NAMES[2:])[0]
    failed = next((file.read_text(encoding="utf-8") for file in sorted(folder.glob("failed-*"))), None)
    signal = next((line for line in lines if "signal" in line), f"exit code {said.returncode}")
    return refused("ranks", f"a rank did not finish: {failed or signal}")
