"""What accuracy costs for every system of the paper: tables and figures in docs/cost/lanes_N, of vectors of N lanes as the
registers of this processor have them, and the page docs/costs.md of the tables of all widths.

    python tests/bench/cost.py                       # all of it and promises.py
    python tests/bench/cost.py --since 2026-11-23    # the same, but tables of this width from that day on stay: continues where it stopped
    python tests/bench/cost.py point_vortices        # only these
    python tests/bench/cost.py --quick --into /tmp/x # two systems, few methods, short: is all of it there?
    python tests/bench/cost.py --page                # figures and page from the tables

General integrators are measured beside where they are there: GSL, SciPy, heyoka (pip install heyoka), SUNDIALS 7
(SUNDIALS_DIR), C by hand. Those that are missing are named on the page.
"""
import argparse
import csv
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import smidgen
from PIL import Image
from smidgen.cost.report import measured_on, words
from smidgen.cost.versus import behind, others, summary, table
from smidgen.show.plot.cost import draw_cost

sys.path.insert(0, str(Path(__file__).resolve().parent))

from machine import cost_tables

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
PARTS = (("", "end_error", "final error"), ("_long", "energy", "energy error"))


def measured(name: str, system: System, folder: Path, seconds: float, methods, since: str) -> None:
    """The tables of one system: with general integrators beside where its long runs are compared too. Each is drawn at once."""
    folder.mkdir(parents=True, exist_ok=True)
    asked = dict(parameters=system.values, methods=methods, native=True, peers=bool(system.long))
    if not stays(folder / f"{name}.csv", since):
        tell(name)
        kept(smidgen.cost(smidgen.load(name), time=system.time, seconds=seconds, **asked), folder / f"{name}.csv")
    if system.long and not stays(folder / f"{name}_long.csv", since):
        tell(f"{name}, to {system.long:g}")
        kept(smidgen.cost(smidgen.load(name), time=system.long, seconds=LONGER * seconds, ends=False, long=False, **asked), folder / f"{name}_long.csv")


def stays(path: Path, since: str) -> bool:
    """Is there a table of that day, or of a later one? No day: none stays."""
    return bool(since) and path.exists() and smidgen.load_cost(path).facts.get("date", "") >= since


def kept(cost, path: Path) -> None:
    """The table, then its figure."""
    cost.save(path)
    drawn(path)


def drawn(path: Path) -> None:
    """The figure of a table, with 128 colours: a third of the bytes."""
    picture = path.with_suffix(".png")
    draw_cost(smidgen.load_cost(path), picture)
    Image.open(picture).convert("RGB").quantize(128).save(picture, optimize=True)


def promises(folder: Path, quick: bool) -> None:
    """The table of promises, by its own bench."""
    tell("promises")
    bench = Path(__file__).with_name("promises.py")
    subprocess.run([sys.executable, bench, "--out", folder / "promises.csv", *["--quick"] * quick], check=True, stdout=subprocess.DEVNULL)


def tell(text: str) -> None:
    print(f"-- {text}", file=sys.stderr, flush=True)


def page(folder: Path, systems: dict) -> str:
    """The page of the tables that there are."""
    widths = sorted(folder.glob("lanes_*"), key=lambda place: -int(place.name.removeprefix("lanes_")))
    parts = [part for name in systems for part in section(name, widths)]
    return "\n".join([HEAD.read_text(encoding="utf-8"), *(part for place in widths for part in more(place, systems)), *parts]) + "\n"


def more(place: Path, systems: dict):
    """Of the tables of one width: who is first, and what other benches of this folder have measured."""
    import choose_random
    import promises
    width = f"vectors of {place.name.removeprefix('lanes_')} lanes"
    found = {name: smidgen.load_cost(place / f"{name}.csv") for name in systems if (place / f"{name}.csv").exists()}
    if found:
        yield f"## The fastest methods, {width}\n\n{HOW_FIRST}\n\n{summary(found)}\n\n{short_of(found)}\n"
    for title, bench, name in (("What each guarantee costs", promises, "promises.csv"), ("Random Hamiltonians", choose_random, "choose_random.csv"), ("Random lattices that go by rows", choose_random, "choose_rows.csv")):
        if (place / name).exists():
            with open(place / name, newline="") as lines:
                yield f"## {title}, {width}\n\n[{name}](cost/{place.name}/{name})\n\n{bench.words(list(csv.DictReader(lines)))}\n"


HOW_FIRST = ("Each column is for one error of the final state, in short runs. The first row of a system gives the fastest method. The second row gives "
             "the fastest general-purpose integrator, if any was measured, and its time divided by that of the best symplectic method.")


def short_of(found: dict) -> str:
    """Where the symplectic methods are behind a general integrator, in how many cells."""
    beside = {name: cost for name, cost in found.items() if others(cost, "end_error")}
    cells = sum(len(behind(cost, "end_error")) for cost in beside.values())
    count = sum(1 for cost in beside.values() for row in others(cost, "end_error").values() for cell in row if cell.name)
    return f"In {cells} of {count} cells, a general-purpose integrator takes less time than the best symplectic method. They are listed below the tables of each system."


def section(name: str, widths):
    """One system: ratios of each width, words and figure of the widest."""
    tables = [(place, f"{name}{end}", what, said) for place in widths for end, what, said in PARTS if (place / f"{name}{end}.csv").exists()]
    if not tables:
        return
    yield f"## {smidgen.load(name).title or name}\n"
    for place, word, what, said in tables:
        cost = smidgen.load_cost(place / f"{word}.csv")
        yield f"[{place.name}/{word}.csv](cost/{place.name}/{word}.csv): by {said}, up to time {float(cost.facts['time']):g}; {on(cost)}\n"
        if others(cost, what):
            yield f"{table(cost, what)}\n"
            yield f"{ahead(cost, behind(cost, what))}\n"
    place, word, *_ = tables[0]
    yield "\n".join(["```", *words(smidgen.load_cost(place / f"{word}.csv")).splitlines(), "```"]) + "\n"
    yield f"![{name}](cost/{place.name}/{name}.png)\n"


def on(cost) -> str:
    """Machine, vectors and date of a table, or that it has them not."""
    return measured_on(cost.facts) + (", width of the vectors and date not recorded" if "lanes" not in cost.facts else "")


def ahead(cost, cells: list[str]) -> str:
    """Where general integrators are ahead, or that none is, with what it was measured on."""
    said = f"faster than the best symplectic method: {'; '.join(cells)}" if cells else "the best symplectic method is faster than every general-purpose integrator in every cell"
    return f"{on(cost)}: {said}."


def main() -> None:
    """Measure, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SPEC", help="systems; default: all")
    parser.add_argument("--seconds", type=float, default=20.0, help="of timed runs for each table")
    parser.add_argument("--into", type=Path, default=DOCS, help="folder of costs.md and cost/; default: docs")
    parser.add_argument("--since", default="", metavar="DATE", help="tables of this width from that day on stay as they are")
    parser.add_argument("--quick", action="store_true", help="two systems, few methods, short runs")
    parser.add_argument("--page", action="store_true", help="measure nothing")
    args = parser.parse_args()
    systems, place = QUICK if args.quick else SYSTEMS, cost_tables(args.into / "cost")
    for name in () if args.page else args.names or systems:
        measured(name, systems[name], place, 2.0 if args.quick else args.seconds, FEW if args.quick else None, args.since)
        written(args.into, systems)
    if not args.page and not args.names:
        promises(place, args.quick)
    for path in sorted((args.into / "cost").glob("lanes_*/*.csv")) if args.page else ():
        if path.stem.removesuffix("_long") in systems:
            drawn(path)
    written(args.into, systems)


def written(into: Path, systems: dict) -> None:
    """The page, of the tables so far."""
    (into / "costs.md").write_text(page(into / "cost", systems), encoding="utf-8")


if __name__ == "__main__":
    main()
