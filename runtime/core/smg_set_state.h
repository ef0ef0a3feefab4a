/* smidgen runtime: another w between two steps, as programs set it that are coupled to the model, or that split its
 * motion. Time, count, h and tolerance stay. The increments of the steps before are those of another orbit, and what w
 * had lost to rounding is lost: history and compensation begin anew, as after smg_begin_state(). */
#ifndef SMG_SET_STATE_H
#define SMG_SET_STATE_H

#include "smg_state.h"

static inline void smg_forget_history(smg_state *s) {
  s->history = 0;
  smg_blank_history(s);
#if SMG_HISTORY_ARRAYS
  smg_forget_arrays(s);
#endif
}

static inline void smg_forget_compensation(smg_state *s) {
#if SMG_BY_ROWS
  if (s->rows) {
    smg_forget_rows(s);
    return;
  }
#endif
  for (int64_t k = 0; k < 3 * smg_sites(&s->c); ++k) s->compensation[k] = 0;
}

/* w is refused as a start would be, and the state is then as it was; so is every w where init gave the state no memory.
 * A site that steps have moved off its sphere, as those of dop853 do, may be as far from it; all are put on their
 * spheres. w may be s->w itself, of which nothing is known but that. */
static inline smg_status smg_set_state(smg_state *s, const smg_real *w) {
  s->report.status =
      s->w ? smg_check_state(&s->c, w, w == s->w ? NULL : s->w, SMG_OFF_SPHERE, &s->report.site) : SMG_BAD_PARAMETER;
  s->report.partner = -1;
  if (s->report.status != SMG_OK) return s->report.status;
  smg_put_state(s, w);
  smg_forget_history(s);
  smg_forget_compensation(s);
#if SMG_BY_ROWS
  smg_choose_rows(s); /* the same way as before: neither h nor parameters are others */
#endif
  return SMG_OK;
}

#endif
