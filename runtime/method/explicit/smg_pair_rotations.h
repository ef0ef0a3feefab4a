/* smidgen method: both spins of a bond turned about what they make together, for H a sum of f(w_i.w_j): explicit,
 * symplectic, of order 2, total momentum kept to round-off.
 *
 * The flow of one f(w_i.w_j) keeps w_i.w_j and L = kappa_i w_i + kappa_j w_j, and
 *
 *     w_i' = (1/kappa_i) f' w_i x w_j = f'/(kappa_i kappa_j) w_i x L,   w_j' likewise:
 *
 * both turn about L by the angle h f' |L|/(kappa_i kappa_j). Any angle that is a function of w_i.w_j makes a symplectic
 * map; here it is that whose half has the tangent |g|, g = a L, a = h f'/(2 kappa_i kappa_j), right to third order
 * (smg_turn_template.h). Where kappa_i = kappa_j the sum of both keeps all its digits. At the end of a step lengths
 * come some of the way back to what they were (smg_lengths.h).
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
  const smg_state *s = turning->s;
  const smg_real one = smg_kappa(&s->c, i), other = smg_kappa(&s->c, j), a = 0.5 * turning->h / (one * other) * slope;
  smg_real *v = s->points + 3 * i, *w = s->points + 3 * j, *v_lost = s->u + 3 * i, *w_lost = s->u + 3 * j;
  const smg_real square = smg_turn_both(a, one, other, v, v_lost, w, w_lost);
  if (!(square <= SMG_MAX))
    v[0] = w[0] = v_lost[0] = w_lost[0] = square - square; /* no number, so that the step fails */
}

/* Bond after bond, and back. */
static inline void smg_turn_bonds(smg_state *s, smg_real h) {
  smg_bond_turning turning = {s, h};
  smg_each_pair(&s->c, s->points, &turning, smg_turn_pair);
  smg_each_pair_back(&s->c, s->points, &turning, smg_turn_pair);
}

/* Class after class, and back; bonds where there are no classes. */
static inline void smg_stage(smg_state *s, smg_real h) {
  const int64_t n = smg_bond_classes(&s->c);
  if (n == 0) smg_turn_bonds(s, 0.5 * h);
  for (int64_t k = 0; k < 2 * n - 1; ++k) {
    smg_bond_turning turning = {s, smg_turn_h(k, n, h)};
    smg_each_of_class(&s->c, smg_there_and_back(k, n), s->points, &turning, smg_turn_pair);
  }
}

#include "smg_explicit_step.h"

#endif
