/* smidgen method: Gauss collocation (smg_gauss.h) on lattices, sites in the lanes of vectors.
 *
 * Components stand by slots (smg_rows.h): those of a colour follow each other, the gradient of a row comes from vectors
 * as they stand. A sweep takes the colours in turn, each with the points of the others as they are by then, all stages
 * of a piece while it is in the nearest cache; what a site's own turning adds is known, and sweeps are relaxed as is
 * best for it (smg_gauss_shift.h). */
#ifndef SMG_GAUSS_ROWS_H
#define SMG_GAUSS_ROWS_H

#include "smg_gauss_step.h"

static void smg_begin_sweep(smg_state *s, smg_gauss_work *a) {
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
  a->told = smg_told_of(&s->c, 0);
  smg_forget_besides(&s->c, SMG_KINDS_OF(s), &a->known);
#if SMG_SITE_VALUES
  a->known.values = s->row_values = smg_slot_component(s, SMG_SLOT_COMPONENTS);
  smg_fill_values(s);
#endif
  smg_begin_piece(&s->c, &a->known, a->gradient, &a->piece);
}

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_stage_row_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_gauss_work sweep;
  smg_begin_sweep(s, &sweep);
  smg_enter_slots(s);
  for (; count > 0 && status == SMG_OK; --count) status = smg_collocate(s, &sweep);
  smg_leave_slots(s);
  return status;
}

static inline smg_status smg_step(smg_state *s) { return smg_stage_row_steps(s, 1); }

#endif
