/* smidgen method: Dormand and Prince of order 8, explicit, with error estimates of orders 5 and 3 and control of its
 * own steps.
 *
 * w' = f(t, w) = (1/kappa) grad C(w) x dH/dw. Twelve stages give one internal step of the size p, with y = w at its
 * start:
 *     k_i = p f(t + c_i p, y + sum_(j<i) a_ij k_j),   y + sum_i b_i k_i,
 * and two linear combinations of them estimate its error. smg_step takes one output step, t0 + n h to t0 + (n + 1) h,
 * by as many internal ones as the tolerance asks; the last ends exactly there. It is no symplectic method: energy and
 * leaves drift.
 *
 * Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 (method) and II.10 (estimates);
 * coefficients in smg_dop853_table.h.
 *
 * What a build may choose:
 *     SMG_TOLERANCE   error of an internal step, as part of s->scale, the largest component: 1e-12, long double 1e-15,
 *                     quad 1e-26
 *     SMG_PROJECT     1: after every internal step each site goes back to its leaf, along grad C; default 0
 *     SMG_FIXED_STEP  1: h itself is the only internal step, whatever its error; default 0
 * Arrays: s->w, s->compensation, s->u (3 a site) and s->stages, which has 42 numbers a site and 1 more. */
#ifndef SMG_DOP853_H
#define SMG_DOP853_H

#include "smg_dop853_control.h"
#include "smg_leaf.h"
#include "smg_rules.h"

#define SMG_ONTO_LEAF 0
#define SMG_NO_DEGREE -1 /* there is no predictor */

#ifndef SMG_HISTORY
#define SMG_HISTORY 0 /* increments of steps before: none are kept */
#endif
#define SMG_LEAVES_DRIFT !SMG_PROJECT
#ifndef SMG_TOLERANCE
#if defined(SMG_LONG_DOUBLE)
#define SMG_TOLERANCE 1e-15
#elif defined(SMG_QUAD)
#define SMG_TOLERANCE 1e-26
#else
#define SMG_TOLERANCE 1e-12
#endif
#endif

#include "smg_dop853_trial.h"

/* ---- the history: one number, the natural size
 * --------------------------------------------------------------------------- */
/* The size of the last internal step that nothing cut short, as part of h; 0: none yet. */
static inline smg_real *smg_natural(const smg_state *s) { return smg_vector(s, SMG_STAGE_VECTORS); }

/* Numbers of the history. */
static inline size_t smg_history_size(SMG_UNUSED const smg_coefficients *c) { return 1; }

static inline void smg_save_history(const smg_state *s, smg_real *out) { *out = *smg_natural(s); }
static inline void smg_restore_history(smg_state *s, const smg_real *in) { *smg_natural(s) = *in; }

#define SMG_HISTORY_ARRAYS 1
static inline void smg_forget_arrays(smg_state *s) { *smg_natural(s) = 0; }

/* ---- one internal step
 * --------------------------------------------------------------------------------------------------- */
#include "smg_dop853_template.h"

/* k_1 of the internal step that is tried; where it is no number, the report has the site. */
static inline int smg_first_stage(smg_state *s, const smg_pace *pace) {
  smg_trial_slope(s, pace->done, pace->size, smg_vector(s, SMG_Y), smg_vector(s, 0));
  const int64_t lost = smg_lost_in(s, smg_vector(s, 0));
  if (lost >= 0) s->report.site = lost;
  return lost < 0;
}

/* The very first size, where k_1 alone would move w by the eighth root of the tolerance; the control soon finds a
 * better one. */
static inline smg_real smg_first_size(smg_state *s) {
  smg_trial_slope(s, 0, 1, smg_vector(s, SMG_Y), smg_vector(s, 0));
  const smg_real most = smg_most(smg_vector(s, 0), smg_width(s)),
                 may = SMG_MATH(sqrt)(SMG_MATH(sqrt)(SMG_MATH(sqrt)(s->tolerance))) * s->scale;
  return most > may ? may / most : 1;
}

#if SMG_PROJECT
/* v.grad C(v) at v = w + compensation, which is |v|^2, or 2 C(v). */
static inline smg_real smg_twice_casimir(const smg_state *s, int64_t k) {
  smg_real n[3];
  smg_normal(&s->c, k, s->w + 3 * k, n);
  return smg_dot(n, s->w + 3 * k) + 2 * smg_dot(n, s->compensation + 3 * k);
}

/* y of site k back on the leaf of the start of the output step. */
static inline void smg_back_on_leaf(const smg_state *s, int64_t k, smg_real *y, smg_real *carry) {
  const smg_real leaf =
      smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) * smg_radius(&s->c, k) : smg_twice_casimir(s, k);
  smg_real n[3];
  int off = 1;
  for (int round = 0; off && round < SMG_LEAF_ROUNDS; ++round) {
    smg_normal(&s->c, k, y, n);
    off = smg_towards_leaf(off, leaf, n, y, carry);
  }
}

#if !SMG_ROW_FIELDS
/* Those of all sites that move. */
static inline void smg_back_on_leaves(smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    if (smg_moves(&s->c, k) > 0)
      smg_back_on_leaf(s, k, smg_vector(s, SMG_Y) + 3 * k, smg_vector(s, SMG_Y_COMPENSATION) + 3 * k);
}
#endif
#endif

/* The square of the error of the increment: the largest of all sites, and the report has the site. */
#if SMG_ROW_FIELDS
#include "smg_dop853_slots.h"
#else
static inline smg_real smg_largest_error(smg_state *s) {
  const smg_real *y = smg_vector(s, SMG_Y), *u = s->u, *e5 = smg_vector(s, SMG_E5), *e3 = smg_vector(s, SMG_E3);
  const int64_t n = smg_width(s);
  smg_real most = 0;
  for (int64_t q = 0; q < n && most == most; q += 3) {
    const smg_real error = smg_site_error(y + q, u + q, e5 + q, e3 + q);
    if (error <= most) continue;
    most = error; /* NaN comes in and stays */
    s->report.site = q / 3;
  }
  return most;
}
#endif

/* The increment, and its error, of which both parts stand where k_2 and k_3 were, which are in none of them. */
static inline void smg_estimate(smg_state *s, smg_pace *pace) {
  smg_combine_slopes(smg_vector(s, 0), smg_width(s), pace->per_allowed, s->u, smg_vector(s, SMG_E5),
                     smg_vector(s, SMG_E3));
  pace->square = smg_largest_error(s);
}

/* The increment u is taken, and y is back on the leaves. */
static inline void smg_take_step(smg_state *s) {
  smg_take_increment(s, 1);
#if SMG_PROJECT
  smg_back_on_leaves(s);
#endif
}

/* ---- an output step
 * ------------------------------------------------------------------------------------------------------ */
/* At the beginning of a step of s, whose w the array of y has. */
static inline void smg_begin_pace(smg_state *s, smg_pace *pace) {
  const smg_real natural = *smg_natural(s), allowed = smg_allowed(s);
  memset(pace, 0, sizeof *pace);
  pace->natural = smg_max(SMG_LEAST_PART, natural > 0 ? natural : smg_first_size(s));
  pace->per_allowed = allowed > 0 ? 1 / allowed : 0;
}

/* All internal steps, in the scratch arrays. */
static smg_status smg_integrate(smg_state *s, smg_pace *pace) {
  while (pace->done < 1) {
    smg_next_try(pace);
    if (!smg_first_stage(s, pace)) return SMG_NOT_FINITE;
    smg_later_stages(s, pace->done, pace->size, smg_vector(s, SMG_Y));
    smg_estimate(s, pace);
    if (smg_judge(pace)) smg_take_step(s);
    if (!smg_gives_up(pace) || pace->done >= 1) continue;
#if SMG_ROW_FIELDS
    s->report.site = smg_site_of_error(s, pace->square);
#endif
    return pace->hopeless && !(pace->square <= SMG_MAX) ? SMG_NOT_FINITE : SMG_NO_CONVERGENCE;
  }
  return SMG_OK;
}

/* The state after the step. */
static void smg_commit_steps(smg_state *s, const smg_pace *pace) {
  smg_copy(smg_spins(s), smg_vector(s, SMG_Y), smg_width(s));
  smg_copy(smg_spins_lost(s), smg_vector(s, SMG_Y_COMPENSATION), smg_width(s));
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) /* open leaves: orbits grow */
    if (smg_kind(&s->c, k) == SMG_NAMBU) s->scale = smg_max(s->scale, smg_largest(s->w + 3 * k));
  *smg_natural(s) = pace->natural;
  ++s->count;
}

/* What the step says of itself: its internal steps, and the largest of their errors. */
static inline void smg_report_pace(smg_state *s, int accepted, smg_real largest) {
  s->report.iterations = accepted;
  s->report.residual = SMG_MATH(sqrt)(largest) * smg_allowed(s);
  s->report.partner = -1;
  s->report.reached = 0;
}

static smg_status smg_one_step(smg_state *s) {
  smg_pace pace;
  smg_copy(smg_vector(s, SMG_Y), smg_spins(s), smg_width(s));
  smg_copy(smg_vector(s, SMG_Y_COMPENSATION), smg_spins_lost(s), smg_width(s));
  s->report.site = -1;
  smg_begin_pace(s, &pace);
  s->report.status = smg_integrate(s, &pace);
  smg_report_pace(s, pace.accepted, pace.largest);
  if (s->report.status != SMG_OK) s->report.reached = pace.done; /* where it could go no further */
  else {
    s->report.site = -1;
    smg_commit_steps(s, &pace);
  }
  return s->report.status;
}

#include "smg_field_steps.h"

#endif
