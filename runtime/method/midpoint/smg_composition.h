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

#if SMG_EXTENDED
#error "smg_composition.h: no SMG_EXTENDED"
#endif

#if SMG_SINGLE_SPHERE
/* What a step changes before it is known to succeed. */
typedef struct smg_before {
  smg_vec w, compensation;
  int row, degree, history;
} smg_before;

/* The rows of a step fit below the newest one: those of the steps before stay as they are until the next begins. */
static inline void smg_hold(smg_state *s, smg_before *b) {
  if (s->row < SMG_COMPOSED) {
    smg_copy(s->rows + 4 * (SMG_ROWS - SMG_HISTORY), s->rows + 4 * s->row, 4 * SMG_HISTORY);
    s->row = SMG_ROWS - SMG_HISTORY;
  }
  b->w = smg_vec_load(s->w);
  b->compensation = smg_vec_load(s->compensation);
  b->row = s->row;
  b->degree = s->degree;
  b->history = s->history;
}

static inline void smg_give_back(smg_state *s, const smg_before *b) {
  smg_vec_store(s->w, b->w);
  smg_vec_store(s->compensation, b->compensation);
  s->row = b->row;
  s->degree = b->degree;
  s->history = b->history;
}

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

static inline smg_status smg_solve_composed_stage(smg_state *s, smg_real middle) {
  s->c = smg_prepared(s)[s->stage <= SMG_COMPOSED / 2 ? s->stage : SMG_COMPOSED - 1 - s->stage];
  smg_set_time_at(&s->c, s, middle);
  return smg_sphere_step(s);
}
#else
/* The state itself: a step changes no array of the increments before it (smg_stage_done). */
typedef smg_state smg_before;

static inline void smg_hold(smg_state *s, smg_before *b) {
  const int64_t n3 = 3 * smg_sites(&s->c);
  smg_copy(s->before, s->w, n3);
  smg_copy(s->before + n3, s->compensation, n3);
  *b = *s;
}

static inline void smg_give_back(smg_state *s, const smg_before *b) {
  const int64_t n3 = 3 * smg_sites(&s->c);
  const smg_report report = s->report;
  *s = *b;
  s->report = report;
  smg_copy(s->w, s->before, n3);
  smg_copy(s->compensation, s->before + n3, n3);
}

/* u has joined the history, and the array of the oldest increment is free. Of the first stages it is one that a failure
 * later in this step would need: it is kept, and a spare one takes its place. */
static inline void smg_stage_done(smg_state *s) {
#if SMG_STAGES_KEPT
  const int64_t n3 = 3 * smg_sites(&s->c);
  smg_copy(s->increments + n3 * s->stage, s->past[0], n3);
#endif
  if (s->stage < SMG_HISTORY) {
    smg_real *oldest = s->u;
    s->u = s->spare[s->stage];
    s->spare[s->stage] = oldest;
  }
  ++s->stage;
}

static inline smg_status smg_solve_composed_stage(smg_state *s, smg_real middle) {
  smg_set_time_at(&s->c, s, middle);
  const smg_status status = smg_advance(s, smg_gamma[s->stage] * smg_signed_h(s->h));
  if (status == SMG_OK) smg_stage_done(s);
  return status;
}
#endif

/* All stages, or those up to one that fails; s->stage counts them. */
static inline smg_status smg_solve_all_stages(smg_state *s) {
  smg_status status = SMG_OK;
  smg_real done = 0, residual = 0;
  int iterations = 0;
  for (int l = 0; l <= SMG_LEVELS; ++l) s->misses[l] = 0;
  for (s->stage = 0; s->stage < SMG_COMPOSED && status == SMG_OK;) {
    const smg_real gamma = smg_gamma[s->stage];
    status = smg_solve_composed_stage(s, done + 0.5 * gamma);
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

static smg_status smg_step(smg_state *s) {
  smg_before before;
#if SMG_SINGLE_SPHERE
  if (!(s->prepared[0] == 1 && s->prepared[1] == (smg_real)s->h)) smg_prepare_stages(s);
#endif
  smg_hold(s, &before);
  const smg_status status = smg_solve_all_stages(s);
  if (status == SMG_OK) ++s->count;
  else {
    smg_give_back(s, &before);
    s->stage = 0;
  }
  return status;
}

#include "smg_steps.h"

#endif
