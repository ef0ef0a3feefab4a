"""Builds and runs folds.c over small lattices of every layout by rows: steps around the end of their branch.

    python -m fuzz.folds [--steps 10000] [--seed 1] [--first CASE] [--only ring,square]

--steps: so many beyond the ends, six of each case.
"""
import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from .bad_models import Model, spec
from .bad_steps import build

LATTICE = """
[space]
w = {{ sphere = "{sites}" }}
{lattice}
[parameters]
n = {n}
[effects.exchange]
over = "bond(i, j) of {over}"
energy = "{energy}"
{more}
"""
AXIS = """[effects.axis]
over = "site(i) of w"
energy = "-0.3*w[i].z^2 + 0.2*w[i].x"
"""
TWIST = " + 0.3*(w[i].x*w[j].y - w[i].y*w[j].x)"


NEAR = '[lattices.near]\nsize = ["n"]\nboundary = "periodic"\nbonds.all = [{ offset = [1] }, { offset = [2] }]\n'


def lattice(name, over, n, sites, energy="-dot(w[i], w[j])", more="", declared=""):
    """By rows, also where there are so few sites that a dense matrix would serve."""
    text = LATTICE.format(sites=sites, lattice=declared, n=n, over=over, energy=energy, more=more)
    return Model(spec(name, text), ((sites.replace("n", f"{n}"), "sphere", "1", "1"),), solver="auto" if over.startswith("chain") else "rotation")


# rows of two colours, in blocks and not, open and closed, with a seam, and joined by bonds; bonds with a twist, sites that feel themselves, strengths of both signs
MODELS = {"ring": lattice("ring", "chain(n, periodic)", 8, "n"),
          "odd_ring": lattice("odd_ring", "chain(n, periodic)", 7, "n", more=AXIS),
          "open_chain": lattice("open_chain", "chain(n, open)", 10, "n", "dot(w[i], w[j])" + TWIST),
          "square": lattice("square", "square(n, 4, periodic)", 3, "4*n", "-dot(w[i], w[j])" + TWIST),
          "open_square": lattice("open_square", "square(n, 3, open)", 4, "3*n", more=AXIS),
          "cubic": lattice("cubic", "cubic(n, 2, 2, open)", 3, "4*n"),
          "joined": lattice("joined", "near.all", 8, "n", "-dot(w[i], w[j])" + TWIST, declared=NEAR)}


def run(name, place, seed, first, cases):
    """(numbers of the summary, violations)."""
    program = build(name, place, models=MODELS, program="folds")
    done = subprocess.run([program, *map(str, (seed, first, cases))], capture_output=True, text=True)
    lines = done.stdout.splitlines()
    if done.returncode not in (0, 1) or not lines:
        raise SystemExit(f"folds: {name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return {key: int(n) for key, n in re.findall(r"(\w+) (\d+)", lines[-1])}, [x for x in lines if x.startswith("VIOLATION")]


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default=",".join(MODELS))
    args = parser.parse_args(words)
    names, bad = args.only.split(","), 0
    for name in names:
        with tempfile.TemporaryDirectory() as place:
            numbers, violations = run(name, Path(place), args.seed, args.first, -(-args.steps // len(names) // 6))
        print(name, *(f"{key} {n}" for key, n in numbers.items()), *violations[:8], sep="  ", flush=True)
        bad += len(violations)
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
