/* smidgen method: which steps of sublattice rotations (smg_sublattice_rotations.h) go by rows of a lattice. */
#ifndef SMG_SUBLATTICE_STATE_H
#define SMG_SUBLATTICE_STATE_H

#include "smg_row_field.h"
#include "smg_turn_state.h"

/* Can no rotation of a step overflow, by the bound on the field? If that depends on time, as it is at the midpoint. */
static inline int smg_turns_are_finite(const smg_state *s) {
  return smg_row_field(&s->c, smg_signed_h(s->h)) <= SMG_FINITE_FIELD;
}

/* Steps go by rows where no two sites of a colour feel each other. */
static inline void smg_choose_rows(smg_state *s) {
  s->rows = !smg_colours_meet(&s->c) && (SMG_ROWS_IN_TIME || smg_turns_are_finite(s));
}
#define smg_next_by_rows(s) 1

#endif
