"""Fourteen scenes of three fields, with all of their effects and with some switched off: operations, instructions, time.

    python tests/bench/scenes.py            # some minutes: docs/scenes.csv, and the table of docs/scenes.md
    python tests/bench/scenes.py --only spins

Each scene builds on a spec and leaves effects out (`without`). Beside it stands a spec that never had them, written with the rest alone: its C is compared with that of
the scene byte for byte, and where the two differ both are counted. Operations are counted in the formulas, as `smidgen effects` does; instructions by callgrind, N and 2 N steps
(instructions.py); the time is that of the processor, the least of some runs.
"""
from __future__ import annotations

import argparse
import csv
import datetime
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import smidgen
from instructions import Kernel, compiled, counted
from machine import processor, put_between
from smidgen.build.binary import FLAGS, compiler_version, find_compiler
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.cost.effects import counts
from smidgen.run.step.prepared import prepare

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- scenes: made by `python tests/bench/scenes.py` -->\n", "<!-- end of scenes -->"
COLUMNS = ("field", "scene", "without", "method", "sites", "operations", "operations_without", "instructions", "instructions_without", "ratio_to_the_rest_alone", "same_c",
           "ns", "ns_without")
STEPS, TIMED, ROUNDS = 20, 1e8, 3      # steps that are counted; instructions of a run that is timed


@dataclass(frozen=True)
class Scene:
    """space: its line; more: parameters and lattices; effects: a line each; without: those that are switched off."""
    field: str
    name: str
    space: str
    effects: dict
    without: tuple
    more: str = ""
    start: str = "random = 1"
    h: float = 0.05

    def text(self, names=None) -> str:
        lines = "\n".join(f"{name} = {{ {said} }}" for name, said in self.effects.items() if names is None or name in names)
        start = self.start if self.start.startswith("[") else f"[starts.s]\n{self.start}"
        return f'[model]\nname = "{self.name}"\n[space]\n{self.space}\n{self.more}\n[effects]\n{lines}\n{start}\n[runs.demo]\nstart = "s"\nh = {self.h}\nsteps = 100\n'

    @property
    def rest(self) -> list[str]:
        return [name for name in self.effects if name not in self.without]


BODY = "Ixx = 1, Iyy = 2, Izz = 4, Ixy = 0.1"
FREE = f'use = "bodies/rotation", {BODY}'
VORTICES = 'use = "vortices/interaction", gamma = "gamma"'
STRENGTHS = '[parameters]\ngamma = { default = [1.0, -0.7, 0.8, 0.5], size = 4 }'
FILM = "square(n, n, periodic)"
SIDE = '[parameters]\nn = 16\n'
ROWS = SIDE + '[lattices.film]\nsize = ["n", "n"]\nboundary = "periodic"\nbonds.x = [{ offset = [1, 0] }]\nbonds.y = [{ offset = [0, 1] }]\n'
LINE = '[parameters]\nn = 100\n[lattices.line]\nsize = ["n"]\nboundary = "periodic"\nbonds.row = [{ at = [[0, -1], [0, 0], [0, 1]] }]\n'
HONEY = ('[parameters]\nn = 8\n[lattices.honey]\nsize = ["n", "n"]\nboundary = "periodic"\nsites = 2\nbonds.x = [{ from = 0, to = 1, offset = [0, 0] }]\n'
         'bonds.y = [{ from = 0, to = 1, offset = [-1, 0] }]\nbonds.z = [{ from = 0, to = 1, offset = [0, -1] }]\n')
EXCHANGE = f'use = "spins/exchange", J = 1, bonds = "{FILM}"'
BATH = 'use = "spins/bath", alpha = 0.1, kT = 0.2'
SCENES = (
    Scene("bodies", "satellite", "w = { r3 = 1 }", {"body": f'use = "bodies/gyrostat", {BODY}, rotor = [0.3, 0, 0]', "sloshing": 'use = "bodies/damping", alpha = 0.05'}, ("sloshing",)),
    Scene("bodies", "orbiting_body", "w = { sphere = 1 }", {"body": FREE, "gravity": 'use = "bodies/gravity_gradient", n = 0.3, CA = 2'}, ("gravity",)),
    Scene("bodies", "forced_body", "w = { sphere = 1 }", {"body": FREE, "drive": 'use = "bodies/forcing", strength = 0.2, omega = 1.3'}, ("drive",)),
    Scene("bodies", "two_bodies_coupled", "w = { r3 = 2 }", {"body": FREE, "joint": 'use = "bodies/coupling", g = 0.3, bonds = "chain(2, open)"'}, ("joint",)),
    Scene("vortices", "turning_vortices", 'w = { sphere = 4, kappa = "gamma[i]" }', {"vortices": VORTICES, "turning": 'use = "vortices/rotation", Omega = 0.3, gamma = "gamma[i]"'},
          ("turning",), STRENGTHS, h=0.02),
    Scene("vortices", "vortices_and_tracers", 'w = { sphere = 4, kappa = "gamma[i]" }\np = { sphere = 200, tracer = true }',
          {"vortices": VORTICES, "carried": 'use = "vortices/transport", gamma = "gamma"', "wave": 'use = "vortices/rossby_haurwitz", A = 0.2, omega = 0.05, Omega = 0.3'},
          ("wave",), STRENGTHS, "[starts.s.w]\nrandom = 1\n[starts.s.p]\nrandom = 2", 0.002),
    Scene("vortices", "tracers_in_a_wave", "p = { sphere = 500 }",
          {"wave": 'use = "vortices/rossby_haurwitz", A = 0.2, omega = 0.05, Omega = 0.3', "turning": 'use = "vortices/rotation", Omega = 0.3, on = "p"'}, ("turning",)),
    Scene("vortices", "vortices_in_a_flow", 'w = { sphere = 4, kappa = "gamma[i]" }',
          {"vortices": VORTICES, "flow": 'use = "vortices/stream_function", psi = "0.2*w[i].x*w[i].y*cos(t)", on = "w"'}, ("flow",), STRENGTHS, h=0.02),
    Scene("spins", "chiral_film", 'w = { sphere = "n*n" }',
          {"exchange": EXCHANGE, "easy": 'use = "spins/uniaxial", K = 0.4', "moriya_x": 'use = "spins/dmi", D = [0, 0.3, 0], bonds = "film.x"',
           "moriya_y": 'use = "spins/dmi", D = [-0.3, 0, 0], bonds = "film.y"'}, ("moriya_x", "moriya_y"), ROWS),
    Scene("spins", "hot_film", 'w = { sphere = "n*n" }', {"exchange": EXCHANGE, "field": 'use = "spins/zeeman", B = [0, 0, 0.3]', "bath": BATH}, ("bath",), SIDE),
    Scene("spins", "driven_chain", 'w = { sphere = "n" }',
          {"exchange": 'use = "spins/exchange", J = 1, bonds = "chain(n, periodic)"', "damping": 'use = "spins/damping", alpha = 0.1',
           "current": 'use = "spins/zhang_li", u = 0.1, beta = 0.05, bonds = "line.row"'}, ("current",), LINE),
    Scene("spins", "diluted_film", 'w = { sphere = "n*n" }', {"exchange": EXCHANGE, "easy": 'use = "spins/uniaxial", K = 0.4', "holes": 'use = "spins/vacancies", part = 0.1'},
          ("holes",), SIDE),
    Scene("spins", "random_magnet", 'w = { sphere = "n*n" }',
          {"bonds": f'use = "spins/random_bonds", mean = 1, spread = 0.3, bonds = "{FILM}"', "axes": 'use = "spins/random_anisotropy", K = 0.3'}, ("axes",), SIDE),
    Scene("spins", "honeycomb_kitaev", 'w = { sphere = "2*n*n" }',
          {**{f"kitaev_{a}": f'use = "spins/kitaev", K = -1, axis = "{a}", bonds = "honey.{a}"' for a in "xyz"}, "gamma_z": 'use = "spins/gamma", G = 0.3, a = "x", b = "y", bonds = "honey.z"'},
          ("gamma_z",), HONEY))


def specs_of(scene: Scene, folder: Path) -> list:
    """The spec with all effects, the scene on it without some, and the spec with the rest alone."""
    (folder / "base.toml").write_text(scene.text())
    left = ", ".join(f'"{name}"' for name in scene.without)
    (folder / "scene.toml").write_text(f'[scene]\nbase = "base.toml"\nname = "{scene.name}"\nwithout = [{left}]\n')
    (folder / "rest.toml").write_text(scene.text(scene.rest))
    return [smidgen.load(folder / f"{name}.toml") for name in ("base", "scene", "rest")]


def c_of(spec) -> dict:
    return generate(replace(select(spec), digest=""))


def operations(spec) -> float:
    """Of the gradients of all effects, for each site."""
    prepared, tracers = prepare(spec, "spherical-midpoint", None, {}), {f.name for f in spec.families if f.tracer}
    moved = {e.name: counts(e, prepared.numbers, tracers)[0] for e in spec.effects}
    return sum(moved.values())


def measured(spec, h: float) -> tuple[float, float]:
    """(instructions, nanoseconds) of a step."""
    kernel = Kernel(spec.name, h=h, start="s", steps=STEPS)
    with tempfile.TemporaryDirectory() as place:
        program = compiled(kernel, select(spec), Path(place))
        first, both = (counted(kernel, program, n * STEPS) for n in (1, 2))
        instructions = (both - first) / STEPS
        many = max(STEPS, int(TIMED / instructions))
        times = [seconds(program, h, n * many) for _ in range(ROUNDS) for n in (1, 2)]
    return instructions, 1e9 * (min(times[1::2]) - min(times[::2])) / many


def seconds(program: Path, h: float, steps: int) -> float:
    """Of the processor, for so many steps with all that comes before them."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([program, str(steps), str(h), "0", "1", program.with_name("starts")], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def row(scene: Scene) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        base, without, rest = specs_of(scene, Path(folder))
        same = c_of(without) == c_of(rest)
        (all_of, ns), (some, ns_without) = measured(base, scene.h), measured(without, scene.h)
        alone = some if same else measured(rest, scene.h)[0]
        sites = sum(count for _, count in prepare(base, "spherical-midpoint", None, {}).numbers.places.values())
        line = dict(zip(COLUMNS, (scene.field, scene.name, " ".join(scene.without), "spherical-midpoint", sites, f"{operations(base):.1f}", f"{operations(without):.1f}", f"{all_of / sites:.1f}",
                                  f"{some / sites:.1f}", f"{some / alone:.4f}", "yes" if same else "no", f"{ns / sites:.1f}", f"{ns_without / sites:.1f}")))
    print(*line.values(), sep=",", file=sys.stderr, flush=True)
    return line


def table(lines: list) -> str:
    """Markdown."""
    about = f"{processor()}; {compiler_version(find_compiler())}, {' '.join(FLAGS)}; {datetime.date.today()}. Spherical midpoint; per step and site.\n"
    head = "| scene | effect switched off | operations | operations without | instructions | instructions without | ratio to a spec without it | same C | ns | ns without |\n|---|---|---:|---:|---:|---:|---:|---|---:|---:|\n"
    cells = (f"| {r['field']}: {r['scene'].replace('_', ' ')}, {r['sites']} site{'s' * (str(r['sites']) != '1')} | {r['without'].replace('_', ' ')} | {r['operations']} | {r['operations_without']} | {r['instructions']} | "
             f"{r['instructions_without']} | {float(r['ratio_to_the_rest_alone']):.2f} | {r['same_c']} | {r['ns']} | {r['ns_without']} |" for r in lines)
    return about + "\n" + head + "\n".join(cells) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="TEXT", default="", help="scenes with this text in field or name; printed, not written")
    args = parser.parse_args()
    lines = [row(scene) for scene in SCENES if args.only in f"{scene.field} {scene.name}"]
    if args.only:
        return
    with open(DOCS / "scenes.csv", "w", newline="") as out:
        found = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        found.writeheader()
        found.writerows(lines)
    put_between(DOCS / "scenes.md", BEGIN, END, table(lines))


if __name__ == "__main__":
    main()
