/* smidgen runtime: another w between two steps, as programs set it that are coupled to the model, or that split its
 * motion; and other parameters. Time, count, h and tolerance stay. The increments of the steps before are those of
 * another orbit, and what w had lost to rounding is lost: history and compensation begin anew, as after
 * smg_begin_state(). */
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
  smg_zero(s->compensation, 3 * smg_sites(&s->c));
}

/* Has the model other parameters than the last step had? */
static inline int smg_is_stale(const smg_state *s) { return s->version != s->c.model->version; }

/* From w on, as from a start. */
static void smg_go_on_from(smg_state *s, const smg_real *w) {
  if (smg_is_stale(s) || SMG_ROWS_IN_TIME) smg_begin_arrays(s, s->w, 3 * smg_sites(&s->c));
  smg_put_state(s, w);
  smg_forget_history(s);
  smg_forget_compensation(s);
#if SMG_BY_ROWS
  smg_choose_rows(s);
  s->row_kept = 0;
#endif
}

/* May the state go on from w? A site may be as much farther off its sphere as it is in `before`, where that is not
 * NULL. */
static smg_status smg_check_going_on(smg_state *s, const smg_real *w, const smg_real *before) {
  s->report.partner = -1;
  smg_choose_own(&s->c);
  s->report.status = s->w && w && (!smg_is_stale(s) || smg_may_begin(s))
                         ? smg_check_state(&s->c, w, before, SMG_OFF_SPHERE, &s->report.site)
                         : SMG_BAD_PARAMETER;
  return s->report.status = smg_status_of_ranks(s->report.status, &s->report.site);
}

/* w is refused as a start would be, and the state is then as it was; so is every w where init gave the state no memory.
 * A site that steps have moved off its sphere, as those of dop853 do, may be as far from it; all are put on their
 * spheres. w may be s->w itself, of which nothing is known but that. */
static inline smg_status smg_set_state(smg_state *s, const smg_real *w) {
  const smg_real *before = w == s->w || s->version == SMG_REFUSED ? NULL : s->w;
  if (smg_check_going_on(s, w, before) == SMG_OK) smg_go_on_from(s, w);
  return s->report.status;
}

/* The state goes on from w with the new parameters, or says why it cannot: a Nambu site may be at C(w) = 0 now. */
SMG_COLD static int smg_renew(smg_state *s) {
  if (s->version == SMG_REFUSED) return 0;
  if (smg_check_going_on(s, s->w, s->w) == SMG_OK) smg_go_on_from(s, s->w);
  return s->report.status == SMG_OK;
}

/* Before a step: has the state memory, and does it know the parameters? One that is 0 has not been given any yet. */
SMG_INLINE int smg_is_ready(smg_state *s) { return (s->w && !smg_is_stale(s)) || smg_renew(s); }

#endif
