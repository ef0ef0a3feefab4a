/* smidgen runtime: the spherical midpoint of one spin in a frozen field, in closed form.
 *
 * The step W - w = h m x b with |m| = |w| = r and m along w + W. With g = (h/2) b and
 * (w + W)/2 = rho m it reads
 *
 *     rho m - m x g = w,     so     m = (rho w + w x g + (g.w/rho) g) / (rho^2 + |g|^2),
 *
 * and |m| = r holds when, with d = g.w/r and k = |g|^2,
 *
 *     rho^4 + (k - 1) rho^2 - d^2 = 0.
 *
 * Its root rho^2 >= 0, without cancellation: with q = sqrt((1-k)^2 + 4 d^2),
 *
 *     k < 1:   rho^2 = (1-k + q)/2;         else   rho = |d| / sqrt((k-1 + q)/2).
 *
 * rho = 0 only when d = 0 and k >= 1: a spin perpendicular to its field with |h b| >= 2. Beyond 2
 * no W of the sphere is far enough from w; at 2, W = -w and the midpoint has no direction. */
#ifndef SMG_SPIN_H
#define SMG_SPIN_H

#include "smg_arrays.h"
#include "smg_site.h"

/* sqrt(a^2 + b^2) of a, b >= 0, also where the squares leave the range of a double. */
SMG_INLINE smg_real smg_hypot(smg_real a, smg_real b) {
  const smg_real square = a * a + b * b, most = a > b ? a : b, least = a > b ? b : a;
  if (square > (smg_real)1e-280 && square < (smg_real)1e280) return SMG_MATH(sqrt)(square);
  if (!(most > 0)) return square; /* 0 or NaN */
  const smg_real ratio = least / most;
  return most * SMG_MATH(sqrt)(1 + ratio * ratio);
}

/* rho = |w + W|/(2r) from k = |g|^2 and d = g.w/r, and ratio = d/rho. */
SMG_INLINE smg_real smg_own_rho(smg_real k, smg_real d, smg_real *ratio) {
  const smg_real below = 1 - k, size = d < 0 ? -d : d;
  const smg_real t = SMG_MATH(sqrt)((smg_abs(below) + smg_hypot(smg_abs(below), 2 * size)) / 2);
  *ratio = below > 0 ? d / t : d < 0 ? -t : t;
  return below > 0 ? t : size / t;
}

/* A field g whose square is beyond the range of a double, by its direction: as strong as that, its
 * strength no longer counts. What is not finite becomes NaN. */
static inline void smg_shorten(smg_real *g) { smg_scale(g, (smg_real)1e100 / smg_norm(g), 3); }

/* m, |m| = r, for the spin w, |w| = r > 0, and g = (h/2) b; W = w + 2 m x g follows. Returns 0
 * when the step has no solution (rho = 0), else 1; what is not finite makes m not finite. */
static inline int smg_own_spin(const smg_real *w, smg_real r, const smg_real *g, smg_real *m) {
  const smg_real k = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  const smg_real d = (w[0] * g[0] + w[1] * g[1] + w[2] * g[2]) / r;
  smg_real ratio;
  if (!(r > 0)) { /* nothing to turn */
    smg_copy(m, w, 3);
    return 1;
  }
  const smg_real rho = smg_own_rho(k, d, &ratio);
  if (k >= 1 && d >= 0 && d <= 0) return 0;
  const smg_real unit = k > 1 ? 1 / k : 1; /* only the direction counts; keeps strong fields in range */
  const smg_real a = rho * unit, s = ratio * r * unit;
  m[0] = a * w[0] + unit * (w[1] * g[2] - w[2] * g[1]) + s * g[0];
  m[1] = a * w[1] + unit * (w[2] * g[0] - w[0] * g[2]) + s * g[1];
  m[2] = a * w[2] + unit * (w[0] * g[1] - w[1] * g[0]) + s * g[2];
  smg_scale(m, r / smg_norm(m), 3);
  return 1;
}

/* u = 2((n.w/n.n) n - w), n along m: W - w of a step that is solved, free of the round-off of a strong field. */
static inline void smg_reflect(const smg_real *w, const smg_real *m, smg_real *u) {
  smg_real n[3];
  smg_unit(m, n);
  smg_multiple(u, smg_dot(n, w) / smg_dot(n, n), n, 3);
  smg_axpy(u, -1, w, 3);
  smg_scale(u, 2, 3);
}

/* Takes from v its part along n. */
SMG_INLINE void smg_across(const smg_real *n, smg_real *v) { smg_axpy(v, -(smg_dot(n, v) / smg_dot(n, n)), n, 3); }

/* Takes from u = h m x b its part along b, which is round-off, and changes the rest until |W| = |w|, W = w + u, w with
 * its compensation, |w| = r, where it is off by round-off: (w + W).u = 0. It is the least change that keeps W.b: along
 * the part of W across b, which is at least |u|/2. Without it round-off of a spin along its field would be along w, and
 * the same in every step. */
static inline void smg_stretch(const smg_real *w, const smg_real *compensation, smg_real r, const smg_real *b,
                               smg_real *u) {
  smg_real n[3], W[3], along = 0;
  smg_unit(b, n);
  smg_across(n, u);
  for (int e = 0; e < 3; e++) {
    W[e] = (w[e] + u[e]) / r;
    along += u[e] / r * (2 * (w[e] + compensation[e]) + u[e]);
  }
  smg_across(n, W);
  smg_axpy(u, -(along / (2 * smg_dot(W, W) + SMG_EPS)), W, 3);
}

#endif
