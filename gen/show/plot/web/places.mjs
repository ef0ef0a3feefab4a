// Sites at their places: cells, bonds and arrows, drawn by WebGL2.
import { it, el, camera } from "./state.mjs";
import { inks } from "./camera.mjs";
import { channels } from "./colours.mjs";
import { attribute, pointed, program, refill, table, use } from "./gl.mjs";
import { isolines } from "./isolines.mjs";
import { fitted, measure, perCell, placed, project, seenSites, slice, sparse } from "./lattice.mjs";
import { ARROWS, CELLS, LINES } from "./shaders.mjs";
import { arrow, cone } from "./shapes.mjs";

const READABLE = 13;                        // pixels between arrows that can be read
const LINKS = 400000;                       // most bonds drawn
const DETAIL = [[600, () => arrow(14)], [2500, () => arrow(6)], [6000, () => cone(5)], [Infinity, () => null]];   // most sites, their shape; null: a triangle
let gl = null, programs = null, m = null, sets = [], tables = {};

export function prepare(canvas) {           // can sites be drawn at their places here?
  const many = placed().reduce((sum, f) => sum + f.count, 0);
  gl = canvas.getContext("webgl2", { antialias: many < (inSoftware() ? 2000 : 20000), preserveDrawingBuffer: true });
  if (!gl) return false;
  programs = { arrows: program(gl, ARROWS), cells: program(gl, CELLS), lines: program(gl, LINES) };
  tables = Object.fromEntries(Object.entries(it.data.tables).map(([name, colors]) => [name, table(gl, colors)]));
  m = measure();
  sets = placed().map((f) => ({ f, cells: layer(null), arrows: null, lines: lines(f), levels: curves() }));
  return true;
}
function inSoftware() {                     // is there no graphics card?
  const probe = document.createElement("canvas").getContext("webgl2"), more = probe && probe.getExtension("WEBGL_debug_renderer_info");
  return !!more && /swiftshader|llvmpipe|software/i.test(probe.getParameter(more.UNMASKED_RENDERER_WEBGL));
}
export const measured = () => m;
export const flatLattice = () => m.plane;

// ---- buffers ----
function layer(shape) {                     // a shape, and what each of its instances has; without one, three corners a site
  const vao = gl.createVertexArray(), each = shape ? 1 : 0;
  gl.bindVertexArray(vao);
  if (shape) for (const [k, numbers] of shape.entries()) attribute(gl, k, numbers, 3, { each: 0 });
  const made = { vao, instances: !!shape, each, corners: shape ? shape[0].length / 3 : 3, sites: new Int32Array(0), frame: -1,
                 place: attribute(gl, 2, new Float32Array(3), 3, { each }), before: attribute(gl, 3, new Int16Array(3), 3, { each }),
                 after: attribute(gl, 4, new Int16Array(3), 3, { each }), value: attribute(gl, 5, new Uint8Array(2), 2, { each, normalized: true }) };
  gl.bindVertexArray(null);
  return made;
}
function lines(f) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  attribute(gl, 2, f.places, 3, { each: 0 });
  const index = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
  gl.bindVertexArray(null);
  return { vao, index, many: 0 };
}
function curves() {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  const place = attribute(gl, 2, new Float32Array(3), 3, { each: 0 });
  gl.bindVertexArray(null);
  return { vao, place };
}
function gathered(Kind, source, one, offset, size) {     // of the sites of a layer
  const { sites, instances } = one, times = instances ? 1 : 3, out = new Kind(times * size * sites.length);
  for (let i = 0, to = 0; i < sites.length; i++) {
    const from = offset + size * sites[i];
    for (let copy = 0; copy < times; copy++) for (let d = 0; d < size; d++) out[to++] = source[from + d];
  }
  return out;
}
function pairs(one, values, here, next) {   // of a map, before and after
  const both = [here, next].map((from) => gathered(Uint8Array, values, one, from, 1)), out = new Uint8Array(2 * both[0].length);
  for (let i = 0; i < both[0].length; i++) { out[2 * i] = both[0][i]; out[2 * i + 1] = both[1][i]; }
  return out;
}
function settle(one, f, sites) {            // these sites are the instances
  Object.assign(one, { sites, frame: -1, next: -1, map: null });
  refill(gl, one.place, gathered(Float32Array, f.places, one, 0, 3));
}
function follow(one, f, channel) {          // the outputs before and after this moment
  const k = Math.min(Math.floor(it.now), it.frames - 1), next = Math.min(k + 1, it.frames - 1);
  const of = channel.map && channel.family === f.name ? channel.map : null;
  if (one.frame === k && one.next === next && one.map === of) return;
  if (one.frame !== k && one.next === k) {  // one further: what was after is before
    [one.before, one.after, one.frame, one.next] = [one.after, one.before, k, one.frame];
    gl.bindVertexArray(one.vao);
    pointed(gl, 3, one.before, Int16Array, 3, one); pointed(gl, 4, one.after, Int16Array, 3, one);
  }
  if (one.frame !== k) refill(gl, one.before, gathered(Int16Array, f.w, one, 3 * k * f.count, 3));
  if (one.next !== next) refill(gl, one.after, gathered(Int16Array, f.w, one, 3 * next * f.count, 3));
  if (of || one.map !== of || one.frame < 0) refill(gl, one.value, of ? pairs(one, of.values, k * f.count, next * f.count) : new Uint8Array(2 * one.sites.length * (one.instances ? 1 : 3)));
  Object.assign(one, { frame: k, next, map: of });
}

// ---- which sites are drawn, and how ----
let last = "", drawn = {};
function key() {
  const c = camera(), controls = ["slice", "layer", "sublattice", "marks"].map((id) => el(id).value);
  return JSON.stringify([c.turn, c.zoom, c.pan, it.width, it.height, controls, it.families.map((f) => f.shown)]);
}
function detailed(set, sites, wide) {       // an arrow shape that suits their number
  const level = wide * camera().unit < 15 ? DETAIL.length - 1 : DETAIL.findIndex(([most]) => sites.length <= most);
  if (!set.arrows || set.level !== level) { set.arrows = layer(DETAIL[level][1]()); set.level = level; }
  settle(set.arrows, set.f, sites);
  set.long = (m.directions < 2 ? 1.5 : 0.86) * wide;      // those of a chain lie beside each other
}
function choose() {
  const c = camera();
  if (c.size !== `${it.width} ${it.height}`) Object.assign(c, { size: `${it.width} ${it.height}`, fit: fitted(m, c.home) });
  Object.assign(c, { unit: c.fit.unit * c.zoom, aside: c.fit.aside });
  if (last === key()) return;
  last = key();
  const marks = el("marks").value, step = marks === "all" || m.directions === 3 ? 0 : READABLE / c.unit;
  drawn = { sites: 0, arrows: 0 };
  for (const set of sets) {
    const seen = set.f.shown ? seenSites(m, set.f) : new Int32Array(0), thin = m.space < step;
    const wide = thin ? m.space * 2 ** Math.ceil(Math.log2(step / m.space)) : m.space;
    settle(set.cells, set.f, marks.includes("cells") ? seen : new Int32Array(0));
    detailed(set, marks === "cells" ? new Int32Array(0) : thin ? sparse(m, set.f, seen, wide) : seen, wide);
    links(set, seen);
    set.seen = seen;
    drawn.sites += seen.length; drawn.arrows += set.arrows.sites.length;
  }
}
function links(set, sites) {                // the bonds between sites that are seen
  const { f, lines: one } = set, seen = new Uint8Array(f.count), kept = [];
  one.many = 0;
  if (el("marks").value.includes("cells")) return;
  if (!f.links.length || f.links.length > 2 * LINKS || m.space * camera().unit < 7) return;
  for (const site of sites) seen[site] = 1;
  for (let b = 0; b < f.links.length; b += 2) if (seen[f.links[b]] && seen[f.links[b + 1]]) kept.push(f.links[b], f.links[b + 1]);
  gl.bindVertexArray(one.vao);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(kept), gl.DYNAMIC_DRAW);
  gl.bindVertexArray(null);
  one.many = kept.length;
}

// ---- drawing ----
const rgb = (color) => [1, 3, 5].map((k) => parseInt(color.slice(k, k + 2), 16) / 255);
function view() {
  const { turn, pan, unit, aside } = camera();
  return { turn, middle: m.middle, paper: rgb(inks().halo), fog: m.directions === 3 && !slice(m) ? 0.7 : 0, scale: [2 * unit / it.width, 2 * unit / it.height], deep: m.deep,
           shift: [2 * (pan[0] - aside) / it.width, -2 * pan[1] / it.height] };
}
export const channel = () => channels()[Number(el("colour").value)] || channels()[0];

function spins() {
  const { centre, tint } = it.data.wheel, one = channel();
  if (one.table) gl.bindTexture(gl.TEXTURE_2D, tables[one.table]);
  return { part: it.now - Math.floor(it.now), kind: one.kind, centre, tint, table: 0 };
}
function instances(one) {
  gl.bindVertexArray(one.vao);
  if (one.instances) gl.drawArraysInstanced(gl.TRIANGLES, 0, one.corners, one.sites.length);
  else gl.drawArrays(gl.TRIANGLES, 0, 3 * one.sites.length);
}
const onPlane = () => m.plane && m.directions === 2;
function disc(f) {                          // its radius, such that discs leave no hole between the sites that are seen
  const only = el("sublattice").value, each = perCell(f), found = f.cover && f.cover[only === "all" || each < 2 ? 0 : 1 + Number(only) % each];
  return found || (each > 1 ? 1.02 : 0.75) * m.space;
}
function drawCells(set, shared) {
  if (!set.cells.sites.length) return;
  const [across, up] = onPlane() ? [[1, 0, 0], [0, 1, 0]] : camera().turn;
  use(gl, programs.cells, { ...shared, across, up, size: onPlane() ? disc(set.f) : 0.34 * m.space, plane: Number(onPlane()) });
  follow(set.cells, set.f, channel());
  instances(set.cells);
}
function drawLines(set, shared) {
  if (!set.lines.many) return;
  use(gl, programs.lines, { ...shared, ink: rgb(inks().soft) });
  gl.bindVertexArray(set.lines.vao);
  gl.drawElements(gl.LINES, set.lines.many, gl.UNSIGNED_INT, 0);
}
function drawArrows(set, shared) {
  if (!set.arrows.sites.length) return;
  const size = set.long * it.data.quantum / it.data.reach;
  use(gl, programs.arrows, { ...shared, size, pieces: set.arrows.corners, inked: Number(el("marks").value === "cells, arrows") });
  follow(set.arrows, set.f, channel());
  instances(set.arrows);
}

function drawLevels(set, shared) {
  if (!el("isolines").checked || !set.f.triangles || !set.f.shown) return;
  const ends = isolines(set.f, channel());
  refill(gl, set.levels.place, ends);
  gl.disable(gl.DEPTH_TEST);
  use(gl, programs.lines, { ...shared, fog: 0, ink: rgb(inks().ink), paper: rgb(inks().ink) });
  gl.bindVertexArray(set.levels.vao);
  gl.drawArrays(gl.LINES, 0, ends.length / 3);
  gl.enable(gl.DEPTH_TEST);
}

export function drawPlaces() {
  choose();
  const shared = { ...view(), ...spins() };
  gl.viewport(0, 0, gl.canvas.width, gl.canvas.height);
  gl.clearColor(0, 0, 0, 0);
  gl.enable(gl.DEPTH_TEST);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  for (const set of sets) drawCells(set, shared);
  if (onPlane()) gl.clear(gl.DEPTH_BUFFER_BIT);
  for (const set of sets) drawLines(set, shared);
  for (const set of sets) drawLevels(set, shared);
  for (const set of sets) drawArrows(set, shared);
  gl.bindVertexArray(null);
  return words();
}
function words() {                          // what to say of sites that are not drawn
  const all = placed().reduce((sum, f) => sum + f.count, 0), rest = it.families.filter((f) => !f.places).map((f) => f.name);
  const some = el("marks").value !== "cells" && drawn.arrows < drawn.sites ? `arrows at ${drawn.arrows} of ${drawn.sites} sites` : "";
  const cut = drawn.sites < all ? `${drawn.sites} of ${all} sites seen` : "";
  return [some, cut, rest.length ? `${rest.join(", ")}: only on the sphere` : ""].filter((part) => part).join("; ");
}
export const finish = () => gl && gl.finish();

export function nearestPlace(x, y) {        // the site under the pointer, as { family, site, at }
  const reach = Math.max(10, 0.5 * m.space * camera().unit);
  let best = null, least = reach;
  for (const { f, seen } of sets) {
    for (const site of seen) {
      const p = project(m, f.places, 3 * site), far = Math.hypot(p[0] - x, p[1] - y) - 1e-3 * p[2];
      if (far < least) { least = far; best = { family: f, site, at: p }; }
    }
  }
  return best;
}
export const spotOfPlace = (f, site) => project(m, f.places, 3 * site);
export const fitAll = () => m.space * fitted(m, camera().home).unit;     // pixels between neighbours at first
