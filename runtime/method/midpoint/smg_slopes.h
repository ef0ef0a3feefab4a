/* smidgen method: a step that follows from slopes a, SMG_SLOPES numbers a site, found by fixed-point iteration over all
 * sites together. A method defines its sweep, smg_sweep_stages of smg_fixed_point.h, which renews them by
 * smg_renew_slopes, and, for a site at w of the length r,
 *
 *     smg_stage_increment(w, a, u)  u = W - w
 *     smg_stage_serves(a)           is the method defined for slopes so large?
 *
 * The iteration begins where the polynomial of degree 2 or less through the slopes of the last steps leads; when that
 * fails, at rest. The lengths of w are kept as smg_lengths.h has it.
 *
 * Beside w, compensation and u the state has the arrays s->points, for the sweeps, 3 numbers a site at least,
 * s->slopes, s->past_slopes, 3 times as many, and s->inverse, 1. */
#ifndef SMG_SLOPES_H
#define SMG_SLOPES_H

#include "smg_fixed_point.h"
#include "smg_lengths.h"
#include "smg_polynomial.h"
#include "smg_report.h"

#if SMG_HISTORY != 3 || SMG_EXTENDED || SMG_PLAIN_SUMS || SMG_COMPOSED
#error "smg_slopes.h: SMG_HISTORY 3, and neither SMG_EXTENDED nor SMG_PLAIN_SUMS nor SMG_COMPOSED"
#endif

#define SMG_NO_DEGREE 0

/* ---- the history: 1/|w|^2 of the start, and the slopes of the last s->history steps, newest first ---- */

static inline size_t smg_history_size(const smg_coefficients *c) {
  return (size_t)((1 + SMG_SLOPES * SMG_HISTORY) * smg_sites(c));
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  const int64_t sites = smg_sites(&s->c);
  smg_save_lengths(s, out);
  smg_copy(out + sites, s->past_slopes, SMG_SLOPES * SMG_HISTORY * sites);
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  const int64_t sites = smg_sites(&s->c);
  smg_copy(s->inverse, in, sites);
  smg_copy(s->past_slopes, in + sites, SMG_SLOPES * SMG_HISTORY * sites);
}

#include "smg_state.h"

/* ---- the iteration ---- */

SMG_INLINE smg_real smg_sum_of_sizes(const smg_real *a, int count) {
  smg_real sum = 0;
  for (int b = 0; b < count; ++b) sum += smg_abs(a[b]);
  return sum;
}

/* The slopes of site k become these; w moves by about twice `weight` times their change, and the products in W - w are
 * about 2 |w| `factors`. How far it moves is kept in s->u. */
static inline void smg_renew_slopes(smg_state *s, int64_t k, const smg_real *next, smg_real weight, smg_real factors,
                                    smg_moved *moved) {
  smg_real *a = s->slopes + SMG_SLOPES * k, change[SMG_SLOPES];
  const smg_real up = smg_site_up(s, k);
  smg_waxpy(change, -1, a, next, SMG_SLOPES);
  smg_copy(a, next, SMG_SLOPES);
  const smg_real by = smg_sum_of_sizes(change, SMG_SLOPES), absolute = 2 * up * weight * by;
  moved->relative = smg_max(moved->relative, by / (smg_sum_of_sizes(next, SMG_SLOPES) + SMG_LEAST));
  moved->absolute = smg_max(moved->absolute, absolute);
  moved->rounding_scale = smg_max(moved->rounding_scale, 2 * up * smg_norm(s->w + 3 * k) * factors);
  s->u[3 * k] = absolute;
}

/* The slopes that it begins with: extrapolated from those of the steps that are known, or 0. */
static void smg_begin_stages(smg_state *s, SMG_UNUSED void *with, int extrapolated) {
  const int64_t size = SMG_SLOPES * smg_sites(&s->c);
  const int steps = extrapolated ? s->history : 0;
  for (int64_t q = 0; q < size; ++q) {
    s->slopes[q] = 0;
    for (int j = 0; j < steps; ++j) s->slopes[q] += smg_weight(steps - 1, j) * s->past_slopes[size * j + q];
  }
}

/* The site that the last sweep moved most, or made no number. */
static int64_t smg_most_moved(const smg_state *s) {
  int64_t site = 0;
  for (int64_t k = 1; k < smg_sites(&s->c); ++k)
    if (!(s->u[3 * k] <= s->u[3 * site])) site = k;
  return site;
}

/* ---- the step ---- */

/* The slopes become the newest of the past. */
static void smg_remember_slopes(smg_state *s) {
  const int64_t size = SMG_SLOPES * smg_sites(&s->c);
  for (int64_t q = SMG_HISTORY * size - 1; q >= size; --q) s->past_slopes[q] = s->past_slopes[q - size];
  smg_copy(s->past_slopes, s->slopes, size);
  if (s->history < SMG_HISTORY) ++s->history;
}

/* u of all sites, and w + u in s->points; refused at the first slope for which the method is not defined, or the first
 * u that is no number. */
static smg_status smg_take_increments(smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real *w = s->w + 3 * k, *a = s->slopes + SMG_SLOPES * k;
    smg_real *u = s->u + 3 * k;
    if (!smg_stage_serves(a)) return smg_end_report(s, SMG_NO_CONVERGENCE, k);
    smg_stage_increment(w, a, u);
    if (!smg_is_finite(u)) return smg_end_report(s, SMG_NOT_FINITE, k);
    smg_waxpy(s->points + 3 * k, 1, u, w, 3);
  }
  return SMG_OK;
}

static smg_status smg_step(smg_state *s) {
  smg_begin_report(s);
  smg_set_time_at(&s->c, s, (smg_real)0.5);
  const smg_status status = smg_solve_stages(s, NULL);
  if (status != SMG_OK) return smg_end_report(s, status, smg_most_moved(s));
  if (smg_take_increments(s) != SMG_OK) return s->report.status;
  if (s->history == 0) smg_begin_lengths(s);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_commit_site(s, k, s->points + 3 * k, s->u + 3 * k);
  smg_remember_slopes(s);
  ++s->count;
  return smg_end_report(s, SMG_OK, -1);
}

#include "smg_steps.h"

#endif
