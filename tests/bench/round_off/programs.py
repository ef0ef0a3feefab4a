"""Programs of the study: a driver, a model, a variant, compiled; and their tables."""
import csv
import subprocess

import smidgen
from smidgen.build import write_files
from smidgen.emit import generate
from smidgen.resources import folder
from smidgen.select import select

from pathlib import Path

HERE = Path(__file__).resolve().parent
FLAGS = ("-std=gnu11", "-O3", "-ffp-contract=off")      # gnu11: the drivers measure in __float128
# variant -> (features, flags of the compiler)
VARIANTS = {
    "default": ((), ()),
    "long double": (("extended",), ()),
    "plain sums": (("plain-sums",), ()),
    "double-double": (("extended",), ("-DSMG_DOUBLE_DOUBLE",)),
}


def program(where: Path, name: str, variant: str, driver: str, real: str = "", more=()) -> Path:
    """The compiled driver of a shipped model in a folder of its own; real: a flag that sets smg_real."""
    features, flags = VARIANTS[variant]
    place = where / f"{name}-{variant}-{driver}{real}{''.join(more)}".replace(" ", "_")
    path = place / "program"
    if not path.exists():
        place.mkdir(parents=True)
        write_files(generate(select(smidgen.load(folder("specs") / f"{name}.toml")), features=features), place)
        words = ["gcc", *FLAGS, *flags, *more, *([real] if real else []), f'-DMODEL="{name}.h"', f"-DM={name}", "-I.",
                 f"-I{folder('runtime')}", f"{name}.c", str(HERE / driver), "-o", "program"]
        subprocess.run([*words, *(["-lquadmath"] if real == "-DSMG_QUAD" else []), "-lm"], cwd=place, check=True)
    return path


def numbers(path: Path):
    """Rows of a table, none when it is not there yet."""
    if not path.exists():
        return []
    with open(path, newline="") as handle:
        return list(csv.DictReader(handle))


def cost_of(where: Path, name: str, repeats: int) -> dict:
    """ns per step of every variant, interleaved so that a busy machine is busy for all: variant -> times."""
    paths = {v: program(where, name, v, "cost.c") for v in VARIANTS}
    paths["double-double, fma"] = program(where, name, "double-double", "cost.c", more=("-mfma",))
    return interleaved(paths, repeats)


def lanes_of(where: Path, repeats: int) -> dict:
    """ns per step and trajectory of the prototypes in lanes."""
    paths = {}
    for label, flags in {"plain": (), "double-double": ("-DWIDE",)}.items():
        paths[label] = where / f"lanes-{label}"
        subprocess.run(["gcc", *FLAGS, "-march=native", *flags, str(HERE / "lanes.c"), "-o", str(paths[label]), "-lm"],
                       check=True)
    return interleaved(paths, repeats)


def interleaved(paths: dict, repeats: int) -> dict:
    """What each program prints as its ns per step, in turns: label -> times."""
    times = {label: [] for label in paths}
    for _ in range(repeats):
        for label, path in paths.items():
            times[label].append(float(subprocess.run([path], capture_output=True, text=True, check=True).stdout.split()[0]))
    return times
