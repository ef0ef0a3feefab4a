"""The whole demo: tasks in two processes, the table, the page."""
from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from ...errors import Exit, SmidgenError, UsageError
from ...read.shipped import shipped
from ..plot.figures import FIGURES
from ..plot.gallery import Picture, Row, gallery
from ..plot.style import save
from .experiments import EXPERIMENTS
from .systems import PLAYED, Outcome, system

COLUMNS = ("system", "method", "steps *", "energy error *", "momentum error *",
           "agreement with witness *", "time *", "note")
LEAD = ("Every spec that comes with smidgen, compiled to C, run, and compared with the witness, an "
        "independent interpreter with its own differentiation and solvers. Energy and momentum "
        "error: largest change over the run. Agreement: largest difference after 100 steps of "
        "the same method. Time: generating, compiling and running, in seconds.")
COMPARED = ("free_rigid_body:classical", "free_rigid_body:moser_veselov",
            "irreversible_rigid_body:classical")        # runs of other methods, in the table too
SLOW = ("accuracy_cost", "forced_sections_flow", "forced_sections", "vortex_manifold", "nambu_leaves")       # begun first


def main(arguments=None) -> int:
    """`python -m smidgen.show.demo`: 0 when every line passed."""
    parser = argparse.ArgumentParser(prog="smidgen.show.demo", description="Compile, run, validate and "
                                     "draw every system; one table, one page.")
    parser.add_argument("--out", default="out/demo", help="folder of the page and the pictures")
    parser.add_argument("--only", default="", help="names of systems and figures, with commas")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    given = parser.parse_args(arguments)
    try:
        return demo(Path(given.out), given.jobs, chosen(given.only))
    except SmidgenError as error:
        print(f"smidgen demo: {error}", file=sys.stderr)
        return int(error.exit_code)
    except KeyboardInterrupt:
        return int(Exit.INTERRUPTED)


def chosen(only: str) -> list[tuple[str, str]]:
    """(kind, name) of every task. Raises UsageError for a name that is none."""
    wanted = {name for name in only.split(",") if name}
    unknown = wanted - set(systems()) - set(EXPERIMENTS)
    if unknown:
        raise UsageError(f"no system or figure {', '.join(sorted(unknown))}")
    tasks = [("figure", n) for n in SLOW] + [("system", n) for n in systems()]
    tasks += [("figure", n) for n in EXPERIMENTS if n not in SLOW]
    return [task for task in tasks if not wanted or task[1] in wanted]


def systems() -> list[str]:
    """Every shipped spec, each followed by its runs with other methods."""
    return sorted([*shipped(), *COMPARED])


def demo(out: Path, jobs: int, tasks) -> int:
    """Do all tasks, print the table, write the page; the exit code."""
    began = time.perf_counter()
    found = perform(tasks, out, jobs)
    lines = [found["system", n] for n in systems() if ("system", n) in found]
    figures = [found["figure", n] for n in EXPERIMENTS if ("figure", n) in found]
    print_table(lines)
    for figure in figures:
        if not figure.passed:
            print(f"figure {figure.system}: {figure.note}", file=sys.stderr)
    page = write_page(out, lines, figures)
    passed = all(x.passed for x in [*lines, *figures])
    print(f"{sum(x.passed for x in lines)} of {len(lines)} systems and {sum(x.passed for x in figures)} "
          f"of {len(figures)} figures in {time.perf_counter() - began:.0f} s: {page}")
    return int(Exit.OK if passed else Exit.VALIDATION)


def perform(tasks, out: Path, jobs: int) -> dict:
    """(kind, name) -> Outcome of every task, `jobs` at a time; a line on stderr for each."""
    found = {}
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max(1, jobs), mp_context=context) as pool:
        running = {pool.submit(perform_one, task, out): task for task in tasks}
        for done in as_completed(running):
            task = running[done]
            found[task] = outcome_of(done, task[1])
            verdict = "ok" if found[task].passed else "FAILED"
            print(f"[{len(found)}/{len(tasks)}] {' '.join(task)}: {verdict}", file=sys.stderr)
    return found


def outcome_of(future, name: str) -> Outcome:
    """The task's Outcome; a task that broke is a line that failed, with what it said."""
    try:
        return future.result()
    except Exception as error:                  # a broken task must not hide the others
        return Outcome(name, note=f"{type(error).__name__}: {error}")


def perform_one(task, out: Path) -> Outcome:
    """One task, in a process of its own."""
    kind, name = task
    return system(name, out) if kind == "system" else figure(name, out)


def figure(name: str, out: Path) -> Outcome:
    """Run what is behind a figure and draw it."""
    began, entry = time.perf_counter(), FIGURES[name]
    data, caption = EXPERIMENTS[name]()
    path = save(entry.draw(**data), out / f"{name}.{entry.ending}")
    picture = Picture(name, path, entry.title, caption, entry.size, entry.part)
    return Outcome(name, seconds=time.perf_counter() - began, passed=True, pictures=(picture,))


# -- table and page ------------------------------------------------------------------------

def cells(line: Outcome) -> tuple[str, ...]:
    """The texts of one line, under COLUMNS."""
    return (line.system, line.method, str(line.steps), number(line.energy), number(line.momentum),
            number(line.agreement), "-" if np.isnan(line.seconds) else f"{line.seconds:.1f}",
            line.note)


def number(value: float) -> str:
    """Two digits, or a dash where there is nothing to measure."""
    return "-" if np.isnan(value) else f"{value:.1e}"


def print_table(lines) -> None:
    """The table on stdout."""
    from rich.console import Console
    from rich.table import Table
    table = Table(title="smidgen demo")
    for name in (*COLUMNS, ""):
        table.add_column(name.removesuffix(" *"), justify="right" if name.endswith("*") else "left",
                         overflow="fold")
    for line in lines:
        table.add_row(*cells(line), "ok" if line.passed else "FAILED")
    console = Console()
    Console(width=max(console.width, 150)).print(table)


def place(picture: Picture) -> tuple:
    """Players in the order of PLAYED, figures as they come, small pictures before broad ones."""
    name = picture.name.removeprefix("player_")
    if picture.name.startswith("player_"):
        return 0, PLAYED.index(name)
    return (2, picture.size == "broad") if picture.part == "systems" else (1, 0)


def write_page(out: Path, lines, figures) -> Path:
    """index.html with the table, the players and all figures."""
    pictures = sorted((p for x in [*figures, *lines] for p in x.pictures), key=place)
    rows = [Row(cells(x), x.passed) for x in lines]
    rows += [Row((x.system, *[""] * (len(COLUMNS) - 2), x.note), False)
             for x in figures if not x.passed]
    return gallery(out, COLUMNS, rows, pictures, "smidgen: every system of the paper", LEAD)
