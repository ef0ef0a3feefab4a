/* smidgen method: the step of an explicit method. Its header defines smg_stage(s, h), which moves s->points by one
 * (symmetric) step of the size h, and adds to s->u by how much; with SMG_ONE_SITE smg_stage(s, h, v, u), which does so
 * with v and u.
 *
 * With SMG_COMPOSED a step is so many stages, the i-th of the size smg_gamma[i] h: the symmetric composition whose
 * table comes before. The time of H is frozen at the middle of each. */
#ifndef SMG_EXPLICIT_STEP_H
#define SMG_EXPLICIT_STEP_H

#include "smg_explicit.h"
#include "smg_report.h"

#if SMG_COMPOSED
#define SMG_STAGES SMG_COMPOSED
#else
#define SMG_STAGES 1
static const smg_real smg_gamma[SMG_STAGES] = {1};
#endif

#if SMG_ONE_SITE
/* All in registers; the site that is no number, or -1. */
static inline int64_t smg_move(smg_state *s) {
  smg_real v[3] = {s->w[0], s->w[1], s->w[2]}, u[3] = {0, 0, 0}, done = 0;
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_set_time_at(&s->c, s, done + (smg_real)0.5 * smg_gamma[i]);
    smg_stage(s, smg_gamma[i] * smg_signed_h(s->h), v, u);
    done += smg_gamma[i];
  }
  if (!smg_is_finite(u)) return 0;
  smg_commit_site(s, 0, v, u);
  return -1;
}
#else
/* Every site where it is. */
static inline void smg_begin_step(smg_state *s) {
  smg_copy(s->points, s->w, 3 * smg_sites(&s->c));
  if (SMG_TURNS_ADDED) smg_copy(s->u, s->compensation, 3 * smg_sites(&s->c));
  else smg_zero(s->u, 3 * smg_sites(&s->c));
}

/* The new state of a site. */
static inline void smg_end_turned_site(smg_state *s, int64_t k) {
#if SMG_TURNS_ADDED
  smg_copy(s->w + 3 * k, s->points + 3 * k, 3);
  smg_copy(s->compensation + 3 * k, s->u + 3 * k, 3);
#if SMG_LENGTHS_LAST
  smg_restore_length(s, k);
#endif
#else
  smg_commit_site(s, k, s->points + 3 * k, s->u + 3 * k);
#endif
}

/* All stages, and if all are numbers the new state; the first site that is none, or -1. */
static inline int64_t smg_move(smg_state *s) {
  const int64_t sites = smg_sites(&s->c);
  smg_real done = 0;
  smg_begin_step(s);
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_set_time_at(&s->c, s, done + (smg_real)0.5 * smg_gamma[i]);
    smg_stage(s, smg_gamma[i] * smg_signed_h(s->h));
    done += smg_gamma[i];
  }
  for (int64_t k = 0; k < sites; ++k)
    if (!smg_is_finite(s->u + 3 * k)) return k;
  for (int64_t k = 0; k < sites; ++k) smg_end_turned_site(s, k);
  return -1;
}
#endif

#if SMG_ROW_CLASSES
#include "smg_pair_rows.h"
#elif SMG_ROW_TURNS
#include "smg_sublattice_rows.h"
#endif

static smg_status smg_step(smg_state *s) {
#if SMG_COMPOSED
  (void)smg_stage_weights;
#endif
  if (s->history == 0) smg_begin_lengths(s);
  smg_begin_report(s);
  const int64_t failed = smg_move(s);
  if (smg_end_report(s, failed < 0 ? SMG_OK : SMG_NOT_FINITE, failed) != SMG_OK) return s->report.status;
  s->history = 1;
  ++s->count;
  return SMG_OK;
}

#include "smg_steps.h"

#endif
