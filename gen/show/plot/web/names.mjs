// The site under the pointer, or the one that was clicked: its name, its cell, its vector, what colours it.
import { it, el, show } from "./state.mjs";
import { at } from "./load.mjs";
import { inks } from "./camera.mjs";
import { siteName } from "./lattice.mjs";
import { channel, nearestPlace, spotOfPlace } from "./places.mjs";
import { nearestOnSphere, spotOnSphere } from "./sphere.mjs";

const find = (x, y) => it.view === "places" ? nearestPlace(x, y) : nearestOnSphere(x, y);

export function valueOf(map, family, site) {
  const k = Math.min(Math.round(it.now), it.frames - 1);
  return map.low + (map.high - map.low) * map.values[k * family.count + site] / 255;
}
export function said({ family, site }) {
  const reach = it.data.reach, w = at(family, it.now, site, [0, 0, 0]).map((x) => show(reach * x));
  const one = channel(), maps = it.view === "places" && one.map && one.family === family.name ? [one] : [];
  return [siteName(family, site), `w = (${w.join(", ")})`, ...maps.map((m) => `${m.name} = ${show(valueOf(m, family, site))}`)].join("\n");
}
function label(found, x, y) {
  const box = el("told");
  box.textContent = said(found);
  box.hidden = false;
  box.style.left = `${Math.min(x + 14, it.width - 190)}px`;
  box.style.top = `${Math.min(y + 14, it.height - 60)}px`;
}
export function hover(x, y) {
  const found = find(x, y);
  if (found) label(found, x, y); else leave();
}
export function leave() { el("told").hidden = true; }

export function pick(x, y) {                // a click names a site until the next
  it.picked = find(x, y);
  el("spoken").textContent = it.picked ? said(it.picked) : "";
  it.draw();
}
export function drawPicked(g) {             // a ring about it, and its words as time goes on
  const box = el("site");
  box.hidden = !it.picked;
  if (!it.picked) return;
  const { family, site } = it.picked, [x, y] = it.view === "places" ? spotOfPlace(family, site) : spotOnSphere(family, site);
  g.strokeStyle = inks().halo; g.lineWidth = 4; g.beginPath(); g.arc(x, y, 9, 0, 2 * Math.PI); g.stroke();
  g.strokeStyle = inks().ink; g.lineWidth = 1.6; g.stroke();
  box.textContent = said(it.picked);
}
