/* smidgen method: both spins of a bond turned about what they make together, for H a sum of f(w_i.w_j): explicit, symplectic, of order 2,
 * total momentum kept to round-off.
 *
 * The flow of one f(w_i.w_j) keeps w_i.w_j and L = kappa_i w_i + kappa_j w_j, and
 *
 *     w_i' = (1/kappa_i) f' w_i x w_j = f'/(kappa_i kappa_j) w_i x L,   w_j' likewise:
 *
 * both turn about L by the angle h f' |L|/(kappa_i kappa_j). Any angle that is a function of w_i.w_j makes a symplectic map; here it is that whose
 * half has the tangent |g|, g = h f'/(2 kappa_i kappa_j) L, right to third order:
 *
 *     W = w + 2/(1 + |g|^2) (w x g + (w x g) x g).
 *
 * A step is the symmetric splitting: bond after bond for h/2, and back. With SMG_COMPOSED it is so many of these (smg_explicit_step.h).
 *
 * Of the model it needs smg_each_pair(c, all, context, visit) and smg_each_pair_back: visit(context, i, j, f') of every bond, f' at the
 * vectors in `all` as they then are; and beside w, compensation and u the arrays s->points, 3 numbers a site, and s->inverse, 1. */
#ifndef SMG_PAIR_ROTATIONS_H
#define SMG_PAIR_ROTATIONS_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"
#include "smg_explicit.h"

/* What a visit works on: the state, and h. */
typedef struct smg_turning {
  smg_state *s;
  smg_real h;
} smg_turning;

/* One bond; slope = f'. */
static inline void smg_turn_pair(void *context, int64_t i, int64_t j, smg_real slope) {
  const smg_turning *turning = (const smg_turning *)context;
  smg_state *s = turning->s;
  smg_real *v = s->points + 3 * i, *w = s->points + 3 * j, g[3];
  const smg_real one = smg_kappa(&s->c, i), other = smg_kappa(&s->c, j), half = 0.5 * turning->h * slope / (one * other);
  for (int b = 0; b < 3; ++b) g[b] = half * (one * v[b] + other * w[b]);
  const smg_real scale = 2 / (1 + smg_dot(g, g));
  smg_turn_about(g, scale, v, s->u + 3 * i);
  smg_turn_about(g, scale, w, s->u + 3 * j);
}

static inline void smg_stage(smg_state *s, smg_real h) {
  smg_turning turning;
  turning.s = s;
  turning.h = 0.5 * h;
  smg_each_pair(&s->c, s->points, &turning, smg_turn_pair);
  smg_each_pair_back(&s->c, s->points, &turning, smg_turn_pair);
}

#include "smg_explicit_step.h"

#endif
