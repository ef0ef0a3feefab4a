"""Pictures, by properties: what is drawn, where it is hidden, what bytes come out."""
import base64
import json
import re
import shutil
import subprocess
import zlib

import numpy as np
import pytest
from support.systems import tiers

from smidgen.methods import NAMES
from smidgen.errors import UsageError
from smidgen.run.output import Result
from smidgen.show.plot import chain, colours, curves, draw, equilibria, facts, leaf, orbits, overview, pictures
from smidgen.show.plot import player, portraits, sphere, style, surfaces, text, view
from smidgen.show.plot.figures import FIGURES
from smidgen.show.plot.gallery import Picture, Row, gallery

INERTIA = np.array([1.0, 2.0, 4.0])
HOSTILE = "</script><script>alert('1')</script>&\"$x_{$\\frac\u202e\x00 <b>"


def midpoint(field, w, h, steps):
    """Spherical midpoint W - w = h m x b(m), m = r (w+W)/|w+W|, by fixed-point iteration."""
    w = np.array(w, float)
    radius, path = np.linalg.norm(w, axis=-1, keepdims=True), [w]
    for _ in range(steps):
        end = w
        for _ in range(100):
            m = w + end
            m = radius * m / np.linalg.norm(m, axis=-1, keepdims=True)
            new = w + h * np.cross(m, field(m))
            if np.array_equal(new, end):
                break
            end = new
        w = end
        path.append(w)
    return np.array(path)


def body(w):
    return w / INERTIA


def neighbours(w):
    return np.roll(w, 1, axis=0) + np.roll(w, -1, axis=0)


def energy_of(w):
    return 0.5 * np.sum(w * w / INERTIA, axis=-1)


@pytest.fixture(scope="module")
def top():
    w = midpoint(body, [[np.cos(1.1), 0, np.sin(1.1)]], 0.1, 200)
    return result({"w": w}, energy=energy_of(w[:, 0]), casimirs=np.sum(w * w, axis=2),
                  **{"momentum.w": w[:, 0]})


@pytest.fixture(scope="module")
def ring():
    i = 2 * np.pi * np.arange(30) / 30
    polar = 0.7 + 0.3 * np.sin(3 * i)
    w = np.stack([np.sin(polar) * np.cos(i), np.sin(polar) * np.sin(i), np.cos(polar)], axis=1)
    return result({"w": midpoint(neighbours, w, 0.1, 40)}, energy=np.zeros(41))


def result(states, title="A title", **values):
    """A Result as a run gives it, with only what pictures read."""
    count = len(next(iter(states.values())))
    meta = {"spec": "made", "title": title, "run": "demo", "method": "spherical-midpoint",
            "h": 0.1, "done": count - 1, "orientation": 1,
            "families": {n: w.shape[1] for n, w in states.items()}}
    return Result(meta, np.arange(count), 0.1 * np.arange(count), states, values)


# -- projection and hidden lines -------------------------------------------------------------

def test_view_is_a_rotation():
    m = view.View(71, -33).matrix
    assert np.allclose(m @ m.T, np.eye(3)) and np.isclose(np.linalg.det(m), 1)


def test_front_of_the_sphere_is_seen_and_the_back_is_not():
    w = np.random.default_rng(1).standard_normal((500, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    sight = view.View(10, 40)
    assert np.array_equal(view.visible(w, sight), w @ sight.matrix[2] >= 0)


@pytest.mark.parametrize("casimir", [np.diag([2.0, 1.0, 0.5]), np.diag([1.0, 1.0, -1.0])])
def test_hidden_points_have_the_surface_before_them(casimir):
    """Brute force: march along the ray from a point and look for a change of sign of C - c."""
    rng, sight = np.random.default_rng(2), view.View(25, 15)
    w = rng.standard_normal((200, 3))
    w = w[np.einsum("ki,ij,kj->k", w, casimir, w) > 0.1]
    w /= np.sqrt(0.5 * np.einsum("ki,ij,kj->k", w, casimir, w))[:, None]
    ray = w[:, None] + np.linspace(1e-3, 40, 8000)[None, :, None] * sight.matrix[2]
    level = 0.5 * np.einsum("ksi,ij,ksj->ks", ray, casimir, ray) - 1
    crossed = np.any(level[:, 1:] * level[:, :-1] < 0, axis=1)
    clear = np.abs(w @ casimir @ sight.matrix[2]) > 1e-2
    assert np.array_equal(view.visible(w, sight, casimir)[clear], ~crossed[clear])


def test_split_keeps_every_point_once_and_drops_nan():
    t = np.linspace(0, 2 * np.pi, 100)
    circle = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    circle[50] = np.nan
    front, back = view.split(circle, view.View())
    assert len(front) >= 1 and len(back) >= 1
    points = {tuple(p) for piece in front + back for p in piece}
    assert len(points) == len({tuple(p) for p in view.View().project(circle)[:, :2]
                               if np.isfinite(p[0])})


# -- leaves ----------------------------------------------------------------------------------

LEAVES = {
    "plane": (np.diag([2.0, 0, 0]), [0.8, 0.5, -0.4]),
    "hyperbolic cylinder": (np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0.0]]), [-0.9, -0.6, 0.4]),
    "cylinder": (np.diag([2.0, 2.0, 0]), [0.6, 0.8, 0.5]),
    "one sheet": (np.array([[0, 0, 1], [0, 2, 0], [1, 0, 0.0]]), [0.7, 0.3, 0.9]),
    "two sheets": (np.array([[0, 0, 1], [0, 2, 0], [1, 0, 0.0]]), [0.7, 0.3, -0.9]),
    "sphere": (2 * np.eye(3), [0.5, -0.6, 1.1]),
    "ellipsoid": (np.diag([1.0, 2.0, 3.0]), [0.5, -0.6, 1.1]),
}


@pytest.mark.parametrize("name", LEAVES)
def test_mesh_lies_on_the_leaf_through_the_start(name):
    A, w = LEAVES[name]
    w = np.array([w])
    sheet = leaf.leaf_of(A, [w])
    grid = leaf.mesh(sheet)
    level = 0.5 * np.einsum("mni,ij,mnj->mn", grid, np.asarray(A), grid)
    assert np.allclose(level, 0.5 * w[0] @ A @ w[0], rtol=1e-9)
    assert np.all(sheet.drawn(grid)) and sheet.drawn(w)[0]
    assert np.min(np.linalg.norm(grid - w[0], axis=2)) < 0.2


def test_no_leaf_on_the_cone():
    with pytest.raises(UsageError, match="no symplectic leaf"):
        leaf.leaf_of(np.diag([1.0, -1.0, 0.0]), [np.array([[1.0, 1.0, 0.3]])])


# -- equilibria ------------------------------------------------------------------------------

def test_equilibria_of_the_free_body():
    found = equilibria.equilibria(body)
    kinds_ = {tuple(np.round(w).astype(int)): k for w, k in found}
    assert len(found) == 6
    assert {w for w, k in kinds_.items() if k == "unstable"} == {(0, 1, 0), (0, -1, 0)}


def test_stable_minus_unstable_is_the_euler_number():
    """Poincare-Hopf: centres minus saddles = 2, for a field with neither symmetry nor chance."""
    found = equilibria.equilibria(lambda w: w / INERTIA + np.array([0.05, -0.08, 0.11]) * w**2)
    signs = [{"stable": 1, "unstable": -1}[k] for _, k in found]
    assert sum(signs) == 2


# -- text ------------------------------------------------------------------------------------

def test_user_text_never_becomes_markup_or_script():
    assert "<" not in text.in_html(HOSTILE) and '"' not in text.in_html(HOSTILE)
    script = text.in_script({"title": HOSTILE})
    assert "<" not in script and "&" not in script and json.loads(script) == {"title": HOSTILE}
    assert "\u202e" not in text.shown(HOSTILE) and "\x00" not in text.shown(HOSTILE)


def test_a_hostile_title_is_drawn(top, tmp_path):
    hostile = result(top.w, HOSTILE, **top.values)
    for kind in ("sphere", "energy", "player"):
        path = draw.plot(hostile, kind, tmp_path / f"x.{'html' if kind == 'player' else 'svg'}")
        assert path.stat().st_size > 1000
    page = (tmp_path / "x.html").read_text()
    assert page.count("<script") == 2 and "<b>" not in page


def test_json_refuses_nan():
    with pytest.raises(ValueError):
        text.in_script([float("nan")])


# -- every kind, every format ----------------------------------------------------------------

@pytest.mark.parametrize("kind", [k for k in pictures.KINDS if k != "player"])
def test_every_kind_draws_something_with_named_axes(kind, top):
    full = result(top.w, **top.values, **{"energy.kinetic": top.values["energy"], "mz": top.t})
    figure = style.styled(pictures.KINDS[kind][0])(full)
    for ax in figure.axes:
        drawn = len(ax.lines) + len(ax.collections) + len(ax.images)
        assert drawn > 0
        assert not ax.axison or ax.get_xlabel() or ax.get_ylabel()


@pytest.mark.parametrize("ending", tiers(style.FORMATS, (), ("svg",)))
def test_same_result_same_bytes(ending, top, tmp_path):
    a, b = (draw.plot(top, "energy", tmp_path / f"{n}.{ending}").read_bytes() for n in "ab")
    assert a == b and len(a) > 1000


def test_svg_of_a_sphere_has_the_same_bytes_and_no_date(top, tmp_path):
    a, b = (draw.plot(top, "sphere", tmp_path / f"{n}.svg").read_bytes() for n in "ab")
    assert a == b and b"<dc:date>" not in a


def test_auto_chooses_what_suits(top, ring):
    assert pictures.suitable(top, False) == "sphere"
    assert pictures.suitable(top, True) == "player"
    assert pictures.suitable(ring, False) == "chain"
    assert pictures.suitable(Result(top.meta, top.step, top.t, None, top.values), False) == "invariants"
    w = top.w["w"] * np.array([1, 2, 3])
    assert pictures.suitable(result({"w": w}), False) == "leaf"


def test_the_callers_own_style_survives(top, tmp_path):
    import matplotlib
    before = dict(matplotlib.rcParams)
    draw.plot(top, "energy", tmp_path / "a.png")
    assert dict(matplotlib.rcParams) == before


# -- errors ----------------------------------------------------------------------------------

@pytest.mark.parametrize("kind, out, words", [
    ("energie", None, "did you mean 'energy'"), ("energy", "a.gif", "ending"),
    ("player", "a.png", ".html"), ("energy", "a.html", "player"), ("auto", "a.gif", "ending"),
])
def test_wrong_wishes_are_usage_errors(kind, out, words, top, tmp_path):
    with pytest.raises(UsageError, match=re.escape(words)):
        draw.plot(top, kind, None if out is None else tmp_path / out)


def test_missing_columns_say_what_to_ask_for(top, tmp_path):
    bare = Result(top.meta, top.step, top.t, None, {})
    for kind in pictures.KINDS:
        with pytest.raises(UsageError, match="--what"):
            draw.plot(bare, kind, tmp_path / ("a.html" if kind == "player" else "a.png"))


def test_a_folder_that_cannot_be_written(top, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot write"):
        draw.plot(top, "energy", tmp_path / "file" / "a.png")
    with pytest.raises(UsageError, match="cannot write"):
        draw.plot(top, "player", tmp_path / "file" / "a.html")


SPOILT = {
    "one output": lambda w: w[:1],
    "nan": lambda w: np.where(np.arange(len(w))[:, None, None] == 5, np.nan, w),
    "all nan": lambda w: w * np.nan,
    "zero": lambda w: 0 * w,
    "huge": lambda w: 1e200 * w,
    "tiny": lambda w: 1e-200 * w,
    "long double": lambda w: w.astype(np.longdouble),
    "at rest": lambda w: 0 * w + [0, 0, 1],
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("how", tiers(SPOILT, (), ("nan", "all nan", "huge")))
def test_spoilt_results_are_drawn_or_refused(how, top, tmp_path):
    w = SPOILT[how](top.w["w"])
    k = len(w)
    spoilt = result({"w": w}, energy=w[:, 0, 0], casimirs=w[:, :, 1],
                    **{"momentum.w": w[:, 0], "mz": np.arange(k), "energy.rotation": np.ones(k)})
    for kind in ("sphere", "energy", "invariants", "chain", "player"):
        try:
            draw.plot(spoilt, kind, tmp_path / ("a.html" if kind == "player" else "a.png"))
        except UsageError as error:
            assert how in ("all nan", "zero", "huge", "tiny") or "two outputs" in str(error)


def test_a_player_without_a_leaf(top):
    w = np.tile([[[1.0, 1.0, 0.3]]], (10, 1, 1))
    page = player.player_page(top.t[:10], {"w": w}, casimirs={"w": np.diag([1.0, -1.0, 0.0])})
    assert data_of(page)["backdrop"] == []


# -- curves ----------------------------------------------------------------------------------

def test_envelope_keeps_the_extremes():
    y = np.random.default_rng(3).standard_normal(100_000)
    t, short = curves.envelope(np.arange(y.size), y)
    assert short.size <= curves.POINTS and short.max() == y.max() and short.min() == y.min()
    assert np.all(np.diff(t) > 0)


def test_slope_triangle_has_the_slope():
    h = 2.0 ** -np.arange(1, 8)
    figure = curves.error_against_step([("a", {"spherical-midpoint": (h, h**2)})])
    x, y = figure.axes[0].lines[-1].get_data()
    assert np.isclose(np.log(y[2] / y[1]) / np.log(x[1] / x[0]), 2)
    assert len(figure.axes[0].lines) == 2


def test_methods_differ_in_colour_dash_and_marker():
    looks = list(style.STYLES.values())
    assert list(style.STYLES) == list(NAMES)
    for column in (1, 2, 3):
        assert len({look[column] for look in looks}) == len(looks)


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
    for file in [*folder.glob("*.py"), folder / "player.js"]:
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
    "sphere": lambda f: discs(f.axes[0]),
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

FILM = """
[model]
name = "film"
[space]
w = { sphere = "nx*ny" }
[parameters]
nx = 6
ny = 5
[effects.exchange]
over = "bond(i, j) of square(nx, ny, open)"
energy = "-dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
"""
FILM_BONDS = {(i, i + 1) for i in range(30) if i % 6 < 5} | {(i, i + 6) for i in range(24)}


@pytest.fixture(scope="module")
def film():
    """A smooth film of 6 by 5 spins, with the spec that it comes from."""
    i = np.arange(30)
    polar, around = 0.4 + 0.2 * (i % 6), 0.5 + 0.25 * (i // 6)
    w = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=1)
    made = result({"w": np.stack([w] * 20)})
    made.meta.update(sources=[["film.toml", FILM]], effects=["exchange", "field"], values={"nx": 6, "ny": 5})
    return made


def pairs_of(bonds):
    return {tuple(sorted(map(int, pair))) for pair in bonds}


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


# -- figures ---------------------------------------------------------------------------------

def test_four_vortices_of_the_manifold():
    w = portraits.on_manifold(0.9, 0.4)
    assert np.allclose(np.linalg.norm(w, axis=1), 1) and np.allclose(w.sum(axis=0), 0)


def test_orbits_on_inner_spheres_are_hidden_but_where_the_outer_is_cut():
    nest = orbits.Nest((0.5, 1.0), (-30, 90))
    toward = view.View(30, 30).matrix[2]
    assert nest.seen(0.5 * toward[None], view.View(30, 30))[0]
    assert not nest.seen(0.5 * view.View(-120, 30).matrix[2][None], view.View(-120, 30))[0]


def test_chain_figures(ring):
    image = chain.chain_image(ring.t, ring.w["w"])
    assert [len(ax.images) for ax in image.axes[:3]] == [1, 1, 1]
    spheres = chain.chain_curves(ring.t, ring.w["w"], times=[0, 2, 4])
    assert len(spheres.axes) == 3


def test_section_draws_every_point():
    w = np.random.default_rng(4).standard_normal((200, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    figure = portraits.sections([("a", [w], []), ("b", [], [w])])
    for ax in figure.axes:
        assert sum(len(c.get_offsets()) for c in ax.collections if hasattr(c, "get_sizes")) == 200


def test_leaves_and_orbits(top):
    figure = surfaces.leaves([{"title": n, "casimir": A, "curves": [np.array([w, w])]}
                              for n, (A, w) in LEAVES.items()])
    assert len(figure.axes) == len(LEAVES)
    assert orbits.coadjoint_orbits([top.w["w"][:, 0], 0.5 * top.w["w"][:, 0]]).axes


def test_overview_has_a_panel_for_each(top, ring):
    w = top.w["w"] * np.array([1, 1, 2])
    stretched = result({"w": w})
    stretched.meta["casimirs"] = {"w": np.diag([1, 1, 0.25])}
    figure = overview.overview([top, ring, stretched], columns=2)
    assert len(figure.axes) == 3
    assert all(len(ax.lines) > 0 for ax in figure.axes)


def test_shading_is_a_ball():
    image = sphere.shading(64)
    assert image[0, 0, 3] == 0 and image[32, 32, 3] == 1 and image.max() <= 1


# -- the player ------------------------------------------------------------------------------

def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.S).group(1))


def test_player_carries_the_states(top):
    data = data_of(pictures.draw_player(top))
    w = np.frombuffer(base64.b64decode(data["families"][0]["w"]), "<i2").reshape(-1, 1, 3)
    assert np.allclose(w * data["quantum"], top.w["w"], atol=1e-4)
    assert np.array_equal(np.frombuffer(base64.b64decode(data["t"])), top.t)


def test_player_loads_nothing(top):
    page = pictures.draw_player(top)
    assert "http:" not in page and "https:" not in page and "src=" not in page and "default-src 'none'" in page


def test_player_is_limited(top):
    w = np.zeros((5000, 2000, 3)) + [0, 0, 1]
    page = player.player_page(np.arange(5000.0), {"w": w}, np.arange(5000.0))
    assert len(page) < 6e6


def test_player_without_states():
    with pytest.raises(UsageError, match="states"):
        player.player_page(np.arange(3), {})


def test_player_survives_nan(top):
    w = top.w["w"].copy()
    w[-1] = np.nan
    energy = top.values["energy"].copy()
    energy[-1] = np.inf
    assert data_of(player.player_page(top.t, {"w": w}, energy))["low"] <= 0


HANDS = """<script>
window.requestAnimationFrame = (f) => setTimeout(() => f(performance.now()), 16);
const canvas = document.getElementById("scene"), seen = [];
const look = () => seen.push(canvas.toDataURL().length + ":" + canvas.toDataURL().slice(-400));
const send = (kind, x, y) => canvas.dispatchEvent(new PointerEvent(kind,
  {pointerId: 1, clientX: x, clientY: y, bubbles: true}));
canvas.setPointerCapture = () => {};
setTimeout(() => {
  look(); send("pointerdown", 100, 100); send("pointermove", 180, 130); send("pointerup", 180, 130);
  look(); document.getElementById("slider").value = 500;
  document.getElementById("slider").dispatchEvent(new Event("input"));
  const half = document.getElementById("clock").textContent;
  document.getElementById("play").click();
  setTimeout(() => {
    const later = document.getElementById("clock").textContent;
    document.title = JSON.stringify({turned: seen[0] !== seen[1], half, later,
                                     button: document.getElementById("play").textContent});
  }, 500);
}, 200);
</script></body>"""
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


with_browser = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def in_browser(page, folder):
    """What the page has become when its script has run for two seconds."""
    return subprocess.run(
        [CHROMIUM, "--no-sandbox", "--headless=new", "--disable-gpu", "--virtual-time-budget=2000",
         f"--user-data-dir={folder}/profile", "--dump-dom", f"file://{page}"],
        capture_output=True, text=True, timeout=120).stdout


@with_browser
def test_player_turns_and_plays(top, tmp_path):
    """Drag, slider and button, sent as events: the picture and the clock change.

    Frames are asked for by a timer: a browser without a window draws few of its own.
    """
    page = draw.plot(top, "player", tmp_path / "p.html")
    page.write_text(page.read_text().replace("</body>", HANDS))
    said = json.loads(re.search(r"<title>(.*?)</title>", in_browser(page, tmp_path)).group(1))
    assert said["turned"] and said["button"] == "Pause"
    half, later = (float(re.search(r"t = ([0-9.]+)", said[k]).group(1)) for k in ("half", "later"))
    assert half == pytest.approx(10.0, abs=0.05) and half < later < 20


@with_browser
def test_player_in_a_browser(top, tmp_path):
    """A headless browser shows user text as text, and the time."""
    hostile = result(top.w, HOSTILE, **top.values)
    page = draw.plot(hostile, "player", tmp_path / "p.html")
    dump = in_browser(page, tmp_path)
    assert re.search(r'<div id="clock"[^>]*>t = 0\.00000 +H \u2212 H\u2080 = 0</div>', dump)
    assert "&lt;/script&gt;" in dump and dump.count("<script") == 2


RECORDER = """<script>
const discs = [], lines = [];                   // all that the player draws: canvas, place, colour
const P = CanvasRenderingContext2D.prototype;
function around(name, first) {
  const was = P[name];
  P[name] = function (...a) { first(this, ...a); return was.apply(this, a); };
}
const part = (c) => c.canvas.closest("#legend") ? "legend" : c.canvas.id;
around("beginPath", (c) => { c.path = []; c.disc = null; });
around("arc", (c, x, y, r) => { c.disc = [x, y, r]; });
around("moveTo", (c, x, y) => { c.from = [x, y]; });
around("lineTo", (c, x, y) => { c.path.push([...c.from, x, y]); c.from = [x, y]; });
around("fill", (c) => { if (c.disc && typeof c.fillStyle === "string") discs.push([c, c.disc, c.fillStyle]); });
around("stroke", (c) => { for (const s of c.path) lines.push([c, s, c.strokeStyle]); });
</script>"""
MOVES = """<script>
const el = (id) => document.getElementById(id), said = {}, scene = el("scene");
scene.setPointerCapture = () => {};
const ask = (target, name, looks) => target.dispatchEvent(new (name.startsWith("key") ? KeyboardEvent :
  name === "wheel" ? WheelEvent : PointerEvent)(name, { bubbles: true, cancelable: true, pointerId: 1, ...looks }));
const press = (key, looks) => !ask(document.activeElement, "keydown", { key, ...looks });     // taken?
const zooms = (looks) => !ask(scene, "wheel", { deltaY: -100, ...looks });
const click = (id) => { ask(el(id), "pointerdown"); el(id).focus(); el(id).click(); };
const clock = () => el("clock").textContent;
const changed = (f) => { const was = clock(); f(); return was !== clock(); };
setTimeout(() => {
  const before = discs.splice(0);
  lines.length = 0;
  el("trail").value = 0; el("trail").dispatchEvent(new Event("change"));
  const all = discs.filter(([c]) => part(c) === "scene");
  said.spots = all.map(([, d, color]) => [...d, color]);
  said.segments = lines.filter(([c]) => part(c) === "scene").map(([, s]) => s);
  said.keys = before.filter(([c]) => part(c) === "legend").map(([, d, color]) => [...d, color]);
  said.wheel = { plain: zooms({}), ctrl: zooms({ ctrlKey: true }) };
  ask(scene, "pointerdown", { clientX: 9, clientY: 9 }); ask(scene, "pointerup");
  said.wheel.clicked = zooms({});
  ask(scene, "pointerleave"); said.wheel.left = zooms({});
  click("play"); said.playing = el("play").textContent;
  said.taken = press(" "); said.paused = el("play").textContent;
  said.steps = changed(() => press(".")); said.turns = press("ArrowLeft");
  said.browser = press("ArrowLeft", { altKey: true });
  ask(el("slider"), "pointerdown"); el("slider").focus();
  said.dragged = changed(() => press("."));
  ask(el("speed"), "pointerdown"); el("speed").focus(); el("speed").dispatchEvent(new Event("change", { bubbles: true }));
  said.chosen = changed(() => press("."));
  el("slider").focus(); said.slider = press("ArrowLeft");
  el("play").focus(); press("Tab"); el("play").click(); said.stays = document.activeElement.id;
  const was = scene.width;
  el("player").style.display = "none";
  setTimeout(() => { said.kept = scene.width === was; document.title = JSON.stringify(said); }, 300);
}, 300);
</script></body>"""


@pytest.fixture(scope="module")
def film_said(film, tmp_path_factory):
    """What a browser says of the film's player: what it draws, and what clicks, keys and wheel do."""
    return moved(film, tmp_path_factory.mktemp("film"))


def moved(made, folder):
    path = draw.plot(made, "player", folder / "p.html")
    page = path.read_text().replace("</title>", "</title>" + RECORDER, 1)
    path.write_text(page.replace("</body>", MOVES))
    title = re.search(r"<title>(.*?)</title>", in_browser(path, folder)).group(1)
    return {**json.loads(title), "data": data_of(page)}


def sites_at(said):
    """Place on the canvas -> number of the site, which its colour tells."""
    numbers = {color: i for i, color in enumerate(said["data"]["families"][0]["colors"])}
    return {(x, y): numbers[color] for x, y, r, color in said["spots"]}


@with_browser
def test_the_player_draws_a_lattice_as_a_lattice(film_said):
    places = sites_at(film_said)
    assert sorted(places.values()) == list(range(30))
    ends = [(places.get((a, b)), places.get((c, d))) for a, b, c, d in film_said["segments"]]
    drawn = [pair for pair in ends if None not in pair]
    assert pairs_of(drawn) == FILM_BONDS and len(drawn) == len(FILM_BONDS)


@with_browser
def test_legend_markers_are_those_drawn(film_said, top, tmp_path):
    """Five of the thirty spins, from the first to the last; of two bodies, each."""
    for said, numbers in [(film_said, [0, 7, 15, 22, 29]),
                          (moved(result({"w": np.concatenate([top.w["w"], -top.w["w"]], axis=1)}), tmp_path), [0, 1])]:
        looks = {(r, color) for x, y, r, color in said["spots"]}
        assert {(r, color) for x, y, r, color in said["keys"]} <= looks
        colors = said["data"]["families"][0]["colors"]
        assert [color for *_, color in said["keys"]] == [colors[i] for i in numbers]


@with_browser
def test_keys_work_after_a_click(film_said):
    """On Play, on the slider, on a choice; what a control needs for itself it keeps."""
    assert film_said["playing"] == "Pause" and film_said["taken"] and film_said["paused"] == "Play"
    assert film_said["steps"] and film_said["turns"] and film_said["dragged"] and film_said["chosen"]
    assert not film_said["slider"] and not film_said["browser"] and film_said["stays"] == "play"


@with_browser
def test_the_wheel_scrolls_the_page_until_it_is_asked_to_zoom(film_said):
    assert film_said["wheel"] == {"plain": False, "ctrl": True, "clicked": True, "left": False}


@with_browser
def test_a_player_that_is_hidden_keeps_its_picture(film_said):
    """A frame has no size while a page is laid out for paper; what it showed is what is printed."""
    assert film_said["kept"]


def pictures_of(pdf):
    """[(width, height on paper, width, height in pixels)] of the images that a PDF draws.

    Only the scales are followed: `cm` multiplies the matrix, `q` and `Q` keep and restore it.
    """
    size = {}
    for number, body in re.findall(rb"(\d+) 0 obj\s*<<(.*?)>>", pdf, re.S):
        if b"/Subtype /Image" in body:
            size[number] = tuple(int(re.search(rb"/%s (\d+)" % k, body).group(1)) for k in (b"Width", b"Height"))
    found, stack, now = [], [], np.eye(2)
    for raw in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.S):
        try:
            words = zlib.decompress(raw).split()
        except zlib.error:
            continue
        for k, word in enumerate(words):
            if word == b"q":
                stack.append(now)
            elif word == b"Q" and stack:
                now = stack.pop()
            elif word == b"cm":
                now = np.array(words[k - 6:k - 2], float).reshape(2, 2) @ now
            elif word == b"Do" and words[k - 1][2:] in size:
                found.append((*np.linalg.norm(now, axis=1), *size[words[k - 1][2:]]))
    return found


@with_browser
@pytest.mark.parametrize("frame", [False, True])
def test_a_printed_player_keeps_its_aspect(top, tmp_path, frame):
    """By itself and inside a page: the canvases are scaled by the same factor both ways."""
    page = pictures.draw_player(top)
    path = tmp_path / "p.html"
    path.write_text(f"<html><body>{player.framed(page)}</body></html>" if frame else page)
    subprocess.run([CHROMIUM, "--no-sandbox", "--headless=new", "--disable-gpu", "--window-size=1400,700",
                    "--virtual-time-budget=2000", f"--user-data-dir={tmp_path}/profile",
                    f"--print-to-pdf={tmp_path}/p.pdf", f"file://{path}"], capture_output=True, timeout=120)
    drawn = [p for p in pictures_of((tmp_path / "p.pdf").read_bytes()) if p[3] > 60]
    assert len(drawn) == 2                               # the scene and the strip
    for wide, high, columns, rows in drawn:
        assert wide / high == pytest.approx(columns / rows, rel=0.01)


# -- the page --------------------------------------------------------------------------------

def test_gallery_is_one_file(top, tmp_path):
    picture = draw.plot(top, "energy", tmp_path / "e.svg")
    played = draw.plot(top, "player", tmp_path / "p.html")
    page = gallery(tmp_path / "out", ["system", "error *", "note"],
                   [Row((HOSTILE, "1e-3", "fine"), True), Row(("b", "2", "bad"), False)],
                   [Picture("e", picture, HOSTILE, "words"), Picture("p", played, "Player")], "T")
    words = page.read_text()
    assert words.count("<img") == 1 and words.count("<iframe") == 1
    assert "<script" not in words and 'class="bad"' in words and "FAILED" in words
    assert "http:" not in words and "https:" not in words
