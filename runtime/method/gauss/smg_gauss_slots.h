/* smidgen method: the arrays of Gauss collocation on lattices (smg_gauss_rows.h), by slots, and z and w in lanes. */
#ifndef SMG_GAUSS_SLOTS_H
#define SMG_GAUSS_SLOTS_H

#include "smg_gauss_site.h"
#include "smg_row_slots.h"

/* ---- arrays ------------------------------------------------------------------------------- */

/* Numbers of the slots, component after component: w, what it has lost, z; and of every stage p, x = (r/|Z_i|^2) Z_i,
 * L_i, and the L_i before; then what differs from site to site. */
enum {
  SMG_SLOT_W = 0,
  SMG_SLOT_LOST = 3,
  SMG_SLOT_Z = 6,
  SMG_SLOT_STAGES = 10,
  SMG_SLOT_POINT = 0,
  SMG_STAGE_X = 3,
  SMG_STAGE_SLOPE = 7,
  SMG_STAGE_PAST = 11,
  SMG_SLOT_STAGE = 15,
  SMG_SLOT_COMPONENTS = SMG_SLOT_STAGES + SMG_SLOT_STAGE * SMG_STAGES
};

static inline int64_t smg_stages_size(const smg_coefficients *c) {
  return SMG_WIDEST + (SMG_SLOT_COMPONENTS + SMG_SITE_VALUES) * smg_pitch(c);
}

/* Slot 0 of a component; where component b of the L_j before is, of a slot. */
static inline smg_real *smg_slot_component(const smg_state *s, int64_t k) {
  return smg_line_from(s->stages) + SMG_BEFORE + k * smg_pitch(&s->c);
}
static inline smg_real *smg_past_number(const smg_state *s, int b, int j, int64_t slot) {
  return smg_slot_component(s, SMG_SLOT_STAGES + SMG_SLOT_STAGE * j + SMG_STAGE_PAST + b) + slot;
}

static inline int64_t smg_places(const smg_coefficients *c) { return smg_slots(c); }

/* Four components of some slots. */
SMG_INLINE void smg_take_four(const smg_real *all, int64_t pitch, int64_t slot, smg_lanes *v) {
  smg_take_from(4, all + slot, pitch, v);
}
SMG_INLINE void smg_put_four(smg_real *all, int64_t pitch, int64_t slot, const smg_lanes *v) {
  smg_put_at(4, all + slot, pitch, v);
}

/* ---- z and w -------------------------------------------------------------------------------- */

/* As smg_lift of smg_gauss_stages.h, with one division in place of two, and only for lengths that are not 0. Absent
 * sites have w = 0 and z = 0. */
SMG_INLINE void smg_lift(const smg_lanes *w, smg_real r, smg_lanes *z) {
  const smg_lanes zero = {0};
  smg_lanes large = smg_lane_sqrt((smg_real)0.5 * (r + smg_lane_abs(w[2])));
  const smg_lanes part = (smg_real)0.5 / large, re = w[0] * part, im = w[1] * part;
  const smg_lane_mask south = (smg_lane_mask)(w[2] < zero);
#if SMG_RESPONDS
  large = smg_lane_select((smg_lane_mask)(smg_lane_abs(w[0]) + smg_lane_abs(w[1]) + smg_lane_abs(w[2]) > zero), large,
                          zero);
#endif
  z[0] = smg_lane_select(south, re, large);
  z[1] = smg_lane_select(south, -im, zero);
  z[2] = smg_lane_select(south, large, re);
  z[3] = smg_lane_select(south, zero, im);
}

static void smg_lift_sites(const smg_state *s) {
  const int64_t pitch = smg_pitch(&s->c), end = smg_slots(&s->c);
  const smg_real *from = smg_slot_component(s, SMG_SLOT_W);
  smg_real *to = smg_slot_component(s, SMG_SLOT_Z);
  for (int64_t slot = 0; slot < end; slot += SMG_LANES) {
    smg_lanes w[3], z[4];
    smg_take_slots(from, pitch, slot, w);
    smg_lift(w, smg_radius(&s->c, 0), z);
    smg_put_four(to, pitch, slot, z);
  }
}

/* Copies w and what it has lost to rounding into slots. Empty slots hold a spin that nothing turns, or 0 if a torque
 * would turn it. */
static void smg_enter_slots(smg_state *s) {
  smg_real *w = smg_slot_component(s, SMG_SLOT_W);
  for (int64_t slot = 0; slot < smg_slots(&s->c); ++slot)
    w[2 * smg_pitch(&s->c) + slot] = SMG_PUSHES ? 0 : smg_radius(&s->c, 0);
  smg_put_absent(s, 1);
  smg_to_slots(s, s->w, w);
  smg_to_slots(s, s->compensation, smg_slot_component(s, SMG_SLOT_LOST));
  smg_lift_sites(s);
}
static void smg_leave_slots(smg_state *s) {
  smg_to_sites(s, smg_slot_component(s, SMG_SLOT_W), s->w);
  smg_put_absent(s, 0);
  smg_to_sites(s, smg_slot_component(s, SMG_SLOT_LOST), s->compensation);
}

#endif
