/* smidgen method: the tangent map of a composition, the product of those of its stages. The state goes back to the
 * start of the step by the increments of its stages, and forward again with the columns. */
#ifndef SMG_COMPOSED_TANGENT_H
#define SMG_COMPOSED_TANGENT_H

#include "smg_tangent.h"

/* w, to which increments are added, by sites or by slots; how many numbers they are. */
static inline smg_real *smg_walked(const smg_state *s) {
#if SMG_BY_ROWS
  if (s->rows) return s->row_w;
#endif
  return s->w;
}
static inline int64_t smg_walked_numbers(const smg_state *s) {
#if SMG_BY_ROWS
  if (s->rows) return 2 * smg_pitch(&s->c) + smg_slots(&s->c);
#endif
  return 3 * smg_sites(&s->c);
}

/* The state after the step is kept before what a stage needs. */
static size_t smg_tangent_memory(const smg_model *model) {
  smg_state s;
  s.c.model = model;
#if SMG_BY_ROWS
  s.rows = 1; /* slots are not fewer than sites */
#endif
  return smg_step_tangent_memory(model) + sizeof(smg_real) * (size_t)smg_walked_numbers(&s);
}

/* Makes the increments of stage i the newest ones of the history, and adds `part` of them to the state. */
static inline void smg_walk_stage(smg_state *s, SMG_UNUSED int row, int i, smg_real part) {
#if SMG_SINGLE_SPHERE
  s->row = row + SMG_COMPOSED - 1 - i;
  const smg_real *u = smg_last_increment(s, 0);
#else
#if SMG_BY_ROWS
  s->past[0] = s->rows ? s->row_increments[i] : s->increments + 3 * smg_sites(&s->c) * i;
#else
  s->past[0] = s->increments + 3 * smg_sites(&s->c) * i;
#endif
  const smg_real *u = s->past[0];
#endif
  smg_axpy(smg_walked(s), part, u, smg_walked_numbers(s));
}

/* All stages from the first, the state before it. */
static smg_status smg_push_stages(smg_state *s, int row, smg_real *v, int64_t columns, smg_real *mem) {
  smg_status status = SMG_OK;
  smg_real done = -1; /* the step has been counted */
  for (int i = 0; i < SMG_COMPOSED && status == SMG_OK; ++i) {
    smg_walk_stage(s, row, i, 1);
    smg_set_time_at(&s->c, s, done + 0.5 * smg_gamma[i]);
    done += smg_gamma[i];
    status = smg_push_step(s, smg_gamma[i] * smg_signed_h(s->h), v, columns, mem);
  }
  return status;
}

/* SMG_BAD_PARAMETER also after a restored state or a refused step: then there is no step just taken. */
static smg_status smg_push_forward(smg_state *s, smg_real *v, int64_t columns, void *mem) {
  const smg_report report = s->report;
  const int64_t numbers = smg_walked_numbers(s);
  smg_real *end = (smg_real *)mem;
#if SMG_SINGLE_SPHERE
  const int row = s->row;
#else
  const int row = 0;
  smg_real *newest = s->past[0];
#endif
  if (s->stage != SMG_COMPOSED) return s->report.status = SMG_BAD_PARAMETER;
  smg_copy(end, smg_walked(s), numbers);
  for (int i = SMG_COMPOSED - 1; i >= 0; --i) smg_walk_stage(s, row, i, -1);
  const smg_status status = smg_push_stages(s, row, v, columns, end + numbers);
  smg_copy(smg_walked(s), end, numbers);
#if SMG_SINGLE_SPHERE
  s->row = row;
#else
  s->past[0] = newest;
#endif
  if (status == SMG_OK) s->report = report;
  s->report.status = status;
  return status;
}

#endif
