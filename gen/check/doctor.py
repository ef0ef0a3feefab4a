"""What this machine has of what smidgen uses, and whether a small model builds, runs and agrees with the independent interpreter."""
from __future__ import annotations

import importlib.metadata
import platform
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass

from ..build.binary import FLAGS, NATIVE, compiler_version, find_compiler, lanes_of, threads_of
from ..build.cache import cache_folder
from ..build.mpi import mpi_compiler
from ..errors import MissingTool, SmidgenError
from ..packages import EXTRAS
from ..read.shipped import load
from ..run.run import run
from ..version import __version__
from .validate import validate

PACKAGES = ("numpy", "sympy", "jinja2", "rich", "portalocker", "tomli_w")
OTHERS = {**EXTRAS, "distributed": "cluster", "mpi4py": "mpi"}      # package -> the extra that brings it
TOY, STEPS = "free_rigid_body", 10


@dataclass(frozen=True)
class Finding:
    """One thing looked at. found: what it is, or what to do where it is missing; needed: by the main job."""
    what: str
    good: bool
    found: str
    needed: bool = True

    @property
    def mark(self) -> str:
        return "ok" if self.good else "BAD" if self.needed else "-"


def examined() -> tuple[Finding, ...]:
    """All findings, in the order in which they are needed."""
    return (*here(), *map(installed, PACKAGES), *(extra(*pair) for pair in OTHERS.items()), *tools(), *toy())


def here() -> tuple[Finding, ...]:
    return (Finding("smidgen", True, __version__),
            Finding("Python", sys.version_info >= (3, 11), f"{platform.python_version()} on {platform.system()} {platform.machine()}"))


def installed(package: str, needed: bool = True, hint: str = "") -> Finding:
    """Of a package of Python: its version."""
    try:
        return Finding(package, True, importlib.metadata.version(package), needed)
    except importlib.metadata.PackageNotFoundError:
        return Finding(package, False, hint or f"pip install {package}", needed)


def extra(package: str, name: str) -> Finding:
    return installed(package, False, f"not installed: pip install 'smidgen[{name}]'")


def tools() -> tuple[Finding, ...]:
    """The compiler, its vectors and threads, MPI, and the cache."""
    return (tried("C compiler", compiler), tried("vectors", vectors, False), tried("threads", lambda: " ".join(threads_of(find_compiler())), False),
            tried("MPI", lambda: shlex.join(mpi_compiler(find_compiler())[3:4]), False), tried("cache", lambda: str(cache_folder())))


def compiler() -> str:
    found = find_compiler()
    return f"{shlex.join(found)} ({compiler_version(found)})"


def vectors() -> str:
    lanes = lanes_of(find_compiler(), (*FLAGS, *NATIVE))
    return f"{lanes} numbers of double precision in a register"


def toy() -> tuple[Finding, ...]:
    """A run, and its comparison with the witness, which needs GSL."""
    return (tried("a run", ran), tried("validation", validated, False))


def ran() -> str:
    result = run(load(TOY), steps=STEPS)
    return f"{TOY}: {STEPS} steps, {result.meta['status']}"


def validated() -> str:
    """Raises ValidationError where the two disagree."""
    return f"{TOY}: {len(validate(load(TOY), steps=STEPS).check().lines)} comparisons agree"


def tried(what: str, find: Callable[[], str], needed: bool = True) -> Finding:
    """What `find` says, or the first line of why it could not. What fails for another reason than a missing tool counts, needed or not."""
    try:
        return Finding(what, True, find(), needed)
    except SmidgenError as problem:
        return Finding(what, False, str(problem).splitlines()[0], needed or not isinstance(problem, MissingTool))
