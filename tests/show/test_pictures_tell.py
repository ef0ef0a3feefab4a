"""What a picture tells: colours by name and site, how much is left out, which spins are joined."""
import base64
import re

import numpy as np
import pytest
from support.pictures import FILM_BONDS, data_of, film, pairs_of, result, ring, top  # noqa: F401

from smidgen.show.plot import chain, colours, facts, overview, pictures, sphere, style, view
from smidgen.show.plot.figures import FIGURES


# -- what a colour means ---------------------------------------------------------------------

def names_and_colors(figure):
    """(name, colour) of every curve that has a name and of every line of a legend."""
    for ax in figure.axes:
        found = [(line.get_label(), line) for line in ax.lines]
        if ax.get_legend():
            found += zip((t.get_text() for t in ax.get_legend().get_texts()), ax.get_legend().legend_handles)
        for name, artist in found:
            if not name.startswith("_") and hasattr(artist, "get_color"):
                yield name, style.matplotlib.colors.to_hex(artist.get_color())


@pytest.fixture(scope="module")
def every_figure(top):
    """The figures of the paper that name something, and the kinds of picture of one result."""
    w, t = top.w["w"][:, 0], top.t
    methods = list(style.STYLES)
    series = [(m, t, 1e-6 * (k + 1) * np.sin(t)) for k, m in enumerate(reversed(methods))]
    h = 2.0 ** -np.arange(1, 5)
    made = [FIGURES["free_body_errors"].draw([("a", {m: (h, h**2) for m in methods})]),
            FIGURES["irreversible_trajectories"].draw(w, -w), FIGURES["irreversible_energy"].draw(series[1:]),
            FIGURES["irreversible_energy_long"].draw(series), FIGURES["forced_sections"].draw([("a", [w], [-w])]),
            FIGURES["chain_invariants"].draw(t, t, top.w["w"][:, 0], top.values["casimirs"])]
    bodies = result({"w": np.concatenate([top.w["w"], -top.w["w"]], axis=1), "p": top.w["w"] * [1, -1, 1]})
    return made + [style.styled(pictures.KINDS[k][0])(bodies) for k in ("sphere", "components", "section")]


def test_a_name_has_one_colour_in_every_figure_and_panel(every_figure):
    colors = {}
    for figure in every_figure:
        for name, color in names_and_colors(figure):
            colors.setdefault(name, set()).add(color)
    assert {"spherical midpoint", "classical midpoint", "chaotic orbits", "w[1]", "p", "$x$"} <= set(colors)
    assert {name: found for name, found in colors.items() if len(found) > 1} == {}


def test_every_colour_that_means_something_is_legible():
    """A contrast of 3 with white paper and with the ball, on which sites and orbits are drawn."""
    ball = sphere.shading(64)[..., :3][sphere.shading(64)[..., 3] == 1].mean(axis=0)
    drawn = [*colours.PALETTE, *colours.COMPONENTS.values(), colours.CHAOTIC, colours.INK, *colours.regular(20), *colours.ordered(np.linspace(0, 1, 9))]
    drawn += [color for n in (8, 40, 300) for color in colours.of_sites({"a": n, "b": n})["b"]]
    assert min(colours.contrast(color) for color in [*drawn, *(look[1] for look in style.STYLES.values())]) >= 3
    assert min(colours.contrast(color, ball) for color in drawn) >= 3


def test_methods_components_and_orbits_share_no_colour():
    taken = [look[1] for look in style.STYLES.values()] + [*colours.COMPONENTS.values(), colours.CHAOTIC]
    assert len(set(taken)) == len(taken)


@pytest.mark.quick
@pytest.mark.parametrize("counts", [(1,), (4,), (7,), (8,), (40,), (3, 20), (1, 1), (6, 1), (6, 2), (1,) * 20, (2, 60, 5)])
def test_every_site_has_its_own_colour(counts):
    found = colours.of_sites({f"f{i}": n for i, n in enumerate(counts)})
    assert tuple(map(len, found.values())) == counts
    every = [color for family in found.values() for color in family]
    assert len(set(every)) == len(every)


def test_a_site_has_one_colour_in_every_kind(top):
    """The colours of the sites in the player, of the leaves, and of what is drawn on the sphere."""
    bodies = result({"w": np.concatenate([top.w["w"], -top.w["w"]], axis=1)})
    known = colours.of_sites({"w": 2})["w"]
    assert data_of(pictures.draw_player(bodies))["families"][0]["colors"] == known
    leaves = style.styled(pictures.draw_leaf)(bodies)
    for ax, color in zip(leaves.axes, known):
        assert ax.lines[-1].get_color() == color
    drawn = {name: color for name, color in names_and_colors(style.styled(pictures.draw_sphere)(bodies))}
    assert [drawn[f"w[{i}]"].upper() for i in (0, 1)] == [color.upper() for color in known]


def test_no_other_file_chooses_colours():
    """A colour is written once, in colours.py; greys of the ball and of grids are no meaning."""
    folder = style.Path(style.__file__).parent
    words = "|".join(["PALETTE", "GREEN", "VERMILION", "PURPLE", "ORANGE", "SKY", "BROWN", *colours.PALETTE])
    for file in [*folder.glob("*.py"), *(folder / "web").glob("*.mjs")]:
        if file.name not in ("colours.py", "style.py"):
            assert not re.search(rf"{words}", file.read_text()), file.name


# -- what is left out ------------------------------------------------------------------------

def spins(*counts, outputs=5):
    """A Result of families a, b, .. of such numbers of sites, on unit spheres."""
    dice = np.random.default_rng(5)
    w = {name: dice.standard_normal((outputs, n, 3)) for name, n in zip("abc", counts)}
    return result({name: v / np.linalg.norm(v, axis=2, keepdims=True) for name, v in w.items()})


SITES_DRAWN = {     # kind -> how many sites a figure of it shows
    "components": lambda f: len(f.axes[0].lines),
    "leaf": lambda f: len(f.axes),
    "chain": lambda f: f.axes[0].images[0].get_array().shape[1],
    "curves": lambda f: discs(f.axes[0]),
    "cloud": lambda f: discs(f.axes[0]),
    "sphere": lambda f: discs(f.axes[0]) // 2,      # starts and ends
    "section": lambda f: discs(f.axes[0]) // 5,
}


def discs(ax):
    return sum(len(c.get_offsets()) for c in ax.collections)


def said_in(figure):
    """All words of a figure below and above its panels."""
    return " ".join([t.get_text() for t in figure.findobj(style.matplotlib.text.Text)])


@pytest.mark.parametrize("kind, counts", [*((kind, (3, 20)) for kind in SITES_DRAWN), ("chain", (700,)), *(
    pytest.param(kind, counts, marks=pytest.mark.long) for kind, counts in [*((kind, (7,)) for kind in SITES_DRAWN), ("leaf", (9,))])])
def test_a_picture_says_how_many_sites_it_leaves_out(kind, counts):
    figure = style.styled(pictures.KINDS[kind][0])(spins(*counts))
    drawn, every = SITES_DRAWN[kind](figure), sum(counts)
    said = re.findall(r"(\d+) of (\d+) sites shown", said_in(figure))
    assert said == ([] if drawn == every else [(str(drawn), str(every))])


@pytest.mark.quick
def test_a_curve_has_one_colour_in_all_panels_of_components():
    axes = style.styled(pictures.draw_components)(spins(5)).axes
    colors = [[line.get_color() for line in ax.lines] for ax in axes]
    assert colors[0] == colors[1] == colors[2] and len(set(colors[0])) == 5


def test_thinned_outputs_are_told(top):
    long = spins(1, outputs=5000)
    assert "600 of 5000 outputs shown" in said_in(style.styled(pictures.draw_chain)(long))
    assert "3000 of 5000 outputs shown" in data_of(pictures.draw_player(long))["facts"]
    assert "shown" not in data_of(pictures.draw_player(top))["facts"]


def test_overview_says_what_it_leaves_out(top):
    mixed = result({"w": top.w["w"], "v": top.w["w"] * [1, 2, 3]})
    mixed.meta["casimirs"] = {"v": np.diag([1, 0.25, 1 / 9])}
    assert "1 of 2 sites shown" in overview.overview([top, mixed]).axes[1].get_title("center")
    assert "shown" not in overview.overview([top, mixed]).axes[0].get_title("center")


# -- lattices --------------------------------------------------------------------------------

@pytest.mark.quick
def test_the_bonds_of_a_film_are_known_from_its_spec(film):
    known = facts.with_facts(film)
    assert pairs_of(known.meta["bonds"]["w"]) == FILM_BONDS and len(known.meta["bonds"]["w"]) == len(FILM_BONDS)
    assert "bonds" not in film.meta                      # the caller's own result is as it was
    film.meta["effects"] = ["field"]
    assert facts.with_facts(film).meta["bonds"] == {}
    film.meta["effects"] = ["exchange", "field"]


def test_lines_run_along_bonds_alone(film, ring):
    """In the player and as arcs: never from the end of a row to the start of the next."""
    known = facts.with_facts(film)
    bonds = np.frombuffer(base64.b64decode(data_of(pictures.draw_player(known))["families"][0]["bonds"]), "<i4")
    assert pairs_of(bonds.reshape(-1, 2)) == FILM_BONDS
    arc = 9 + 1                                          # points of an arc and the gap behind it
    w = film.w["w"][0]
    view_ = view.View(60, 60)
    ax = style.styled(chain.chain_curves)(known.t, known.w["w"], [0], known.meta["bonds"]["w"], view=view_).axes[0]
    longest = max(len(line.get_xdata()) for line in ax.lines if line.get_zorder() == 3.0)
    assert longest == arc * len(FILM_BONDS) and np.all(w @ view_.matrix[2] > 0)
    unknown = data_of(pictures.draw_player(ring))["families"][0]["bonds"]
    assert unknown == ""                                 # numbers alone do not say what is joined
