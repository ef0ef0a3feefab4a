"""The whole demo: tasks in two processes, the table, the page."""
from __future__ import annotations

import argparse
import dataclasses
import datetime
import multiprocessing
import os
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing.connection import wait
from pathlib import Path

import numpy as np

from ...version import __version__
from ...build import compiler_version, find_compiler
from ...cost.report import machine
from ...errors import Exit, MissingTool, SmidgenError, UsageError
from ...resources import scenes, shipped
from ..plot.figures import FIGURES
from ..plot.gallery import Picture, Row, Words, gallery
from ..plot.style import save
from ..plot.view import View
from .experiments import EXPERIMENTS
from .systems import KEPT, Outcome, system

COLUMNS = (("system", "criterion:"), ("method", ""), ("steps *", ""), ("energy error *", "none: bounded, not zero"), ("momentum error *", f"\u2264 {KEPT:.0e} \u03a3|\u03ba|"),
           ("Casimir error *", f"\u2264 {KEPT:.0e}"), ("order *", "1.8 to 2.2"), ("difference from the witness *", "\u2264 the bound beside it"),
           ("seconds *", ""), ("note", ""))
LEAD = ("Each spec is a text file with the Hamiltonian as a formula. smidgen compiles it to C, runs it, and compares it with the witness, an "
        "independent interpreter with its own differentiation and solvers. Energy, momentum and Casimir error: largest change over the run, the last "
        "relative. Difference: after 100 steps of the same method. Seconds: the time to generate, compile and run. A dash means that there is nothing to measure.")
PAPER = (("The method and the examples: R. McLachlan, K. Modin, O. Verdier, \u201cA minimal-variable symplectic integrator on spheres\u201d, "
          "Mathematics of Computation 86 (2017), 2325\u20132344, ", ""), ("doi:10.1090/mcom/3153", "https://doi.org/10.1090/mcom/3153"), (".", ""))
WORDS = Words("smidgen: the examples of \u201cA minimal-variable symplectic integrator on spheres\u201d",
              "From a Hamiltonian on spheres to a symplectic integrator in C",
              "Write the energy of rigid bodies, spins or vortices as a formula; smidgen compiles it to a small C program that steps it with the "
              "spherical midpoint method, which preserves the geometry of the motion with three numbers per sphere.", PAPER, lead=LEAD)
COMPARED = ("free_rigid_body:classical", "free_rigid_body:moser_veselov",
            "irreversible_rigid_body:classical")        # runs of other methods, in the table too
SLOW = ("accuracy_cost", "moving_body", "moving_section", "forced_sections_flow", "forced_sections", "vortex_manifold", "nambu_leaves")       # begun first


def main(arguments=None) -> int:
    """`python -m smidgen.show.demo`: 0 when every line passed."""
    parser = argparse.ArgumentParser(prog="smidgen.show.demo", description="Compile, run, validate and "
                                     "draw every system; one table, one page.")
    parser.add_argument("--out", default="out/demo", help="folder for the page and the pictures")
    parser.add_argument("--only", default="", help="names of systems and figures, separated by commas")
    parser.add_argument("--jobs", type=int, default=2, help="number of processes to run at the same time")
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
    """Every shipped spec and scene, each followed by its runs with other methods."""
    return sorted([*shipped(), *scenes(), *COMPARED])


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
    with ProcessPoolExecutor(max(1, jobs), mp_context=context, initializer=end_with_parent) as pool:
        running = {pool.submit(perform_one, task, out): task for task in tasks}
        for done in as_completed(running):
            task = running[done]
            found[task] = outcome_of(done, task[1])
            verdict = "ok" if found[task].passed else "FAILED"
            print(f"[{len(found)}/{len(tasks)}] {' '.join(task)}: {verdict}", file=sys.stderr)
    return found


def end_with_parent() -> None:
    """In a spawned process: it ends when the process that started it does, for whatever reason."""
    threading.Thread(target=wait_and_exit, args=(multiprocessing.parent_process().sentinel,), daemon=True).start()


def wait_and_exit(sentinel) -> None:
    wait([sentinel])
    os._exit(1)


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
    path = save(entry.draw(**posed(data)), out / f"{name}.{entry.ending}")
    words = " ".join(part for part in (entry.see, caption) if part)
    moving = {**data, "seconds": entry.seconds} if entry.seconds else None
    picture = Picture(name, path, entry.title, words, entry.size, entry.part, entry.number, moving=moving)
    return Outcome(name, seconds=time.perf_counter() - began, passed=True, pictures=(picture,))


def posed(data: dict) -> dict:
    """The arguments of a figure, a view of two angles as View."""
    return {**data, "view": View(*data["view"])} if "view" in data else data


# -- table and page ------------------------------------------------------------------------

def cells(line: Outcome) -> tuple[str, ...]:
    """The texts of one line, under COLUMNS."""
    beside = f"{number(line.agreement)} \u2264 {line.bound}" if line.bound else "-"
    return (line.system, line.method, str(line.steps), number(line.energy), number(line.momentum), number(line.casimir),
            "-" if np.isnan(line.order) else f"{line.order:.2f}", beside, "-" if np.isnan(line.seconds) else f"{line.seconds:.1f}", line.note)


def number(value: float) -> str:
    """Two digits, or a dash where there is nothing to measure."""
    return "-" if np.isnan(value) else f"{value:.1e}"


def print_table(lines) -> None:
    """The table on stdout."""
    from rich.console import Console
    from rich.table import Table
    table = Table(title="smidgen demo")
    for name in (*(name for name, _ in COLUMNS), ""):
        table.add_column(name.removesuffix(" *"), justify="right" if name.endswith("*") else "left",
                         overflow="fold")
    for line in lines:
        table.add_row(*cells(line), "ok" if line.passed else "FAILED")
    console = Console()
    Console(width=max(console.width, 150)).print(table)


def place(picture: Picture) -> tuple:
    """Figures in the order of FIGURES, which is that of the paper; then the systems, small pictures before broad ones."""
    figures = list(FIGURES)
    return (0, figures.index(picture.name)) if picture.name in figures else (1, picture.size == "broad")


def write_page(out: Path, lines, figures) -> Path:
    """index.html with the spheres, the table and all figures."""
    pictures = sorted((p for x in [*figures, *lines] for p in x.pictures), key=place)
    rows = [Row(cells(x), x.passed) for x in lines]
    rows += [Row((x.system, *[""] * (len(COLUMNS) - 2), x.note), False) for x in figures if not x.passed]
    good = sum(x.passed for x in lines)
    verdict = (f"{good} of {len(lines)} runs passed every check of the table below{'' if good == len(lines) else ': see those that did not'}.", made())
    return gallery(out, COLUMNS, rows, pictures, dataclasses.replace(WORDS, verdict=verdict, made="Made by `make demo`: " + made()))


def made() -> str:
    """Version, compiler, machine and date."""
    try:
        compiler = compiler_version(find_compiler())
    except MissingTool:
        compiler = "no compiler"
    return f"smidgen {__version__}; {compiler}; {machine()}; {datetime.date.today():%d %B %Y}".replace("; 0", "; ")
