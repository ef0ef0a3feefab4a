/* smidgen method: the state of methods whose turns go by rows of a lattice, sites in the lanes of vectors. No step
 * fails there, so w itself is turned. */
#ifndef SMG_TURN_STATE_H
#define SMG_TURN_STATE_H

#include "smg_row_arrays.h"
#include "smg_row_team.h"
#include "smg_state.h"

#include "smg_in_lanes.h"
#include "smg_turn_template.h"
#include "smg_in_numbers.h"

#define SMG_FINITE_FIELD (smg_real)1e100 /* |g|^2 up to which no turn overflows, by far */

/* The arrays by slots: w, and what it has lost to rounding. */
static inline size_t smg_row_layout(smg_state *s, smg_real *mem) {
  const size_t size = (size_t)smg_array_size(&s->c);
  if (mem) (void)smg_place_row_arrays(s, mem, size);
  const size_t used = SMG_WIDEST + 3 * size;
  return used + smg_place_tables(s, mem ? mem + used : NULL);
}

static inline void smg_make_tables(smg_state *s) {
  if (s->rows) smg_fill_tables(s);
}

/* A stage: the h of it and of the next one; after: has one gone before in this call? before: does one follow? end: is
 * it the last of a step? */
typedef struct smg_turn_stage {
  smg_real h, next;
  int after, before, end;
} smg_turn_stage;

/* What turns work with: w and what it has lost, by slots. */
typedef struct smg_turned {
  smg_real *w, *lost;
  int64_t pitch;
} smg_turned;

static inline smg_turned smg_turned_of(const smg_state *s) {
  const smg_turned all = {s->row_w, s->row_compensation, smg_pitch(&s->c)};
  return all;
}

/* The spins of the slots of one vector, and what they have lost. */
typedef struct smg_lane_spins {
  smg_lanes w[3], lost[3];
} smg_lane_spins;

SMG_INLINE void smg_take_spins(const smg_turned all, int64_t slot, smg_lane_spins *a) {
  smg_take_slots(all.w, all.pitch, slot, a->w);
  smg_take_slots(all.lost, all.pitch, slot, a->lost);
}
SMG_INLINE void smg_put_spins(const smg_turned all, int64_t slot, const smg_lane_spins *a) {
  smg_put_slots(all.w, all.pitch, slot, a->w);
  smg_put_slots(all.lost, all.pitch, slot, a->lost);
}

/* A saved state has what is lost, and the lengths, of each site. */
static void smg_save_rows(const smg_state *s, smg_real *lost, smg_real *past) {
  smg_to_sites(s, s->row_compensation, lost);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) past[k] = s->history > 0 ? smg_inverse_square(&s->c) : 0;
}

static void smg_restore_rows(smg_state *s, const smg_real *lost, SMG_UNUSED const smg_real *past) {
  smg_to_slots(s, lost, s->row_compensation);
}

#endif
