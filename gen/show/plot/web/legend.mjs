// Families of sites, each with its markers, to show or to hide.
import { it, el } from "./state.mjs";
import { fit } from "./camera.mjs";
import { disc, line } from "./sphere.mjs";

function sample(f, sites) {                 // markers as they are drawn, on the line of their bonds
  const canvas = document.createElement("canvas"), wide = 14, size = wide * sites.length;
  canvas.style.width = size + "px"; canvas.style.height = wide + "px";
  const c = fit(canvas, canvas.getContext("2d"), size, wide);
  if (f.bonds.length) {
    c.strokeStyle = line(f); c.lineWidth = 1.1;
    c.beginPath(); c.moveTo(0, wide / 2); c.lineTo(size, wide / 2); c.stroke();
  }
  sites.forEach((site, k) => disc(c, [wide * (k + 0.5), wide / 2], f, site));
  return canvas;
}
function text(words) {
  const made = document.createElement("span");
  made.textContent = words;
  return made;
}
function keys(f) {                          // few sites: a marker and a number each; many: five shades
  const last = f.count - 1, all = [...Array(Math.min(f.count, 8)).keys()];
  if (f.count === 1) return [sample(f, [0]), text(f.name)];
  if (f.count <= 8) return [text(f.name), ...all.flatMap((i) => [sample(f, [i]), text(String(i))])];
  return [text(f.name), text("0"), sample(f, [0, 0.25, 0.5, 0.75, 1].map((s) => Math.round(s * last))), text(String(last))];
}
function entry(f) {
  const item = document.createElement("li"), button = document.createElement("button");
  button.type = "button"; button.title = "Show or hide " + f.name + ", by number of the site";
  button.setAttribute("aria-pressed", "true");
  button.append(...keys(f));
  button.addEventListener("click", () => {
    f.shown = !f.shown; button.setAttribute("aria-pressed", String(f.shown)); it.draw();
  });
  item.append(button);
  return item;
}
export function makeLegend() { el("legend").append(...it.families.map(entry)); }
