/* smidgen method: a step of h by an increment u that is no iteration's: smg_solve_increment(s) of the method puts it
 * into s->u, and does not change w. */
#ifndef SMG_INCREMENT_STEP_H
#define SMG_INCREMENT_STEP_H

#include "smg_state.h"

/* A site whose new state is no number, or -1. */
#if SMG_ROW_FIELDS
static inline int64_t smg_lost_site(const smg_state *s) { return smg_lost_in(s, s->u); } /* w is on spheres, or near */
#else
static inline int64_t smg_lost_site(const smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real *w = s->w + 3 * k, *u = s->u + 3 * k, end[3] = {w[0] + u[0], w[1] + u[1], w[2] + u[2]};
    if (!(smg_largest(end) <= SMG_MAX)) return k;
  }
  return -1;
}
#endif

/* Apart: in the loop over steps gcc keeps what is the same in all of them in registers that a step needs, of the
 * irreversible body 8 % more instructions. */
SMG_APART static smg_status smg_one_step(smg_state *s) {
  smg_solve_increment(s);
  s->report.partner = -1;
  s->report.site = smg_lost_site(s);
  s->report.status = s->report.site < 0 ? SMG_OK : SMG_NOT_FINITE;
  if (s->report.status != SMG_OK) return s->report.status;
  smg_add_step(smg_numbers(s), smg_spins(s), smg_spins_lost(s), s->u);
  ++s->count;
  return SMG_OK;
}

#include "smg_field_steps.h"

#endif
