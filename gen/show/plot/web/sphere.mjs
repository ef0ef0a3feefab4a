// Sites on their spheres or leaves, with trails: drawn on a canvas of two dimensions.
import { it, el, camera } from "./state.mjs";
import { at } from "./load.mjs";
import { times3, inks, dark, LIGHT } from "./camera.mjs";

const MOST = 20000;                         // sites that are drawn, evenly chosen
let g = null, width = 0, height = 0, cx = 0, cy = 0, unit = 1, now = 0;

function place(v) {
  const p = times3(camera().turn, v);
  return [cx + unit * p[0], cy - unit * p[1], p[2]];
}
const LENGTHS = [0, 0.03, 0.12, Infinity];     // of trails, as shares of all frames: none, short, medium, whole
function trailLength() {
  const share = LENGTHS[el("trail").value];
  return share === Infinity ? Infinity : share * (it.frames - 1);
}
function ball() {
  for (const r of [...it.data.radii].reverse()) {          // the largest first: the others on it
    const s = unit * r / it.data.reach, big = r === it.data.radii[it.data.radii.length - 1];
    g.beginPath(); g.arc(cx, cy, s, 0, 2 * Math.PI);
    if (big) {
      const light = g.createRadialGradient(cx - 0.42 * s, cy - 0.5 * s, 0.05 * s, cx, cy, 1.05 * s);
      light.addColorStop(0, "#fcfdff"); light.addColorStop(0.55, "#eceff4");
      light.addColorStop(1, "#d3d8e0");
      g.fillStyle = light; g.fill();
    } else {
      g.strokeStyle = "rgba(90,100,112,.45)"; g.lineWidth = 1; g.setLineDash([3, 3]); g.stroke();
      g.setLineDash([]);
    }
  }
}
function polyline(points, step, style, wide, front) {
  g.strokeStyle = style; g.lineWidth = wide; g.beginPath();
  let open = false;
  for (let i = 0; i + 2 < points.length; i += step) {
    const p = place([points[i] / it.data.reach, points[i + 1] / it.data.reach, points[i + 2] / it.data.reach]);
    const on = !it.data.ball || (p[2] >= 0) === front;
    if (on) { if (open) g.lineTo(p[0], p[1]); else g.moveTo(p[0], p[1]); }
    open = on;
  }
  g.stroke();
}
function axes(front) {
  const names = ["x", "y", "z"], from = it.data.ball ? it.data.radii[it.data.radii.length - 1] / it.data.reach : 0;
  g.font = "italic 13px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle";
  for (let k = 0; k < 3; k++) {
    const v = [0, 0, 0]; v[k] = 1;
    const tip = place(v.map((c) => 1.17 * c)), foot = place(v.map((c) => from * c));
    if ((tip[2] >= 0) !== front) continue;
    const inside = !front && it.data.ball && Math.hypot(tip[0] - cx, tip[1] - cy) < from * unit;
    g.globalAlpha = inside ? 0.25 : 0.85;
    const ink = it.data.ball ? inks() : LIGHT;
    g.beginPath(); g.moveTo(foot[0], foot[1]); g.lineTo(tip[0], tip[1]);
    g.strokeStyle = ink.halo; g.lineWidth = 3; g.stroke();
    g.strokeStyle = ink.ink; g.lineWidth = 1; g.stroke();
    const label = place(v.map((c) => 1.25 * c));
    g.strokeStyle = ink.halo; g.lineWidth = 3; g.strokeText(names[k], label[0], label[1]);
    g.fillStyle = ink.ink; g.fillText(names[k], label[0], label[1]);
    g.globalAlpha = 1;
  }
}
export function color(f, site) { return f.colors[Math.floor(site * f.colors.length / f.count)]; }
export function line(f) { return f.colors[f.colors.length >> 1]; }       // of its bonds
function radius(f) { return f.count > 200 ? 1.6 : f.count > 12 ? 3 : 5.5; }
function trailed(f) { return Math.min(f.count, 200); }            // sites with a trail, evenly chosen
export function disc(c, p, f, site) {
  c.fillStyle = color(f, site);
  c.beginPath(); c.arc(p[0], p[1], radius(f), 0, 2 * Math.PI); c.fill();
  if (radius(f) > 3) { c.strokeStyle = "#fff"; c.lineWidth = 1.2; c.stroke(); }
}
function trails(front) {
  const long = trailLength();
  if (long === 0) return;
  const from = Math.max(0, now - long), v = [0, 0, 0];
  for (const f of it.families) {
    if (!f.shown) continue;
    const many = trailed(f);
    const pieces = Math.max(2, Math.min(Math.ceil((now - from) * f.fine), Math.floor(24000 / many)));
    for (let pick = 0; pick < many; pick++) {
      const site = Math.floor(pick * f.count / many);
      g.strokeStyle = color(f, site); g.lineWidth = f.count > 12 ? 0.9 : 1.5;
      let last = null, bin = -1;
      for (let i = 0; i <= pieces; i++) {
        const s = i / pieces, p = place(at(f, from + s * (now - from), site, v));
        const b = long === Infinity ? 3 : Math.floor(s * 3.999);
        const on = !it.data.ball || (p[2] >= 0) === front;
        if (b !== bin || !on || last === null) {
          if (bin >= 0) g.stroke();
          g.globalAlpha = (it.data.ball && !front ? 0.16 : 0.28 + 0.18 * b) * (f.count > 12 ? 0.6 : 1);
          g.beginPath(); bin = b;
          if (last !== null) g.moveTo(last[0], last[1]); else g.moveTo(p[0], p[1]);
        }
        if (on) g.lineTo(p[0], p[1]); else if (last !== null) g.moveTo(p[0], p[1]);
        last = on ? p : null;
      }
      if (bin >= 0) g.stroke();
    }
  }
  g.globalAlpha = 1;
}
function spotsOf(f) {                       // of every site that is drawn: its number, its place on the canvas
  const many = Math.min(f.count, MOST), v = [0, 0, 0], sites = [];
  for (let pick = 0; pick < many; pick++) sites.push(many === f.count ? pick : Math.floor(pick * f.count / many));
  return sites.map((site) => [site, place(at(f, now, site, v))]);
}
function arcs(f, spots, front) {
  g.lineWidth = 1.1; g.strokeStyle = line(f); g.globalAlpha = front ? 0.75 : 0.14;
  g.beginPath();
  for (let b = 0; b < f.bonds.length; b += 2) {
    const p = spots[f.bonds[b]][1], q = spots[f.bonds[b + 1]][1];
    if ((p[2] + q[2] >= 0) === front) { g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); }
  }
  g.stroke();
}
function spins(front) {
  for (const f of it.families) {
    if (!f.shown) continue;
    const spots = spotsOf(f);
    if (f.bonds.length && f.count <= MOST) arcs(f, spots, front);
    for (const [site, p] of spots) {
      const seen = !it.data.ball || p[2] >= 0;
      if (seen !== front) continue;
      g.globalAlpha = seen ? 1 : 0.28;
      disc(g, p, f, site);
    }
  }
  g.globalAlpha = 1;
}
function untrailed() {                      // what to say where only some sites have trails
  const seen = it.families.filter((f) => f.shown), sum = (list) => list.reduce((a, b) => a + b, 0);
  const some = sum(seen.map(trailed)), all = sum(seen.map((f) => f.count));
  return trailLength() > 0 && some < all ? `trails of ${some} of ${all} sites shown` : "";
}
function left() {                           // what to say where only some sites are drawn
  const all = it.families.reduce((sum, f) => sum + f.count, 0);
  const some = it.families.reduce((sum, f) => sum + Math.min(f.count, MOST), 0);
  return some < all ? `${some} of ${all} sites shown` : "";
}
function set(context) {
  g = context; now = it.now;
  [width, height] = [it.width, it.height];
  [cx, cy] = [width / 2, height / 2];
  unit = scale();
}

export const scale = () => 0.39 * Math.min(it.width, it.height) * camera().zoom;      // pixels of the greatest |w|

export function drawSphere(context) {
  set(context);
  g.clearRect(0, 0, width, height);
  const ball_ = it.data.ball, sheet = !ball_ && dark(), thin = ball_ ? ".13" : ".28";
  el("stage").classList.toggle("sheet", sheet);
  if (sheet) { g.fillStyle = "#eef1f5"; g.fillRect(0, 0, width, height); }
  axes(false);
  if (ball_) ball();
  for (const b of it.backdrop) polyline(b, 3, `rgba(90,100,112,${thin})`, 0.8, false);
  trails(false); spins(false);
  if (ball_) for (const b of it.backdrop) polyline(b, 3, "rgba(90,100,112,.30)", 0.8, true);
  axes(true);
  if (ball_) trails(true);
  spins(true);
  return [left(), untrailed()].filter((words) => words).join("; ");
}
export function nearestOnSphere(x, y) {     // the site under the pointer, as { family, site }
  let best = null, least = 12;
  for (const f of it.families.filter((each) => each.shown)) {
    for (const [site, p] of spotsOf(f)) {
      const far = Math.hypot(p[0] - x, p[1] - y) + (it.data.ball && p[2] < 0 ? 100 : 0);
      if (far < least) { least = far; best = { family: f, site, at: p }; }
    }
  }
  return best;
}
export function spotOnSphere(f, site) { return place(at(f, it.now, site, [0, 0, 0])); }
