"""One rank of MPI that takes the steps of a check: `mpirun -n 2 python -m smidgen.check.verify.rank FOLDER`.

FOLDER/asked holds what to build the integrator from, the starts and the calls, pickled by `shared.ranks`. Each rank K writes beside it
began-K once MPI runs, and then found-K, or failed-K with the exception that ended it.
"""
from __future__ import annotations

import ctypes
import pickle
import sys
from pathlib import Path


def main(folder: Path) -> None:
    from ...ranks import RANK, variable
    asked = pickle.loads((folder / "asked").read_bytes())
    library = ctypes.CDLL(str(asked[0][1].binary), mode=ctypes.RTLD_GLOBAL)
    library.MPI_Init(None, None)
    mine = variable(RANK)
    (folder / f"began-{mine}").touch()
    try:
        found = steps(*asked)
    except Exception as problem:
        (folder / f"failed-{mine}").write_text(f"{type(problem).__name__}: {problem}", encoding="utf-8")
        raise
    (folder / f"found-{mine}").write_bytes(pickle.dumps(found))
    library.MPI_Finalize()


def steps(made, places, calls) -> list:
    from ...run.step.integrator import Integrator
    from .shared import path
    one = Integrator(*made)
    return [path(one.start(w.copy(), t0=t, h=h), calls) for w, t, h in places]


if __name__ == "__main__":
    main(Path(sys.argv[1]))
