"""Lattices at their places: in pictures, in films, and in what a player carries."""
import base64
import zlib

import numpy as np
import pytest
import smidgen
from PIL import Image
from support.lattices import MEASURED
from support.pages import blocks
from support.pictures import data_of, film, ring, top  # noqa: F401

from smidgen.errors import MissingTool, UsageError
from smidgen.show.plot import cells, draw, film as films, part, pictures, style

SPEC = """
[model]
name = "crystal"
[space]
w = {{ sphere = {sites} }}
[effects.exchange]
over = "bond(i, j) of {over}"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 1
"""
LATTICES = {    # lattice: sites, area of a cell in squares of the distance of neighbours, bonds drawn at an inner site
    "square(6, 6, periodic)": (36, 1, 4), "triangular(6, 6, periodic)": (36, np.sqrt(3) / 2, 6),
    "honeycomb(5, 5, periodic)": (50, 3 * np.sqrt(3) / 4, 3), "kagome(5, 5, periodic)": (75, 2 / np.sqrt(3), 4),
}


def drawn_from(over, sites):
    spec = smidgen.load_text(SPEC.format(over=over, sites=sites))
    return draw.result_of(smidgen.run(spec, start="random", h=0.1, steps=4, what=["states"]), None)


def areas(stage):
    """Of the cells, in squares of the distance of neighbours, by the shoelace formula."""
    x, y = np.moveaxis(stage.outlines / stage.space, -1, 0)
    return 0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1))


@pytest.mark.parametrize("over", LATTICES)
def test_cells_fill_the_plane(over):
    """None reaches over its neighbours."""
    sites, area, _ = LATTICES[over]
    _, stage, _ = pictures.stage_of(drawn_from(over, sites), {})
    assert np.allclose(areas(stage), area, rtol=2e-3 if "kagome" in over else 1e-9)


@pytest.mark.parametrize("over", LATTICES)
def test_bonds_are_drawn_between_neighbours_alone(over):
    """All equal, and at an inner site evenly about it: those of a honeycomb at 120 degrees; in the picture and in the player."""
    sites, _, each = LATTICES[over]
    drawn = drawn_from(over, sites)
    _, stage, _ = pictures.stage_of(drawn, {})
    family = data_of(draw.page(drawn))["families"][0]
    places, links = (np.frombuffer(zlib.decompress(base64.b64decode(family[key]["deflated"])), kind) for key, kind in (("places", "<f4"), ("links", "<i4")))
    for where, bonds in [(stage.flat / stage.space, stage.bonds), (places.reshape(-1, 3)[:, :2], links.reshape(-1, 2))]:
        along = where[bonds[:, 1]] - where[bonds[:, 0]]
        assert np.allclose(np.linalg.norm(along, axis=1), 1, rtol=1e-6)
        inner = np.argmin(np.linalg.norm(where - where.mean(axis=0), axis=1))
        rays = np.concatenate([along[bonds[:, 0] == inner], -along[bonds[:, 1] == inner]])
        turns = np.diff(np.sort(np.degrees(np.arctan2(*rays.T[::-1]))))
        assert len(rays) == each and (np.allclose(turns, 360 / each, atol=1e-3) or "kagome" in over)


CELLS = ('name = "honeycomb"', "vectors = [[2, 0], [1, 1]]\npositions = [[0, 0], [0.5, 0]]")


def of_constant(cell, constant, length=""):
    """(the stage, the names of its axes, what the player carries) of a lattice whose constant has a unit."""
    drawn = draw.result_of(smidgen.run(smidgen.load_text(MEASURED.format(cell=cell, constant=f'constant = "{constant}"', length=length)), start="random", h="1 fs", steps=2, what=["states"]), None)
    _, stage, _ = pictures.stage_of(drawn, {})
    axes = style.styled(pictures.draw_places)(drawn).axes
    return stage, {ax.get_xlabel() for ax in axes if ax.get_xlabel()}, data_of(draw.page(drawn))["families"][0]


@pytest.mark.parametrize("cell", CELLS)
def test_a_lattice_looks_alike_in_every_unit_of_length(cell):
    """Cells, bonds and arrows, in distances of neighbours; the axes have the unit that [units] names, else that of the constant."""
    stage, names, family = of_constant(cell, "3 angstrom", 'length = "angstrom"')
    assert names == {"x (angstrom)"} and len(stage.bonds) > 50
    for constant, name in [("3 angstrom", "angstrom"), ("3e-10 m", "m"), ("300 pm", "pm")]:
        other, found, data = of_constant(cell, constant)
        assert found == {f"x ({name})"}
        assert np.allclose(areas(other), areas(stage)) and np.allclose(other.flat / other.space, stage.flat / stage.space)
        assert np.array_equal(other.bonds, stage.bonds) and np.isclose(other.long / other.space, stage.long / stage.space)
        for key, kind in (("places", "<f4"), ("links", "<i4")):
            one, same = (np.frombuffer(zlib.decompress(base64.b64decode(d[key]["deflated"])), kind) for d in (data, family))
            assert np.allclose(one, same, atol=1e-5), key


def test_a_layer_and_a_part_have_no_smallest_size():
    where = np.indices((4, 5, 6)).reshape(3, -1).T * 1e-10
    assert len(part.seen(where, part.part_of("z=3e-10")).sites) == 20 and len(part.seen(where, part.part_of("x=1e-10:2e-10,z=4e-10")).sites) == 10


def test_arrows_and_colours_are_those_of_the_sites():
    drawn = drawn_from("honeycomb(5, 5, periodic)", 50)
    assert pictures.suitable(drawn, False) == "places"
    *panels, bar = style.styled(pictures.draw_places)(drawn).axes
    for ax, w in zip(panels, drawn.w["w"]):
        hexagons, bonds, arrows = ax.collections
        assert np.allclose(hexagons.get_array(), w[:, 2]) and np.allclose(np.stack([arrows.U, arrows.V], 1), w[:, :2])
        assert np.allclose(arrows.XY, drawn.meta["standing"]["w"]["places"][:, :2])


def test_a_part_and_a_layer():
    where = np.indices((4, 5, 6)).reshape(3, -1).T.astype(float)
    for given, count, axes in [(None, 20, (0, 1)), ("z=3.2", 20, (0, 1)), ("x=1", 30, (1, 2)), ("x=1:2,z=4", 10, (0, 1)), ({"y": (0, 1), "x": 2}, 12, (1, 2))]:
        found = part.seen(where, part.part_of(given))
        assert len(found.sites) == count and found.axes == axes
    assert part.seen(where, part.part_of("z=3.2")).said == "the layer z = 3, one of 6"


@pytest.mark.parametrize("given, said", [("q=1", "refers to x, y or z, not 'q'"), ("x", "is written x=0:20"), ("x=1,z=2", "at most one layer"), ("x=3:1", "is empty: 3 is not below 1"),
                                         ("x=a", "a number or a range"), ("x=nan", "a number or a range"), ("x=90:99", "no site is in this part; the lattice extends from")])
def test_a_wrong_part_is_refused(given, said, film, tmp_path):
    with pytest.raises(UsageError, match=said):
        draw.plot(film, part=given, out=tmp_path / "p.png")


def test_what_has_no_places_has_no_part(top, film, tmp_path):
    with pytest.raises(UsageError, match="no family of this result has positions"):
        draw.plot(top, part="x=0:1", out=tmp_path / "p.png")
    with pytest.raises(UsageError, match="a part can be drawn with the kind 'places' and in films, not with 'energy'"):
        draw.plot(film, kind="energy", part="x=0:1", out=tmp_path / "p.png")


def test_arrows_of_many_sites_stand_on_a_grid():
    flat = np.indices((100, 100)).reshape(2, -1).T.astype(float)
    some, long = cells.sparse(flat, 1.0)
    assert len(some) == 25 ** 2 and long == pytest.approx(3.6)


def test_a_film_has_its_outputs(film, ring, tmp_path):
    """Of a lattice at its places, and of sites on a sphere."""
    for name, made in [("lattice", film), ("sphere", ring)]:
        kept = pictures.dataclasses.replace(made, t=made.t[:4], step=made.step[:4], w={n: w[:4] for n, w in made.w.items()}, values={})
        with Image.open(draw.plot(kept, out=tmp_path / f"{name}.gif")) as seen:
            assert seen.n_frames == 4 and seen.size[0] > 500


@pytest.mark.skipif(films.writers.is_available("ffmpeg"), reason="ffmpeg is installed")
def test_a_film_without_ffmpeg_is_refused(film, tmp_path):
    with pytest.raises(MissingTool, match="needs the program ffmpeg, which was not found: install it, or write film.gif"):
        draw.plot(film, out=tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())


def test_a_film_of_a_curve_is_refused(film, tmp_path):
    with pytest.raises(UsageError, match="not 'energy': omit --kind"):
        draw.plot(film, kind="energy", out=tmp_path / "film.gif")


@pytest.mark.parametrize("number, small", [(0, {"n": 64}), (1, {"n": 2})])
def test_the_large_lattices_of_the_document_are_drawn(number, small, tmp_path):
    """Smaller here; as they stand they have at most forty lines."""
    text = blocks("figures.md", "toml")[number]
    assert len(text.splitlines()) <= 40
    found = smidgen.run(smidgen.load_text(text), steps=2, parameters=small, estimate=False)
    assert draw.plot(found, out=tmp_path / "p.png").stat().st_size > 20_000 and len(draw.page(draw.with_facts(found))) > 20_000


OWN = """
[model]
name = "brick"
[space]
w = { sphere = 24 }
[lattices.brick]
size = [4, 3]
vectors = [[2, 0, 0], [1, 1, 0]]
positions = [[0, 0], [0.5, 0]]
boundary = "open"
[effects.exchange]
over = "bond(i, j) of brick"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 1
"""


def test_a_lattice_of_ones_own_is_drawn_as_it_is_written(tmp_path):
    """Two sites a cell: they are where the spec puts them, and a player names cell and site."""
    found = draw.result_of(smidgen.run(smidgen.load_text(OWN), start="random", h=0.1, steps=2, what=["states"]), None)
    _, stage, _ = pictures.stage_of(found, {})
    assert np.allclose(stage.flat, [[2 * (i // 2 % 4) + i // 8 + i % 2, i // 8] for i in range(24)])
    assert data_of(draw.page(found))["families"][0]["cell"] == {"size": [4, 3], "sites": 2, "names": ["0", "1"]}


def test_sublattices_have_the_names_that_the_spec_gives_them():
    """In the player and in a schematic; the discs of the player leave no hole, of all sites and of one place of a cell."""
    text = OWN.replace("positions", 'sites = ["iron", "oxygen"]\npositions')
    found = draw.result_of(smidgen.run(smidgen.load_text(text), start="random", h=0.1, steps=2, what=["states"]), None)
    family = data_of(draw.page(found))["families"][0]
    assert family["cell"]["names"] == ["iron", "oxygen"] and "sites iron, oxygen of a cell" in style.styled(pictures.draw_lattice)(found).texts[-1].get_text()
    for where, radius in zip([found.meta["standing"]["w"]["places"][k::step] for k, step in ((0, 1), (0, 2), (1, 2))], family["cover"]):
        square = np.mean(where, axis=0)[:2] + np.stack(np.meshgrid(*2 * [np.linspace(-0.5, 0.5, 21)]), -1).reshape(-1, 2)
        assert np.linalg.norm(square[:, None] - where[None, :, :2], axis=2).min(axis=1).max() < radius < 1.6


def test_units_of_a_result_are_said(film):
    """At places, in a film, in the player and its strip; without them in model units. The spec of this film names none of length."""
    known = pictures.dataclasses.replace(film, values={"mz": np.arange(20.0)}, meta={**film.meta, "units": {
        "codata": 2022, "time": "ps", "energy": "meV", "length": "nm", "field": "T", "columns": {"t": "ps", "energy": "meV", "mz": "mu_B"}}})
    for made, time, energy, moment in [(known, "ps", "meV", "mu_B"), (film, "model units", "", None)]:
        made = draw.with_facts(made)
        panel = style.styled(pictures.draw_places)(made).axes[3]
        assert panel.get_title("left").endswith("1.1 ps" if moment else "1.1") and panel.get_xlabel() == "x (model units)"
        assert style.styled(pictures.film_parts)(made, {})[0].axes[0].get_ylabel() == "y (model units)"
        data = data_of(draw.page(made))
        assert data["timeUnit"] == time and {m["unit"] for m in data["maps"]} == {energy}
        assert [s["unit"] for s in data["series"]] == ([] if moment is None else [moment])
