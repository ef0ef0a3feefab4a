/* smidgen method: RATTLE on T*S^3, reduced: symplectic, of order 2. A comparator. A unit quaternion q and a quaternion
 * p across it stand for the w of a site, w = vec(q* p)/2 with the conjugate q*. H(w) says nothing of p along q, and
 * RATTLE (Andersen 1983; for general H Jay, SIAM J. Numer. Anal. 33, 1996; Hairer, Lubich, Wanner, Geometric Numerical
 * Integration, VII.1.4) asks for it: it is taken as that of H + (kappa c/2r) (q.p)^2, r = |w|, and the step depends on
 * c. With q = 1 at the start of the step and q1 at its end, p = (s, 2 A) in its middle, q1* p = (sigma, 2 B),
 * f = (h/2) b(A), g = (h/2) b(B), b = (1/kappa) dH/dw, both at t + h/2, and e = h c/2r,
 *
 *     w = x A - (s/4) f + f x A/2,   q1 = (x + f/2)/(y - g/2),   |q1| = 1,   x = 1 + e s,   y = 1 - e sigma,
 *     W = q1* w q1 = w + A x f + B x g.
 *
 * Only b counts, not the scale of H and kappa, nor that of w. A and B are no points of the sphere: H is taken as its
 * formula has it off the sphere too, and momentum is kept where a rotation leaves that formula unchanged. */
#ifndef SMG_RATTLE_H
#define SMG_RATTLE_H

#define SMG_ONTO_LEAF 0
#define SMG_SLOPES 8 /* f, g, e s, e sigma */
#ifndef SMG_EXTENSION
#define SMG_EXTENSION (smg_real)0.25 /* c */
#endif

#include "smg_model.h"

/* A positive multiple of q1 = (x + f/2)(y + g/2)/|y - g/2|^2. */
SMG_INLINE void smg_rattle_turn(const smg_real *a, smg_real *q) {
  const smg_real x = 1 + a[6], y = 1 - a[7], *f = a, *g = a + 3;
  smg_cross(q + 1, f, g);
  for (int b = 0; b < 3; ++b) q[1 + b] = (smg_real)0.25 * q[1 + b] + (smg_real)0.5 * (x * g[b] + y * f[b]);
  q[0] = x * y - (smg_real)0.25 * smg_dot(f, g);
}

/* W = q1* w q1. */
SMG_INLINE void smg_stage_increment(const smg_real *w, const smg_real *a, smg_real *u) {
  smg_real q[4];
  smg_rattle_turn(a, q);
  smg_turn_increment(q[0], q + 1, w, u);
}

/* A is found by a division by x; B, from the end of the step, by y. */
SMG_INLINE int smg_stage_serves(const smg_real *a) { return 1 + a[6] > 0 && 1 - a[7] > 0; }

#include "smg_slopes.h"

/* e: of the motion, and so without the signs of kappa and of the bracket. */
SMG_INLINE smg_real smg_rattle_e(const smg_state *s, const smg_real *w) {
  const smg_real r = smg_norm(w);
  return (smg_real)0.5 * SMG_EXTENSION * s->h / (r > 0 ? r : 1);
}

/* A with f and s: x (x^2 + |d|^2) A = x^2 v - x d x v + d (d.v), d = f/2, v = w + (s/2) d. */
SMG_INLINE void smg_rattle_first(const smg_real *w, smg_real s, const smg_real *a, smg_real *A) {
  const smg_real x = 1 + a[6], d[3] = {a[0] / 2, a[1] / 2, a[2] / 2};
  const smg_real v[3] = {w[0] + s / 2 * d[0], w[1] + s / 2 * d[1], w[2] + s / 2 * d[2]};
  const smg_real along = smg_dot(d, v), scale = 1 / (x * (x * x + smg_dot(d, d)));
  smg_cross(A, v, d);
  for (int b = 0; b < 3; ++b) A[b] = scale * (x * (x * v[b] + A[b]) + along * d[b]);
}

/* (sigma, 2 B) = q1* (s, 2 A), with q1 made of length 1; sigma. */
SMG_INLINE smg_real smg_rattle_second(smg_real s, const smg_real *a, const smg_real *A, smg_real *B) {
  smg_real q[4];
  smg_rattle_turn(a, q);
  const smg_real scale = 1 / SMG_MATH(sqrt)(q[0] * q[0] + smg_dot(q + 1, q + 1));
  smg_cross(B, A, q + 1);
  for (int b = 0; b < 3; ++b) B[b] = scale * (q[0] * A[b] + B[b] - s / 2 * q[1 + b]);
  return scale * (q[0] * s + 2 * smg_dot(q + 1, A));
}

/* (h/2) b in place of each of these points. */
static inline void smg_rattle_fields(smg_state *s, smg_real *points) {
  const int64_t sites = smg_sites(&s->c);
  smg_zero(s->u, 3 * sites);
  smg_gradient(&s->c, points, s->u);
  for (int64_t k = 0; k < sites; ++k) {
    const smg_real half = 0.5 * smg_h_over_kappa(&s->c, k, smg_signed_h(s->h));
    smg_multiple(points + 3 * k, half, s->u + 3 * k, 3);
  }
}

/* New f and g; e s - e sigma is `apart`, and e s + e sigma follows from |q1| = 1: x^2 - y^2 = (g.g - f.f)/4. */
static inline void smg_rattle_renew(smg_state *s, int64_t k, const smg_real *f, const smg_real *g, smg_real apart,
                                    smg_moved *moved) {
  const smg_real *a = s->slopes + SMG_SLOPES * k, size = smg_norm(s->w + 3 * k);
  const smg_real sum = (smg_dot(g, g) - smg_dot(f, f)) / (4 * (2 + a[6] - a[7]));
  const smg_real next[SMG_SLOPES] = {f[0], f[1], f[2], g[0], g[1], g[2], (sum + apart) / 2, (sum - apart) / 2};
  smg_renew_slopes(s, k, next, size / 2, smg_sum_of_sizes(next, 6) / 2, moved);
}

static smg_moved smg_sweep_stages(smg_state *s, SMG_UNUSED void *with) {
  const int64_t sites = smg_sites(&s->c);
  smg_real *A = s->points, *B = A + 3 * sites, *apart = B + 3 * sites;
  smg_moved moved = {0, 0, 0};
  for (int64_t k = 0; k < sites; ++k) {
    const smg_real *w = s->w + 3 * k, *a = s->slopes + SMG_SLOPES * k, e = smg_rattle_e(s, w), along = a[6] / e;
    smg_rattle_first(w, along, a, A + 3 * k);
    apart[k] = a[6] - e * smg_rattle_second(along, a, A + 3 * k, B + 3 * k);
  }
  smg_rattle_fields(s, A);
  smg_rattle_fields(s, B);
  for (int64_t k = 0; k < sites; ++k) smg_rattle_renew(s, k, A + 3 * k, B + 3 * k, apart[k], &moved);
  return moved;
}

#endif
