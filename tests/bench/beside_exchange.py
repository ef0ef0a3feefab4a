"""What one word more in a spec costs: scenes beside exchange alone, on the cubic lattice.

    python tests/bench/beside_exchange.py                  # some minutes: docs/beside_exchange.csv and its page
    python tests/bench/beside_exchange.py --times          # times as well, taken in turns with exchange alone, on a machine without other work
    python tests/bench/beside_exchange.py --only kappa     # the rows whose name has this text are made anew, the others stay

Each scene is exchange with something added to it. The table says whether its steps go by rows in lanes, what prevents it where they do not (as `smidgen explain` says it), how many
operations its formulas have, and how many instructions a spin and step takes: by callgrind, with vectors of LANES numbers, of 12^3 spins, from the steps in which the history is full. Times are those of 20^3 spins.
"""
from __future__ import annotations

import argparse
import csv
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import smidgen
from instructions import MIDPOINT, Kernel, compiled, counted
from machine import machine, put_between
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.cost.effects import counts
from smidgen.run.step.prepared import prepare

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- beside exchange: made by `make bench-scenes` -->\n", "<!-- end of beside exchange -->"
COLUMNS = ("added", "method", "layout", "prevented_by", "operations", "instructions", "operations_beside", "instructions_beside", "ns", "ns_beside")
VECTORS, LANES = ("-mavx2",), 4      # callgrind knows none that are wider
STEPS, H = 6, 0.0247
COUNTED, SIDE = 12, 20           # spins along an edge, where instructions are counted and where time is taken
TIMED, TURNS = 0.05, 20        # seconds of a turn; turns
TEXT = """[model]
name = "scene"
[space]
{space}
[parameters]
n = {n}
[lattices.cube]
size = ["n", "n", "n"]
boundary = "periodic"
bonds.second = [{{ offset = [1, 1, 0] }}, {{ offset = [1, -1, 0] }}, {{ offset = [1, 0, 1] }}, {{ offset = [1, 0, -1] }}, {{ offset = [0, 1, 1] }}, {{ offset = [0, 1, -1] }}]
bonds.third = [{{ offset = [2, 0, 0] }}, {{ offset = [0, 2, 0] }}, {{ offset = [0, 0, 2] }}]
bonds.diagonal = [{{ offset = [1, 1, 1] }}, {{ offset = [1, 1, -1] }}, {{ offset = [1, -1, 1] }}, {{ offset = [1, -1, -1] }}]
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "{exchange}"
{more}
{start}
"""
NEAR, OPEN = "cubic(n, n, n, periodic)", "cubic(n, n, n, open)"
RANDOM = "[starts.s]\nrandom = 1"


@dataclass(frozen=True)
class Scene:
    """What is added: the name of the row, effects by their lines, and what else is not as in exchange alone."""
    name: str
    effects: tuple = ()
    exchange: str = "-dot(w[i], w[j])"
    space: str = 'w = {{ sphere = "n*n*n"{} }}'
    family: str = ""
    lattice: str = NEAR
    odd: int = 0
    method: str = MIDPOINT
    features: tuple = ()
    pushed: int = 0
    start: str = RANDOM
    beside: str = "exchange alone"

    def text(self, n: int = COUNTED) -> str:
        more = "\n".join(f"[effects.e{k}]\n{one}" for k, one in enumerate(self.effects))
        return TEXT.format(space=self.space.format(self.family), n=n + self.odd, lattice=self.lattice, exchange=self.exchange, more=more, start=self.start)

    def sites(self, n: int = COUNTED) -> int:
        return (n + self.odd) ** 3 * self.space.count("sphere")


def site(energy: str) -> str:
    return f'over = "site(i) of w"\nenergy = "{energy}"'


def bonds(energy: str, over: str = NEAR) -> str:
    return f'over = "bond(i, j) of {over}"\nenergy = "{energy}"'


def own(word: str) -> str:
    return f'over = "site(i) of w"\n{word}'


TWIST, FIELD, AXIS = bonds("-0.3*triple(vec(0, 0, 1), w[i], w[j])"), site("-0.5*w[i].z"), site("-0.4*w[i].z^2/2")
DAMPED = own('damping = "0.1"')
TURNING = "sublattice rotations"
AXES = [f"w[i].{a}*w[j].{a}" for a in "xyz"]
SCENES = (
    Scene("exchange alone"),
    Scene("DMI", (TWIST,)),
    Scene("tensor exchange", (bonds("-0.2*w[i].x*w[j].x - 0.1*w[i].z*w[j].y - 0.1*w[i].y*w[j].z"),)),
    Scene("field", (FIELD,)),
    Scene("anisotropy", (AXIS,)),
    Scene("DMI, anisotropy, field", (TWIST, AXIS, FIELD)),
    Scene("open boundaries", lattice=OPEN),
    Scene("sides of odd length", odd=1),
    Scene("field that depends on time", (site("-0.5*cos(t)*w[i].z"),)),
    Scene("rotating field", (site("-0.5*(cos(t)*w[i].x + sin(t)*w[i].y)"),)),
    Scene("exchange that depends on time", exchange="-(1 + 0.2*cos(t))*dot(w[i], w[j])"),
    Scene("exchange that grows linearly in time", exchange="-(1 + 0.001*t)*dot(w[i], w[j])"),
    Scene("field that differs by site", (site("-normal(1, i)*w[i].z/2"),)),
    Scene("field given by a formula of i", (site("-0.5*sin(0.1*i)*w[i].z"),)),
    Scene("travelling wave", (site("-0.5*cos(0.1*i - t)*w[i].z"),)),
    Scene("anisotropy that differs by site", (site("-(0.4 + 0.1*normal(1, i))*w[i].z^2/2"),)),
    Scene("exchange that differs by bond", exchange="-(1 + 0.1*uniform(1, i, j))*dot(w[i], w[j])"),
    Scene("exchange that differs by bond, random axes", (site("-0.1*(normal(1, i)*w[i].x + normal(2, i)*w[i].y + normal(3, i)*w[i].z)^2"),),
          "-(1 + 0.1*uniform(1, i, j))*dot(w[i], w[j])"),
    Scene("kappa that differs by site", family=', kappa = "1 + mod(i, 2)"'),
    Scene("radius that differs by site", family=', radius = "1 + mod(i, 2)"'),
    Scene("J1 + J2", (bonds("0.2*dot(w[i], w[j])", "cube.second"),)),
    Scene("J1 + J3", (bonds("0.2*dot(w[i], w[j])", "cube.third"),)),
    Scene("32 neighbours", tuple(bonds(f"{J}*dot(w[i], w[j])", f"cube.{shell}") for J, shell in ((0.2, "second"), (0.1, "diagonal"), (0.1, "third")))),
    Scene("cubic anisotropy", (site("-0.1*(w[i].x^4 + w[i].y^4 + w[i].z^4)"),)),
    Scene("biquadratic", (bonds("-0.1*dot(w[i], w[j])^2"),)),
    Scene("three effects on the same bonds", tuple(bonds(f"-{xx}") for xx in AXES[1:]), exchange=f"-{AXES[0]}"),
    Scene("six effects on the same bonds", tuple(bonds(f"-{xx}/2") for xx in (*AXES[1:], *AXES)), exchange=f"-{AXES[0]}/2"),
    Scene("two families", (bonds("-dot(v[i], v[j])", NEAR + " on v"),),
          lattice=NEAR + " on w", space='w = {{ sphere = "n*n*n" }}\nv = {{ sphere = "n*n*n" }}', start="[starts.s.w]\nrandom = 1\n[starts.s.v]\nrandom = 2"),
    Scene("damping", (DAMPED,)),
    Scene("damping and noise", (own('damping = "0.1"\nkT = 0.3'),)),
    Scene("damping that differs by site", (own('damping = "0.1 + 0.05*mod(i, 2)"'),)),
    Scene("torque", (own('torque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"'),)),
    Scene("torque that depends on time", (own('torque = "0.2*cos(t)*cross(w[i], cross(w[i], vec(0, 1, 0)))"'),)),
    Scene("torque without a closed form", (own('torque = "0.2*w[i].z*cross(w[i], vec(0, 1, 0))"'),)),
    Scene("absent sites", (own('absent = "uniform(7, i) < 0.1"'),)),
    Scene("pinned sites", (own('pinned = "uniform(7, i) < 0.1"'),)),
    Scene("Gauss of order 4", method="gauss-4"),
    Scene("Gauss of order 8", method="gauss-8"),
    Scene("DOP853", method="dop853"),
    Scene("extrapolation of order 12", method="extrapolation-12"),
    Scene("classical midpoint", method="classical-midpoint"),
    Scene("tangent map, steps alone", features=("tangent",)),
    Scene("tangent map of one vector", features=("tangent",), pushed=1),
    Scene("composition of order 4", method="spherical-midpoint-4"),
    Scene(TURNING, method="sublattice-rotations"),
    Scene("sublattice rotations, field that depends on time", (site("-0.5*cos(t)*w[i].z"),), method="sublattice-rotations", beside=TURNING),
)


def spec_of(scene: Scene):
    return select(smidgen.load_text(scene.text()))


def operations(scene: Scene) -> float:
    """Of the gradients of all effects, a site: those of damping and torques too. A vector that is carried along takes those of another gradient, of its change."""
    spec = spec_of(scene)
    numbers = prepare(spec, scene.method, None, {}, "auto").numbers
    return sum(counts(effect, numbers, set())[0] for effect in spec.effects) * (1 + scene.pushed)


def kernel_of(scene: Scene) -> Kernel:
    return Kernel(scene.name, scene.method, H, steps=STEPS, text=scene.text(), features=scene.features, pushed=scene.pushed)


def row(scene: Scene) -> dict:
    files = generate(spec_of(scene), scene.method, features=scene.features)
    prevented = files.notes["reason"].partition("site by site, because ")[2]
    with tempfile.TemporaryDirectory() as place:
        program = compiled(kernel_of(scene), spec_of(scene), Path(place), VECTORS)
        first, both = (counted(kernel_of(scene), program, k * STEPS) for k in (1, 2))
    line = dict.fromkeys(COLUMNS, "") | dict(added=scene.name, method=scene.method, layout="sites" if prevented or not files.notes["lanes"] else "rows", prevented_by=prevented,
                                             operations=f"{operations(scene):.1f}", instructions=f"{(both - first) / STEPS / scene.sites():.1f}")
    print(*line.values(), sep=",", file=sys.stderr, flush=True)
    return line


def beside(lines: list) -> list:
    """With the ratios."""
    found = {line["added"]: line for line in lines}
    for scene in SCENES:
        if scene.name in found and scene.beside in found:
            for what in ("operations", "instructions"):
                mine, other = (found[name][what] for name in (scene.name, scene.beside))
                found[scene.name][f"{what}_beside"] = f"{float(mine) / float(other):.2f}" if mine and other else ""
    return lines


# Times

def built(scene: Scene):
    """steps(count) of the scene: all at once, or each followed by the map of a tangent vector."""
    model = smidgen.build(smidgen.load_text(scene.text(SIDE)), method=scene.method, features=scene.features, native=True).start("s", h=H).steps(10)
    if not scene.pushed:
        return model.steps
    vector = np.cross(model.w, [0.0, 0.0, 1.0])

    def pushed(count: int) -> None:
        for _ in range(count):
            model.step().tangent(vector)
    return pushed


def turn(steps, sites: int, count: int) -> float:
    """Nanoseconds a spin and step."""
    begin = time.process_time()
    steps(count)
    return (time.process_time() - begin) / count / sites * 1e9


def timed(scene: Scene, other: Scene) -> tuple:
    """Of both, the least of some turns that they take one after the other."""
    mine, its = built(scene), built(other)
    count = max(2, int(TIMED / (turn(mine, scene.sites(SIDE), 2) * 1e-9 * scene.sites(SIDE))))
    turns = [(turn(mine, scene.sites(SIDE), count), turn(its, other.sites(SIDE), count)) for _ in range(TURNS)]
    return tuple(map(min, zip(*turns)))


# Tables

def words(value: str) -> str:
    return value.replace("|", r"\|")


def table(lines: list) -> str:
    head = "| effect added | stepped | instructions | ratio to exchange alone | operations, ratio | ns | ns, ratio |\n|---|---|---:|---:|---:|---:|---:|\n"
    rows = [f"| {line['added']} | {'by rows' if line['layout'] == 'rows' else 'site by site: ' + words(line['prevented_by']) if line['prevented_by'] else 'site by site'} | {line['instructions']} | "
            f"{line['instructions_beside']} | {line['operations_beside']} | {line['ns']} | {line['ns_beside']} |\n" for line in lines]
    return f"{machine()}. Instructions with vectors of {LANES} numbers ({' '.join(VECTORS)}).\n\n" + head + "".join(rows)


def before() -> list:
    """The rows that the table has."""
    with open(DOCS / "beside_exchange.csv", newline="") as table:
        table.readline()
        return list(csv.DictReader(table))


def written(lines: list) -> None:
    with open(DOCS / "beside_exchange.csv", "w", newline="") as out:
        out.write(f"# {machine()}; instructions with {LANES} lanes ({' '.join(VECTORS)})\n")
        found = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        found.writeheader()
        found.writerows(lines)
    put_between(DOCS / "beside_exchange.md", BEGIN, END, table(lines))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="TEXT", default="", help="rows whose name has this text")
    parser.add_argument("--times", action="store_true")
    parser.add_argument("--processes", type=int, choices=(1, 2), default=1)
    args = parser.parse_args()
    scenes = [scene for scene in SCENES if args.only in scene.name]
    with ThreadPoolExecutor(args.processes) as pool:
        lines = list(pool.map(row, scenes))
    kept(lines)
    others = {scene.name: scene for scene in SCENES}
    for scene, line in zip(scenes, lines) if args.times else ():
        mine, its = timed(scene, others[scene.beside])
        line |= dict(ns=f"{mine:.1f}", ns_beside=f"{mine / its:.2f}")
        print(scene.name, line["ns"], line["ns_beside"], file=sys.stderr, flush=True)
        kept(lines)


def kept(lines: list) -> None:
    """These rows in the table, beside those that it has."""
    made = {line["added"]: line for line in (*before(), *lines)}
    written(beside([made[scene.name] for scene in SCENES if scene.name in made]))


if __name__ == "__main__":
    main()
