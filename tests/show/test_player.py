"""The player: what its page carries, what a browser does with it, and the page that frames it."""
import base64
import dataclasses
import json
import re
import shutil
import subprocess
import zlib

import numpy as np
import pytest
from support.pictures import FILM_BONDS, HOSTILE, data_of, film, pairs_of, result, top  # noqa: F401

from smidgen.errors import UsageError
from smidgen.show.demo.stages import WORDS
from smidgen.show.plot import draw, pictures, player
from smidgen.show.plot.gallery import Picture, Row, gallery


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


def test_a_player_without_a_leaf(top):
    w = np.tile([[[1.0, 1.0, 0.3]]], (10, 1, 1))
    page = player.player_page(top.t[:10], {"w": w}, casimirs={"w": np.diag([1.0, -1.0, 0.0])})
    assert data_of(page)["backdrop"] == []


# -- in a browser ----------------------------------------------------------------------------

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


def in_browser(page, folder, *flags):
    """What the page has become when its script has run for two seconds."""
    return subprocess.run(
        [CHROMIUM, *flags, "--no-sandbox", "--headless=new", "--disable-gpu", "--virtual-time-budget=2000",
         f"--user-data-dir={folder}/profile", "--dump-dom", f"file://{page}"],
        capture_output=True, text=True, timeout=120).stdout


@with_browser
def test_player_turns_and_plays(top, tmp_path):
    """Drag, slider and button, sent as events: the picture and the clock change.

    Frames are asked for by a timer: a browser without a window draws few of its own.
    """
    page = draw.plot(top, kind="player", out=tmp_path / "p.html")
    page.write_text(page.read_text().replace("</body>", HANDS))
    said = json.loads(re.search(r"<title>(.*?)</title>", in_browser(page, tmp_path)).group(1))
    assert said["turned"] and said["button"] == "Pause"
    half, later = (float(re.search(r"t = ([0-9.]+)", said[k]).group(1)) for k in ("half", "later"))
    assert half == pytest.approx(10.0, abs=0.05) and half < later < 20


@with_browser
def test_player_in_a_browser(top, tmp_path):
    """A headless browser shows user text as text, and the time."""
    hostile = result(top.w, HOSTILE, **top.values)
    page = draw.plot(hostile, kind="player", out=tmp_path / "p.html")
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
  if (!el("view").hidden) el("view").click();     // sites stand on a lattice: to the sphere
  discs.length = lines.length = 0;
  el("trail").value = 0; el("trail").dispatchEvent(new Event("change"));
  const all = discs.filter(([c]) => part(c) === "scene");
  said.spots = all.map(([, d, color]) => [...d, color]);
  said.segments = lines.filter(([c]) => part(c) === "scene").map(([, s]) => s);
  said.keys = before.filter(([c]) => part(c) === "legend").map(([, d, color]) => [...d, color]);
  said.wheel = { plain: zooms({}), ctrl: zooms({ ctrlKey: true }) };
  scene.matches = () => false;                    // as after a click of a mouse, which is no :focus-visible
  ask(scene, "pointerdown", { clientX: 9, clientY: 9 }); scene.focus(); ask(scene, "pointerup");
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
    path = draw.plot(made, kind="player", out=folder / "p.html")
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
    """The first click arms it, which also gives the canvas the focus."""
    assert film_said["wheel"] == {"plain": False, "ctrl": True, "clicked": True, "left": False}


@with_browser
def test_a_player_that_is_hidden_keeps_its_picture(film_said):
    """A frame has no size while a page is laid out for paper; what it showed is what is printed."""
    assert film_said["kept"]


def streams_of(pdf):
    """What the pages of a PDF draw, unpacked."""
    for raw in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.S):
        try:
            yield zlib.decompress(raw)
        except zlib.error:
            continue


def scales_of(pdf):
    """[(horizontal, vertical)] of every matrix with which the pages of a PDF scale what they draw."""
    every = [stream.split() for stream in streams_of(pdf)]
    return [tuple(np.linalg.norm(np.array(words[k - 6:k - 2], float).reshape(2, 2), axis=1))
            for words in every for k, word in enumerate(words) if word == b"cm"]


@with_browser
@pytest.mark.parametrize("frame", [False, True])
def test_a_printed_player_has_its_sphere_in_its_aspect(top, tmp_path, frame):
    """By itself, and far down in a page, where its frame was never on the screen: one ball, shaded, scaled equally both ways."""
    page = pictures.draw_player(top)
    path = tmp_path / "p.html"
    path.write_text(f"<html><body><p style='height: 4000px'></p>{player.framed(page)}</body></html>" if frame else page)
    subprocess.run([CHROMIUM, "--no-sandbox", "--headless=new", "--disable-gpu", "--window-size=1400,700",
                    "--virtual-time-budget=2000", f"--user-data-dir={tmp_path}/profile",
                    f"--print-to-pdf={tmp_path}/p.pdf", f"file://{path}"], capture_output=True, timeout=120)
    pdf = (tmp_path / "p.pdf").read_bytes()
    assert pdf.count(b"/ShadingType 3") == 1             # the radial gradient of the ball, drawn as a vector
    assert len(scales_of(pdf)) > 3 and all(wide == pytest.approx(high, rel=0.01) for wide, high in scales_of(pdf))


# -- the page of the demo --------------------------------------------------------------------

def moving(top):
    """A sphere that moves, from the path of the top: its dots, and a trail."""
    w = top.w["w"] / np.linalg.norm(top.w["w"], axis=2, keepdims=True)
    layers = [{"name": HOSTILE, "kind": "dots", "colors": ["#0072b2"], "w": w}, {"name": "", "kind": "trails", "colors": ["#d55e00"], "w": -w}]
    return {"layers": layers, "backdrop": [w[:, 0]], "view": (35, 22), "seconds": 9}


@pytest.fixture(scope="module")
def demo_page(top, tmp_path_factory):
    """index.html with three spheres that move, a table, a figure and a system with its player."""
    folder = tmp_path_factory.mktemp("page")
    picture, played = draw.plot(top, kind="sphere", out=folder / "e 1.svg"), draw.plot(top, kind="player", out=folder / "p.html")
    spheres = [Picture(f"s{k}", picture, "One drifts", "Words of some length, as they stand below each.", part="opening", number="Figure 4", moving=moving(top)) for k in range(3)]
    return gallery(folder / "out", [("system", "criterion:"), ("error *", "\u2264 1"), ("note", "")],
                   [Row((HOSTILE, "1e-3", "fine"), True), Row(("b", "2", "bad"), False)],
                   [*spheres, Picture("e", picture, HOSTILE, "words", number="Figure 1"), Picture("p", picture, "Played", part="systems", player=played)],
                   dataclasses.replace(WORDS, made="by hand"))


def test_the_page_is_small_and_has_its_pictures_beside_it(demo_page):
    words = demo_page.read_text()
    assert len(words) < 100_000 and "base64," not in words and "http:" not in words
    assert re.findall(r"https://[^\"]*", words) == ["https://doi.org/10.1090/mcom/3153"]       # a link: nothing is loaded from a network
    for source in re.findall(r'(?:src|class="play" href)="([^"]*)"', words):
        assert (demo_page.parent / source.replace("%20", " ")).is_file()
    assert words.count("<img") == 5 and words.count("<canvas") == 3 and words.count('class="play"') == 1
    assert len(re.findall(r'<img alt="[^"]+"', words)) == 5 and "<b>bold" not in words and "<iframe" not in words
    assert 'class="bad"' in words and "FAILED" in words and "\u2264 1" in words and words.count("<script") == 2


LAYOUT = """<script>
addEventListener("load", () => setTimeout(() => {
  const bottom = (what) => [...document.querySelectorAll(what)].map((e) => Math.round(e.getBoundingClientRect().bottom));
  const painted = [...document.querySelectorAll("canvas")].map((c) => {
    const p = c.getContext("2d").getImageData(0, 0, c.width, c.height).data, seen = new Set();
    for (let i = 0; i < p.length; i += 4) if (p[i + 3] === 255) seen.add(p[i] - p[i + 2] > 60 ? "orange" : p[i + 2] - p[i] > 60 ? "blue" : "ball");
    return [...seen].sort().join() + (c.width === c.height ? "" : " of another shape");
  });
  const said = { headline: bottom("h1"), doi: bottom(".paper a"), canvas: bottom("canvas"), painted, button: document.getElementById("motion").textContent,
                 wide: document.documentElement.scrollWidth - document.documentElement.clientWidth };
  document.querySelector("a.play").click();
  said.player = document.querySelectorAll("iframe").length;
  parent.postMessage(JSON.stringify(said), "*");
}, 800));
</script></body>"""


def page_said(page, folder, size, *flags):
    """What a browser shows in a frame of this size."""
    (page.parent / "told.html").write_text(page.read_text().replace("</body>", LAYOUT))
    frame = page.parent / "frame.html"
    frame.write_text(f'<script>onmessage = (e) => {{ document.title = e.data; }};</script><title></title><iframe width="{size[0]}" height="{size[1]}" src="told.html">')
    return json.loads(re.search(r"<title>(.*?)</title>", in_browser(frame, folder, *flags)).group(1))


@with_browser
@pytest.mark.parametrize("size, spheres", [((1440, 900), 3), ((390, 844), 1)])
def test_the_first_screen_says_what_was_shown(demo_page, tmp_path, size, spheres):
    """The headline, the paper and the spheres, painted, round and in motion; on a phone the first of them, and nothing wider than the screen."""
    said = page_said(demo_page, tmp_path, size)
    assert said["headline"][0] < said["doi"][0] < said["canvas"][0] and sum(b <= size[1] for b in said["canvas"]) == spheres
    assert said["painted"] == ["ball,blue,orange"] * 3 and said["button"] == "Pause" and said["wide"] == 0 and said["player"] == 1


@with_browser
def test_who_wants_less_motion_gets_none(demo_page, tmp_path):
    said = page_said(demo_page, tmp_path, (1440, 900), "--force-prefers-reduced-motion")
    assert said["button"] == "Play" and said["painted"] == ["ball,blue,orange"] * 3


@with_browser
def test_the_printed_page_has_all_spheres(demo_page, tmp_path):
    """The shaded ball of each of the five pictures, which is an image with transparent corners, is drawn."""
    subprocess.run([CHROMIUM, "--no-sandbox", "--headless=new", "--disable-gpu", "--virtual-time-budget=3000", f"--user-data-dir={tmp_path}/profile",
                    f"--print-to-pdf={tmp_path}/p.pdf", f"file://{demo_page}"], capture_output=True, timeout=120)
    pdf = (tmp_path / "p.pdf").read_bytes()
    balls = [number for number, body in re.findall(rb"(\d+) 0 obj\s*<<(.*?)>>", pdf, re.S) if b"/Subtype /Image" in body and b"/SMask" in body]
    assert sum(words.count(b"/X%s Do" % number) for words in streams_of(pdf) for number in balls) == 5
