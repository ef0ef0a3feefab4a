// Lines of equal value over a flat lattice: through its triangles, linear in each.
import { it } from "./state.mjs";
import { at } from "./load.mjs";

const LEVELS = 9;

function valuesOf(f, channel) {             // of every site, now; of directions the component z
  const out = new Float32Array(f.count), k = Math.min(Math.floor(it.now), it.frames - 1), next = Math.min(k + 1, it.frames - 1), s = it.now - k;
  const map = channel.map && channel.family === f.name ? channel.map : null, axis = channel.kind === 0 ? 2 : channel.kind - 1, w = [0, 0, 0];
  for (let i = 0; i < f.count; i++) {
    if (map) out[i] = ((1 - s) * map.values[k * f.count + i] + s * map.values[next * f.count + i]) / 255;
    else {
      at(f, it.now, i, w);
      out[i] = 0.5 + 0.5 * w[axis] / (Math.hypot(...w) || 1);
    }
  }
  return out;
}
function crossing(p, from, to, a, b, level, out) {      // where the side from a to b has this value
  const s = (level - from) / (to - from);
  for (let d = 0; d < 3; d++) out.push(p[3 * a + d] + s * (p[3 * b + d] - p[3 * a + d]));
}
function across(f, values, corners, out) {  // the pieces in one triangle
  const v = corners.map((i) => values[i]), low = Math.min(...v), high = Math.max(...v);
  for (let n = Math.ceil(low * (LEVELS + 1)); n <= LEVELS && n < high * (LEVELS + 1); n++) {
    const level = n / (LEVELS + 1);
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]]) {
      if (v[a] < level !== v[b] < level) crossing(f.places, v[a], v[b], corners[a], corners[b], level, out);
    }
  }
}
export function isolines(f, channel) {      // ends of pieces, three numbers each
  const values = valuesOf(f, channel), out = [], t = f.triangles;
  for (let k = 0; k < t.length; k += 3) across(f, values, [t[k], t[k + 1], t[k + 2]], out);
  return Float32Array.from(out);
}
