/* smidgen method: rotations about the axes, for H = A(all x) + B(all y) + C(all z): explicit, symplectic, of order 2.
 *
 * The flow of A leaves every x alone, so its gradient too: it turns site k about the x axis by the angle (h/kappa_k)
 * dA/dx_k. One step is the symmetric (Strang) splitting
 *
 *     Phi_h = X(h/2) Y(h/2) Z(h) Y(h/2) X(h/2),
 *
 * the time of H frozen at its middle. McLachlan and Quispel, Splitting methods, Acta Numerica 11 (2002), section 3.
 *
 * A rotation is known by tau, the tangent of half its angle: sin = 2 tau/(1 + tau^2), 1 - cos = tau sin. Where no term
 * joins two sites (SMG_SEPARATE) tau is half the angle itself: any angle that is a function of x_k alone makes a
 * symplectic map, and this one is right to third order and needs no tangent. Where terms do, kappa_k times the angle
 * must be the gradient of a function of all x: then it is exact.
 *
 * With SMG_COMPOSED a step is so many of these (smg_explicit_step.h).
 *
 * Of the model it needs SMG_AXES (1, 2, 4: there are x, y, z in H) and
 *   SMG_SEPARATE (and SMG_ONE_SITE, where there is but one): smg_slope_x(c, k, v), _y, _z   dH/dx_k at the vector v of
 *   the site
 *   otherwise: smg_slopes_x(c, w, g), _y, _z                                                g[k] += dH/dx_k of all
 *   sites
 * and beside w, compensation and u the arrays s->points, 3 numbers a site, s->slopes and s->inverse, 1 each. */
#ifndef SMG_AXIS_SPLITTING_H
#define SMG_AXIS_SPLITTING_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"
#include "smg_explicit.h"

/* R v for v, and (R - 1) v more for u: the rotation R about an axis that w' = w x b makes of b along it,
 * (R - 1) v = sin (v x axis) - (1 - cos) v across it. */
SMG_INLINE void smg_turn_about_axis(int axis, smg_real tau, smg_real *v, smg_real *u) {
  const int b = (axis + 1) % 3, d = (axis + 2) % 3;
  const smg_real square = tau * tau, scale = 2 / (1 + square);
  const smg_real x = scale * (tau * v[d] - square * v[b]), y = scale * (tau * v[b] + square * v[d]);
  v[b] += x;
  u[b] += x;
  v[d] -= y;
  u[d] -= y;
}

/* Is there anything to turn about this axis? */
#define SMG_HAS_AXIS(axis) ((SMG_AXES >> (axis)) & 1)

#if SMG_SEPARATE
SMG_INLINE smg_real smg_slope(const smg_coefficients *c, int axis, int64_t k, const smg_real *v) {
  return axis == 0 ? smg_slope_x(c, k, v) : axis == 1 ? smg_slope_y(c, k, v) : smg_slope_z(c, k, v);
}

/* About one axis; half = h/(2 kappa) times its part of the step. */
SMG_INLINE void smg_turn_site(const smg_coefficients *c, int axis, int64_t k, smg_real half, smg_real *v, smg_real *u) {
  if (SMG_HAS_AXIS(axis)) smg_turn_about_axis(axis, half * smg_slope(c, axis, k, v), v, u);
}

/* A stage of site k. */
SMG_INLINE void smg_stage_of_site(const smg_coefficients *c, int64_t k, smg_real h, smg_real *v, smg_real *u) {
  const smg_real half = 0.5 * smg_h_over_kappa(c, k, h);
  SMG_UNROLL
  for (int n = 0; n < 5; ++n) smg_turn_site(c, (int)smg_there_and_back(n, 3), k, smg_turn_h(n, 3, half), v, u);
}

#if SMG_ONE_SITE
SMG_INLINE void smg_stage(smg_state *s, smg_real h, smg_real *v, smg_real *u) { smg_stage_of_site(&s->c, 0, h, v, u); }
#else
static inline void smg_stage(smg_state *s, smg_real h) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_stage_of_site(&s->c, k, h, s->points + 3 * k, s->u + 3 * k);
}
#endif
#else
/* All sites about one axis, for the part h of the step. */
SMG_INLINE void smg_turn_all(smg_state *s, int axis, smg_real h) {
  const int64_t sites = smg_sites(&s->c);
  if (!SMG_HAS_AXIS(axis)) return;
  smg_zero(s->slopes, sites);
  if (axis == 0) smg_slopes_x(&s->c, s->points, s->slopes);
  if (axis == 1) smg_slopes_y(&s->c, s->points, s->slopes);
  if (axis == 2) smg_slopes_z(&s->c, s->points, s->slopes);
  for (int64_t k = 0; k < sites; ++k) {
    const smg_real half = 0.5 * smg_h_over_kappa(&s->c, k, h) * s->slopes[k];
    smg_turn_about_axis(axis, SMG_MATH(tan)(half), s->points + 3 * k, s->u + 3 * k);
  }
}

static inline void smg_stage(smg_state *s, smg_real h) {
  SMG_UNROLL
  for (int n = 0; n < 5; ++n) smg_turn_all(s, (int)smg_there_and_back(n, 3), smg_turn_h(n, 3, h));
}
#endif

#include "smg_explicit_step.h"

#endif
