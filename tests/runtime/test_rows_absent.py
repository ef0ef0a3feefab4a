"""Lattices by rows with absent sites: effects on the same bonds of which some are sums and products alone."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from test_rows import lattice
from test_rows_by_site import MIDPOINT
from test_rows_families import CLOSED, layers
from test_rows_in_time import by_rows

METHODS = (MIDPOINT, "gauss-4", "dormand-prince-8")
EXCHANGE, TWIST, IN_TIME, SHARED = "-0.5*dot({0}[i], {0}[j])", "0.2*triple(vec(0, 0, 1), {0}[i], {0}[j])", "0.1*cos(3*t)*{0}[i].x*{0}[j].x", "0.2*{0}[i].y*{0}[j].y/n"


def effect(name, over, value, word="energy") -> str:
    return f'[effects.{name}]\nover = "{over}"\n{word} = "{value}"\n'


def square(*effects, hole="mod(i, 7) == 3"):
    """6 x 6 sites, some absent; effects: (name, over, value, word), over "bonds" and "sites" of it."""
    over = {"bonds": "bond(i, j) of square(n, 6, periodic)", "sites": "site(i) of w", "row": "bond(i, j) of line.near"}
    return lattice("square", "", 6, "6*n", "".join(effect(name, over[where], value, *word) for name, where, value, *word in (*effects, ("hole", "sites", hole, "absent"))), LINE)


LINE = '[lattices.line]\nsize = ["n", 6]\nboundary = ["periodic", "periodic"]\nbonds.near = [{ offset = [1, 0] }]\n'


def on_bonds(*energies, over="bonds") -> list:
    return [(f"e{n}", over, e.format("w")) for n, e in enumerate(energies)]


def distance(spec, method, features=(), **how) -> float:
    """From the witness, which knows no rows."""
    model = smidgen.build(spec, method=method, features=features, **how).start("random", h=0.05, t0=0.37)
    w = model.w.copy()
    found = Witness(spec).steps(w, 0.37, 0.05, 3, method)
    return np.abs(model.steps(3).w - (found if np.ndim(found) == 2 else found[-1])).max()


JOINED = {"the last in time": square(*on_bonds(EXCHANGE, TWIST, IN_TIME)), "the first in time, one a quotient": square(*on_bonds(IN_TIME, EXCHANGE, SHARED, TWIST)),
          "on some of the bonds": square(*on_bonds(EXCHANGE, TWIST, IN_TIME), ("more", "row", IN_TIME.format("w")), ("twist", "row", TWIST.format("w"))),
          "of two families": layers(*(("bond(i, j) of within.near on " + f, e.format(f)) for f in "ab" for e in (EXCHANGE, TWIST, IN_TIME.replace("j].x", "j].z"))),
                                    ("bond(i of a, j of b) of between.near", "0.3*dot(a[i], b[j])"), ("bond(i of a, j of b) of between.near", "0.1*cos(t)*a[i].x*b[j].y"), ("site(i) of b", "mod(i, 7) == 3", "absent"), boundary=CLOSED)}


@pytest.mark.parametrize("name, method", [*((n, MIDPOINT) for n in JOINED), *(("the last in time", m) for m in METHODS[1:]), *(pytest.param(n, m, marks=pytest.mark.long) for n in [*JOINED][1:] for m in METHODS[1:])])
def test_effects_on_the_same_bonds(name, method):
    assert by_rows(JOINED[name], method) and distance(JOINED[name], method) <= 2e-14
