/* smidgen method: which steps of sublattice rotations (smg_sublattice_rotations.h) go by rows of a lattice. */
#ifndef SMG_SUBLATTICE_STATE_H
#define SMG_SUBLATTICE_STATE_H

#include "smg_row_field.h"
#include "smg_turn_state.h"

/* Steps go by rows where no two sites of a colour feel each other. */
static inline void smg_choose_rows(smg_state *s) {
  s->rows = !smg_colours_meet(&s->c) && smg_row_field(&s->c, smg_signed_h(s->h)) <= SMG_FINITE_FIELD;
}

#endif
