/* smidgen runtime: vectors of one site, indices of lattices, stagnation. */
#ifndef SMG_SITE_H
#define SMG_SITE_H

#include "smg_arrays.h"
#include "smg_triple_template.h"

/* Right-handed orthonormal (e1, e2, m) of a unit vector m; branch-free, no case is singular. Duff et al.,
 * "Building an orthonormal basis, revisited", JCGT 6 (2017). */
SMG_INLINE void smg_unit_frame(const smg_real *m, smg_real *e1, smg_real *e2) {
  const smg_real s = SMG_MATH(copysign)(1, m[2]), a = -1 / (s + m[2]), b = m[0] * m[1] * a;
  e1[0] = 1 + s * m[0] * m[0] * a;
  e1[1] = s * b;
  e1[2] = -s * m[0];
  e2[0] = b;
  e2[1] = s + m[1] * m[1] * a;
  e2[2] = -m[1];
}

/* u = m/|m|; the z axis where m = 0, which has no direction. */
SMG_INLINE void smg_unit(const smg_real *m, smg_real *u) {
  const smg_real size = smg_norm(m), scale = 1 / size;
  for (int k = 0; k < 3; ++k) u[k] = size > (smg_real)1e-280 ? scale * m[k] : size > 0 ? m[k] / size : k == 2;
  if (size != size) u[0] = u[1] = u[2] = size;
}

/* The frame for m of any length. */
SMG_INLINE void smg_frame(const smg_real *m, smg_real *e1, smg_real *e2) {
  smg_real u[3];
  smg_unit(m, u);
  smg_unit_frame(u, e1, e2);
}

/* Frame E of the tangent plane {v : n.v = 0} of a leaf at m, n = grad C(m), and its dual F along m:
 * v = a1 E1 + a2 E2 + s m has a_r = F_r.v, F_r = E_r - (E_r.m / n.m) n. */
SMG_INLINE void smg_leaf_frame(const smg_real *m, const smg_real *n, smg_real *E, smg_real *F) {
  smg_frame(n, E, E + 3);
  for (int r = 0; r < 2; ++r) { smg_waxpy(F + 3 * r, -(smg_dot(E + 3 * r, m) / smg_dot(n, m)), n, E + 3 * r, 3); }
}

/* The cell x - n, x or x + n that lies in [0, n); |offset| is at most n. */
static inline int64_t smg_wrap(int64_t x, int64_t n) { return x < 0 ? x + n : x >= n ? x - n : x; }

/* Remainder and quotient that belong to rounding down. */
static inline int64_t smg_mod(int64_t a, int64_t b) {
  const int64_t r = a % b;
  return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}
static inline int64_t smg_quotient(int64_t a, int64_t b) { return (a - smg_mod(a, b)) / b; }

/* How far an iterate moved: relative to each component's own size, and absolutely, a small site of R^3 as
 * if it were as large as the others; and the size of the products that increments are made of, h (1/kappa) |grad C|
 * |dH/dw|: their round-off stays. */
typedef struct smg_change {
  smg_real relative, absolute, rounding_scale;
} smg_change;

/* Takes in one component: r = its change, own = the size of what it is made of, up = smg_up of its site. */
static inline void smg_change_add(smg_change *d, smg_real r, smg_real own, smg_real up) {
  const smg_real a = SMG_MATH(fabs)(r), b = up * a;
  if (b > d->absolute || b != b) d->absolute = b; /* NaN comes in and stays */
  if (a > d->relative * own || a != a) d->relative = a / own;
}

/* The largest component, and NaN where there is one. */
static inline smg_real smg_largest(const smg_real *a) {
  const smg_real x = smg_abs(a[0]), y = smg_abs(a[1]), z = smg_abs(a[2]);
  return smg_max(x, smg_max(y, z));
}

/* The largest difference of two vectors, alike. */
static inline smg_real smg_apart_by(const smg_real *a, const smg_real *b) {
  const smg_real d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return smg_largest(d);
}

/* How much smaller than `scale` a site is, within the range of numbers. */
static inline smg_real smg_up(smg_real scale, const smg_real *w) {
  const smg_real size = smg_largest(w);
  return size > 0 ? smg_min(scale / size, (smg_real)1e290) : 1;
}

/* ulps of the whole, below which motion is taken for round-off; half or twice: the same; 0 loses a step in 200 */
#define SMG_STILL 8
/* part of its size that it keeps when it shrinks no more: Newton squares it; half or twice: the same */
#define SMG_SLOWED (smg_real)0.5

/* Is a change so small that it may be round-off of a whole of this size? */
SMG_INLINE int smg_still(smg_real change, smg_real scale) { return change <= SMG_STILL * SMG_EPS * scale; }

/* Do changes shrink no more? */
SMG_INLINE int smg_slowed(smg_real now, smg_real last) { return now >= SMG_SLOWED * last; }

/* Stagnation: every component moves by at most an ulp of its own size; or the motion is down to
 * round-off of the whole (`scale`, or the terms of the increments) and its relative size falls no more. A component of
 * 1e-300 that still converges at its own rate keeps the iteration going. */
static inline int smg_settled(const smg_change *now, const smg_change *last, smg_real scale) {
  if (now->relative <= SMG_EPS) return 1;
  return smg_still(now->absolute, smg_max(scale, now->rounding_scale)) && smg_slowed(now->relative, last->relative);
}

/* mbar = w + compensation + u/2, the midpoint of n components of a step with the increment u. */
SMG_INLINE void smg_middle(int64_t n, const smg_real *w, const smg_real *compensation, const smg_real *u,
                           smg_real *mbar) {
  for (int64_t k = 0; k < n; ++k) mbar[k] = w[k] + (compensation[k] + 0.5 * u[k]);
}

/* The end of a step: w + u, compensated where sums are, of n components. */
static inline void smg_add_step(int64_t n, smg_real *w, SMG_UNUSED smg_real *compensation, const smg_real *u) {
#if SMG_PLAIN_SUMS
  smg_axpy(w, 1, u, n);
#else
  for (int64_t k = 0; k < n; ++k) smg_add_compensated(w + k, compensation + k, u[k]);
#endif
}

#endif
