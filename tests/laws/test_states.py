"""States after a hundred steps from twenty starts, to the bit, as they were: a change of numbers that no other test asks about is seen here.

Contraction is off and the models need no function of the mathematical library but the square root, so the bits are those of
every compiler and processor. Where numbers are meant to change, SMIDGEN_UPDATE_GOLDEN=1 writes them anew.
"""
import csv
import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
import smidgen

FILE = Path(__file__).parents[1] / "golden" / "states.csv"
CASES = {
    **{f"free_rigid_body {method} {h}": ("free_rigid_body", method, {}, h) for method, h in
       [("spherical-midpoint", 0.1), ("spherical-midpoint", 2.0), ("spherical-midpoint", 3.0), ("spherical-midpoint-4", 4.0), ("moser-veselov", 0.2), ("axis-splitting", 0.2)]},
    **{f"irreversible_rigid_body {method} {h}": ("irreversible_rigid_body", method, {}, h) for method, h in
       [("spherical-midpoint", 1.5), ("spherical-midpoint-4", 2.0), ("gauss-6", 0.2)]},
    **{f"heisenberg_chain {method} {h}": ("heisenberg_chain", method, {"n": 24}, h) for method, h in
       [("spherical-midpoint", 0.1), ("spherical-midpoint", 0.9), ("classical-midpoint", 0.1), ("pair-rotations", 0.1), ("sublattice-rotations", 0.1)]},
    "landau_lifshitz isospectral-midpoint 0.001": ("landau_lifshitz", "isospectral-midpoint", {}, 0.001),
}


def start(sites: int, first: int):
    """Unit vectors, all different, from whole numbers."""
    rows = np.array([[(7 * k + 3) % 11 - 5, (4 * k * k + k + 2) % 13 - 6.5, (5 * k + 1) % 7 - 2.5] for k in range(first, first + sites)])
    return rows / np.sqrt((rows * rows).sum(axis=1))[:, None]


def digest(spec, method, values, h) -> str:
    model = smidgen.build(smidgen.load(spec), method=method, parameters=values)
    states = [model.start(start(model.sites, 5 * k), h=h).steps(100).state().tobytes() for k in range(20)]
    return hashlib.sha256(b"".join(states)).hexdigest()[:32]


def kept() -> dict:
    return dict(csv.reader(FILE.read_text().splitlines())) if FILE.exists() else {}


@pytest.mark.parametrize("case", CASES)
def test_states_after_a_hundred_steps(case):
    found = digest(*CASES[case])
    if os.environ.get("SMIDGEN_UPDATE_GOLDEN"):
        rows = {c: was for c, was in (kept() | {case: found}).items() if c in CASES}
        FILE.write_text("".join(f"{c},{sha}\n" for c, sha in rows.items()))
    assert kept()[case] == found
