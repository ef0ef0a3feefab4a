/* smidgen method: Gauss collocation (smg_gauss.h) on lattices, sites in the lanes of vectors.
 *
 * Components stand by slots (smg_rows.h): those of a colour follow each other, the gradient of a row comes from vectors
 * as they stand. A sweep takes the colours in turn, each with the points of the others as they are by then, all stages
 * of a piece while it is in the nearest cache; what a site's own turning adds is known, and sweeps are relaxed as is
 * best for it (smg_gauss_shift.h). */
#ifndef SMG_GAUSS_ROWS_H
#define SMG_GAUSS_ROWS_H

#include "smg_gauss.h"

#include "smg_gauss_sweep.h"

/* The L_j of the slots of one vector as the next step wants them: times the phase conj(y).z/r that takes y to z. */
SMG_INLINE void smg_turn_slopes(const smg_slot_sweep *a, int64_t slot, const smg_lanes *y, const smg_lanes *z) {
  const smg_lanes re = a->inverse * (y[0] * z[0] + y[1] * z[1] + (y[2] * z[2] + y[3] * z[3]));
  const smg_lanes im = a->inverse * (y[0] * z[1] - y[1] * z[0] + (y[2] * z[3] - y[3] * z[2]));
  for (int j = 0; j < SMG_STAGES; ++j)
    for (int b = 0; b < 4; b += 2) {
      const smg_lanes x = smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b) + slot),
                      v = smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b + 1) + slot);
      smg_lane_put(smg_sweep_stage(a, j, SMG_SLOT_PAST + b) + slot, re * x - im * v);
      smg_lane_put(smg_sweep_stage(a, j, SMG_SLOT_PAST + b + 1) + slot, re * v + im * x);
    }
}

/* u = 2 B(z + dz/2, dz) and the state after the step. */
static void smg_commit_all(const smg_state *s, const smg_slot_sweep *a) {
  const int64_t end_slot = smg_slots(&s->c), pitch = a->pitch;
  for (int64_t slot = 0; slot < end_slot; slot += SMG_LANES) {
    smg_lanes z[4], dz[4], middle[4], end[4], u[3], w[3];
    smg_take_four(a->z, pitch, slot, z);
    for (int b = 0; b < 4; ++b) {
      dz[b] = smg_lane_take(smg_sweep_stage(a, 0, SMG_SLOT_SLOPE + b) + slot);
      for (int j = 1; j < SMG_STAGES; ++j) dz[b] += smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b) + slot);
      middle[b] = z[b] + (smg_real)0.5 * dz[b];
      end[b] = z[b] + dz[b];
    }
    smg_collect(middle, dz, u);
    smg_take_slots(a->w, pitch, slot, w);
    for (int k = 0; k < 3; ++k) smg_lane_add_step(w + k, a->w + (SMG_SLOT_LOST + k) * pitch + slot, u[k]);
    smg_put_slots(a->w, pitch, slot, w);
    smg_lift(w, a->radius, z);
    smg_put_four(a->z, pitch, slot, z);
    smg_turn_slopes(a, slot, end, z);
  }
}

/* From the polynomial of the step before; when that fails, or there is none, from rest. */
static smg_status smg_slot_step(smg_state *s, smg_slot_sweep *a) {
  smg_begin_report(s);
  s->report.iterations = 0;
  smg_status status = s->history > 0 ? smg_settle_slots(s, a, 1) : SMG_NO_CONVERGENCE;
  if (status != SMG_OK) status = smg_settle_slots(s, a, 0);
  if (status != SMG_OK) return smg_end_report(s, status, smg_moving_site(s, a));
  smg_commit_all(s, a);
  s->history = 1;
  ++s->count;
  return smg_end_report(s, SMG_OK, -1);
}

static void smg_begin_sweep(smg_state *s, smg_slot_sweep *a) {
  a->w = smg_slot_component(s, SMG_SLOT_W);
  a->z = smg_slot_component(s, SMG_SLOT_Z);
  a->stages = smg_slot_component(s, SMG_SLOT_STAGES);
  a->pitch = smg_pitch(&s->c);
  a->radius = smg_radius(&s->c, 0);
  a->inverse = 1 / a->radius;
  a->size = SMG_MATH(sqrt)(a->radius);
  a->half = (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, smg_signed_h(s->h));
  a->marks = NULL;
  a->shift.theta = 0;
  smg_forget_besides(&s->c, &a->known);
#if SMG_SITE_VALUES
  a->known.values = s->row_values = smg_slot_component(s, SMG_SLOT_COMPONENTS);
  smg_fill_values(s);
#endif
  smg_begin_piece(&s->c, &a->known, a->gradient, &a->piece);
}

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_slot_sweep sweep;
  smg_begin_sweep(s, &sweep);
  smg_enter_slots(s);
  for (; count > 0 && status == SMG_OK; --count) status = smg_slot_step(s, &sweep);
  smg_leave_slots(s);
  return status;
}

static inline smg_status smg_step(smg_state *s) { return smg_steps(s, 1); }

#endif
