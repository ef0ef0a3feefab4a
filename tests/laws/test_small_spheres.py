"""A sphere much smaller than the others, which turns faster than they do, keeps its length whatever iteration finds the step: what is left of its own changes is no round-off because it is of theirs."""
import numpy as np
import pytest
import smidgen

HEAD = """[model]
name = "small"
[space]
w = {{ sphere = "{sites}", radius = "if({small}, r, 1)", kappa = "{kappa}" }}
[parameters]
n = {n}
r = 1e-9
J = 2.0
{lattice}
[effects.exchange]
over = "{over}"
energy = "{energy}*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "0.3*w[i].x"
[starts.random]
random = 3
"""
ALL_PAIRS = smidgen.load_text(HEAD.format(sites="n", small="i == 1", kappa="if(i == 1, 0.2, 1)", n=4, lattice="", over="pair(i, j) of w", energy="1"))
# bonds are listed twice, so that it is stepped site by site; every second line is of small spheres, with an exchange that turns them as fast as spheres of radius 1
LINES = smidgen.load_text(HEAD.format(sites="n*n", small="mod(floor(i/n), 2) == 1", kappa="1", n=8, over="bond(i, j, b) of lines",
                                      energy="if(mod(floor(i/n), 2) == 1, J/r, 0.2)*(1 + 0.1*sin(b))", lattice="""[lattices.lines]
size = ["n", "n"]
bonds.all = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [1, 0] }]"""))
SMALL = np.arange(64) // 8 % 2 == 1


@pytest.mark.parametrize("spec, method", [(ALL_PAIRS, "gauss-2"), (ALL_PAIRS, "gauss-4"), (ALL_PAIRS, "geodesic-midpoint"), (LINES, "spherical-midpoint")],
                         ids=["gauss-2", "gauss-4", "geodesic-midpoint", "rotation sweeps"])
def test_it_keeps_its_length(spec, method):
    model = smidgen.build(spec, method=method).start("random", h=0.1)
    lengths = np.linalg.norm(model.w, axis=1)
    assert np.abs(np.linalg.norm(model.steps(400).w, axis=1) / lengths - 1).max() <= 5e-15


def test_large_steps_do_not_depend_on_the_unit():
    """Newton's systems are solved to a part of the right-hand side of all sites: with the small ones in their own units, else their steps are refused."""
    found = []
    for r in (1.0, 1e-9):
        model = smidgen.build(LINES, parameters={"r": r, "J": 5.0}).start("random", h=0.1)
        found.append(model.steps(5).w[SMALL] / r)
    assert np.abs(found[0] - found[1]).max() <= 1e-12


def test_tangent_vectors_of_lines_apart_do_not_disturb_each_other():
    model = smidgen.build(LINES, features=["tangent"]).start("random", h=0.1)
    all_lines = np.cross(np.random.default_rng(1).standard_normal((64, 3)), model.w)
    small_ones = np.where(SMALL[:, None], all_lines, 0)
    model.steps(1)
    assert np.abs(model.tangent(all_lines) - model.tangent(small_ones))[SMALL].max() <= 1e-13 * 1e-9
