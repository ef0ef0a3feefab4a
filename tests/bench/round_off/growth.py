"""How far round-off carries what the map keeps, and how far from the same map in quadruple precision."""
from pathlib import Path

import numpy as np

import smidgen
from smidgen.resources import folder
from smidgen.run.step.start import initial_state

from .programs import DEFAULT, LANES, LONG, PAIRS, PLAIN, ask, lanes, program, words
from .rows import Growth

H = 0.1
SHORT, MIDDLE, LONGER, LONGEST = 10**5, 10**6, 10**7, 10**8
ALL, FEW = (SHORT, MIDDLE, LONGER, LONGEST), (10**4, SHORT, MIDDLE)
MODELS = {"free": ("free_rigid_body", "1 2 4 0"), "irreversible": ("irreversible_rigid_body", "1 2 4 0.6666666666666666")}
# table -> variant -> runs: so many orbits, their numbers of steps
RUNS = {
    "free": {PLAIN: [(40, ALL[:3]), (8, ALL[3:])], DEFAULT: [(40, ALL)], LONG: [(40, ALL)],
             PAIRS: [(40, ALL[:2]), (8, ALL[2:3]), (4, ALL[3:])]},
    "lanes": {variant: [(40, ALL[:3]), (16, ALL[3:])] for variant in LANES},
    "irreversible": {PLAIN: [(8, ALL[:2])], DEFAULT: [(8, ALL[:3]), (4, ALL[3:])], LONG: [(8, ALL[:3]), (2, ALL[3:])],
                     PAIRS: [(8, ALL[:2])]},
    "chain of 8": {PLAIN: [(8, ALL[:2])], DEFAULT: [(8, ALL)], LONG: [(8, ALL)], PAIRS: [(8, ALL[:2])]},
    "chain of 100": {PLAIN: [(100, FEW[:2])], DEFAULT: [(100, FEW)], LONG: [(100, FEW[:2])], PAIRS: [(100, FEW[:2])]},
}
TABLES = (*RUNS, "distance", "cost")
CHAINS = {"chain of 8": "random", "chain of 100": "smooth"}     # the start
NEAR, FAR = (10**3, 10**4, SHORT), (10**3, 10**4, SHORT, MIDDLE, LONGER)


def orbits(count, seed=5):
    """Starts on the sphere, uniform, and steps within 5 % of H: rows x y z h; the first of forty."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(40, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    return np.column_stack([w, H * (1 + 0.1 * (rng.random(40) - 0.5))])[:count]


def rows_of(table, quantity, variant, orbits, steps, found):
    """Rows of the changes `found` (orbits, steps)."""
    for n, column in zip(steps, found.T):
        yield Growth(table, quantity, variant, orbits, n, float(np.sqrt(np.mean(column**2))), float(np.mean(column)), "")


def bodies(table, where: Path, runs):
    """dH and d|w| of one rigid body. H of the irreversible body is no constant of the map."""
    name, constants = MODELS[table]
    for variant in runs:
        path = program(where, name, variant, "body.c")
        for count, steps in runs[variant]:
            found = ask(path, [*constants.split(), *steps], words(orbits(count))).reshape(count, len(steps), 2)
            if table == "free":
                yield from rows_of(table, "H", variant, count, steps, found[:, :, 0])
            yield from rows_of(table, "|w|", variant, count, steps, found[:, :, 1] / 2)     # |w| = 1: d|w| = d|w|^2/2


def in_lanes(table, where: Path, runs):
    """dH and d|w| of the free body, eight orbits in the lanes of vectors."""
    for variant in runs:
        for count, steps in runs[variant]:
            found = ask(lanes(where, variant), steps, words(orbits(count))).reshape(count, len(steps), 2)
            yield from rows_of(table, "H", variant, count, steps, found[:, :, 0])
            yield from rows_of(table, "|w|", variant, count, steps, found[:, :, 1] / 2)     # |w| = 1: d|w| = d|w|^2/2


def chains(table, where: Path, runs):
    """d|w_i| over the spins of a ring."""
    for variant in runs:
        path = program(where, "heisenberg_chain", variant, "chain.c")
        for n, steps in runs[variant]:
            start = initial_state(smidgen.load(folder("specs") / "heisenberg_chain.toml"), CHAINS[table], {"n": n})
            found = ask(path, [H, *steps], f"{n} {words(start)}").reshape(1, len(steps), 2)[:, :, 1]
            yield from rows_of(table, "|w|", variant, n, steps, found / 2)


def states(where: Path, variant, starts, steps, real=""):
    """States of the free body after these numbers of steps as pairs of doubles: (orbits, steps, 3, 2)."""
    path = program(where, "free_rigid_body", variant, "states.c", real)
    return np.array([ask(path, [repr(float(row[3])), *steps], f"1 {words(row[:3])}").reshape(len(steps), 3, 2)
                     for row in starts])


def apart(a, b):
    """Distances of states given as pairs, to the digits of pairs: (orbits, steps)."""
    d = a - b
    return np.sqrt(np.sum((d[..., 0] + d[..., 1])**2, axis=-1))


def distance(table, where: Path, near=NEAR, far=FAR, count=8):
    """To the same map in quadruple precision; beyond `near` to the run of pairs of doubles, which is off by less."""
    starts = orbits(count)
    quad, pairs = states(where, DEFAULT, starts, near, "-DSMG_QUAD"), states(where, PAIRS, starts, far)
    exact = np.concatenate([quad, pairs[:, len(near):]], axis=1)
    yield from rows_of(table, "|dw|", PAIRS, count, near, apart(pairs[:, :len(near)], quad))
    for variant in (PLAIN, DEFAULT, LONG):
        yield from rows_of(table, "|dw|", variant, count, far, apart(states(where, variant, starts, far), exact))


MEASURES = {"free": bodies, "lanes": in_lanes, "irreversible": bodies, "chain of 8": chains, "chain of 100": chains}


def measured(table, where: Path, runs=None):
    """Rows of a table, each as soon as it is there."""
    if table == "distance":
        return distance(table, where)
    return MEASURES[table](table, where, runs or RUNS[table])
