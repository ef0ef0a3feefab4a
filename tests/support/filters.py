"""Small C filters (tests/runtime) around the solvers of the C runtime, and numpy's side of the comparison."""
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from smidgen.resources import folder, include_flags

from .strict import CALLS

HERE = Path(__file__).parent.parent
WARNINGS = ("-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wvla -Werror "
            "-ffp-contract=off").split()
BUILDS = {
    "gcc": ["gcc", "-std=c11", "-O1"],
    "gcc-long-double": ["gcc", "-std=c11", "-O1", "-DSMG_LONG_DOUBLE"],
    "gcc-sanitized": ["gcc", "-std=c11", "-O0", CALLS, "-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
    "clang": ["clang", "-std=c11", "-O3"],
    "g++": ["g++", "-x", "c++", "-std=c++11", "-O1"],
    "clang++": ["clang++", "-x", "c++", "-std=c++11", "-O2"],
}
QUICK = ("gcc", "gcc-sanitized")
EVERY_BUILD = [pytest.param(b, marks=pytest.mark.quick if b == "gcc" else () if b in (*QUICK, "clang++") else pytest.mark.long) for b in BUILDS]


def copied_runtime(to):
    """The headers of runtime/ in one folder, to be changed."""
    place = to / "runtime"
    place.mkdir()
    for header in folder("runtime").rglob("*.h"):
        shutil.copy(header, place)
    return place


def compile_filter(build, name, bs, to, include=None):
    command = BUILDS[build]
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    program = to / f"{build}-{name}{bs}"
    if not program.exists():
        fresh = to / f"{program.name}-{os.getpid()}"
        subprocess.run([*command, *WARNINGS, f"-DSMG_BS={bs}", *([f"-I{include}"] if include else include_flags()), f"-I{HERE / 'runtime'}",
                        str(HERE / "runtime" / f"{name}.c"), "-o", str(fresh), "-lm"], check=True)
        fresh.replace(program)
    return program


def feed(program, *parts):
    """Numbers into the filter's stdin, numbers out of its stdout."""
    sent = np.concatenate([np.ravel(np.asarray(p, dtype=float)) for p in parts])
    done = subprocess.run([program], input=sent.tobytes(), stdout=subprocess.PIPE, check=True)
    return np.frombuffer(done.stdout)


@pytest.fixture(scope="session")
def make(tmp_path_factory):
    """make(build, name, bs): the compiled filter, compiled once for all test processes."""
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "filters"
    shared.mkdir(exist_ok=True)
    return lambda build, name, bs=2: compile_filter(build, name, bs, shared)


def random(seed):
    return np.random.default_rng(seed)


def backward_error(A, x, b):
    """Largest residual in units of |A| |x| + |b|."""
    residual = np.abs(np.einsum("...ij,...j->...i", A, x) - b)
    size = np.abs(A).sum(-1).max(-1) * np.abs(x).max(-1) + np.abs(b).max(-1)
    return (residual.max(-1) / size).max()


def positive(A):
    """True when A has no real eigenvalue <= 0 by numpy, and how far the spectrum is from the other
    verdict, relative to its size."""
    values = np.linalg.eigvals(A)
    real = np.abs(values.imag) == 0
    gap = np.where(real, np.abs(values.real), np.where(values.real <= 0, np.abs(values.imag), np.inf))
    return not np.any(real & (values.real <= 0)), gap.min() / np.abs(values).max()


def block_pivots(full, bs):
    """Pivot blocks of the block LU in the natural order."""
    full, found = full.copy(), []
    for p in range(0, len(full), bs):
        found.append(full[p:p + bs, p:p + bs].copy())
        rest = slice(p + bs, None)
        full[rest, rest] -= full[rest, p:p + bs] @ np.linalg.solve(found[-1], full[p:p + bs, rest])
    return found
