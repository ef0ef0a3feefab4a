"""Ends of bonds of lattices by rows: those that a formula does not name, and those that are farther from each other than their ring is long."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from smidgen.run.step.status import Status
from support.by_sites import by_sites
from test_rows import EXCHANGE, lattice
from test_rows_by_site import close
from test_rows_in_time import MIDPOINT, TURNS, by_rows
from test_rows_tangent import mapped
from test_rows_torques import pushed


def bond(energy: str, name="one", over="{over}", ends="i, j") -> str:
    return f'[effects.{name}]\nover = "bond({ends}) of {over}"\nenergy = "{energy}"\n'


def declared(ends, boundary="periodic", size='["n", 5]') -> str:
    return f'[lattices.l]\nsize = {size}\nboundary = "{boundary}"\nbonds.all = [{{ at = {ends} }}]\n'


def many(name, ends, effects, n, **more):
    return lattice(name, "l.all", n, "5*n", effects, declared(ends, **more))


# Beyond an open end there is no bond, and no field of it

LINEAR, QUARTIC = bond("0.1*w[i].x"), bond("0.3*w[j].x^4")
TWISTED = bond("-0.4*dot(w[i], w[j]) + 0.2*triple(w[i], w[j], vec(0, 0, 1))", ends="i, j, k")
OPEN = {
    "linear": lattice("linear", "square(n, 6, open)", 6, "6*n", EXCHANGE + LINEAR), "quartic": lattice("quartic", "square(n, 6, open)", 9, "6*n", EXCHANGE + QUARTIC),
    "half open": lattice("half_open", "cubic(n, 4, 3, periodic, open, periodic)", 4, "12*n", EXCHANGE + bond("0.2*w[j].y^2")),
    "a torque": lattice("torque", "chain(n, open)", 16, "n", EXCHANGE + pushed("0.1*w[i].z*cross(w[i], vec(1, 0, 0))", "bond(i, j) of {over}")),
    "three ends": many("three_ends", "[[0, 0, 0], [0, 1, 0], [0, 1, 1]]", TWISTED, 7, boundary="open"), "three ends, two behind": many("behind", "[[0, 0, 0], [0, -1, 0], [0, -1, -1]]", TWISTED, 6, boundary="open"),
    "closed": lattice("closed", "square(n, 6, periodic)", 6, "6*n", EXCHANGE + LINEAR + QUARTIC.replace("one", "other"))}
METHODS = [("linear", MIDPOINT), ("linear", TURNS), ("quartic", "gauss-4"), ("half open", MIDPOINT), ("quartic", "dormand-prince-8"), ("a torque", MIDPOINT), ("three ends", MIDPOINT), ("three ends, two behind", MIDPOINT), ("closed", MIDPOINT)]
QUICK = (("linear", MIDPOINT), ("quartic", "gauss-4"), ("three ends", MIDPOINT))


@pytest.mark.parametrize("name, method", [pytest.param(*one, marks=() if one in QUICK else pytest.mark.long) for one in METHODS])
def test_ends_that_are_not_named_must_be_there(name, method):
    assert by_rows(OPEN[name], method) and close(OPEN[name], method, 3) <= 2e-14


@pytest.mark.long
def test_the_tangent_map_too():
    rows, sites = (mapped(build(OPEN["quartic"], features=("tangent",))) for build in (smidgen.build, by_sites))
    assert np.abs(rows - sites).max() <= 3e-15 * np.abs(sites).max()


def test_absent_sites_that_are_not_named_prevent_rows():
    """They would be felt like others."""
    spec = lattice("absent", "square(n, 6, periodic)", 6, "6*n", EXCHANGE + LINEAR + '[effects.hole]\nover = "site(i) of w"\nabsent = "mod(i, 7) == 3"\n')
    assert "because the formula of `one` does not name all spins of its bonds, but some sites are absent" in generate(spec).notes["reason"]
    assert close(spec, steps=2) <= 2e-14


# An end may be farther from another one than the ring is long, though none is from the base cell

RING = bond("0.3*dot(w[i], w[j])*w[k].z + 0.2*triple(w[i], w[j], w[k])", ends="i, j, k")
EVEN = bond("0.3*dot(w[i], w[j])*w[k].z", ends="i, j, k")
SHORT = {"along": many("along", "[[0, -2, 0], [0, 0, 0], [0, 2, 0]]", RING, 3), "across": many("across", "[[0, 0, -2], [0, 0, 0], [0, 0, 2]]", RING, 3, size='[5, "n"]'),
         "even": many("even", "[[0, -2, 0], [0, 0, 0], [0, 2, 0]]", EVEN, 3)}
FAMILIES = smidgen.load_text("""[model]
name = "families"
[space]
a = { sphere = "5*n" }
b = { sphere = "5*n" }
[parameters]
n = 3
[lattices.l]
size = [5, "n"]
boundary = "periodic"
bonds.all = [{ at = [[0, 0, -2], [0, 0, 0], [0, 0, 2]] }]
[effects.ring]
over = "bond(i of a, j of b, k of a) of l.all"
energy = "0.3*dot(a[i], b[j])*a[k].z"
[starts.random.a]
random = 1
[starts.random.b]
random = 2
""")


@pytest.mark.parametrize("spec, method", [(SHORT["along"], MIDPOINT), *(pytest.param(*one, marks=pytest.mark.long) for one in [
    (SHORT["across"], MIDPOINT), (SHORT["even"], "gauss-4"), (SHORT["even"], "dormand-prince-8"), (FAMILIES, MIDPOINT)])])
def test_ends_far_from_each_other_on_a_short_ring(spec, method):
    assert by_rows(spec, method) and close(spec, method, 3) <= 2e-14


# Bonds that differ, of which one end feels a constant field or has no Hessian of its own

def drawn(energy: str, *others: str):
    return lattice("drawn", "chain(n, periodic)", 16, "n", bond(energy) + "".join(others))


def test_a_field_at_one_end_alone_counts_in_bounds():
    """Without it sweeps go on where the field turns spins by more than they can find."""
    spec = drawn("-0.5*(1 + 0.1*uniform(1, i))*dot(w[i], w[j]) - 30*(1 + uniform(2, i))*w[j].z")
    assert by_rows(spec) and close(spec, steps=2) <= 2e-14


@pytest.mark.parametrize("K", [3, pytest.param(-4, marks=pytest.mark.long)])
def test_a_hessian_at_one_end_alone_counts_in_bounds(K):
    """Rows decide as Newton's method does, which shows that the branch has been left."""
    spec = drawn(f"-0.05*(1 + 0.1*uniform(1, i))*w[i].x + {K}*(1 + uniform(2, i))*w[j].z^2", bond("-dot(w[i], w[j])", "far", "chain(n, periodic, 2)"))
    for solver in ("auto", "newton"):
        with pytest.raises(RunError) as refused:
            smidgen.build(spec, solver=solver).start("random", h=0.4, t0=0.37).step()
        assert refused.value.status == Status.WRONG_BRANCH
