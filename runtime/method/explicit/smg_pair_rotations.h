/* smidgen method: both spins of a bond turned about what they make together, for H a sum of f(w_i.w_j): explicit,
 * symplectic, of order 2, total momentum kept to round-off.
 *
 * The flow of one f(w_i.w_j) keeps w_i.w_j and L = kappa_i w_i + kappa_j w_j, and
 *
 *     w_i' = (1/kappa_i) f' w_i x w_j = f'/(kappa_i kappa_j) w_i x L,   w_j' likewise:
 *
 * both turn about L by the angle h f' |L|/(kappa_i kappa_j). Any angle that is a function of w_i.w_j makes a symplectic
 * map; here it is that whose half has the tangent |g|, g = a L, a = h f'/(2 kappa_i kappa_j), right to third order:
 *
 *     W = w + 2/(1 + |g|^2) (w x g + (w x g) x g).
 *
 * Of both ends that is one vector, for w_i x g = a kappa_j p and w_j x g = -a kappa_i p with p = w_i x w_j:
 *
 *     W_i = w_i + kappa_j q,   W_j = w_j - kappa_i q,   q = 2 a/(1 + |g|^2) (p + p x g).
 *
 * Every turn is added to w with its rounding error carried along, so where kappa_i = kappa_j the sum of both keeps all
 * its digits. At the end of a step lengths come some of the way back to what they were (smg_lengths.h).
 *
 * On a lattice whose rings fit its colours the bonds go by classes: all of one direction whose first site has one
 * colour. No two of them meet, so that their order is of no account. A step is the symmetric splitting: the classes one
 * after the other for h/2, the last for h, and back. Elsewhere it is bond after bond for h/2, and back. With
 * SMG_COMPOSED it is so many of these (smg_explicit_step.h).
 *
 * On a lattice whose sites are alike it goes by rows, sites in lanes (smg_pair_rows.h), where SMG_ROW_CLASSES says so.
 *
 * Of the model it needs smg_bond_classes(c), smg_each_of_class(c, which, all, context, visit), smg_each_pair(c, all,
 * context, visit) and smg_each_pair_back: visit(context, i, j, f') of every bond, f' at the vectors in `all` as they
 * then are; and beside w, compensation and u the arrays s->points, 3 numbers a site, and s->inverse, 1. */
#ifndef SMG_PAIR_ROTATIONS_H
#define SMG_PAIR_ROTATIONS_H

#define SMG_ONTO_LEAF 0
#define SMG_TURNS_ADDED 1
#define SMG_LENGTHS_LAST 1

#include "smg_model.h"
#include "smg_explicit.h"

/* What a visit works on: the state, and h. */
typedef struct smg_bond_turning {
  smg_state *s;
  smg_real h;
} smg_bond_turning;

/* One bond; slope = f'. */
static inline void smg_turn_pair(void *context, int64_t i, int64_t j, smg_real slope) {
  const smg_bond_turning *turning = (const smg_bond_turning *)context;
  smg_state *s = turning->s;
  smg_real *v = s->points + 3 * i, *w = s->points + 3 * j, *v_lost = s->u + 3 * i, *w_lost = s->u + 3 * j, g[3], p[3],
           pg[3];
  const smg_real one = smg_kappa(&s->c, i), other = smg_kappa(&s->c, j), a = 0.5 * turning->h / (one * other) * slope;
  for (int b = 0; b < 3; ++b) g[b] = a * (one * v[b] + other * w[b]);
  /* of what overflows, no number */
  const smg_real square = smg_dot(g, g), scale = square <= SMG_MAX ? 2 / (1 + square) * a : square - square;
  smg_cross(p, v, w);
  smg_cross(pg, p, g);
  for (int b = 0; b < 3; ++b) {
    const smg_real q = scale * (p[b] + pg[b]);
    smg_add_compensated(v + b, v_lost + b, other * q);
    smg_add_compensated(w + b, w_lost + b, -(one * q));
  }
}

static inline void smg_turn_class(smg_state *s, int64_t which, smg_real h) {
  smg_bond_turning turning;
  turning.s = s;
  turning.h = h;
  smg_each_of_class(&s->c, which, s->points, &turning, smg_turn_pair);
}

/* Bond after bond, and back. */
static inline void smg_turn_bonds(smg_state *s, smg_real h) {
  smg_bond_turning turning;
  turning.s = s;
  turning.h = h;
  smg_each_pair(&s->c, s->points, &turning, smg_turn_pair);
  smg_each_pair_back(&s->c, s->points, &turning, smg_turn_pair);
}

static inline void smg_stage(smg_state *s, smg_real h) {
  const int64_t last = smg_bond_classes(&s->c) - 1;
  if (last < 0) {
    smg_turn_bonds(s, 0.5 * h);
    return;
  }
  for (int64_t k = 0; k < last; ++k) smg_turn_class(s, k, 0.5 * h);
  smg_turn_class(s, last, h);
  for (int64_t k = last - 1; k >= 0; --k) smg_turn_class(s, k, 0.5 * h);
}

#include "smg_explicit_step.h"

#endif
