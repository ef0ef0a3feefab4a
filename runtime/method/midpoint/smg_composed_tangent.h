/* smidgen method: the tangent map of a composition, the product of those of its stages. The state goes back to the
 * start of the step by the increments of its stages, and forward again with the columns. */
#ifndef SMG_COMPOSED_TANGENT_H
#define SMG_COMPOSED_TANGENT_H

#include "smg_tangent.h"

/* The state after the step is kept behind what a stage needs. */
static size_t smg_tangent_memory(const smg_model *model) {
  return smg_step_tangent_memory(model) + sizeof(smg_real) * (size_t)(3 * smg_sites_of(model));
}

/* Makes the increment of stage i the newest one of the history. */
static inline void smg_recall_stage(smg_state *s, SMG_UNUSED int row, int i) {
#if SMG_SINGLE_SPHERE
  s->row = row + SMG_COMPOSED - 1 - i;
#else
  s->past[0] = s->increments + 3 * smg_sites(&s->c) * i;
#endif
}

/* All stages from the first, s->w before it. */
static smg_status smg_push_stages(smg_state *s, int row, smg_real *v, int64_t columns, smg_real *mem) {
  smg_status status = SMG_OK;
  smg_real done = -1; /* the step has been counted */
  for (int i = 0; i < SMG_COMPOSED && status == SMG_OK; ++i) {
    smg_recall_stage(s, row, i);
    smg_axpy(s->w, 1, smg_last_increment(s, 0), 3 * smg_sites(&s->c));
    smg_set_time_at(&s->c, s, done + 0.5 * smg_gamma[i]);
    done += smg_gamma[i];
    status = smg_push_step(s, smg_gamma[i] * smg_signed_h(s->h), v, columns, mem);
  }
  return status;
}

/* The state before the step. */
static void smg_step_back(smg_state *s, int row) {
  for (int i = SMG_COMPOSED - 1; i >= 0; --i) {
    smg_recall_stage(s, row, i);
    smg_axpy(s->w, -1, smg_last_increment(s, 0), 3 * smg_sites(&s->c));
  }
}

/* SMG_BAD_PARAMETER also after a restored state or a refused step: then there is no step just taken. */
static smg_status smg_push_forward(smg_state *s, smg_real *v, int64_t columns, void *mem) {
  const smg_report report = s->report;
  const int64_t n3 = 3 * smg_sites(&s->c);
  smg_real *end = (smg_real *)mem;
#if SMG_SINGLE_SPHERE
  const int row = s->row;
#else
  const int row = 0;
  smg_real *newest = s->past[0];
#endif
  if (s->stage != SMG_COMPOSED) return s->report.status = SMG_BAD_PARAMETER;
  smg_copy(end, s->w, n3);
  smg_step_back(s, row);
  const smg_status status = smg_push_stages(s, row, v, columns, end + n3);
  smg_copy(s->w, end, n3);
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
