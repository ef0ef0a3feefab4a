// Hands: drag, wheel, pinch, keys.
import { it, el, camera } from "./state.mjs";
import { drag, pan, reset, zoom } from "./camera.mjs";
import { go, play } from "./clock.mjs";
import { frameAt } from "./strip.mjs";
import { hover, leave, pick } from "./names.mjs";
import { scale } from "./sphere.mjs";

const scene = el("scene"), strip = el("errors");
const held = new Map();
let armed = false, moved = 0, hint = 0;     // does the wheel zoom without Ctrl? not until a click here

const rate = () => it.view === "sphere" ? scale() : 0.39 * Math.min(it.width, it.height);
const inside = (event) => {
  const box = scene.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
};
function down(event) {
  armed = true; moved = 0;
  scene.setPointerCapture(event.pointerId);
  held.set(event.pointerId, [event.clientX, event.clientY]);
}
function pinch(was, is, other) {
  const far = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
  zoom(far(is) / Math.max(far(was), 1));
  pan((is[0] - was[0]) / 2, (is[1] - was[1]) / 2);
}
function move(event) {
  const was = held.get(event.pointerId);
  if (!was) { hover(...inside(event)); return; }
  const is = [event.clientX, event.clientY], step = [is[0] - was[0], is[1] - was[1]];
  moved += Math.hypot(...step);
  if (held.size === 2) pinch(was, is, [...held].find(([id]) => id !== event.pointerId)[1]);
  else if (held.size === 1 && (event.shiftKey || event.buttons === 2)) pan(...step);
  else if (held.size === 1) drag(step[0] / rate(), step[1] / rate());
  held.set(event.pointerId, is);
  leave(); it.draw();
}
function up(event) {
  if (held.size === 1 && moved < 4 && event.type === "pointerup") pick(...inside(event));
  held.delete(event.pointerId);
}
function tell() {
  el("hint").classList.add("told");
  clearTimeout(hint);
  hint = setTimeout(() => el("hint").classList.remove("told"), 1200);
}
function wheel(event) {
  if (!armed && !event.ctrlKey && !event.metaKey) { tell(); return; }     // the page scrolls
  event.preventDefault();
  zoom(Math.exp(-event.deltaY / 600), ...inside(event));
  it.draw();
}
function seek(event) {
  play(false);
  go(frameAt(event.clientX - strip.getBoundingClientRect().left));
}

const OWN = {                               // keys that a focused control needs for itself
  SELECT: /./, BUTTON: /^( |Enter)$/, INPUT: /^(Arrow|Page|Home|End)/, SUMMARY: /^( |Enter)$/,
};
const NUDGE = 0.08;
const turns = (dx, dy) => () => { drag(dx, dy); it.draw(); };
const zooms = (factor) => () => { zoom(factor); it.draw(); };
const tap = (id) => () => { if (!el(id).hidden) el(id).click(); };
export const KEYS = {                       // key -> what it does; a step is 10 frames with Shift
  " ": () => play(!it.playing), ".": (step) => go(it.now + step), ",": (step) => go(it.now - step),
  ">": (step) => go(it.now + step), "<": (step) => go(it.now - step),
  Home: () => { play(false); go(0); }, End: () => { play(false); go(it.frames - 1); },
  ArrowLeft: turns(-NUDGE, 0), ArrowRight: turns(NUDGE, 0), ArrowUp: turns(0, -NUDGE), ArrowDown: turns(0, NUDGE),
  "+": zooms(1.2), "=": zooms(1.2), "-": zooms(1 / 1.2), 0: () => { reset(); it.draw(); },
  f: tap("full"), l: tap("loop"), v: tap("view"), p: tap("picture"),
  "?": () => el("keys").toggleAttribute("open"),
};
let byHand = false;                         // what was pressed last: a pointer or a key?
function pressed(event) {
  byHand = false;
  const needed = OWN[event.target.tagName];
  if ((needed && needed.test(event.key)) || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key](event.shiftKey ? 10 : 1);
}

export function listen() {
  const on = (target, names, what, how) => names.split(" ").forEach((name) => target.addEventListener(name, what, how));
  on(scene, "pointerdown", down); on(scene, "pointermove", move); on(scene, "pointerup pointercancel", up);
  on(scene, "focus", () => { armed = armed || scene.matches(":focus-visible"); });   // by Tab, or by the click itself
  on(scene, "blur pointerleave", () => { armed = false; leave(); });
  on(scene, "wheel", wheel, { passive: false });
  on(scene, "contextmenu", (event) => { if (it.view === "places") event.preventDefault(); });
  on(strip, "pointerdown", (event) => { strip.setPointerCapture(event.pointerId); seek(event); });
  on(strip, "pointermove", (event) => { if (event.buttons) seek(event); });
  on(document, "pointerdown", () => { byHand = true; }, true);
  on(el("player"), "click change", (event) => {         // a control that was clicked gives the keys back
    if (byHand && (event.type === "change" || event.target.closest("button"))) scene.focus({ preventScroll: true });
  });
  on(document, "keydown", pressed);
}
