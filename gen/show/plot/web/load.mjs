// From the text in the page to arrays of numbers. What is long is deflated, and vectors of constant length are directions there.
import { it, el } from "./state.mjs";

const LEVELS = 2046, MASK = 2047;           // greatest coordinate of a direction; coding.py writes the same

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}
async function numbers(packed, Kind) {
  if (typeof packed === "string") return new Kind(bytes(packed));
  const stream = new Blob([bytes(packed.deflated)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Kind(await new Response(stream).arrayBuffer());
}

// Changes from frame to frame, modulo 65536: all low bytes, then all high bytes.
export function summed(planes, each, mask) {
  const many = planes.length / 2, out = new Uint16Array(many);
  for (let i = 0; i < many; i++) {
    const change = planes[i] | (planes[many + i] << 8);
    out[i] = (change + (i < each ? 0 : out[i - each])) & mask;
  }
  return out;
}
// A direction on the octahedron |x| + |y| + |z| = 1, unfolded to a square.
export function unfolded(p, q, out) {
  let x = 2 * p / LEVELS - 1, y = 2 * q / LEVELS - 1;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
  const size = 1 / Math.sqrt(x * x + y * y + z * z);
  out[0] = x * size; out[1] = y * size; out[2] = z * size;
}
function directed(planes, lengths, quantum) {
  const count = lengths.length, q = summed(planes, 2 * count, MASK), many = q.length / 2;
  const w = new Int16Array(3 * many), v = [0, 0, 0];
  for (let i = 0; i < many; i++) {
    unfolded(q[2 * i], q[2 * i + 1], v);
    const scale = lengths[i % count] / quantum;
    for (let d = 0; d < 3; d++) w[3 * i + d] = Math.round(v[d] * scale);
  }
  return w;
}
async function vectors(f, quantum) {
  if (f.w) return numbers(f.w, Int16Array);
  const planes = await numbers(f.changes, Uint8Array);
  if (f.lengths) return directed(planes, await numbers(f.lengths, Float32Array), quantum);
  return new Int16Array(summed(planes, 3 * f.count, 65535).buffer);
}
async function family(f, quantum) {
  const places = f.places ? await numbers(f.places, Float32Array) : null;
  return { ...f, w: await vectors(f, quantum), bonds: await numbers(f.bonds, Int32Array), places,
           triangles: f.triangles ? await numbers(f.triangles, Int32Array) : null,
           links: f.links ? await numbers(f.links, Int32Array) : new Int32Array(0), shown: true };
}

export async function load() {
  const data = it.data = JSON.parse(el("data").textContent);
  it.times = await numbers(data.t, Float64Array);
  it.frames = it.times.length;
  it.errors = data.error === null ? null : await numbers(data.error, Float64Array);
  for (const line of data.backdrop) it.backdrop.push(await numbers(line, Float32Array));
  for (const f of data.families) it.families.push(await family(f, data.quantum));
  for (const m of data.maps) it.maps.push({ ...m, values: await numbers(m.values, Uint8Array) });
  for (const s of data.series) it.series.push({ ...s, values: await numbers(s.values, Float32Array) });
}

export function at(family, frame, site, out) {      // linear between frames, kept at its own length
  const k = Math.min(Math.floor(frame), it.frames - 1), s = frame - k;
  const a = (k * family.count + site) * 3, b = k + 1 < it.frames ? a + 3 * family.count : a;
  let la = 0, lb = 0, lm = 0;
  for (let i = 0; i < 3; i++) {
    const p = family.w[a + i], q = family.w[b + i];
    out[i] = p + s * (q - p);
    la += p * p; lb += q * q; lm += out[i] * out[i];
  }
  const want = Math.sqrt(la) * (1 - s) + Math.sqrt(lb) * s, scale = it.data.quantum / it.data.reach;
  const grow = it.data.ball && s > 0 && lm > 0 ? want / Math.sqrt(lm) : 1;
  for (let i = 0; i < 3; i++) out[i] *= scale * grow;
  return out;
}
