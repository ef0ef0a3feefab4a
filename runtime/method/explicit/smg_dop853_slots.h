/* smidgen method: what smg_dop853.h asks of single sites, by slots of a lattice (smg_field_rows.h): the largest error
 * of an internal step, and, with SMG_PROJECT, each site back on its sphere. */
#ifndef SMG_DOP853_SLOTS_H
#define SMG_DOP853_SLOTS_H

#include "smg_dop853_control.h"
#include "smg_dop853_trial.h"

#if SMG_ROW_FIELDS
#include "smg_field_rows.h"
#include "smg_lane_vec.h"

#define smg_site_error smg_lane_site_error
#include "smg_in_lanes.h"
#include "smg_dop853_error_template.h"
#include "smg_in_numbers.h"
#undef smg_site_error

/* The errors of the slots of one vector. */
SMG_INLINE smg_lanes smg_errors_at(const smg_state *s, int64_t slot) {
  const int64_t pitch = smg_pitch(&s->c), at = SMG_BEFORE + slot;
  smg_lanes y[3], u[3], e5[3], e3[3];
  smg_take_slots(smg_vector(s, SMG_Y), pitch, at, y);
  smg_take_slots(s->u, pitch, at, u);
  smg_take_slots(smg_vector(s, SMG_E5), pitch, at, e5);
  smg_take_slots(smg_vector(s, SMG_E3), pitch, at, e3);
  return smg_lane_site_error(y, u, e5, e3);
}

/* The site of the largest, for the report. */
static inline int64_t smg_site_of_error(const smg_state *s, smg_real most) {
  const int64_t last = smg_slots(&s->c) - 1;
  for (int64_t slot = 0;; ++slot) {
    const smg_lanes errors = smg_errors_at(s, slot);
    const smg_real error = smg_lane_get(&errors, 0);
    if (slot == last || (most == most ? error >= most : error != error)) return smg_site_at(s, slot);
  }
}

static smg_real smg_largest_error(smg_state *s) {
  smg_lanes most = {0};
  for (int64_t slot = 0; slot < smg_slots(&s->c); slot += SMG_LANES) most = smg_lane_max(most, smg_errors_at(s, slot));
  return smg_lane_largest(most);
}

#if SMG_PROJECT
SMG_INLINE void smg_slot_on_leaf(void *context, int64_t site, int64_t slot) {
  const smg_state *s = (const smg_state *)context;
  const int64_t pitch = smg_pitch(&s->c);
  smg_real *y = smg_vector(s, SMG_Y) + SMG_BEFORE + slot, *lost = smg_vector(s, SMG_Y_COMPENSATION) + SMG_BEFORE + slot;
  smg_real v[3] = {y[0], y[pitch], y[2 * pitch]}, carry[3] = {lost[0], lost[pitch], lost[2 * pitch]};
  if (!(smg_moves(&s->c, site) > 0)) return;
  smg_back_on_leaf(s, site, v, carry);
  for (int b = 0; b < 3; ++b) {
    y[b * pitch] = v[b];
    lost[b * pitch] = carry[b];
  }
}
static void smg_back_on_leaves(smg_state *s) { smg_each_slot(&s->c, s, smg_slot_on_leaf); }
#endif
#endif

#endif
