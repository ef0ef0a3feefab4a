// What the page shows now: one object that every part reads.
export const el = (id) => document.getElementById(id);

export const it = {
  data: null, times: null, frames: 0, errors: null, families: [], backdrop: [], maps: [], series: [],
  now: 0,                       // the frame, with a fraction between two
  view: "sphere",               // or "places"
  cameras: {},                  // of both views
  width: 1, height: 1, strip: { width: 0, height: 0 }, printing: false,
  picked: null,                 // { family, site } that was clicked
  draw: () => {}, film: null,   // draw anew; what films every frame while a video is made
};

export const camera = () => it.cameras[it.view];

export function show(x) {                   // a number in few characters
  if (!(Math.abs(x) > 0)) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(x)));
  if (exponent >= -3 && exponent < 4) return String(+x.toPrecision(3)).replace("-", "\u2212");
  return x.toExponential(1).replace(/-/g, "\u2212").replace("e+", "e");
}

export const behind = (unit) => !unit || unit === "model units" ? "" : /^\d/.test(unit) ? ` (${unit})` : ` ${unit}`;

export function time() {                    // of the model, now
  const k = Math.floor(it.now), next = Math.min(k + 1, it.frames - 1);
  return it.times[k] + (it.now - k) * (it.times[next] - it.times[k]);
}
