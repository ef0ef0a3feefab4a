// The strip below: the energy error, or any other number of the result, over time.
import { it, el, show, time } from "./state.mjs";
import { inks, dark, pale } from "./camera.mjs";

const LEFT = 74, RIGHT = 12, TOP = 26, BOTTOM = 22;
let e = null;

function shown() {                          // what it shows: values, their range, their name
  const choice = Number(el("series").value), found = it.series[choice - (it.errors ? 1 : 0)];
  if (it.errors && choice === 0) {
    const note = it.data.note ? it.data.note + ", " : "";
    return { values: it.errors, low: it.data.low, high: it.data.high, label: `energy H \u2212 H\u2080 (${note}${it.data.unit})` };
  }
  return { ...found, label: found.name + (found.unit ? ` (${found.unit})` : "") };
}
function scales(one) {
  const { width, height } = it.strip, span = it.times[it.frames - 1] - it.times[0] || 1;
  return { X: (t) => LEFT + (width - LEFT - RIGHT) * (t - it.times[0]) / span,
           Y: (y) => TOP + (height - TOP - BOTTOM) * (one.high - y) / (one.high - one.low) };
}
function marks(one, Y) {
  const list = [one.high, one.low], high = it.strip.height;
  const clear = (y) => Math.abs(Y(0) - y) > 12;
  return one.low < 0 && one.high > 0 && clear(TOP) && clear(high - BOTTOM) ? [...list, 0] : list;
}
function frame(one, Y) {
  const { width, height } = it.strip;
  e.font = "11.5px system-ui, sans-serif"; e.textBaseline = "middle"; e.textAlign = "right";
  for (const y of marks(one, Y)) {
    e.strokeStyle = inks().line; e.lineWidth = 1;
    e.beginPath(); e.moveTo(LEFT, Y(y)); e.lineTo(width - RIGHT, Y(y)); e.stroke();
    e.fillStyle = inks().soft; e.fillText(show(y), LEFT - 7, Y(y));
  }
  e.textAlign = "left"; e.fillText(one.label, LEFT, 10);
  e.textAlign = "center";
  e.fillText(show(it.times[0]), LEFT, height - 9); e.fillText(`time t (${it.data.timeUnit})`, (LEFT + width - RIGHT) / 2, height - 9);
  e.textAlign = "right"; e.fillText(show(it.times[it.frames - 1]), width - RIGHT, height - 9);
}
function curve(one, { X, Y }) {
  e.strokeStyle = dark() ? pale(it.data.color) : it.data.color; e.lineWidth = 1.1; e.beginPath();
  let open = false;
  for (let k = 0; k < it.frames; k++) {
    if (!isFinite(one.values[k])) continue;
    const x = X(it.times[k]), y = Y(one.values[k]);
    if (open) e.lineTo(x, y); else e.moveTo(x, y);
    open = true;
  }
  e.stroke();
}
function cursor(one, { X, Y }) {
  const x = X(time()), y = one.values[Math.min(Math.round(it.now), it.frames - 1)];
  e.strokeStyle = inks().ink; e.beginPath(); e.moveTo(x, TOP - 2); e.lineTo(x, it.strip.height - BOTTOM + 2); e.stroke();
  if (!isFinite(y)) return;
  e.fillStyle = inks().ink; e.beginPath(); e.arc(x, Y(y), 3.2, 0, 2 * Math.PI); e.fill();
}

export const nothing = () => !it.errors && !it.series.length;

export function drawStrip(context) {
  if (nothing()) return;
  e = context;
  const one = shown(), scale = scales(one);
  e.clearRect(0, 0, it.strip.width, it.strip.height);
  frame(one, scale.Y); curve(one, scale); cursor(one, scale);
}
export function frameAt(share) {            // the frame nearest to a place of the strip, 0 to its width
  const t = it.times[0] + (share - LEFT) / (it.strip.width - LEFT - RIGHT) * (it.times[it.frames - 1] - it.times[0]);
  let k = 0;
  while (k + 1 < it.frames && Math.abs(it.times[k + 1] - t) <= Math.abs(it.times[k] - t)) k++;
  return k;
}
export function words() {                   // the value now, for those who listen
  const one = shown(), y = one.values[Math.min(Math.round(it.now), it.frames - 1)];
  return `${one.label}: ${show(y)}`;
}
