"""Bytes that a spin takes where steps go by rows: five vectors a spin, and what its place in a row costs."""
import json
import subprocess
import sys

import pytest

PROGRAM = """
import json, sys
import numpy as np, smidgen
name, values, sites = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
model = smidgen.build(smidgen.load(name), parameters=values)
w = np.random.default_rng(1).normal(size=(sites, 3))
w /= np.linalg.norm(w, axis=1)[:, None]
resident = lambda: int(open("/proc/self/statm").read().split()[1]) * 4096
before = resident()
model.start(w, h=0.0247)
first = model.energy()
model.steps(3)
print(json.dumps({"bytes": (resident() - before) / sites, "energy": abs(model.energy() - first) / sites,
                  "length": float(np.abs(np.linalg.norm(model.w, axis=1) - 1).max())}))
"""
BYTES, LOST = 160, 2e-5       # of energy a spin: what random spins at this h may lose, whatever the time


def probe(name: str, values: dict, sites: int) -> dict:
    """Three steps of random spins, in a process of its own: what it added to its memory, energy and length that it lost."""
    said = subprocess.run([sys.executable, "-c", PROGRAM, name, json.dumps(values), str(sites)], check=True, capture_output=True, text=True)
    return json.loads(said.stdout)


def holds(found: dict) -> None:
    assert found["bytes"] <= BYTES
    assert found["energy"] < LOST and found["length"] < 1e-15


@pytest.mark.parametrize("name, values, sites", [("cubic_lattice", {"nx": 50, "ny": 80, "nz": 100}, 400_000),
                                                 pytest.param("heisenberg_chain", {"n": 400_000}, 400_000, marks=pytest.mark.long)])
def test_bytes_of_a_spin(name, values, sites):
    holds(probe(name, values, sites))


@pytest.mark.long
def test_ten_million_spins():
    holds(probe("cubic_lattice", {"nx": 250, "ny": 200, "nz": 200}, 10_000_000))
