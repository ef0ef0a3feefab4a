"""Programs of the study: a driver, a shipped model and a variant of its C, compiled."""
import subprocess
from pathlib import Path

import numpy as np

import smidgen
from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.resources import folder, include_flags
from smidgen.compile.select import select

HERE = Path(__file__).resolve().parent
FLAGS = ("-std=gnu11", "-O3", "-ffp-contract=off")      # gnu11: the drivers measure in __float128
PLAIN, DEFAULT, LONG, PAIRS = "plain sums", "default", "long double", "double-double"
FUSED = f"{PAIRS}, fma"
# variant -> (features, flags of the compiler)
VARIANTS = {
    PLAIN: (("plain-sums",), ()),
    DEFAULT: ((), ()),
    LONG: (("extended",), ()),
    PAIRS: (("extended",), ("-DSMG_DOUBLE_DOUBLE",)),
    FUSED: (("extended",), ("-DSMG_DOUBLE_DOUBLE", "-mfma")),
}
LANES = {"lanes, double and carry": (), "lanes, double-double": ("-DWIDE",)}


def program(where: Path, name: str, variant: str, driver: str, real: str = "") -> Path:
    """The compiled driver of a shipped model in a folder of its own; real: a flag that sets smg_real."""
    features, flags = VARIANTS[variant]
    place = where / f"{name}-{variant}-{driver}{real}".replace(" ", "_")
    path = place / "program"
    if not path.exists():
        place.mkdir(parents=True)
        write_files(generate(select(smidgen.load(folder("specs") / f"{name}.toml")), features=features), place)
        words = ["gcc", *FLAGS, *flags, *([real] if real else []), f'-DMODEL="{name}.h"', f"-DM={name}", "-I.",
                 *include_flags(), f"{name}.c", str(HERE / driver), "-o", "program"]
        subprocess.run([*words, *(["-lquadmath"] if real == "-DSMG_QUAD" else []), "-lm"], cwd=place, check=True)
    return path


def lanes(where: Path, variant: str) -> Path:
    """The compiled prototype in lanes."""
    path = where / variant.replace(" ", "_").replace(",", "")
    if not path.exists():
        subprocess.run(["gcc", *FLAGS, "-march=native", *LANES[variant], str(HERE / "lanes.c"), "-o", str(path), "-lm"],
                       check=True)
    return path


def words(numbers) -> str:
    """Numbers as text that reads back the same."""
    return " ".join(repr(float(x)) for x in np.ravel(numbers))


def ask(path, arguments, given: str = ""):
    """The numbers that a program prints, line by line. Raises CalledProcessError when a step failed."""
    said = subprocess.run([path, *map(str, arguments)], input=given, capture_output=True, text=True, check=True)
    return np.array([[float(x) for x in line.split()] for line in said.stdout.splitlines()])
