"""One rank of MPI that takes the steps of a check: `mpirun -n 2 python -m smidgen.check.verify.rank FOLDER`.

FOLDER/asked holds what to build the integrator from, the starts and the calls, pickled by `parallel.ranks`; each rank writes what it
found beside it.
"""
from __future__ import annotations

import ctypes
import pickle
import sys
from pathlib import Path


def main(folder: Path) -> None:
    from ...run.step.integrator import Integrator
    from ...ranks import RANK, variable
    from .shared import path
    (prepared, built), places, calls = pickle.loads((folder / "asked").read_bytes())
    library = ctypes.CDLL(str(built.binary), mode=ctypes.RTLD_GLOBAL)
    library.MPI_Init(None, None)
    one = Integrator(prepared, built)
    found = [path(one.start(w.copy(), t0=t, h=h), calls) for w, t, h in places]
    (folder / f"found-{variable(RANK)}").write_bytes(pickle.dumps(found))
    library.MPI_Finalize()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
