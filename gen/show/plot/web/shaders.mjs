// The texts of the programs that draw sites at their places.
const CAMERA = `
uniform mat3 turn; uniform vec3 middle; uniform vec2 scale; uniform vec2 shift; uniform float deep;
vec4 seen(vec3 place) {
  vec3 p = (place - middle) * turn;       // rows of the rotation
  return vec4(p.xy * scale + shift, -p.z / deep, 1.0);
}`;

const SPIN = `
uniform float part; uniform int kind; uniform vec3 centre; uniform mat3 tint; uniform sampler2D table;
vec3 spin(vec3 before, vec3 after) {      // between two outputs, kept at its own length
  vec3 w = mix(before, after, part);
  float size = length(w), want = mix(length(before), length(after), part);
  return size > 0.0 ? w * (want / size) : vec3(0.0);
}
vec3 of_lab(vec3 lab) {
  float y = (lab.x + 16.0) / 116.0;
  vec3 f = vec3(y + lab.y / 500.0, y, y - lab.z / 200.0);
  vec3 xyz = mix((f - 4.0 / 29.0) * (108.0 / 841.0), f * f * f, vec3(greaterThan(f, vec3(6.0 / 29.0)))) * vec3(0.95047, 1.0, 1.08883);
  vec3 rgb = clamp(mat3(3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.204, -0.4986, 0.0415, 1.057) * xyz, 0.0, 1.0);
  return mix(12.92 * rgb, 1.055 * pow(rgb, vec3(1.0 / 2.4)) - 0.055, vec3(greaterThan(rgb, vec3(0.0031308))));
}
vec3 colour_of(vec3 u, vec2 value) {
  if (kind == 0) return of_lab(centre + u * tint);
  float x = kind == 4 ? mix(value.x, value.y, part) : 0.5 + 0.5 * u[kind - 1];
  return texture(table, vec2(clamp(x, 0.0, 1.0), 0.5)).rgb;
}`;

const HEAD = `#version 300 es
precision highp float; precision highp int;
layout(location=2) in vec3 place; layout(location=3) in vec3 before; layout(location=4) in vec3 after; layout(location=5) in vec2 value;`;

export const ARROWS = [`${HEAD}
layout(location=0) in vec3 shape; layout(location=1) in vec3 normal;
uniform int pieces; uniform float size; uniform int inked; uniform vec3 paper; uniform float fog; out vec3 colour;
${CAMERA}${SPIN}
vec3 triangle(vec3 u) {                   // flat, towards the viewer, for arrows of a few pixels: no instances, three corners each
  vec3 toward = turn[2], side = normalize(cross(toward, u) + 1e-3 * turn[0]), along = 0.5 * u + 0.12 * cross(side, toward);
  int corner = gl_VertexID % 3;
  return corner == 0 ? along : (corner == 1 ? 0.26 : -0.26) * side - along;
}
void main() {
  vec3 w = spin(before, after);
  float far = length(w);
  if (far == 0.0) { gl_Position = vec4(0.0, 0.0, 9.0, 1.0); return; }
  vec3 u = w / far, across = normalize(abs(u.z) < 0.9 ? vec3(u.y, -u.x, 0.0) : vec3(0.0, u.z, -u.y)), beside = cross(u, across);
  mat3 frame = mat3(across, beside, u);
  vec3 from = pieces == 3 ? triangle(u) : frame * shape;
  gl_Position = seen(place + size * far * from);
  vec3 flat_ = colour_of(u, value);
  if (inked == 1) flat_ = vec3(dot(flat_, vec3(0.3, 0.6, 0.1)) > 0.4 ? 0.05 : 0.95);
  float light = pieces == 3 ? 1.0 : 0.80 + 0.24 * dot((frame * normal) * turn, normalize(vec3(-0.4, 0.6, 0.7)));
  colour = inked == 1 ? flat_ : mix(flat_ * light, paper, clamp(fog * 1.2 * gl_Position.z, 0.0, 0.5));
}`, `#version 300 es
precision highp float;
in vec3 colour; out vec4 seen_;
void main() { seen_ = vec4(colour, 1.0); }`];

// Discs in a plane, each in a triangle about it; where two overlap the nearer site wins, which draws Voronoi cells.
export const CELLS = [`${HEAD}
uniform vec3 across; uniform vec3 up; uniform float size; out vec3 colour; out vec2 from;
${CAMERA}${SPIN}
void main() {
  vec3 w = spin(before, after);
  float far = length(w);
  if (far == 0.0) { gl_Position = vec4(0.0, 0.0, 9.0, 1.0); return; }
  int corner = gl_VertexID % 3;
  from = corner == 0 ? vec2(0.0, 2.0) : vec2(corner == 1 ? -1.7321 : 1.7321, -1.0);
  colour = colour_of(w / far, value);
  gl_Position = seen(place + size * (from.x * across + from.y * up));
}`, `#version 300 es
precision highp float;
uniform int plane; in vec3 colour; in vec2 from; out vec4 seen_;
void main() {
  float r = length(from);
  if (r > 1.0) discard;
  gl_FragDepth = plane == 1 ? r : gl_FragCoord.z;
  seen_ = vec4(plane == 1 ? colour : colour * (0.72 + 0.28 * sqrt(1.0 - r * r)), 1.0);
}`];

export const LINES = [`#version 300 es
precision highp float;
layout(location=2) in vec3 place;
${CAMERA}
void main() { gl_Position = seen(place); }`, `#version 300 es
precision highp float;
uniform vec3 ink; uniform vec3 paper; uniform float fog; out vec4 seen_;
void main() { seen_ = vec4(mix(ink, paper, clamp(fog * gl_FragCoord.z, 0.3, 0.8)), 1.0); }`];
