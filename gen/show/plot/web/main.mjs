// The player: reads its data, makes its controls, draws.
import { it, el, camera } from "./state.mjs";
import { load } from "./load.mjs";
import { PAPER, dark, fit, inks, look, night, reset, times3, turned } from "./camera.mjs";
import { clockText, go, play, SPEEDS } from "./clock.mjs";
import { channels, drawKey } from "./colours.mjs";
import { canFilm, filmed, savePicture, saveVideo } from "./files.mjs";
import { listen } from "./hands.mjs";
import { perCell, placed } from "./lattice.mjs";
import { makeLegend } from "./legend.mjs";
import { drawPicked } from "./names.mjs";
import { channel, drawPlaces, finish, fitAll, flatLattice, measured, prepare } from "./places.mjs";
import { drawSphere } from "./sphere.mjs";
import { drawStrip, nothing } from "./strip.mjs";
import { show } from "./state.mjs";

const scene = el("scene"), strip = el("errors");
const g = scene.getContext("2d"), e = strip.getContext("2d"), KEY = 118;
let keyed = "";

// ---- drawing ----
function triad() {                          // where x, y and z point, in a corner
  const above = it.height - 24 - el("keybox").offsetHeight - 52, from = above > 60 ? [it.width - 74, above] : [34, it.height - 58], long = 22;
  g.font = "italic 12px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle"; g.lineWidth = 1.2;
  ["x", "y", "z"].forEach((name, k) => {
    const v = [0, 0, 0]; v[k] = 1;
    const p = times3(camera().turn, v), tip = [from[0] + long * p[0], from[1] - long * p[1]];
    if (Math.hypot(p[0], p[1]) < 0.05) return;
    g.strokeStyle = g.fillStyle = inks().ink;
    g.beginPath(); g.moveTo(...from); g.lineTo(...tip); g.stroke();
    g.fillText(name, from[0] + 1.45 * long * p[0], from[1] - 1.45 * long * p[1]);
  });
}
function placesView() {
  g.clearRect(0, 0, it.width, it.height);
  el("stage").classList.remove("sheet");
  const words = drawPlaces();
  drawnKey();
  triad();
  return words;
}
function drawnKey() {
  const one = channel(), now = `${one.name} ${dark()} ${it.view} ${window.devicePixelRatio}`;
  if (keyed === now) return;
  keyed = now;
  const key = el("key"), high = one.kind === 0 ? KEY : 40;
  el("keybox").hidden = it.view !== "places";
  key.style.width = KEY + "px"; key.style.height = KEY + "px";
  drawKey(fit(key, key.getContext("2d"), KEY, KEY), one, KEY, inks().soft);
  const range = one.kind === 0 ? "direction of w, rim: \u2212z" : `${one.name}: ${show(one.low)} to ${show(one.high)}${one.unit ? " " + one.unit : ""}`;
  key.setAttribute("aria-label", one.kind === 0 ? "Key: hue shows the azimuth of w, lightness its z" : `Key: ${range}`);
  el("range").textContent = range;
  el("keybox").classList.toggle("bar", high < KEY);
}
function draw() {
  const words = it.view === "places" ? placesView() : drawSphere(g);
  drawPicked(g);
  el("clock").textContent = clockText();
  el("note").textContent = [it.without, words].filter((part) => part).join("; ");
  if (it.view === "sphere") drawnKey();
  drawStrip(e);
  filmed();
}

// ---- sizes ----
function resize() {
  const box = scene.getBoundingClientRect(), below = strip.getBoundingClientRect();
  if (it.printing || matchMedia("print").matches) return toPaper();
  if (box.width * box.height > 0) size(box.width, box.height, below.width, below.height);     // else hidden
}
function size(wide, high, stripWide, stripHigh) {
  it.width = wide; it.height = high;
  it.strip = { width: stripWide, height: stripHigh };
  fit(scene, g, wide, high); fit(strip, e, stripWide, stripHigh);
  el("field").width = scene.width; el("field").height = scene.height;
  it.draw();
}
// On paper the canvases are pictures of a size of their own: a frame that was never on the screen has none yet.
function toPaper() { if (it.width !== PAPER[0] || it.height !== PAPER[1]) size(PAPER[0], PAPER[1], PAPER[0], PAPER[2]); }

// ---- controls ----
function choices(id, names, chosen, values = names.keys()) {
  const list = [...values];
  el(id).replaceChildren(...names.map((name, k) => {
    const option = document.createElement("option");
    option.textContent = name; option.value = list[k]; option.selected = k === chosen;
    return option;
  }));
}
function changes(id, what = () => it.draw()) { el(id).addEventListener(el(id).tagName === "BUTTON" ? "click" : "change", what); }

function setView(view) {
  it.view = view;
  el("player").dataset.view = view;
  el("legend").hidden = view === "places" && it.families.length < 2;
  el("field").style.visibility = view === "places" ? "visible" : "hidden";
  el("view").textContent = view === "places" ? "Show the sphere" : "Show the lattice";
  scene.setAttribute("aria-label", (view === "places" ? "Sites at their places" : "Sites on the sphere") + ". Drag to turn; Ctrl and wheel, or wheel after a click, to zoom");
}
function tellLayer() { el("layerat").textContent = `${Number(el("layer").value) + 1} of ${Number(el("layer").max) + 1}`; }
function chosenSlice() {                    // seen from the side on which it lies flat
  const axis = "xyz".indexOf(el("slice").value), many = axis < 0 ? 0 : measured().layers[axis].length;
  el("layer").max = Math.max(0, many - 1); el("layer").value = Math.floor(many / 2);
  el("layerbox").hidden = many < 2;
  tellLayer();
  if (axis >= 0) camera().turn = turned(...[[0, 0], [-90, 0], [-90, 90]][axis]);
  else reset();
  it.draw();
}
function first() {                          // the side from which a lattice is seen at first
  const m = measured();
  return m.directions === 3 ? [-65, 24] : m.directions < 2 ? [-80, 20] : m.plane ? [-90, 90] : [-65, 24];
}
function makePlaces() {
  const most = Math.max(...placed().map(perCell)), m = measured();
  choices("colour", channels().map((c) => c.name), 0);
  choices("slice", ["none", "x", "y", "z"], 0, ["none", "x", "y", "z"]);
  const widest = placed().find((f) => perCell(f) === most);
  choices("sublattice", ["all", ...(most > 1 ? widest.cell.names : [0])], 0, ["all", ...Array(most).keys()]);
  choices("marks", ["arrows", "cells, arrows", "cells", "every arrow"], 0, ["arrows", "cells, arrows", "cells", "all"]);
  el("slicebox").hidden = m.directions < 3; el("sublatticebox").hidden = most < 2; el("isobox").hidden = !placed().some((f) => f.triangles); el("layerbox").hidden = true;
  it.cameras.places = { first: first(), home: turned(...first()) };
  setView("places"); reset();
  el("marks").value = flatLattice() && fitAll() < 13 ? "cells, arrows" : "arrows";
}
function makeControls() {
  choices("speed", SPEEDS.map(([name]) => name), 2);
  choices("trail", ["none", "short", "medium", "whole"], it.data.trail);
  choices("series", [...(it.errors ? ["H \u2212 H\u2080"] : []), ...it.series.map((s) => s.name)], 0);
  changes("play", () => play(!it.playing));
  el("slider").addEventListener("input", (event) => { play(false); go(event.target.value / 1000 * (it.frames - 1)); });
  el("layer").addEventListener("input", () => { tellLayer(); it.draw(); });
  ["trail", "colour", "sublattice", "marks", "series", "isolines"].forEach((id) => changes(id));
  changes("slice", chosenSlice);
  changes("reset", () => { reset(); it.draw(); });
  changes("view", () => { setView(it.view === "places" ? "sphere" : "places"); it.picked = null; it.draw(); });
  changes("picture", savePicture); changes("video", saveVideo);
  changes("full", () => document.fullscreenElement ? document.exitFullscreen() : el("player").requestFullscreen());
  el("full").hidden = !document.fullscreenEnabled; el("video").hidden = !canFilm();
}

// ---- start ----
function open() {
  el("title").textContent = it.data.title;
  el("facts").textContent = it.data.facts;
  makeControls();
  if (nothing()) el("strip").classList.add("none");
  el("series").hidden = it.series.length + (it.errors ? 1 : 0) < 2;
  makeLegend();
  it.cameras.sphere = { first: it.data.view };
  setView("sphere"); reset();
  it.now = it.data.start * (it.frames - 1);
  resize();
  lattice();
  it.draw = draw;
  listen();
  addEventListener("beforeprint", () => { it.printing = true; toPaper(); });
  addEventListener("afterprint", () => { it.printing = false; resize(); });
  night.addEventListener("change", () => it.draw());
  new ResizeObserver(resize).observe(el("stage"));
  resize();
  go(it.now);
  if (it.data.autoplay && !matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
}
function lattice() {                        // the places, where there are any and they can be drawn
  const any = placed().length > 0, able = any && drawable();
  el("view").hidden = !able;
  if (any && !able && !it.without) it.without = "this browser has no WebGL2: sites are shown on the sphere alone";
  if (able) makePlaces();
}
function drawable() {
  el("field").addEventListener("webglcontextlost", () => onlySphere("the graphics card has stopped: sites are shown on the sphere alone"));
  try { return prepare(el("field")); } catch (problem) { onlySphere(`sites are shown on the sphere alone: ${problem.message}`); }
  return false;
}
function onlySphere(why) {
  it.without = why; it.picked = null;
  el("view").hidden = true;
  setView("sphere"); it.draw();
}
window.player = { it, go, finish };         // for who measures
load().then(open).catch((problem) => {
  el("facts").textContent = `This page cannot be shown here: ${problem.message}`;
  throw problem;
});
