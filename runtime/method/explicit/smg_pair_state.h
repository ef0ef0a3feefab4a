/* smidgen method: which steps of pair rotations (smg_pair_rotations.h) go by rows of a lattice. */
#ifndef SMG_PAIR_STATE_H
#define SMG_PAIR_STATE_H

#include "smg_turn_state.h"

/* h/(2 kappa^2) of the part h of a step. */
static inline smg_real smg_pair_half(const smg_state *s, smg_real h) {
  const smg_real kappa = smg_kappa(&s->c, 0);
  return (smg_real)0.5 * h / (kappa * kappa);
}

/* Steps go by rows where no ring closes a class upon itself, and |g| <= |h/(2 kappa^2)| |f'| 2 |kappa| r and products
 * of spins stay far from overflow. */
static inline void smg_choose_rows(smg_state *s) {
  const smg_real r = smg_radius(&s->c, 0), square = r * r, half = smg_abs(smg_pair_half(s, smg_signed_h(s->h)));
  const smg_real g = half * smg_slope_bound(&s->c, square) * 2 * smg_abs(smg_kappa(&s->c, 0)) * r;
  s->rows =
      !smg_colours_meet(&s->c) && square <= SMG_FINITE_FIELD && half <= SMG_FINITE_FIELD && g * g <= SMG_FINITE_FIELD;
}

#endif
