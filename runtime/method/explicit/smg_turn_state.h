/* smidgen method: the state of methods whose turns go by rows of a lattice, sites in the lanes of vectors. No step
 * fails there, so w itself is turned. */
#ifndef SMG_TURN_STATE_H
#define SMG_TURN_STATE_H

#include "smg_row_arrays.h"
#include "smg_row_team.h"
#include "smg_state.h"

#define SMG_FINITE_FIELD (smg_real)1e100 /* |g|^2 up to which no turn overflows, by far */

/* The arrays by slots: w, and what it has lost to rounding. */
static inline size_t smg_row_layout(smg_state *s, smg_real *mem) {
  const size_t size = (size_t)smg_array_size(&s->c);
  if (mem) (void)smg_place_row_arrays(s, mem, size);
  const size_t used = SMG_WIDEST + 3 * size;
  return used + smg_place_tables(s, mem ? mem + used : NULL);
}

/* A stage: the h of it and of the next one; after: has one gone before in this call? before: does one follow? end: is
 * it the last of a step? */
typedef struct smg_turn_stage {
  smg_real h, next;
  int after, before, end;
} smg_turn_stage;

/* 1/|w|^2, as smg_lengths.h has it for spheres. */
static inline smg_real smg_row_inverse(const smg_state *s) { return 1 / (smg_radius(&s->c, 0) * smg_radius(&s->c, 0)); }

/* A saved state has what is lost, and the lengths, of each site. */
static void smg_save_rows(const smg_state *s, smg_real *lost, smg_real *past) {
  smg_to_sites(s, s->row_compensation, lost);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) past[k] = s->history > 0 ? smg_row_inverse(s) : 0;
}

static void smg_restore_rows(smg_state *s, const smg_real *lost, const smg_real *past) {
  (void)past;
  smg_to_slots(s, lost, s->row_compensation);
}

#endif
