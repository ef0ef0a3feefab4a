"""What accuracy costs for every system of the paper: docs/cost/*.csv and figures, and the page docs/costs.md.

    python tests/bench/cost.py                       # all of it and promises.py, some twenty minutes on a quiet machine
    python tests/bench/cost.py point_vortices        # only these
    python tests/bench/cost.py --quick --into /tmp/x # two systems, few methods, short: is all of it there?
    python tests/bench/cost.py --page                # figures and page from the tables

General integrators are measured beside where they are there: GSL, SciPy, heyoka (pip install heyoka), SUNDIALS 7
(SUNDIALS_DIR). Those that are missing are named on the page.
"""
import argparse
import csv
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import smidgen
from PIL import Image
from smidgen.cost.report import words
from smidgen.cost.versus import behind, others, table
from smidgen.show.plot.cost import draw_cost

sys.path.insert(0, str(Path(__file__).resolve().parent))

DOCS = Path(__file__).resolve().parents[2] / "docs"
HEAD = Path(__file__).with_name("costs.md.in")


@dataclass(frozen=True)
class System:
    """time: of the short runs; long: of those that are compared by what they keep, 0 for none; values: parameters that are set."""
    time: float
    long: float = 0
    values: dict = field(default_factory=dict)


SYSTEMS = {"free_rigid_body": System(100, 1e5), "irreversible_rigid_body": System(100, 1e5), "point_vortices": System(100, 1e4),
           "heisenberg_chain": System(20, 2000, {"n": 100}), "forced_rigid_body": System(50), "landau_lifshitz": System(5), "test_particles": System(10),
           "vortex_tracers": System(20), "nambu_a31": System(10), "lagrange": System(0.5), "product": System(10), "two_bodies": System(20)}
QUICK = {"irreversible_rigid_body": System(10, 100), "two_bodies": System(2)}
LONGER = 1.5        # times as many seconds for the long runs: their methods need some to get to small errors
FEW = ("spherical-midpoint", "gauss-4", "gauss-8", "dop853")
PARTS = (("", "end_error", "end error"), ("_long", "energy", "energy error"))


def measured(name: str, system: System, folder: Path, seconds: float, methods) -> None:
    """The tables of one system: with general integrators beside where its long runs are compared too."""
    folder.mkdir(parents=True, exist_ok=True)
    spec, asked = smidgen.load(name), dict(values=system.values, methods=methods, native=True, peers=bool(system.long))
    tell(name)
    smidgen.cost(spec, time=system.time, seconds=seconds, **asked).save(folder / f"{name}.csv")
    if system.long:
        tell(f"{name}, to {system.long:g}")
        smidgen.cost(spec, time=system.long, seconds=LONGER * seconds, ends=False, long=False, **asked).save(folder / f"{name}_long.csv")


def promises(folder: Path, quick: bool) -> None:
    """The table of promises, by its own bench."""
    tell("promises")
    bench = Path(__file__).with_name("promises.py")
    subprocess.run([sys.executable, bench, "--out", folder / "promises.csv", *["--quick"] * quick], check=True, stdout=subprocess.DEVNULL)


def tell(text: str) -> None:
    print(f"-- {text}", file=sys.stderr, flush=True)


def page(folder: Path, systems: dict) -> str:
    """The page of the tables that there are."""
    parts = [part for name in systems if (folder / f"{name}.csv").exists() for part in section(name, folder)]
    return "\n".join([HEAD.read_text(encoding="utf-8"), *more(folder), *parts]) + "\n"


def more(folder: Path):
    """What other benches of this folder have measured."""
    import choose_random
    import promises
    for title, bench, name in (("What each promise costs", promises, "promises.csv"), ("Random Hamiltonians", choose_random, "choose_random.csv")):
        if (folder / name).exists():
            with open(folder / name, newline="") as lines:
                yield f"## {title}\n\n[{name}](cost/{name})\n\n{bench.words(list(csv.DictReader(lines)))}\n"


def section(name: str, folder: Path):
    """One system: ratios, words, figure."""
    yield f"## {smidgen.load(name).title or name}\n"
    found = [(f"{name}{end}", what, said, smidgen.load_cost(folder / f"{name}{end}.csv")) for end, what, said in PARTS if (folder / f"{name}{end}.csv").exists()]
    for word, what, said, cost in found:
        yield f"[{word}.csv](cost/{word}.csv): by {said}, to time {float(cost.facts['time']):g}\n"
        if others(cost, what):
            yield f"{table(cost, what)}\n"
            yield f"{short_of(behind(cost, what))}\n"
    yield "\n".join(["```", *words(found[0][3]).splitlines(), "```"]) + "\n"
    yield f"![{name}](cost/{name}.png)\n"


def short_of(cells: list[str]) -> str:
    """Where the symplectic methods are behind, or that they are not."""
    return f"Ahead of the best symplectic method: {'; '.join(cells)}." if cells else "The best symplectic method is ahead of every general integrator in every cell."


def lighter(picture: Path) -> None:
    """128 colours, a third of the bytes."""
    Image.open(picture).convert("RGB").quantize(128).save(picture, optimize=True)


def main() -> None:
    """Measure, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SPEC", help="systems; default: all")
    parser.add_argument("--seconds", type=float, default=20.0, help="of timed runs for each table")
    parser.add_argument("--into", type=Path, default=DOCS, help="folder of costs.md and cost/; default: docs")
    parser.add_argument("--quick", action="store_true", help="two systems, few methods, short runs")
    parser.add_argument("--page", action="store_true", help="measure nothing")
    args = parser.parse_args()
    systems, folder = QUICK if args.quick else SYSTEMS, args.into / "cost"
    for name in () if args.page else args.names or systems:
        measured(name, systems[name], folder, 2.0 if args.quick else args.seconds, FEW if args.quick else None)
    if not args.page and not args.names:
        promises(folder, args.quick)
    for path in sorted(folder.glob("*.csv")):
        if path.stem.removesuffix("_long") in systems:
            draw_cost(smidgen.load_cost(path), path.with_suffix(".png"))
            lighter(path.with_suffix(".png"))
    (args.into / "costs.md").write_text(page(folder, systems), encoding="utf-8")


if __name__ == "__main__":
    main()
