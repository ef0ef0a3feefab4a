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
 * Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 (method), II.10 (estimates) and II.6
 * (dense output); coefficients in smg_dop853_table.h.
 *
 * What a build may choose:
 *     SMG_TOLERANCE   error of an internal step, as part of s->scale, the largest component: 1e-12, long double 1e-15,
 *                     quad 1e-26
 *     SMG_PROJECT     1: after every internal step each site goes back to its leaf, along grad C; default 0
 *     SMG_FIXED_STEP  1: h itself is the only internal step, whatever its error; default 0
 * Arrays: s->w, s->compensation, s->u (3 a site) and s->stages, which has 45 numbers a site and 4 more. */
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

/* The four numbers: the size of the last internal step that nothing cut short (0: none yet); where the last internal
 * step began and its size (0: there is none to interpolate); are k_13 .. k_16 there? Sizes are parts of h. */
enum { SMG_NATURAL, SMG_LAST_FROM, SMG_LAST_SIZE, SMG_EXTRA_READY, SMG_KEPT };

static inline smg_real *smg_kept(const smg_state *s);

/* ---- the history: one number, the natural size
 * --------------------------------------------------------------------------- */
/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) { return (void)c, 1; }

static inline void smg_save_history(const smg_state *s, smg_real *out) { out[0] = smg_kept(s)[SMG_NATURAL]; }

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  smg_kept(s)[SMG_NATURAL] = in[0];
  smg_kept(s)[SMG_LAST_SIZE] = 0;
}

#define SMG_HISTORY_ARRAYS 1
static inline void smg_forget_arrays(smg_state *s) { smg_kept(s)[SMG_NATURAL] = smg_kept(s)[SMG_LAST_SIZE] = 0; }

#include "smg_dop853_trial.h"

static inline smg_real *smg_kept(const smg_state *s) { return smg_vector(s, SMG_STAGE_VECTORS); }

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
  smg_real *y = smg_vector(s, SMG_Y), *before = smg_vector(s, SMG_Y_BEFORE);
  smg_copy(before, y, smg_width(s));
  smg_take_increment(s, 1);
#if SMG_PROJECT
  smg_back_on_leaves(s);
#endif
}

/* ---- an output step
 * ------------------------------------------------------------------------------------------------------ */
/* At the beginning of a step of s, whose w the array of y has. */
static inline void smg_begin_pace(smg_state *s, smg_pace *pace) {
  const smg_real natural = smg_kept(s)[SMG_NATURAL], allowed = smg_allowed(s);
  memset(pace, 0, sizeof *pace);
  pace->natural = smg_max(SMG_LEAST_PART, natural > 0 ? natural : smg_first_size(s));
  pace->per_allowed = allowed > 0 ? 1 / allowed : 0;
}

/* All internal steps, in the scratch arrays. */
static smg_status smg_integrate(smg_state *s, smg_pace *pace) {
  while (pace->done < 1) {
    smg_kept(s)[SMG_LAST_FROM] = pace->done;
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
  smg_kept(s)[SMG_NATURAL] = pace->natural;
  smg_kept(s)[SMG_LAST_SIZE] = pace->size;
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
  smg_kept(s)[SMG_LAST_SIZE] = smg_kept(s)[SMG_EXTRA_READY] = 0;
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

#if !SMG_ROW_FIELDS
/* ---- dense output
 * -------------------------------------------------------------------------------------------------------- */
/* The part of h that the last internal step took; 0 before a step, after a failed one and after a restart. */
static inline smg_real smg_dense_part(const smg_state *s) { return smg_kept(s)[SMG_LAST_SIZE]; }

/* k_13 = f at the end, k_14 .. k_16, in the places of k_2 .. k_5. The step is counted already: its parts of h are less
 * 1. */
static inline void smg_extra_stages(const smg_state *s) {
  const smg_real *before = smg_vector(s, SMG_Y_BEFORE), *kept = smg_kept(s);
  const int64_t n = smg_width(s);
  smg_coefficients c = s->c;
  smg_set_time_at(&c, s, 0);
  smg_right_side(&c, kept[SMG_LAST_SIZE], s->w, smg_vector(s, 1));
  for (int i = 0; i < 3; ++i) {
    for (int64_t q = 0; q < n; ++q)
      s->u[q] = before[q] + smg_weighted(smg_dop853_extra[i], SMG_STAGES_USED, s->stages + q, n);
    smg_set_time_at(&c, s, kept[SMG_LAST_FROM] + smg_dop853_c[13 + i] * kept[SMG_LAST_SIZE] - 1);
    smg_right_side(&c, kept[SMG_LAST_SIZE], s->u, smg_vector(s, 2 + i));
  }
}

/* w at the part theta of the last internal step, to order 7: with r = 1 - theta the cubic through both ends and their
 * slopes,
 *     y + theta^2 (3 - 2 theta) (w - y) + theta r (r k_1 - theta k_13),
 * and (theta r)^2 sum_i (d_1i + theta d_2i + theta r d_3i + theta^2 r d_4i) k_i. Where there is no such step it is w
 * itself. */
static inline void smg_dense(const smg_state *s, smg_real theta, smg_real *w) {
  const int64_t n = 3 * smg_sites(&s->c);
  const smg_real *y = smg_vector(s, SMG_Y_BEFORE), r = 1 - theta;
  const smg_real end = theta * theta * (3 - 2 * theta), bump = theta * r * (theta * r);
  smg_real a[SMG_STAGES_USED];
  if (!(smg_dense_part(s) > 0)) {
    smg_copy(w, s->w, n);
    return;
  }
  if (smg_kept(s)[SMG_EXTRA_READY] == 0) smg_extra_stages(s);
  smg_kept(s)[SMG_EXTRA_READY] = 1;
  for (int i = 0; i < SMG_STAGES_USED; ++i)
    a[i] = bump *
           (smg_dop853_d[0][i] + theta * (smg_dop853_d[1][i] + r * (smg_dop853_d[2][i] + theta * smg_dop853_d[3][i])));
  a[0] += theta * r * r;
  a[1] -= theta * theta * r;
  for (int64_t q = 0; q < n; ++q) {
    const smg_real rest = smg_weighted(a, SMG_STAGES_USED, s->stages + q, n);
    w[q] = y[q] + (end * (s->w[q] - y[q]) + rest);
  }
}
#endif

#endif
