"""What the variants cost, in turns, so that a busy machine is busy for all."""
from pathlib import Path

import numpy as np

from .programs import LANES, VARIANTS, ask, lanes, program
from .rows import Cost

MODELS = {"free": "free_rigid_body", "irreversible": "irreversible_rigid_body", "chain of 100": "heisenberg_chain"}


def in_turns(paths: dict, repeats: int) -> dict:
    """What each program prints as its ns a step, in turns: label -> times."""
    times = {label: [] for label in paths}
    for _ in range(repeats):
        for label, path in paths.items():
            times[label].append(float(ask(path, [])[0, 0]))
    return times


def programs(table: str, where: Path) -> dict:
    """The timed programs of a table."""
    if table == "lanes":
        return {variant: lanes(where, variant) for variant in LANES}
    return {variant: program(where, MODELS[table], variant, "cost.c") for variant in VARIANTS}


def costs(where: Path, repeats: int = 15):
    """Rows of all tables."""
    for table in (*MODELS, "lanes"):
        for variant, times in in_turns(programs(table, where), repeats).items():
            yield Cost(table, variant, repeats, float(min(times)), float(np.median(times)), float(max(times)), "")
