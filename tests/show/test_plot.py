"""Pictures, by properties: what is drawn, where it is hidden, what bytes come out."""
import dataclasses
import json
import re

import numpy as np
import pytest
import smidgen
from support.pictures import HOSTILE, INERTIA, body, result, ring, top  # noqa: F401
from support.systems import tiers

from smidgen.errors import UsageError
from smidgen.methods import NAMES
from smidgen.run.files.output import Result
from smidgen.show.plot import chain, curves, draw, equilibria, lattice, leaf, orbits, overview, pictures
from smidgen.show.plot import portraits, sphere, style, surfaces, text, view


# -- projection and hidden lines -------------------------------------------------------------

def test_view_is_a_rotation():
    m = view.View(71, -33).matrix
    assert np.allclose(m @ m.T, np.eye(3)) and np.isclose(np.linalg.det(m), 1)


def test_front_of_the_sphere_is_seen_and_the_back_is_not():
    w = np.random.default_rng(1).standard_normal((500, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    sight = view.View(10, 40)
    assert np.array_equal(view.visible(w, sight), w @ sight.matrix[2] >= 0)


@pytest.mark.parametrize("size", [1e-10, 1e-4, 1e10])
def test_what_is_hidden_does_not_depend_on_the_unit(size):
    w, sight = np.random.default_rng(1).standard_normal((500, 3)), view.View(10, 40)
    for casimir in (None, np.diag([2.0, 1.0, 0.5]), np.diag([1.0, 1.0, -1.0])):
        seen = view.visible(w, sight, casimir)
        assert np.array_equal(view.visible(size * w, sight, casimir), seen) and 0 < seen.sum() < 500
        assert casimir is None or np.array_equal(view.visible(w, sight, casimir / size ** 2), seen)


def test_a_leaf_in_another_unit_hides_the_same():
    turn = np.linspace(0, 2 * np.pi, 60)
    w, sight = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), view.View(10, 40)
    seen, small = (leaf.leaf_of(np.eye(3) / size ** 2, [size * w]).seen(size * w, sight) for size in (1, 1e-10))
    assert np.array_equal(seen, small) and 0 < seen.sum() < 60


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


def test_a_power_of_ten_in_prose_is_not_broken_over_lines():
    assert text.prose("at most 3e-04, x1e5 & 2e+10") == ('at most <span class="power">3\u00d710<sup>\u22124</sup></span>, x1e5 &amp; '
                                                         '<span class="power">2\u00d710<sup>10</sup></span>')
    assert "<span" not in text.prose(HOSTILE)


def test_a_hostile_title_is_drawn(top, tmp_path):
    hostile = result(top.w, HOSTILE, **top.values)
    for kind in ("sphere", "energy", "player"):
        path = draw.plot(hostile, kind=kind, out=tmp_path / f"x.{'html' if kind == 'player' else 'svg'}")
        assert path.stat().st_size > 1000
    page = (tmp_path / "x.html").read_text()
    assert page.count("<script") == 2 and "<b>" not in page


def test_json_refuses_nan():
    with pytest.raises(ValueError):
        text.in_script([float("nan")])


# -- every kind, every format ----------------------------------------------------------------

@pytest.mark.parametrize("kind", [k for k in pictures.KINDS if k not in ("player", "lattice", "places")])
def test_every_kind_draws_something_with_named_axes(kind, top):
    full = result(top.w, **top.values, **{"energy.kinetic": top.values["energy"], "mz": top.t})
    figure = style.styled(pictures.KINDS[kind][0])(full)
    for ax in figure.axes:
        drawn = len(ax.lines) + len(ax.collections) + len(ax.images)
        assert drawn > 0
        assert not ax.axison or ax.get_xlabel() or ax.get_ylabel()


LATTICE = """
[model]
name = "layers"
[space]
w = {{ sphere = {sites}, radius = 2 }}
p = {{ sphere = 2, tracer = true }}
[lattices.honey]
size = [4, 4]
sites = 2
boundary = "periodic"
bonds.all = [{{ from = 0, to = 1, offset = [0, 0] }}, {{ from = 0, to = 1, offset = [-1, 0] }}, {{ from = 0, to = 1, offset = [0, -1] }}]
[effects.exchange]
over = "bond(i, j) of {over} on w"
energy = "-dot(w[i], w[j])"
[starts.random]
w = {{ random = 1 }}
p = {{ random = 2 }}
"""
LAYERS = {      # a lattice; the directions that are drawn; the sites of the lowest layer, rows of numbers as they are drawn; what is said of it
    "film": ("square(5, 3, open)", 15, (0, 1), np.arange(15).reshape(3, 5), ""),
    "crystal": ("cubic(4, 3, 2, periodic)", 24, (0, 1), np.arange(12).reshape(3, 4), "the lowest of 2 layers"),
    "edge": ("cubic(1, 4, 5, open)", 20, (1, 2), np.arange(20).reshape(5, 4), ""),
    "ladder": ("square(12, 2, open)", 24, (0, 1), np.arange(24).reshape(2, 12), ""),
    "honeycomb": ("honey.all", 32, (0, 1), np.arange(32).reshape(4, 8), "schematic: the 2 sites of a cell side by side"),
}


def drawn_from(name, steps=9):
    """A run of a lattice, as `plot` has it."""
    spec = smidgen.load_text(LATTICE.format(over=LAYERS[name][0], sites=LAYERS[name][1]))
    return draw.result_of(smidgen.run(spec, start="random", h=0.1, steps=steps, what=["states"]), None)


@pytest.mark.parametrize("name", LAYERS)
def test_a_lattice_is_seen_from_above(name):
    _, _, (along, up), numbers, note = LAYERS[name]
    drawn, (rows, columns), sites = drawn_from(name), numbers.shape, 2 if name == "honeycomb" else 1
    assert pictures.suitable(drawn, False) == "lattice"
    figure = style.styled(pictures.draw_lattice)(drawn)
    *panels, bar = figure.axes
    assert len(panels) == 6 and bar.get_ylabel() and note in " ".join(t.get_text() for t in figure.texts) and "6 of 10 outputs" in figure.texts[-1].get_text().replace("\n", " ")
    assert [ax.get_xlabel() for ax in panels] == [""] * 3 + [f"cell of direction {along}"] * 3
    assert [ax.get_ylabel() for ax in panels] == [f"cell of direction {up}", "", ""] * 2
    for ax, k in zip(panels, np.linspace(0, 9, 6).astype(int)):
        shown, (image,) = drawn.w["w"][k][numbers] / 2, ax.images
        assert ax.get_title("left").startswith(f"$t$ = {drawn.t[k]:g}")
        assert image.origin == "lower" and image.get_extent() == [-0.5, columns / sites - 0.5, -0.5, rows - 0.5] and np.allclose(image.get_array(), shown[..., 2], atol=1e-15)
        assert len(ax.collections) == (name != "ladder") and ax.get_aspect() == ("auto" if name == "ladder" else 1)
        if not ax.collections:
            continue
        arrows, = ax.collections
        assert np.allclose(arrows.U, shown[..., 0].ravel()) and np.allclose(arrows.V, shown[..., 1].ravel())
        across = (np.arange(columns) + 0.5) / sites - 0.5
        assert np.allclose(arrows.XY, np.stack(np.meshgrid(across, np.arange(rows)), -1).reshape(-1, 2))
        assert arrows.scale_units == "xy" and np.isclose(arrows.scale, sites / 0.9) and len(ax.lines) == (columns // sites - 1 if sites > 1 else 0)


def test_a_lattice_at_periods_is_no_section_and_the_kind_is_told(tmp_path):
    """A section is for few sites, or for sites on no lattice; `plot` tells what it has chosen, not what was asked for."""
    drawn, told = drawn_from("film"), []
    assert pictures.suitable(dataclasses.replace(drawn, meta={**drawn.meta, "period": 1.0}), False) == "lattice"
    assert pictures.suitable(dataclasses.replace(drawn, meta={**drawn.meta, "period": 1.0, "grids": {}}), False) == "section"
    for kind in ("auto", "components"):
        draw.plot(drawn, kind=kind, out=tmp_path / f"{kind}.png", chose=told.append)
    assert told == ["lattice"]


def test_a_schematic_says_whether_places_are_known():
    """Also: a wide lattice has a flat page, and cells are counted in whole numbers."""
    assert "does not say where they stand" in lattice.schematic(2, False) and "--kind places draws them where they stand" in lattice.schematic(2, True)
    w = np.ones((2, 3, 12, 1, 3))
    figure = lattice.lattice_images(np.arange(2.0), w)
    assert figure.get_figheight() < 0.35 * figure.get_figwidth()
    assert all(tick == round(tick) for tick in [*figure.axes[0].get_xticks(), *figure.axes[0].get_yticks()])


@pytest.mark.filterwarnings("error")
def test_spins_that_all_point_up_are_drawn(tmp_path):
    drawn = drawn_from("film", steps=3)
    drawn.w["w"][:] = [0, 0, 2]
    draw.plot(drawn, kind="lattice", out=tmp_path / "up.png")
    below = [ax.get_xlabel() != "" for ax in style.styled(pictures.draw_lattice)(drawn).axes[:4]]
    assert below == [False, True, True, True]


LINES = """
[model]
name = "lines"
[space]
w = { sphere = "n" }
[parameters]
n = 49
[effects.line]
over = "bond(i, j) of chain(n, open)"
energy = "-dot(w[i], w[j])"
[effects.film]
over = "bond(i, j) of square(7, 7, open)"
energy = "dot(w[i], w[j])"
[starts.random]
random = 1
"""


def test_what_a_run_does_not_call_is_no_lattice_of_it():
    """Here it would not even fit the sites."""
    spec = smidgen.load_text(LINES)
    for values, effects, wanted in ({}, ["film"], ((7, 7), 1)), ({"n": 30}, ["line"], ((30,), 1)):
        drawn = draw.result_of(smidgen.run(spec, start="random", h=0.1, steps=2, what=["states"], effects=effects, parameters=values), None)
        assert drawn.meta["grids"] == {"w": wanted}
        assert (pictures.suitable(drawn, False) == "lattice") == (effects == ["film"])


@pytest.mark.parametrize("run, said", [("noise", "'noise' cannot select another$"), ("picture.png", "use --out picture.png")])
def test_a_result_has_no_runs(top, run, said):
    with pytest.raises(UsageError, match=said):
        draw.plot(top, run, kind="sphere")


def test_a_chain_is_no_such_lattice(ring):
    with pytest.raises(UsageError, match="this result has no lattice of two or three directions: use the kind 'chain'"):
        pictures.draw_lattice(ring)


@pytest.mark.parametrize("ending", tiers(style.FORMATS, (), ("svg",)))
def test_same_result_same_bytes(ending, top, tmp_path):
    a, b = (draw.plot(top, kind="energy", out=tmp_path / f"{n}.{ending}").read_bytes() for n in "ab")
    assert a == b and len(a) > 1000


def test_svg_of_a_sphere_has_the_same_bytes_and_no_date(top, tmp_path):
    a, b = (draw.plot(top, kind="sphere", out=tmp_path / f"{n}.svg").read_bytes() for n in "ab")
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
    draw.plot(top, kind="energy", out=tmp_path / "a.png")
    assert dict(matplotlib.rcParams) == before


# -- errors ----------------------------------------------------------------------------------

@pytest.mark.parametrize("kind, out, words", [
    ("energie", None, "did you mean 'energy'"), ("energy", "a.gif", "omit --kind"),
    ("player", "a.png", ".html"), ("energy", "a.html", "player"), ("auto", "a.tiff", "must end in"),
])
def test_wrong_wishes_are_usage_errors(kind, out, words, top, tmp_path):
    with pytest.raises(UsageError, match=re.escape(words)):
        draw.plot(top, kind=kind, out=None if out is None else tmp_path / out)


def test_missing_columns_say_what_to_ask_for(top, tmp_path):
    bare = Result(top.meta, top.step, top.t, None, {})
    for kind in pictures.KINDS:
        with pytest.raises(UsageError, match="--what"):
            draw.plot(bare, kind=kind, out=tmp_path / ("a.html" if kind == "player" else "a.png"))


def test_a_folder_that_cannot_be_written(top, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot write"):
        draw.plot(top, kind="energy", out=tmp_path / "file" / "a.png")
    with pytest.raises(UsageError, match="cannot write"):
        draw.plot(top, kind="player", out=tmp_path / "file" / "a.html")


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
            draw.plot(spoilt, kind=kind, out=tmp_path / ("a.html" if kind == "player" else "a.png"))
        except UsageError as error:
            assert how in ("all nan", "zero", "huge", "tiny") or "two outputs" in str(error)


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
