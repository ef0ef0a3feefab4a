// The view: rows of the rotation are right, up, towards the viewer.
import { it, camera } from "./state.mjs";

export const PAPER = [760, 520, 112];       // width, height of the scene and of the strip on paper

export function turned(azimuth, elevation) {
  const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
  const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
  return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
}
export function look(azimuth, elevation) {
  Object.assign(camera(), { turn: turned(azimuth, elevation), zoom: 1, pan: [0, 0] });
}
export function reset() { look(...camera().first); }

export function times3(m, v) {
  return [0, 1, 2].map((i) => m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2]);
}
export function drag(dx, dy) {              // turn about the screen's up and right axes
  const ca = Math.cos(dx), sa = Math.sin(dx), cb = Math.cos(dy), sb = Math.sin(dy);
  const yaw = [[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]];
  const pitch = [[1, 0, 0], [0, cb, -sb], [0, sb, cb]];
  const cols = [0, 1, 2].map((j) => times3(pitch, times3(yaw, camera().turn.map((r) => r[j]))));
  camera().turn = [0, 1, 2].map((i) => cols.map((c) => c[i]));
}
export function zoom(factor, x = it.width / 2, y = it.height / 2) {     // about a point of the screen
  const c = camera(), old = c.zoom, most = it.view === "sphere" ? 12 : 200;
  c.zoom = Math.min(Math.max(old * factor, 0.4), most);
  if (it.view === "sphere") return;
  const grown = c.zoom / old, from = [x - it.width / 2 + (c.aside || 0), y - it.height / 2];
  c.pan = c.pan.map((p, d) => from[d] - grown * (from[d] - p));
}
export function pan(dx, dy) {
  if (it.view === "places") camera().pan = [camera().pan[0] + dx, camera().pan[1] + dy];
}

// ---- canvases ----
export function fit(canvas, context, wide, high) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(wide * ratio));
  canvas.height = Math.max(1, Math.round(high * ratio));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}

// ---- light and dark: the ball is light in both, and colours are made for it; leaves stand on a light sheet ----
export const night = matchMedia("(prefers-color-scheme: dark)");
export const LIGHT = { ink: "#2b3138", soft: "#5b6570", line: "#e3e6ea", halo: "#ffffff" };
const DARK = { ink: "#e8ecf1", soft: "#a5b0bc", line: "#303030", halo: "#161616" };
export const dark = () => night.matches && !it.printing && !matchMedia("print").matches;
export const inks = () => dark() ? DARK : LIGHT;
export function pale(color) {               // halfway to white, for a line on a dark ground
  const part = (k) => Math.round((parseInt(color.slice(k, k + 2), 16) + 255) / 2);
  return `rgb(${part(1)},${part(3)},${part(5)})`;
}
