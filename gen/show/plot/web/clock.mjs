// Time: play, pause, go to a frame.
import { it, el, behind, show, time } from "./state.mjs";
import { nothing, words } from "./strip.mjs";

export const SPEEDS = [["\u00bc\u00d7", 0.25], ["\u00bd\u00d7", 0.5], ...[1, 2, 4, 10, 30, 100].map((x) => [`${x}\u00d7`, x])];
let before = 0;

export function go(frame) {
  it.now = Math.min(Math.max(frame, 0), it.frames - 1);
  const slider = el("slider");
  slider.value = it.frames > 1 ? Math.round(1000 * it.now / (it.frames - 1)) : 0;
  slider.setAttribute("aria-valuetext", `t = ${show(time())}` + (nothing() ? "" : `, ${words()}`));
  it.draw();
}
export function play(on) {
  it.playing = on && it.frames > 1;
  if (it.playing && it.now >= it.frames - 1) it.now = 0;
  el("play").textContent = it.playing ? "Pause" : "Play";
  before = 0;
  if (it.playing) requestAnimationFrame(tick);
}
function tick(stamp) {
  if (!it.playing) return;
  const passed = before ? (stamp - before) / 1000 : 0, last = it.frames - 1;
  before = stamp;
  const next = it.now + passed * SPEEDS[el("speed").value][1] * last / it.data.seconds;
  const around = el("loop").checked && !it.film && next >= last;
  go(around ? next % last : next);
  if (it.now >= last) play(false); else requestAnimationFrame(tick);
}
export function clockText() {
  const k = Math.min(Math.round(it.now), it.frames - 1);
  return "t = " + time().toPrecision(6) + behind(it.data.timeUnit) + (it.errors ? "    H \u2212 H\u2080 = " + show(it.errors[k]) + behind(it.data.unit) : "");
}
