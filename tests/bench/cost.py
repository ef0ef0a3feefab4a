"""What accuracy costs for every system of the paper: docs/cost/*.csv and figures, and the page docs/costs.md.

    python tests/bench/cost.py                       # half an hour on a quiet machine
    python tests/bench/cost.py point_vortices        # only these
    python tests/bench/cost.py --page                # figures and page from the tables
"""
import argparse
import sys
from pathlib import Path

import smidgen
from smidgen.cost.report import words
from smidgen.show.plot.cost import draw_cost

DOCS = Path(__file__).resolve().parents[2] / "docs"
SYSTEMS = {     # spec -> how long, and what is set
    "free_rigid_body": (100, {}), "irreversible_rigid_body": (100, {}), "forced_rigid_body": (50, {}), "point_vortices": (100, {}),
    "heisenberg_chain": (20, {"n": 100}), "landau_lifshitz": (5, {}), "test_particles": (10, {}), "vortex_tracers": (20, {}),
    "nambu_a31": (10, {}), "lagrange": (0.5, {}), "product": (10, {}), "two_bodies": (20, {})}
HEAD = """# What accuracy costs, measured

Of every system of the paper: the time that each method needs for an end error, and which is first. The tables and figures are
those of `smidgen cost` ([what they hold](cost.md)); `python tests/bench/cost.py` measures again and writes this page, the tables
and the figures. Times are of one core, with portable flags; ratios within a table come from one run.
"""


def measured(name: str, seconds: float):
    """The table of one system, kept below docs/cost."""
    time, values = SYSTEMS[name]
    print(f"-- {name}", file=sys.stderr, flush=True)
    table = smidgen.cost(smidgen.load(name), time=time, values=values, seconds=seconds)
    (DOCS / "cost").mkdir(exist_ok=True)
    table.save(DOCS / "cost" / f"{name}.csv")


def page() -> str:
    """The page of the tables that there are."""
    found = [(name, smidgen.load_cost(DOCS / "cost" / f"{name}.csv")) for name in SYSTEMS if (DOCS / "cost" / f"{name}.csv").exists()]
    return "\n".join([HEAD, *(part for name, table in found for part in section(name, table))]) + "\n"


def section(name: str, table):
    """One system: words and figure."""
    yield f"## {smidgen.load(name).title or name}\n"
    yield f"[{name}.csv](cost/{name}.csv)\n"
    yield "\n".join(f"    {line}" for line in words(table).splitlines()) + "\n"
    yield f"![{name}](cost/{name}.png)\n"


def main() -> None:
    """Measure, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SPEC", help="systems; default: all")
    parser.add_argument("--seconds", type=float, default=30.0, help="of timed runs for each")
    parser.add_argument("--page", action="store_true", help="measure nothing")
    args = parser.parse_args()
    for name in () if args.page else args.names or SYSTEMS:
        measured(name, args.seconds)
    for path in sorted((DOCS / "cost").glob("*.csv")):
        draw_cost(smidgen.load_cost(path), path.with_suffix(".png"))
    (DOCS / "costs.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
