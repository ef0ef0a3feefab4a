/* smidgen method: a symmetric composition of a midpoint method, of the order and the coefficients that its table has.
 *
 * One step is SMG_COMPOSED steps of the base method one after the other, its stages,
 *
 *     Phi_h = phi_(gamma_n h) o .. o phi_(gamma_1 h),   sum gamma_i = 1,
 *
 * stage i at the time t + (gamma_1 + .. + gamma_(i-1) + gamma_i/2) h. What every phi keeps, Phi keeps: it is symplectic
 * and time-reversible where the base method is. Some stages go backward; each passes the branch check with its own
 * step. Hairer, Lubich and Wanner, Geometric Numerical Integration, II.4 and V.3.
 *
 * A stage that fails ends the step: the state, the history and all else is as it was before the first stage. The report
 * then is that of the failed stage: its site, its residual, and `reached`, the part of gamma_i h up to which solutions
 * exist. After a step it has the sum of the iterations and the largest residual. */
#ifndef SMG_COMPOSITION_H
#define SMG_COMPOSITION_H

#if SMG_SINGLE_SPHERE
#include "smg_single_sphere.h"
#else
#include "smg_step.h"
#endif

#if !SMG_BY_ROWS
struct smg_row_call; /* there is none */
#endif

#if SMG_EXTENDED
#error "smg_composition.h: no SMG_EXTENDED"
#endif

/* What a step changes before it is known to succeed: the state, but no array of the increments before it
 * (smg_stage_done), with w and compensation in s->before. By rows the second stage begins in other arrays. */
typedef smg_state smg_before;

static inline void smg_hold(smg_state *s, smg_before *b, const struct smg_row_call *rows) {
  const int64_t n3 = 3 * smg_sites(&s->c);
#if SMG_SINGLE_SPHERE
  /* The rows of a step fit below the newest one: those of the steps before stay as they are until the next begins. */
  if (s->row < SMG_COMPOSED) {
    smg_copy(s->rows + 4 * (SMG_ROWS - SMG_HISTORY), s->rows + 4 * s->row, 4 * SMG_HISTORY);
    s->row = SMG_ROWS - SMG_HISTORY;
  }
#endif
  *b = *s;
  if (rows) return; /* by rows there is no s->before */
  smg_copy(s->before, s->w, n3);
  smg_copy(s->before + n3, s->compensation, n3);
}

static inline void smg_give_back(smg_state *s, const smg_before *b, const struct smg_row_call *rows) {
  const int64_t n3 = 3 * smg_sites(&s->c);
  const smg_report report = s->report;
  *s = *b;
  s->report = report;
#if SMG_BY_ROWS
  s->row_due = 0; /* the first stage has added what the step before had left */
#endif
  if (rows) return;
  smg_copy(s->w, s->before, n3);
  smg_copy(s->compensation, s->before + n3, n3);
}

#if SMG_SINGLE_SPHERE
/* The coefficients of a stage: some have the step in them. Those of all sizes of stages are kept, after the h that they
 * are for: s->prepared is 1 and h, then one smg_coefficients a size. */
static inline size_t smg_prepared_size(int64_t stages) {
  return 2 + (size_t)(stages / 2 + 1) * ((sizeof(smg_coefficients) + sizeof(smg_real) - 1) / sizeof(smg_real));
}
static inline smg_coefficients *smg_prepared(const smg_state *s) {
  return (smg_coefficients *)(void *)(s->prepared + 2);
}

SMG_COLD static void smg_prepare_stages(smg_state *s) {
  for (int i = 0; i <= SMG_COMPOSED / 2; ++i) {
    smg_set_step(&s->c, smg_gamma[i] * smg_signed_h(s->h)); /* what is not finite ends the step that meets it */
    smg_prepared(s)[i] = s->c;
  }
  s->prepared[0] = 1;
  s->prepared[1] = (smg_real)s->h;
}
static inline void smg_have_stages(smg_state *s) {
  if (!(s->prepared[0] == 1 && s->prepared[1] == (smg_real)s->h)) smg_prepare_stages(s);
}

/* The size of a stage is that of the one as far from the end. */
SMG_INLINE int smg_size_of_stage(int stage) { return stage <= SMG_COMPOSED / 2 ? stage : SMG_COMPOSED - 1 - stage; }

static inline smg_status smg_solve_composed_stage(smg_state *s, smg_real middle, SMG_UNUSED struct smg_row_call *rows) {
  s->c = smg_prepared(s)[smg_size_of_stage(s->stage)];
  smg_set_time_at(&s->c, s, middle);
  return smg_sphere_step(s);
}
#else
#if SMG_STAGES_KEPT
/* The increments of this stage, for the tangent map. */
static inline void smg_keep_stage(smg_state *s) {
  const int64_t n3 = 3 * smg_sites(&s->c);
#if SMG_BY_ROWS
  if (s->rows) {
    smg_newest_increments(s, s->row_increments[s->stage]);
    return;
  }
#endif
  smg_copy(s->increments + n3 * s->stage, s->past[0], n3);
}
#endif

/* u has joined the history, and the array of the oldest increment is free. Of the first stages it is one that a failure
 * later in this step would need: it is kept, and a spare one takes its place. */
static inline void smg_stage_done(smg_state *s, smg_real **u) {
#if SMG_STAGES_KEPT
  smg_keep_stage(s);
#endif
  if (s->stage < SMG_HISTORY) {
    smg_real *oldest = *u;
    *u = s->spare[s->stage];
    s->spare[s->stage] = oldest;
  }
  ++s->stage;
}

#if SMG_BY_ROWS
static inline void smg_exchange(smg_real **a, smg_real **b) {
  smg_real *const kept = *a;
  *a = *b;
  *b = kept;
}

/* One stage by rows. The second adds the increments of the first to w of the start, which is kept, in other arrays. The
 * first pass that is watched is that of the stage with the fewest. */
static inline smg_status smg_solve_row_stage(smg_state *s, smg_real h, struct smg_row_call *rows) {
  int64_t from;
  if (s->stage == 1) {
    smg_exchange(&s->row_w, &s->row_w_before);
    smg_exchange(&s->row_compensation, &s->row_compensation_before);
  }
  const smg_status status = smg_solve_rows(s, rows->known, h, rows->more || s->stage + 1 < SMG_COMPOSED, &from);
  if (status != SMG_OK) return status;
  rows->from = s->stage == 0 || from < rows->from ? from : rows->from;
  smg_stage_done(s, &s->row_late);
  return SMG_OK;
}
#endif

static inline smg_status smg_solve_composed_stage(smg_state *s, smg_real middle, SMG_UNUSED struct smg_row_call *rows) {
  const smg_real h = smg_gamma[s->stage] * smg_signed_h(s->h);
  smg_set_time_at(&s->c, s, middle);
#if SMG_BY_ROWS
  if (rows) return smg_solve_row_stage(s, h, rows);
#endif
  const smg_status status = smg_advance(s, h);
  if (status == SMG_OK) smg_stage_done(s, &s->u);
  return status;
}
#endif

/* All stages, or those up to one that fails; s->stage counts them. */
static inline smg_status smg_solve_all_stages(smg_state *s, struct smg_row_call *rows) {
  smg_status status = SMG_OK;
  smg_real done = 0, residual = 0;
  int iterations = 0;
  for (int l = 0; l <= SMG_LEVELS; ++l) s->misses[l] = 0;
  for (s->stage = 0; s->stage < SMG_COMPOSED && status == SMG_OK;) {
    const smg_real gamma = smg_gamma[s->stage];
    status = smg_solve_composed_stage(s, done + 0.5 * gamma, rows);
    done += gamma;
    iterations += s->report.iterations;
    residual = smg_max(residual, s->report.residual);
  }
  if (status == SMG_OK) {
    s->report.iterations = iterations;
    s->report.residual = residual;
  }
  return status;
}

/* A step from site to site, or by rows. */
static smg_status smg_compose(smg_state *s, struct smg_row_call *rows) {
  smg_before before;
#if SMG_SINGLE_SPHERE
  smg_have_stages(s);
#endif
  smg_hold(s, &before, rows);
  const smg_status status = smg_solve_all_stages(s, rows);
  if (status == SMG_OK) ++s->count;
  else {
    smg_give_back(s, &before, rows);
    s->stage = 0;
  }
  return status;
}

static smg_status smg_step(smg_state *s) {
#if SMG_BY_ROWS
  if (s->rows) return smg_row_steps(s, 1);
#endif
  return smg_compose(s, NULL);
}

#include "smg_steps.h"

#endif
