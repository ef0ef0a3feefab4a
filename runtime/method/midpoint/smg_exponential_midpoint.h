/* smidgen method: the Lie-group method with the exponential map: symplectic, of order 2. A comparator. Variational on
 * T*SU(2) (McLachlan, Modin, Verdier, A minimal-variable symplectic integrator on spheres, name it beside RATTLE;
 * Bou-Rabee and Marsden, Hamilton-Pontryagin integrators on Lie groups, Found. Comput. Math. 9, 2009), with the
 * exponential map from the algebra to the group, and reduced by the rotations that leave w unchanged. With
 * x = h b(v), b = (1/kappa) dH/dw, t = |x|,
 *
 *     w = v - v x x/2 + k ((x.v) x - t^2 v),   W = v + v x x/2 + k ((x.v) x - t^2 v),   k = (1 - (t/2) cot(t/2))/t^2.
 *
 * W is w turned about x, and v the mean of w along this turn:
 *
 *     v = w + (s^2/2) w x x + c (w x x) x x,   s = sin(t/2)/(t/2),   c = (1 - sin(t)/t)/t^2.
 *
 * The isospectral midpoint is the same with the Cayley map in place of the exponential. As there, v is no point of the
 * sphere: H is taken as its formula has it off the sphere too, and W - w = h v x b(v) keeps momentum where a rotation
 * leaves that formula unchanged. */
#ifndef SMG_EXPONENTIAL_MIDPOINT_H
#define SMG_EXPONENTIAL_MIDPOINT_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"
#include "smg_rotation.h"

/* The exponential map is a local diffeomorphism where t < 2 pi: so far the method is defined. */
#define SMG_HALF_TURN (smg_real)3.141592653589793

/* v; the slope is x/2. That 1 - sin(t)/t is a difference of nearby numbers costs an ulp of w, not more: c is multiplied
 * by t^2. */
SMG_INLINE void smg_stage_point(const smg_real *w, const smg_real *a, smg_real *v) {
  const smg_real half = smg_norm(a), s = smg_sinc(half), square = 4 * half * half;
  const smg_real c = square > 0 ? (1 - smg_sinc(2 * half)) / square : 0;
  smg_real x[3], xx[3];
  smg_cross(x, w, a);
  smg_cross(xx, x, a);
  for (int b = 0; b < 3; ++b) v[b] = w[b] + s * s * x[b] + 4 * c * xx[b];
}

SMG_INLINE void smg_stage_increment(const smg_real *w, const smg_real *a, smg_real *u) {
  const smg_real x[3] = {2 * a[0], 2 * a[1], 2 * a[2]};
  smg_real W[3] = {w[0], w[1], w[2]};
  smg_zero(u, 3);
  smg_turn_by(x, W, u);
}

SMG_INLINE int smg_stage_serves(const smg_real *a) { return smg_norm(a) < SMG_HALF_TURN; }

#include "smg_one_stage.h"

#endif
