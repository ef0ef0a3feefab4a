"""A sphere much smaller than the others, which turns faster than they do, keeps its length whatever iteration finds the step: what is left of its own changes is no round-off because it is of theirs."""
import numpy as np
import pytest
import smidgen

HEAD = """[model]
name = "small"
[space]
w = {{ sphere = "{sites}", radius = "if({small}, 1e-9, 1)", kappa = "{kappa}" }}
[parameters]
n = {n}
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
# listed twice, so that it is stepped site by site; every second line is of small spheres, with an exchange that turns them as fast as the others
LINES = smidgen.load_text(HEAD.format(sites="n*n", small="mod(floor(i/n), 2) == 1", kappa="1", n=8, over="bond(i, j, b) of lines",
                                      energy="if(mod(floor(i/n), 2) == 1, 2e9, 0.2)*(1 + 0.1*sin(b))", lattice="""[lattices.lines]
size = ["n", "n"]
bonds.all = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [1, 0] }]"""))


@pytest.mark.parametrize("spec, method", [(ALL_PAIRS, "gauss-2"), (ALL_PAIRS, "gauss-4"), (ALL_PAIRS, "geodesic-midpoint"), (LINES, "spherical-midpoint")],
                         ids=["gauss-2", "gauss-4", "geodesic-midpoint", "rotation sweeps"])
def test_it_keeps_its_length(spec, method):
    model = smidgen.build(spec, method=method).start("random", h=0.1)
    lengths = np.linalg.norm(model.w, axis=1)
    assert np.abs(np.linalg.norm(model.steps(400).w, axis=1)/lengths - 1).max() <= 5e-15
