"""The film in smidgen.

    python with_smidgen.py method tolerance n steps pieces [damping]      > seconds; the state in smidgen.npy
"""
import sys
import time
from pathlib import Path

import numpy as np
import scene
import smidgen

SPEC = Path(__file__).parent / "film.toml"
CONSERVATIVE = ["along_x", "along_y", "axis", "field"]


def run(method: str, tolerance: float, n: int, steps: int, pieces: int, damping: float) -> float:
    hard = np.where(scene.pattern(n), scene.K[1], scene.K[0])
    model = smidgen.build(SPEC, method=method, effects=CONSERVATIVE + ["damping"] * bool(damping), parameters={"n": n, "K": hard, "alpha": damping})
    w = scene.start(n)
    model.start(w, h=scene.PIECE / steps, tolerance=tolerance or None)
    begin = time.process_time()
    for _ in range(pieces):
        model.steps(steps)
    took = time.process_time() - begin
    np.save("smidgen.npy", w)
    return took


if __name__ == "__main__":
    method, tolerance, n, steps, pieces = sys.argv[1], float(sys.argv[2]), *map(int, sys.argv[3:6])
    print(run(method, tolerance, n, steps, pieces, float(sys.argv[6]) if len(sys.argv) > 6 else 0.0))
