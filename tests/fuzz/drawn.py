"""What is drawn beside the formulas of a random spec: its method and solver, its features, and with what it is compiled.

The last two stand in comments of the text, since TOML has no place for them:

    # layout: rows                  what the spec was written for
    # features: ensemble tangent
    # build: clang++ -O2 | gcc -O3  the program under the sanitizers | the library
    # define: -DSMG_WAVE_FROM=0     further options of the program
"""
from __future__ import annotations

from smidgen.compile.features import FEATURES
from smidgen.methods import METHODS

PROGRAMS, LIBRARIES = ("gcc", "g++", "clang", "clang++"), ("gcc", "clang")
LEVELS = ("-O0",) * 12 + ("-O1",) * 3 + ("-O2", "-O3")     # under the sanitizers -O3 takes five times as long to compile as -O0
SINGLE = [m for m in METHODS.values() if m.stages == 1 and not m.free_body and not m.splitting]
COMPOSED = [m for m in METHODS.values() if m.stages > 1 and not m.free_body and not m.splitting]
SPLIT = {kind: [m.name for m in METHODS.values() if m.splitting == kind] for kind in ("axes", "sublattices", "pairs")}
FREE = [m.name for m in METHODS.values() if m.free_body]


def any_method(dice, kinds) -> tuple[str, str]:
    """(method, solver) for factors of these kinds: half of the time a midpoint as it is, with any of its solvers."""
    if dice.randint(0, 1):
        method = METHODS[dice.choice(("spherical-midpoint",) * 3 + ("classical-midpoint",))]
    else:
        method = dice.choice([m for m in (SINGLE if dice.randint(0, 2) else COMPOSED) if kinds <= set(m.spaces)])
    return method.name, dice.choice(("auto",) * 2 + method.solvers)


def comments(dice, layout: str, define: str = "", features=None) -> str:
    """The first lines of a text. features: as they are, in place of those that chance takes."""
    wanted = [f for f in FEATURES if dice.randint(0, 4) == 0] if features is None else features
    lines = [f"# layout: {layout}", f"# build: {dice.choice(PROGRAMS)} {dice.choice(LEVELS)} | {dice.choice(LIBRARIES)} {dice.choice(LEVELS)}",
             *[f"# features: {' '.join(wanted)}"] * bool(wanted), *[f"# define: {define}"] * bool(define)]
    return "\n".join(lines) + "\n"


def said(text: str, key: str) -> str:
    """What the comment `# key: ..` of a text says; "" without one."""
    start = f"# {key}: "
    return next((line[len(start):] for line in text.split("\n") if line.startswith(start)), "")


def features_of(text: str) -> tuple:
    return tuple(said(text, "features").split())


def builds_of(text: str) -> tuple[list, list]:
    """([compiler, level] of the program, of the library); for a text that names none, such as one by hand, gcc."""
    program, _, library = said(text, "build").partition(" | ")
    return program.split() or ["gcc", "-O0"], library.split() or ["gcc", "-O1"]
