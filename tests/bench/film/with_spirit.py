"""The film in Spirit 2.2.

    python with_spirit.py solver n steps pieces [damping]      > seconds; the state in spirit.npy

One basis cell holds the 8 x 8 sites whose kinds repeat. In energies of meV, moments of mu_B and times of ps a rate is E gamma/(m mu_B). Its motion has another
gamma than its constants say, from the eighth digit on: GAMMA is that of its first steps.
"""
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scene
from spirit import constants, hamiltonian, simulation, state, system
from spirit.parameters import llg

SOLVERS = {"semi-implicit B": simulation.SOLVER_SIB, "Depondt": simulation.SOLVER_DEPONDT, "Heun": simulation.SOLVER_HEUN, "Runge-Kutta 4": simulation.SOLVER_RK4}
RATE = scene.GAMMA / constants.mu_B          # rad/ps of a meV, with a moment of mu_B


def lines(n: int) -> list:
    """The lines of an input file."""
    cells, inner, hard = n // scene.CELL, scene.CELL, scene.harder().ravel()
    places = [(x, y) for y in range(inner) for x in range(inner)]
    text = [f"n_basis_cells {cells} {cells} 1", "bravais_vectors", f"{inner} 0 0", f"0 {inner} 0", "0 0 1", "basis", len(places)]
    text += [f"{x / inner!r} {y / inner!r} 0" for x, y in places]
    text += ["mu_s " + " ".join("1" for _ in places), "boundary_conditions 1 1 0", "hamiltonian heisenberg_pairs", "external_field_magnitude 0",
             "external_field_normal 0 0 1", f"n_anisotropy {len(places)}", "i K Kx Ky Kz"]
    text += [f"{k} {scene.K[int(h)] / RATE!r} 0 0 1" for k, h in enumerate(hard)]
    text += [f"n_interaction_pairs {2 * len(places)}", "i j da db dc Jij Dij Dijx Dijy Dijz"]
    for x, y in places:
        for (dx, dy), along in (((1, 0), "0 1 0"), ((0, 1), "-1 0 0")):
            a, b = divmod(x + dx, inner), divmod(y + dy, inner)
            text.append(f"{x + inner * y} {a[1] + inner * b[1]} {a[0]} {b[0]} 0 {scene.J / RATE!r} {scene.D / RATE!r} {along}")
    return [*text, "ddi_method none", "output_file_tag film", "llg_force_convergence 0", "log_to_console 0", "log_to_file 0"]


def order(n: int) -> np.ndarray:
    """Where Spirit's k-th spin stands in arrays of x + n y."""
    cells, inner = n // scene.CELL, scene.CELL
    b, a, y, x = np.meshgrid(np.arange(cells), np.arange(cells), np.arange(inner), np.arange(inner), indexing="ij")
    return ((inner * a + x) + n * (inner * b + y)).ravel()


def run(solver: str, n: int, steps: int, pieces: int, damping: float) -> float:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "film.cfg")
        file.write_text("\n".join(str(line) for line in lines(n)) + "\n")
        with state.State(str(file), quiet=True) as p:
            for setting in (llg.set_output_general, llg.set_output_energy, llg.set_output_configuration):
                setting(p, *([False] * (3 if setting is not llg.set_output_configuration else 2)))
            llg.set_temperature(p, 0)
            llg.set_damping(p, damping)
            llg.set_convergence(p, 0)
            llg.set_timestep(p, scene.PIECE / steps)
            where = order(n)
            spins = system.get_spin_directions(p)
            spins[:] = scene.start(n)[where]
            begin = time.process_time()
            for piece in range(pieces):
                hamiltonian.set_field(p, scene.tesla(piece), [0, 0, 1])
                simulation.start(p, simulation.METHOD_LLG, SOLVERS[solver], n_iterations=steps, n_iterations_log=steps)
            took = time.process_time() - begin
            found = np.empty_like(spins)
            found[where] = system.get_spin_directions(p)
            np.save("spirit.npy", found)
            return took


if __name__ == "__main__":
    solver, n, steps, pieces = sys.argv[1], *map(int, sys.argv[2:5])
    print(run(solver, n, steps, pieces, float(sys.argv[5]) if len(sys.argv) > 5 else 0.0))
