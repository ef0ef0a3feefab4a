// Colours of directions and of numbers. A direction u has the colour centre + tint u in CIELAB: hue by azimuth, lightness by u_z.
import { it } from "./state.mjs";

const clear = (x) => Math.min(1, Math.max(0, x));
const gamma = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;

export function ofLab([L, a, b]) {          // sRGB, 0 to 1; white of D65
  const y = (L + 16) / 116;
  const [X, Y, Z] = [y + a / 500, y, y - b / 200].map((f) => f > 6 / 29 ? f ** 3 : (f - 4 / 29) * 108 / 841);
  const x = 0.95047 * X, z = 1.08883 * Z;
  return [3.2406 * x - 1.5372 * Y - 0.4986 * z, -0.9689 * x + 1.8758 * Y + 0.0415 * z, 0.0557 * x - 0.204 * Y + 1.057 * z]
    .map((c) => gamma(clear(c)));
}
export function ofDirection(u) {
  const { centre, tint } = it.data.wheel;
  return ofLab(centre.map((c, k) => c + tint[k][0] * u[0] + tint[k][1] * u[1] + tint[k][2] * u[2]));
}
export function ofNumber(share, table) {    // 0 to 1, in a table of colours
  const colors = it.data.tables[table], place = clear(share) * (colors.length - 1), k = Math.min(Math.floor(place), colors.length - 2);
  return [0, 1, 2].map((c) => (colors[k][c] + (place - k) * (colors[k + 1][c] - colors[k][c])) / 255);
}
export const css = (rgb) => `rgb(${rgb.map((c) => Math.round(255 * c)).join(",")})`;

// What colours sites: directions, a component of w/|w|, a map of the page.
export function channels() {
  const own = ["x", "y", "z"].map((axis, k) => ({ name: `w_${axis} / |w|`, kind: k + 1, low: -1, high: 1, table: "diverging" }));
  return [{ name: "direction", kind: 0 }, ...own, ...it.maps.map((m) => ({ ...m, kind: 4, map: m }))];
}

export function drawKey(c, channel, size, ink) {
  c.clearRect(0, 0, size, size);
  c.font = "11.5px system-ui, sans-serif"; c.textBaseline = "middle"; c.textAlign = "center"; c.fillStyle = ink;
  if (channel.kind === 0) wheel(c, size, ink); else bar(c, channel, size);
}
function wheel(c, size, ink) {              // all directions: z in the middle, -z along the rim
  const middle = size / 2, rim = middle - 17, ratio = c.canvas.width / size;
  const side = Math.ceil(2 * rim * ratio), image = c.createImageData(side, side);
  for (let k = 0; k < side * side; k++) {
    const x = 2 * (k % side + 0.5) / side - 1, y = 1 - 2 * (Math.floor(k / side) + 0.5) / side, r = Math.hypot(x, y);
    if (r > 1) continue;
    const polar = Math.PI * r, s = r > 0 ? Math.sin(polar) / r : 0;
    const rgb = ofDirection([s * x, s * y, Math.cos(polar)]);
    image.data.set([...rgb.map((v) => 255 * v), 255], 4 * k);
  }
  c.putImageData(image, Math.round((middle - rim) * ratio), Math.round((middle - rim) * ratio));
  for (const [name, x, y] of [["x", 1, 0], ["y", 0, -1], ["\u2212x", -1, 0], ["\u2212y", 0, 1]]) {
    c.fillText(name, middle + x * (rim + 9), middle + y * (rim + 9));
  }
  c.fillStyle = "#000"; c.fillText("z", middle, middle);
}
function bar(c, channel, size) {
  const wide = size - 20;
  for (let x = 0; x < wide; x++) {
    c.fillStyle = css(ofNumber(x / (wide - 1), channel.table));
    c.fillRect(10 + x, size - 34, 1.5, 12);
  }
}
