// Where sites stand: the box around them, the space between them, layers, which of them are seen, their names.
import { it, el, camera } from "./state.mjs";

export const placed = () => it.families.filter((f) => f.places);
const axisOf = (name) => "xyz".indexOf(name);

function box() {
  const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
  for (const f of placed()) {
    for (let i = 0; i < f.places.length; i++) {
      low[i % 3] = Math.min(low[i % 3], f.places[i]); high[i % 3] = Math.max(high[i % 3], f.places[i]);
    }
  }
  return { low, high };
}
function nearest(p, site) {                 // the square of the distance to the next site
  let least = Infinity;
  for (let i = 0; i < p.length; i += 3) {
    const far = (p[i] - p[site]) ** 2 + (p[i + 1] - p[site + 1]) ** 2 + (p[i + 2] - p[site + 2]) ** 2;
    if (i !== site && far > 1e-12 && far < least) least = far;
  }
  return least;
}
function spacing(f) {                       // of a few sites, evenly chosen
  const tries = Math.min(24, f.count), found = [...Array(tries).keys()].map((k) => nearest(f.places, 3 * Math.floor(k * f.count / tries)));
  const middle = found.sort((a, b) => a - b)[found.length >> 1];
  return isFinite(middle) ? Math.sqrt(middle) : 1;
}
function layers(axis) {                     // the coordinates along an axis at which there are sites
  const found = new Set();
  for (const f of placed()) for (let i = axis; i < f.places.length; i += 3) found.add(Math.round(1e4 * f.places[i]));
  return [...found].sort((a, b) => a - b).map((x) => x / 1e4);
}

export function measure() {                 // what does not change with the view
  const { low, high } = box(), thick = high.map((x, d) => x - low[d]);
  const space = Math.min(...placed().map(spacing));
  const flat = thick.filter((x) => x > 1e-6 * Math.max(...thick)).length;
  return { low, high, space, middle: low.map((x, d) => (x + high[d]) / 2), directions: flat, plane: flat === 2 && thick[2] <= 1e-6 * Math.max(...thick),
           deep: Math.hypot(...thick) + 4 * space, layers: [0, 1, 2].map((d) => flat === 3 ? layers(d) : []) };
}
const KEY = 130;                            // pixels at the right that the key takes
function reach(m, turn, k) {                // how far sites stand from the middle, along a side of the screen
  let most = 0;
  for (const { places, count } of placed()) {
    const step = Math.max(1, Math.floor(count / 5000));
    for (let i = 0; i < places.length; i += 3 * step) {
      most = Math.max(most, Math.abs(turn[k].reduce((sum, r, d) => sum + r * (places[i + d] - m.middle[d]), 0)));
    }
  }
  return most + 0.7 * m.space;
}
export function fitted(m, turn) {           // where all is seen: pixels of a length of one, and how far the middle moves from the key
  const wide = 0.5 * (it.width - 20) / reach(m, turn, 0), high = 0.5 * (it.height - 30) / reach(m, turn, 1);
  const left = Math.min(high, wide * (it.width - 20 - KEY) / (it.width - 20));
  return { unit: left, aside: Math.min(KEY / 2, Math.max(0, KEY - 0.5 * it.width + left * reach(m, turn, 0))) };
}
export function project(m, p, i) {          // of the coordinates p[i], ..: place on the canvas, and depth
  const { turn, pan, unit, aside } = camera(), x = p[i] - m.middle[0], y = p[i + 1] - m.middle[1], z = p[i + 2] - m.middle[2];
  const along = (r) => r[0] * x + r[1] * y + r[2] * z;
  return [it.width / 2 + pan[0] - aside + unit * along(turn[0]), it.height / 2 + pan[1] - unit * along(turn[1]), along(turn[2])];
}

export function slice(m) {                  // { axis, at } or null
  const axis = axisOf(el("slice").value), list = m.layers[axis];
  return axis < 0 || !list || !list.length ? null : { axis, at: list[Math.min(Number(el("layer").value), list.length - 1)] };
}
export const perCell = (f) => f.cell ? f.cell.sites : 1;

export function seenSites(m, f) {           // numbers of the sites on the screen, of the slice and of the sublattice
  const cut = slice(m), only = el("sublattice").value, each = perCell(f), found = [], edge = 40;
  for (let site = 0; site < f.count; site++) {
    if (only !== "all" && site % each !== Number(only) % each) continue;
    if (cut && Math.abs(f.places[3 * site + cut.axis] - cut.at) > 1e-4) continue;
    const [x, y] = project(m, f.places, 3 * site);
    if (x > -edge && y > -edge && x < it.width + edge && y < it.height + edge) found.push(site);
  }
  return Int32Array.from(found);
}
export function sparse(m, f, sites, wide) { // one site of each square of this width, the nearest to its middle
  const best = new Map(), p = f.places;
  for (const site of sites) {
    const x = (p[3 * site] - m.low[0]) / wide, y = (p[3 * site + 1] - m.low[1]) / wide, a = Math.floor(x), b = Math.floor(y);
    const key = a * 65536 + b, far = (x - a - 0.5) ** 2 + (y - b - 0.5) ** 2, held = best.get(key);
    if (!held || far < held[0]) best.set(key, [far, site]);
  }
  return Int32Array.from([...best.values()].map(([, site]) => site));
}

export function siteName(f, site) {
  if (!f.cell) return `${f.name}[${site}]`;
  const { size, sites, names } = f.cell;
  let number = Math.floor(site / sites);
  const cell = size.map((n) => { const c = number % n; number = Math.floor(number / n); return c; });
  return `${f.name}[${site}], ` + (sites > 1 ? `site ${names[site % sites]} of ` : "") + `cell (${cell.join(", ")})`;
}
