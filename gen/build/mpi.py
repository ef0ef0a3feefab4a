"""The C compiler with what MPI needs."""
from __future__ import annotations

import os
import shlex
import shutil

from ..errors import MissingTool

WRAPPER = "mpicc"


def mpi_compiler(compiler: tuple[str, ...]) -> tuple[str, ...]:
    """mpicc, or what $MPICC names, calling `compiler`. Raises MissingTool."""
    words = shlex.split(os.environ.get("MPICC", "")) or [WRAPPER]
    path = shutil.which(words[0])
    if path is None:
        raise MissingTool(f"running on several ranks requires {words[0]}, the MPI compiler: install it (on Debian: apt-get install libopenmpi-dev openmpi-bin), or set MPICC")
    program, *options = compiler
    return ("/usr/bin/env", f"OMPI_CC={program}", f"MPICH_CC={program}", path, *words[1:], *options, "-DSMG_MPI", "-D_DEFAULT_SOURCE")
