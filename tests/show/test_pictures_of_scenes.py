"""Pictures of scenes: effects that the run does not use, sites that are absent, vectors that are not of length 1."""
import numpy as np
import pytest

import smidgen
from smidgen.show.plot import chain, draw, facts, film, pictures, portraits, standing

pytestmark = pytest.mark.quick
HOLE = 7
TEXT = f"""
[model]
name = "scene"
[space]
w = {{ sphere = 36, radius = 2.5, kappa = 2.5 }}
[lattices.sq]
vectors = [[1, 0], [0, 1]]
size = [6, 6]
boundary = "open"
[effects.exchange]
over = "bond(i, j) of sq.first"
energy = "1.5 - dot(w[i], w[j])"
[effects.next]
over = "bond(i, j) of sq.second"
energy = "0.1*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "0.2*(1 - w[i].z)"
[effects.hole]
over = "site(i) of w"
absent = "i == {HOLE}"
[starts.any]
w = {{ random = 3 }}
[runs.demo]
start = "any"
h = 0.1
steps = 4
output = {{ every = 2, what = ["states", "energy"] }}
"""


@pytest.fixture(scope="module")
def holed():
    return facts.with_facts(smidgen.run(smidgen.load_text(TEXT), effects=["exchange", "field", "hole"]))


@pytest.fixture(scope="module")
def whole():
    return facts.with_facts(smidgen.run(smidgen.load_text(TEXT), effects=["exchange", "field"]))


def test_bonds_are_those_of_the_run(holed, whole):
    for result, count in ((holed, 56), (whole, 60)):
        assert len(result.meta["bonds"]["w"]) == len(result.meta["standing"]["w"]["links"]) == count


def test_the_numbers_of_sites_add_up_to_the_column(holed, whole):
    for result, absent in ((holed, True), (whole, False)):
        maps = standing.site_maps(result.meta["numbers"], set(result.meta["effects"]), result.t, result.w)
        assert {one["name"] for one in maps} == {"energy", "energy.exchange", "energy.field"}
        for one in maps:
            assert np.allclose(one["values"].sum(axis=1), result.values[one["name"]], rtol=1e-12)
            assert np.all(one["values"][:, HOLE] == 0) == absent


def test_absent_sites_have_no_colour_and_no_point(holed):
    images = draw.figure(holed, "chain").axes[0].images[0], draw.figure(holed, "lattice").axes[0].images[0]
    assert [np.argwhere(~np.isfinite(np.ma.filled(image.get_array().astype(float), np.nan))).tolist() for image in images] == [[[k, HOLE] for k in range(3)], [[1, 1]]]
    points = [len(part.get_offsets()) for part in draw.figure(holed, "cloud").axes[0].collections]
    assert sum(points) == 35
    _, frame, _ = film.sphere_film(holed.t, holed.w)
    assert len(portraits.several(holed.w).axes[0].lines) and frame(0) is None


@pytest.mark.parametrize("times", [[0.0, 0.5, 1.0], [0.0, -0.5, -1.0]])
def test_an_output_is_in_the_middle_of_its_row(times):
    """Also of a run backward."""
    w = np.random.default_rng(1).normal(size=(len(times), 5, 3))
    low, high = chain.chain_image(np.array(times), w).axes[0].images[0].get_extent()[2:]
    edges = np.linspace(low, high, len(times) + 1)
    assert np.allclose((edges[1:] + edges[:-1]) / 2, times) and low != high


def test_the_ball_has_the_radius_of_the_spins(holed):
    ball = chain.chain_curves(holed.t, holed.w["w"], bonds=holed.meta["bonds"]["w"]).axes[0].images[0]
    assert ball.get_extent() == pytest.approx([-2.5, 2.5, -2.5, 2.5])


def test_short_vectors_have_a_ball_too(holed):
    ax = portraits.several({"w": 1e-9 * holed.w["w"][:, :3]}).axes[0]
    assert ax.images[0].get_extent() == pytest.approx([-2.5e-9, 2.5e-9, -2.5e-9, 2.5e-9])


def test_rows_of_a_chain_lie_at_their_times(holed):
    low, high = pictures.draw_chain(holed).axes[0].images[0].get_extent()[2:]
    assert (low, high) == pytest.approx((-0.1, 0.5))
