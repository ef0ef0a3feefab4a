"""A browser shows a lattice at its places: by WebGL2, in software; without it the sphere."""
import json
import re

import numpy as np
import pytest
from support.pictures import result
from test_player import in_browser, with_browser

from smidgen.show.plot import draw

SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
SPEC = """
[model]
name = "slab"
[space]
w = { sphere = 24 }
[effects.exchange]
over = "bond(i, j) of cubic(4, 3, 2, open)"
energy = "-dot(w[i], w[j])"
"""
ASK = """<script>
addEventListener("error", (event) => { document.title = JSON.stringify({ error: event.message }); });
const el = (id) => document.getElementById(id), said = {}, scene = el("scene");
scene.setPointerCapture = () => {};
const set = (id, value) => { el(id).value = value; el(id).dispatchEvent(new Event("change", { bubbles: true })); };
const ask = (name, x, y, looks) => { const box = scene.getBoundingClientRect(); scene.dispatchEvent(new PointerEvent(name,
  { bubbles: true, cancelable: true, pointerId: 1, clientX: box.left + x, clientY: box.top + y, ...looks })); };
const press = (key) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
function colours() {                        // of the field: pixels that something covers, and how many colours
  const gl = el("field").getContext("webgl2"), size = 4 * gl.drawingBufferWidth * gl.drawingBufferHeight, p = new Uint8Array(size), seen = new Set();
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, p);
  let many = 0;
  for (let i = 0; i < size; i += 4) if (p[i + 3] > 0) { many++; seen.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]); }
  return [many, seen.size];
}
setTimeout(() => {
  const P = window.player, it = P.it;
  said.view = it.view; said.without = el("note").textContent; said.offered = !el("view").hidden;
  if (it.view === "sphere") { press("v"); said.view = it.view; document.title = JSON.stringify(said); return; }
  said.all = colours();
  set("marks", "cells"); said.cells = colours(); set("marks", "arrows");
  set("slice", "z"); said.layers = Number(el("layer").max) + 1; said.layer = Number(el("layer").value); said.at = el("layerat").textContent;
  said.layered = el("note").textContent; said.slice = colours();
  const middle = [it.width / 2 - it.cameras.places.aside, it.height / 2], unit = it.cameras.places.unit;
  ask("pointermove", middle[0] + 0.5 * unit, middle[1] - unit); said.hover = el("told").hidden ? "" : el("told").textContent;
  ask("pointermove", 3, 3); said.left = el("told").hidden;
  ask("pointerdown", middle[0] + 0.5 * unit, middle[1]); ask("pointerup", middle[0] + 0.5 * unit, middle[1]);
  said.spoken = el("spoken").textContent; said.ring = !el("site").hidden;
  set("colour", [...el("colour").options].findIndex((o) => o.textContent === "energy.exchange")); said.range = el("range").textContent;
  said.named = el("site").textContent.split("\\n").pop(); said.key = el("key").getAttribute("aria-label");
  said.colours = [...el("colour").options].map((o) => o.textContent);
  press("End"); said.end = it.now; said.value = el("slider").getAttribute("aria-valuetext"); press("Home"); said.home = it.now;
  set("series", 1); said.series = [...el("series").options].map((o) => o.textContent);
  press("v"); said.sphere = it.view; press("v"); said.back = it.view;
  press("?"); said.keys = el("keys").open;
  said.named_controls = [...document.querySelectorAll("button, select, input, canvas[role]")].every((e) => e.getAttribute("aria-label") || e.textContent || e.closest("label") || e.title);
  HTMLAnchorElement.prototype.click = function () { said.file = this.download; document.title = JSON.stringify(said); };
  HTMLCanvasElement.prototype.toBlob = function (then) { said.wide = this.width; then(new Blob([])); };     // a headless browser may take its time
  el("picture").click();
}, 600);
</script></body>"""


def slab():
    """Spins that turn about z, each from an azimuth of its own; site 23 is missing."""
    i, t = np.arange(24), np.arange(5)[:, None]
    w = np.stack([np.cos(i + 0.1 * t), np.sin(i + 0.1 * t), 0 * i + 0 * t], axis=-1)
    w[:, 23] = 0
    made = result({"w": w}, "A slab", energy=np.arange(5.0), mz=np.arange(5.0) ** 2)
    made.meta.update(spec="slab", sources=[["slab.toml", SPEC]], effects=["exchange"], parameters={})
    return made


def told(made, folder, *flags):
    path = draw.plot(made, kind="player", out=folder / "p.html")
    path.write_text(path.read_text().replace("</body>", ASK))
    page = in_browser(path, folder, *flags)
    return json.loads(re.search(r"<title>(.*?)</title>", page).group(1).replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&"))


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    found = told(slab(), tmp_path_factory.mktemp("slab"), *SOFTWARE)
    if found.get("view") == "sphere":
        pytest.skip("this browser has no WebGL2, not even in software")
    return found


@with_browser
def test_arrows_and_cells_are_drawn(said):
    """In many colours; a slice shows fewer."""
    assert said.get("error") is None and said["view"] == "places" and said["offered"]
    assert said["all"][0] > 2000 and said["all"][1] > 100 and said["cells"][0] > said["all"][0]
    assert 500 < said["slice"][0] and said["layers"] == 2 and "12 of 24 sites seen" in said["layered"]


@with_browser
def test_a_site_is_named_with_its_cell_and_vector(said):
    """The layer z = 1 from above: half a cell right of the middle and one up is cell (2, 2, 1), which is site 22."""
    name, vector = said["hover"].replace("\u2212", "-").split("\n")
    assert said["layer"] == 1 and said["at"] == "2 of 2" and name == "w[22], cell (2, 2, 1)" and said["left"]
    assert [float(x) for x in re.findall(r"[-.\d]+", vector)] == pytest.approx([np.cos(22), np.sin(22), 0], abs=2e-4)
    assert said["spoken"].startswith("w[18], cell (2, 1, 1)\nw = (") and said["ring"]


@with_browser
def test_a_map_colours_and_is_told(said):
    """Of site 18 half of its four bonds: to 14 and 22, 17 and 19 (and 6 below)."""
    assert said["colours"] == ["direction", "w_x / |w|", "w_y / |w|", "w_z / |w|", "energy.exchange"]
    wanted = -0.5 * sum(np.cos(18 - j) for j in (14, 22, 17, 19, 6))
    name, _, value = said["named"].partition(" = ")
    assert name == "energy.exchange" and float(value.replace("\u2212", "-")) == pytest.approx(wanted, abs=0.02)
    assert said["key"].startswith("Key: energy.exchange") and " to " in said["range"]


@with_browser
def test_keys_controls_and_files(said):
    assert said["end"] == 4 and said["home"] == 0 and said["value"].startswith("t = 0.4, energy H")
    assert (said["sphere"], said["back"]) == ("sphere", "places") and said["keys"] and said["named_controls"]
    assert said["series"] == ["H \u2212 H\u2080", "energy", "mz"] and said["file"] == "A_slab_demo.png" and said["wide"] > 300


@with_browser
def test_without_webgl_the_sphere_is_shown(tmp_path):
    found = told(slab(), tmp_path, "--disable-3d-apis")
    assert found == {"view": "sphere", "without": "this browser has no WebGL2: sites are shown on the sphere alone", "offered": False}
