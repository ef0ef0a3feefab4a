/* smidgen runtime: the midpoint of one spin in a frozen field, in closed form, in every lane: the formulas of
 * smg_spin.h without its branches, for fields with k = |g|^2 < 1, g = (h/2) b.
 *
 *     m = r v/|v|,  v = rho (rho w + w x g) + (g.w) g,      rho^2 = ((1-k) + sqrt((1-k)^2 + 4 d^2))/2,  d = g.w/r.
 *
 * rho = w.m/r^2 as well: of the m from the sweep before, it lacks one correction by Newton on x^2 + (k-1) x - d^2 = 0,
 * x = rho^2. That spares two roots, and a rough 1/(2 rho (2x + k-1)) will do: k times its 13 % of the error stay. In
 * weak fields 1/2 is as good: x lies between 1 - k and 1.
 *
 * In them 1/|v| is found from near 1/r too: |v|/r = rho (x + k), so |v|^2/r^2 lies between 1 - k and (1 + k)^2. */
#ifndef SMG_ROW_SPIN_H
#define SMG_ROW_SPIN_H

#include "smg_lanes.h"
#include "smg_spin.h"

/* 1/radius^2, of one radius or of those of several sites. */
#if SMG_RADII
typedef smg_lanes smg_inverse;
#else
typedef smg_real smg_inverse;
#endif

/* rho by its root; one: |w|^2/r^2. */
SMG_INLINE smg_lanes smg_lane_rho(smg_lanes one, const smg_lanes *w, const smg_lanes *g, smg_inverse inverse) {
  const smg_lanes below = one - smg_lane_dot(g, g), along = smg_lane_dot(w, g);
  const smg_lanes square = below * below + 4 * inverse * (along * along);
  const smg_lanes rho2 = (smg_real)0.5 * (below + square * smg_lane_inverse_root(square));
  return rho2 * smg_lane_inverse_root(rho2);
}

/* One to begin with: rho = 1 - (k - d^2)/2 + O(k^2). */
SMG_INLINE smg_lanes smg_lane_first_rho(const smg_lanes *w, const smg_lanes *g, smg_inverse inverse) {
  const smg_lanes along = smg_lane_dot(w, g);
  return 1 - (smg_real)0.5 * (smg_lane_dot(g, g) - inverse * (along * along));
}

/* The same from one that is nearly right; flat: may 2 (2x + k-1) = 2 sqrt((1-k)^2 + 4 d^2) be small? Where it is, a
 * correction may lead anywhere, and rho is found by its root. */
#define SMG_ROW_FLAT (smg_real)1
SMG_INLINE smg_lanes smg_lane_corrected_rho(smg_lanes one, const smg_lanes *w, const smg_lanes *g, smg_lanes rho,
                                            smg_inverse inverse, int weak, int flat) {
  const smg_lanes x = rho * rho, above = smg_lane_dot(g, g) - one, along = smg_lane_dot(w, g);
  const smg_lanes off = x * (x + above) - inverse * (along * along);
  if (weak) return rho - (smg_real)0.5 * off;
  const smg_lanes slope = 4 * x + 2 * above, next = rho - off * smg_lane_rough_inverse(rho * slope);
  const smg_lane_mask astray = (smg_lane_mask)(slope < SMG_ROW_FLAT);
  return flat && smg_lane_any(astray) ? smg_lane_select(astray, smg_lane_rho(one, w, g, inverse), next) : next;
}

/* v from w, g and rho. */
SMG_INLINE void smg_lane_along_spin(const smg_lanes *w, const smg_lanes *g, smg_lanes rho, smg_lanes *v) {
  const smg_lanes along = smg_lane_dot(w, g);
  smg_lane_cross(v, w, g);
  for (int k = 0; k < 3; ++k) v[k] = rho * (rho * w[k] + v[k]) + along * g[k];
}

/* 1/sqrt(1 - e) to two ulps of double for |e| <= 0.0215: y = 1 + e/2 + 3/8 e^2 leaves 1 - (1 - e) y^2 = 5/8 e^3, and
 * that to the second power 0.08 e^9. */
SMG_INLINE smg_lanes smg_lane_inverse_root_near_1(smg_lanes x) {
  const smg_lanes e = 1 - x, y = 1 + e * ((smg_real)0.5 + (smg_real)0.375 * e), r = 1 - x * y * y;
  return y + y * r * ((smg_real)0.5 + (smg_real)0.375 * r);
}

/* |v| = r; near: where it nearly is. */
SMG_INLINE void smg_lane_stretch_to(smg_inverse inverse, int near, smg_lanes *v) {
  const smg_lanes square = inverse * smg_lane_dot(v, v),
                  scale = near ? smg_lane_inverse_root_near_1(square) : smg_lane_inverse_root(square);
  smg_lane_scale(v, scale, 3);
}

/* The midpoint of w in the field g where that is no projection, m - m x g = w: v with rho = 1, and |m| <= |w|. */
SMG_INLINE void smg_lane_midpoint(const smg_lanes *w, const smg_lanes *g, smg_lanes *m) {
  const smg_lanes scale = 1 / (1 + smg_lane_dot(g, g));
  smg_lane_along_spin(w, g, smg_lane_of(1), m);
  for (int k = 0; k < 3; ++k) m[k] *= scale;
}

/* Takes from v its part along b; inverse = 1/|b|^2. */
SMG_INLINE void smg_lane_across(const smg_lanes *b, smg_lanes inverse, smg_lanes *v) {
  smg_lane_axpy(v, -(smg_lane_dot(b, v) * inverse), b, 3);
}

/* smg_stretch in the lanes where |b|^2 >= weakest, of |h b| = 1/3; inverse = 1/r^2. */
SMG_INLINE void smg_lane_stretch(const smg_lanes *w, const smg_lanes *compensation, const smg_lanes *b,
                                 smg_inverse inverse, smg_real weakest, smg_lanes *u) {
  const smg_lanes square = smg_lane_dot(b, b), over = 1 / square;
  const smg_lane_mask some = (smg_lane_mask)(square >= weakest);
  smg_lanes v[3] = {u[0], u[1], u[2]}, W[3], along = {0};
  smg_lane_across(b, over, v);
  for (int k = 0; k < 3; ++k) {
    W[k] = w[k] + v[k];
    along += v[k] * (2 * (w[k] + compensation[k]) + v[k]);
  }
  smg_lane_across(b, over, W);
  const smg_lanes part = inverse * along / (2 * inverse * smg_lane_dot(W, W) + SMG_EPS);
  for (int k = 0; k < 3; ++k) u[k] = smg_lane_select(some, v[k] - part * W[k], u[k]);
}

#endif
