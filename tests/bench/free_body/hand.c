/* The designs. Each advances one step to stagnation; those that expect two evaluations call `iterate` when a
 * third is needed. Degrees of extrapolation that do best were found by trial. */
#include "body.h"

#ifndef STEP
#define STEP __attribute__((noinline)) static
#endif
#define ALWAYS static inline __attribute__((always_inline))
#define NEVER __attribute__((noinline, cold)) static

typedef struct vec {
  double x, y, z;
} vec;

/* Row p: u_{n+1} = sum_j (-1)^j C(p+1, j+1) u_{n-j}, the extrapolation of degree p. */
static const double extrapolate[MAX_DEGREE + 1][MAX_DEGREE + 1] = {
    {1},
    {2, -1},
    {3, -3, 1},
    {4, -6, 4, -1},
    {5, -10, 10, -5, 1},
    {6, -15, 20, -15, 6, -1},
    {7, -21, 35, -35, 21, -7, 1},
    {8, -28, 56, -70, 56, -28, 8, -1},
    {9, -36, 84, -126, 126, -84, 36, -9, 1},
    {10, -45, 120, -210, 252, -210, 120, -45, 10, -1},
    {11, -55, 165, -330, 462, -462, 330, -165, 55, -11, 1},
    {12, -66, 220, -495, 792, -924, 792, -495, 220, -66, 12, -1},
    {13, -78, 286, -715, 1287, -1716, 1716, -1287, 715, -286, 78, -13, 1},
    {14, -91, 364, -1001, 2002, -3003, 3432, -3003, 2002, -1001, 364, -91, 14, -1},
    {15, -105, 455, -1365, 3003, -5005, 6435, -6435, 5005, -3003, 1365, -455, 105, -15, 1},
    {16, -120, 560, -1820, 4368, -8008, 11440, -12870, 11440, -8008, 4368, -1820, 560, -120, 16, -1}};

void body_start(body *s, const body_params *p, const double w[3]) {
  memset(s, 0, sizeof *s);
  s->p = *p;
  s->k = ROWS - MAX_DEGREE - 1;
  memcpy(s->w, w, sizeof s->w);
}

ALWAYS vec predict(const body *s, int degree, double *lane) {
  const double(*const row)[4] = (const double(*)[4])(s->u + s->k);
  const double *c = extrapolate[degree];
  double t[4];
  for (int i = 0; i < 4; i++) t[i] = c[degree] * row[degree][i];
  for (int j = degree - 1; j >= 0; j--)
    for (int i = 0; i < 4; i++) t[i] += c[j] * row[j][i];
  *lane = t[3];
  return (vec){t[0], t[1], t[2]};
}

ALWAYS void commit(body *s, int degree, vec W, vec u, double lane) {
  s->w[0] = W.x, s->w[1] = W.y, s->w[2] = W.z;
  if (s->k == 0) {
    memcpy(s->u + ROWS - degree, s->u, sizeof *s->u * (size_t)degree);
    s->k = ROWS - degree;
  }
  double *row = s->u[--s->k];
  row[0] = u.x, row[1] = u.y, row[2] = u.z, row[3] = lane;
}

/* One unit in the last place of each component: W = w + v, from u to v. */
ALWAYS int settled(vec W, vec v, vec u) {
  return fabs(v.x - u.x) <= DBL_EPSILON * fabs(W.x) && fabs(v.y - u.y) <= DBL_EPSILON * fabs(W.y) &&
         fabs(v.z - u.z) <= DBL_EPSILON * fabs(W.z);
}
ALWAYS double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ALWAYS vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
ALWAYS vec state(const body *s) { return (vec){s->w[0], s->w[1], s->w[2]}; }
ALWAYS vec twice_midpoint(vec w, vec u) { return (vec){2 * w.x + u.x, 2 * w.y + u.y, 2 * w.z + u.z}; }

/* h (1/I_k - 1/I_j), cyclic */
ALWAYS vec constants(const body_params *p) {
  const double *a = p->inverse_moment;
  return (vec){p->h * (a[2] - a[1]), p->h * (a[0] - a[2]), p->h * (a[1] - a[0])};
}

/* s h S x I^-1 S */
ALWAYS vec product(vec d, vec S, double s) {
  return (vec){(d.x * s) * (S.y * S.z), (d.y * s) * (S.z * S.x), (d.z * s) * (S.x * S.y)};
}

/* G(u) = h (S x I^-1 S)/|S|^2, S = 2 w + u. */
ALWAYS vec image(vec d, vec w, vec u) {
  const vec S = twice_midpoint(w, u);
  return product(d, S, 1 / dot(S, S));
}

/* Fixed point to stagnation from u. Near a zero of W_i one unit of W_i may lie below the round-off of u_i, and
 * u may alternate between neighbours for ever: after some tries a few units of u_i count as stagnation too. */
ALWAYS int alternates(double v, double u) { return fabs(v - u) <= 8 * DBL_EPSILON * fabs(v); }
NEVER void iterate(body *s, int degree, vec v, int form) {
  const vec d = constants(&s->p), w = state(s);
  vec u, W;
  int k = 0, done;
  do {
    u = v, v = image(d, w, u), W = add(w, v);
    done = settled(W, v, u) || (k > 20 && alternates(v.x, u.x) && alternates(v.y, u.y) && alternates(v.z, u.z));
  } while (!done && ++k < CAP);
  const vec S = add(w, W);
  const double lane = 1 / dot(S, S);
  commit(s, degree, W, v, form == 1 ? sqrt(lane) : form == 2 ? .25 * dot(v, v) / dot(w, w) * lane : lane);
}

/* The first steps: nothing to extrapolate from. */
ALWAYS int early_step(body *s, int degree, int form) {
  if (s->count > degree) return 0;
  s->count++;
  iterate(s, degree, (vec){0, 0, 0}, form);
  return 1;
}

/* 1. Fixed point u <- G(u) from an extrapolation of high degree; the third evaluation is the rule. */
ALWAYS void fixed_point(body *s, int degree) {
  if (early_step(s, degree, 0)) return;
  const vec d = constants(&s->p), w = state(s);
  double unused;
  vec v = image(d, w, predict(s, degree, &unused)), u;
  for (int k = 0; k < 2; k++) {
    u = v, v = image(d, w, u);
    const vec W = add(w, v);
    if (settled(W, v, u)) { commit(s, degree, W, v, 0); return; }
  }
  iterate(s, degree, v, 0);
}

/* 2. (1 - E + 2 (p/Q^2) S^T) x = r, E = D p/Q, p = h S x I^-1 S, Q = |S|^2: Newton by the adjugate. */
ALWAYS vec newton_image(vec d, vec w, vec u) {
  const vec S = twice_midpoint(w, u);
  const double x = S.x, y = S.y, z = S.z, s = 1 / dot(S, S);
  const vec g = product(d, S, s);
  const double r0 = g.x - u.x, r1 = g.y - u.y, r2 = g.z - u.z;
  const double a = 2 * g.x * s, b = 2 * g.y * s, e = 2 * g.z * s, X = d.x * s, Y = d.y * s, Z = d.z * s;
  const double m00 = 1 + a * x, m01 = a * y - X * z, m02 = a * z - X * y;
  const double m10 = b * x - Y * z, m11 = 1 + b * y, m12 = b * z - Y * x;
  const double m20 = e * x - Z * y, m21 = e * y - Z * x, m22 = 1 + e * z;
  const double c0 = m11 * m22 - m12 * m21, c1 = m12 * m20 - m10 * m22, c2 = m10 * m21 - m11 * m20;
  const double t = 1 / (m00 * c0 + m01 * c1 + m02 * c2);
  return (vec){u.x + t * (c0 * r0 + (m02 * m21 - m01 * m22) * r1 + (m01 * m12 - m02 * m11) * r2),
               u.y + t * (c1 * r0 + (m00 * m22 - m02 * m20) * r1 + (m02 * m10 - m00 * m12) * r2),
               u.z + t * (c2 * r0 + (m01 * m20 - m00 * m21) * r1 + (m00 * m11 - m01 * m10) * r2)};
}

ALWAYS void newton_once(body *s, int degree) {
  if (early_step(s, degree, 0)) return;
  const vec d = constants(&s->p), w = state(s);
  double unused;
  const vec u = newton_image(d, w, predict(s, degree, &unused)), v = image(d, w, u), W = add(w, v);
  if (settled(W, v, u)) commit(s, degree, W, v, 0);
  else iterate(s, degree, v, 0);
}

/* With one step of Newton's reciprocal, s(2 - |S|^2 s), from a good s. */
ALWAYS vec image_near(vec d, vec w, vec u, double s) {
  const vec S = twice_midpoint(w, u), g = product(d, S, s);
  const double f = 2 - dot(S, S) * s;
  return (vec){g.x * f, g.y * f, g.z * f};
}

/* 3. The scale s = 1/|S|^2 extrapolated beside u: no division before the update, and the Jacobian of the
 * first evaluation is E alone; u <- G + (E + E^2)(G - u), then one honest evaluation. */
ALWAYS vec corrected_image(vec d, vec w, vec u, double s) {
  const vec S = twice_midpoint(w, u), g = product(d, S, s);
  const double X = .25 * d.x, Y = .25 * d.y, Z = .25 * d.z;
  const double r0 = g.x - u.x, r1 = g.y - u.y, r2 = g.z - u.z;
  const double e01 = X * S.z, e02 = X * S.y, e10 = Y * S.z, e12 = Y * S.x, e20 = Z * S.y, e21 = Z * S.x;
  return (vec){g.x + ((e01 * e10 + e02 * e20) * r0 + ((e01 + e02 * e21) * r1 + (e02 + e01 * e12) * r2)),
               g.y + ((e10 * e01 + e12 * e21) * r1 + ((e10 + e12 * e20) * r0 + (e12 + e10 * e02) * r2)),
               g.z + ((e20 * e02 + e21 * e12) * r2 + ((e20 + e21 * e10) * r0 + (e21 + e20 * e01) * r1))};
}

ALWAYS void truncated(body *s, int degree) {
  if (early_step(s, degree, 2)) return;
  const vec d = constants(&s->p), w = state(s);
  double lane;
  const vec p = predict(s, degree, &lane);
  const double a = .25 / dot(w, w), scale = a + lane;
  const vec u = corrected_image(d, w, p, scale), v = image_near(d, w, u, scale), W = add(w, v);
  if (settled(W, v, u)) commit(s, degree, W, v, dot(v, v) * a * scale);
  else iterate(s, degree, v, 2);
}

/* 4. Newton on (u, s) jointly, s extrapolated beside u: no division before the 3 x 3 matrix. */
ALWAYS vec joint_image(vec d, vec w, vec u, double s, double *scale) {
  const vec S = twice_midpoint(w, u);
  const double x = S.x, y = S.y, z = S.z, X = d.x * s, Y = d.y * s, Z = d.z * s;
  const double f = 2 - dot(S, S) * s;
  const double r0 = X * (y * z) * f - u.x, r1 = Y * (z * x) * f - u.y, r2 = Z * (x * y) * f - u.z;
  const double t = 2 * s, a = t * u.x, b = t * u.y, e = t * u.z;
  const double m00 = 1 + a * x, m01 = a * y - X * z, m02 = a * z - X * y;
  const double m10 = b * x - Y * z, m11 = 1 + b * y, m12 = b * z - Y * x;
  const double m20 = e * x - Z * y, m21 = e * y - Z * x, m22 = 1 + e * z;
  const double c0 = m11 * m22 - m12 * m21, c1 = m12 * m20 - m10 * m22, c2 = m10 * m21 - m11 * m20;
  const double i = 1 / (m00 * c0 + (m01 * c1 + m02 * c2));
  *scale = s * f;
  return (vec){u.x + i * (c0 * r0 + ((m02 * m21 - m01 * m22) * r1 + (m01 * m12 - m02 * m11) * r2)),
               u.y + i * (c1 * r0 + ((m00 * m22 - m02 * m20) * r1 + (m02 * m10 - m00 * m12) * r2)),
               u.z + i * (c2 * r0 + ((m01 * m20 - m00 * m21) * r1 + (m00 * m11 - m01 * m10) * r2))};
}
ALWAYS void joint(body *s, int degree) {
  if (early_step(s, degree, 0)) return;
  const vec d = constants(&s->p), w = state(s);
  double s0, s1;
  const vec p = predict(s, degree, &s0), u = joint_image(d, w, p, s0, &s1), v = image_near(d, w, u, s1), W = add(w, v);
  if (settled(W, v, u)) commit(s, degree, W, v, s1);
  else iterate(s, degree, v, 0);
}

/* 5. q = 1/|S| extrapolated, m = q S; Newton on the plane across m, where E v = h q m x C v - (h q X.v) m with
 * C = I^-1 - (m.I^-1 m) has trace 0, so that (1 - E)^-1 = 1 + (E + E^2)/det(1 - E). */
ALWAYS vec turn(vec k, vec C, vec a) {
  const double x = C.x * a.x, y = C.y * a.y, z = C.z * a.z;
  return (vec){k.y * z - k.z * y, k.z * x - k.x * z, k.x * y - k.y * x};
}
ALWAYS vec motion(vec D, vec m) { return (vec){D.x * (m.y * m.z), D.y * (m.z * m.x), D.z * (m.x * m.y)}; }
ALWAYS vec tangent_image(const body *s, vec D, vec w, vec u, double *q) {
  const double *A = s->p.inverse_moment, h = s->p.h, a0 = h * A[0], a1 = h * A[1], a2 = h * A[2];
  const vec S = twice_midpoint(w, u), m = {*q * S.x, *q * S.y, *q * S.z}, k = {*q * m.x, *q * m.y, *q * m.z};
  const vec o = motion(D, m);
  const double eps = .5 - dot(S, S) * (.5 * *q * *q), f = 1 + 2 * eps, mu = dot(m, u);
  const double beta = a0 * (m.x * m.x) + a1 * (m.y * m.y) + a2 * (m.z * m.z);
  const vec C = {a0 - beta, a1 - beta, a2 - beta};
  const double t = 1 + (C.y * C.z * (k.x * k.x) + C.z * C.x * (k.y * k.y) + C.x * C.y * (k.z * k.z)), i = 1 / t;
  const vec g = {f * o.x, f * o.y, f * o.z};
  const vec a = {g.x + (mu * m.x - u.x), g.y + (mu * m.y - u.y), g.z + (mu * m.z - u.z)};
  const vec c = add(a, turn(k, C, a)), d = turn(k, C, c);
  const double gc = dot(g, c), l = (*q * i) * gc;
  *q = (*q + *q * (eps + *q * mu)) + (*q * *q * (*q * i)) * gc;
  return (vec){(g.x + i * d.x) - l * m.x, (g.y + i * d.y) - l * m.y, (g.z + i * d.z) - l * m.z};
}
ALWAYS void tangent(body *s, int degree) {
  if (early_step(s, degree, 1)) return;
  const vec D = constants(&s->p), w = state(s);
  double q;
  const vec p = predict(s, degree, &q), u = tangent_image(s, D, w, p, &q), S = twice_midpoint(w, u);
  const vec v = motion(D, (vec){q * S.x, q * S.y, q * S.z}), W = add(w, v);
  if (settled(W, v, u)) commit(s, degree, W, v, q);
  else iterate(s, degree, v, 1);
}

/* 6. The same without square roots: s = 1/|S|^2 extrapolated, u = g = s p, p = h S x I^-1 S. With M = s Dp,
 * S.M v = -g.v and M S = 2 g: across S the Newton matrix is 1 - E, E a = M a, E E a = M E a + 2 s (g.a) g,
 * det(1 - E) = 1 + e2(M) - 2 s |g|^2, and again (1 - E)^-1 = 1 + (E + E^2)/det. */
typedef struct pairs {
  double xy, xz, yx, yz, zx, zy;
} pairs;
ALWAYS vec apply(pairs M, vec a) {
  return (vec){M.xy * a.y + M.xz * a.z, M.yx * a.x + M.yz * a.z, M.zx * a.x + M.zy * a.y};
}
ALWAYS vec bilinear_image(vec D, vec w, vec u, double *scale) {
  const double s = *scale, X = s * D.x, Y = s * D.y, Z = s * D.z;
  const vec S = twice_midpoint(w, u);
  const double xx = S.x * S.x, yy = S.y * S.y, zz = S.z * S.z, f = 2 - (xx + yy + zz) * s, sigma = dot(S, u), r = s * sigma;
  const pairs M = {X * S.z, X * S.y, Y * S.z, Y * S.x, Z * S.y, Z * S.x};
  const vec g = {M.xz * S.z * f, M.yz * S.z * f, M.zy * S.y * f};
  const vec a = {g.x + (r * S.x - u.x), g.y + (r * S.y - u.y), g.z + (r * S.z - u.z)}, b = apply(M, a), e = apply(M, b);
  const double t = 1 - (X * Y * zz + X * Z * yy + Y * Z * xx + 2 * s * dot(g, g)), i = 1 / t, ga = dot(g, a);
  const double l = 2 * s * ga;
  *scale = s * (f + 2 * s * (sigma + i * (ga + dot(g, b))));
  return (vec){g.x + i * (b.x + (e.x + l * g.x)), g.y + i * (b.y + (e.y + l * g.y)), g.z + i * (b.z + (e.z + l * g.z))};
}
ALWAYS void bilinear(body *s, int degree) {
  if (early_step(s, degree, 0)) return;
  const vec D = constants(&s->p), w = state(s);
  double q;
  const vec p = predict(s, degree, &q), u = bilinear_image(D, w, p, &q), v = product(D, twice_midpoint(w, u), q), W = add(w, v);
  if (settled(W, v, u)) commit(s, degree, W, v, q);
  else iterate(s, degree, v, 0);
}

/* 7. The same; when the second evaluation leaves every bit of W, the next step goes on from the first by branch
 * prediction, without waiting for the second. */
ALWAYS void foresight(body *s, int degree) {
  if (early_step(s, degree, 0)) return;
  const vec D = constants(&s->p), w = state(s);
  double q;
  const vec p = predict(s, degree, &q), u = bilinear_image(D, w, p, &q), v = product(D, twice_midpoint(w, u), q);
  const vec U = add(w, u), W = add(w, v);
  if (U.x == W.x && U.y == W.y && U.z == W.z) commit(s, degree, U, u, q);
  else if (settled(W, v, u)) commit(s, degree, W, v, q);
  else iterate(s, degree, v, 0);
}

#define DESIGN(kind, degree)                                     \
  STEP void kind##_##degree##_step(body *s) { kind(s, degree); } \
  static void kind##_##degree(void *s, int64_t n) {              \
    for (int64_t i = 0; i < n; i++) kind##_##degree##_step((body *)s); \
  }
#define ENTRY(kind, degree) {#kind " " #degree, kind##_##degree},
#define LIST(DO)                                                                                                \
  DO(fixed_point, 4) DO(fixed_point, 10) DO(fixed_point, 12) DO(fixed_point, 14) DO(newton_once, 4)            \
  DO(newton_once, 5) DO(newton_once, 6) DO(truncated, 11) DO(truncated, 12) DO(joint, 5) DO(joint, 6)          \
  DO(joint, 7) DO(tangent, 5) DO(tangent, 6) DO(bilinear, 5) DO(bilinear, 6) DO(bilinear, 7)   \
  DO(foresight, 5) DO(foresight, 6)
LIST(DESIGN)
const design hand_designs[] = {LIST(ENTRY)};
const int hand_count = sizeof hand_designs / sizeof *hand_designs;
