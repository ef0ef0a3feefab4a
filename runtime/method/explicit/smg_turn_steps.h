/* smidgen method: steps whose turns go by rows of a lattice. The header that includes this one defines smg_row_stage(s,
 * known, part), what smg_stage is from site to site. */
#ifndef SMG_TURN_STEPS_H
#define SMG_TURN_STEPS_H

#include "smg_explicit_step.h"
#include "smg_rows.h"
#include "smg_turn_state.h"

/* Stages that follow each other share a turn (SMG_TURN_BOTH), but where each has its own time, and so its own field. */
#if SMG_TIMED
#define SMG_STAGES_MEET 0
#else
#define SMG_STAGES_MEET 1
#endif

/* more: does another step follow in this call? */
static void smg_row_step(smg_state *s, smg_besides *known, int first, int more) {
  smg_real h = smg_signed_h(s->h), done = 0;
  for (int i = 0; i < SMG_STAGES; ++i) {
    const int end = i == SMG_STAGES - 1, after = SMG_STAGES_MEET && (i > 0 || !first),
              before = SMG_STAGES_MEET && (!end || more);
    const smg_turn_stage part = {smg_gamma[i] * h, smg_gamma[(i + 1) % SMG_STAGES] * h, after, before, end};
    smg_set_time_at(&s->c, s, done + (smg_real)0.5 * smg_gamma[i]);
    smg_row_stage(s, known, part);
    done += smg_gamma[i];
  }
  s->history = 1;
  ++s->count;
}

/* Could a rotation of the next step overflow, by the bound on the field at its midpoint? */
static int smg_overflows(SMG_UNUSED smg_state *s) {
#if SMG_ROWS_IN_TIME
  smg_set_time_at(&s->c, s, (smg_real)0.5);
  return !smg_turns_are_finite(s);
#else
  return 0;
#endif
}

/* count steps, or fewer: none fails but one that overflows. */
static smg_status smg_row_steps(smg_state *s, int64_t count) {
  smg_besides known;
  smg_begin_call(s, &known);
  s->report.status = SMG_OK;
  for (int64_t k = 0; k < count && s->report.status == SMG_OK; ++k)
    if (smg_overflows(s)) s->report.status = SMG_NOT_FINITE;
    else smg_row_step(s, &known, k == 0, k + 1 < count);
  smg_leave_rows(s);
  s->report.site = s->report.partner = -1;
  return s->report.status;
}

#endif
