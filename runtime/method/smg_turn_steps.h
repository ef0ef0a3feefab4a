/* smidgen method: steps whose turns go by rows of a lattice. The header that includes this one defines smg_row_stage(s, known, h, end), what smg_stage is
 * from site to site, of a field that does not depend on time; end: the last of a step. */
#ifndef SMG_TURN_STEPS_H
#define SMG_TURN_STEPS_H

#include "smg_rows.h"

static void smg_row_step(smg_state *s, smg_besides *known) {
  for (int i = 0; i < SMG_STAGES; ++i) smg_row_stage(s, known, smg_gamma[i] * smg_signed_h(s->h), i == SMG_STAGES - 1);
  s->history = 1;
  ++s->count;
}

/* count steps: none fails. */
static smg_status smg_row_steps(smg_state *s, int64_t count) {
  smg_besides known;
  smg_forget_besides(&s->c, &known);
  s->row_team = smg_row_team(&s->c);
  if (s->row_team > 1) smg_know_besides(&s->c, &known);
  smg_enter_rows(s);
  while (count-- > 0) smg_row_step(s, &known);
  smg_leave_rows(s);
  s->report.site = s->report.partner = -1;
  return s->report.status = SMG_OK;
}

#endif
