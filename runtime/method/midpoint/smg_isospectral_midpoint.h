/* smidgen method: the isospectral midpoint of so(3): symplectic, of order 2. A comparator. Modin and Viviani, A
 * minimal-variable symplectic integrator for isospectral flows (BIT 60, 2020): with w as the matrix that maps x to w x
 * x, and B as that of -b, so that w' = [B, w],
 *
 *     w = (1 - (h/2) B) v (1 + (h/2) B),   W = (1 + (h/2) B) v (1 - (h/2) B),   B taken at v.
 *
 * As vectors, with g = (h/2) b(v), b = (1/kappa) dH/dw: w = v - v x g + (g.v) g and W = v + v x g + (g.v) g. Solved for
 * v,
 *
 *     v = (w + w x g)/(1 + |g|^2),   W = w + 2/(1 + |g|^2) (w x g + (w x g) x g):
 *
 * a rotation of w about g by the angle whose half has the tangent |g|. v is no point of the sphere: H is taken as its
 * formula has it off the sphere too, which close vortices bear with small steps only (smg_gauss.h). W - w = h v x b(v)
 * keeps momentum where a rotation leaves that formula unchanged. */
#ifndef SMG_ISOSPECTRAL_MIDPOINT_H
#define SMG_ISOSPECTRAL_MIDPOINT_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"

/* v; the slope is g. */
SMG_INLINE void smg_stage_point(const smg_real *w, const smg_real *g, smg_real *v) {
  smg_cross(v, w, g);
  smg_axpy(v, 1, w, 3);
  smg_scale(v, 1 / (1 + smg_dot(g, g)), 3);
}

SMG_INLINE void smg_stage_increment(const smg_real *w, const smg_real *g, smg_real *u) {
  smg_turn_increment(1, g, w, u);
}

SMG_INLINE int smg_stage_serves(SMG_UNUSED const smg_real *a) { return 1; }

#include "smg_one_stage.h"

#endif
