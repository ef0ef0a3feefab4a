// Arrows along z from -1/2 to 1/2, as triangles: [positions, normals], three numbers a corner. Fewer sides where there are many.
const HEAD = 0.08, WIDE = 0.19, THIN = 0.075;       // where the head begins, radii of head and shaft

function ring(sides, radius, height) {
  return [...Array(sides + 1).keys()].map((k) => {
    const a = 2 * Math.PI * k / sides;
    return [radius * Math.cos(a), radius * Math.sin(a), height];
  });
}
const around = (p, rise) => {               // the normal of a surface of revolution there
  const r = Math.hypot(p[0], p[1]) || 1, size = Math.hypot(1, rise);
  return [p[0] / r / size, p[1] / r / size, rise / size];
};
function band(low, high, rise) {            // between two rings
  const corners = [], normals = [];
  for (let k = 0; k + 1 < low.length; k++) {
    const [a, b, c, d] = [low[k], low[k + 1], high[k], high[k + 1]];
    corners.push(a, b, c, b, d, c);
    normals.push(...[[a, a], [b, b], [c, a], [b, b], [d, b], [c, a]].map(([, p]) => around(p, rise)));
  }
  return [corners, normals];
}
function lid(edge) {                        // a disc that looks down
  const corners = [];
  for (let k = 0; k + 1 < edge.length; k++) corners.push(edge[k], [0, 0, edge[k][2]], edge[k + 1]);
  return [corners, corners.map(() => [0, 0, -1])];
}
const joined = (parts) => [0, 1].map((k) => new Float32Array(parts.flatMap((p) => p[k]).flat()));

export function arrow(sides) {
  const tip = ring(sides, 0, 0.5), wide = ring(sides, WIDE, HEAD), thin = ring(sides, THIN, HEAD), foot = ring(sides, THIN, -0.5);
  return joined([band(wide, tip, WIDE / (0.5 - HEAD)), lid(wide), band(foot, thin, 0), lid(foot)]);
}
export function cone(sides) {
  const tip = ring(sides, 0, 0.5), wide = ring(sides, 0.24, -0.5);
  return joined([band(wide, tip, 0.24), lid(wide)]);
}
