/* smidgen method: a step with one stage in its middle, found by fixed-point iteration over all sites together. Its
 * header defines, for a site at w, of the length r, with the slope a of its stage,
 *
 *     smg_stage_point(w, r, a, v)      the point v where the field is taken, at the time t + h/2
 *     smg_stage_slope(v, g, a)         a from the field g = (h/2) b(v), b = (1/kappa) dH/dw
 *     smg_stage_increment(w, r, a, u)  u = W - w
 *     smg_stage_weight(r)              w moves by about twice as much as this times a change of a
 *     smg_stage_serves(a)              is the method defined for a slope so large?
 *
 * The iteration begins where the polynomial of degree 2 or less through the slopes of the last steps leads; when that
 * fails, at rest. The lengths of w are kept as smg_lengths.h has it.
 *
 * Beside w, compensation and u the state has the arrays s->points, 3 numbers a site, s->slopes, 3, s->past_slopes, 9,
 * and s->inverse, 1. */
#ifndef SMG_ONE_STAGE_H
#define SMG_ONE_STAGE_H

#include "smg_fixed_point.h"
#include "smg_lengths.h"
#include "smg_respond.h"

#if SMG_HISTORY != 3 || SMG_EXTENDED || SMG_PLAIN_SUMS || SMG_COMPOSED
#error "smg_one_stage.h: SMG_HISTORY 3, and neither SMG_EXTENDED nor SMG_PLAIN_SUMS nor SMG_COMPOSED"
#endif

#define SMG_NO_DEGREE 0

/* ---- the history: 1/|w|^2 of the start, and the slopes of the last s->history steps, newest first ---- */

static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

static inline size_t smg_history_size(const smg_coefficients *c) {
  return (size_t)((1 + 3 * SMG_HISTORY) * smg_sites(c));
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  const int64_t sites = smg_sites(&s->c);
  for (int64_t k = 0; k < sites; ++k) out[k] = s->history > 0 ? s->inverse[k] : 0;
  for (int64_t q = 0; q < 3 * SMG_HISTORY * sites; ++q) out[sites + q] = s->past_slopes[q];
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  const int64_t sites = smg_sites(&s->c);
  for (int64_t k = 0; k < sites; ++k) s->inverse[k] = in[k];
  for (int64_t q = 0; q < 3 * SMG_HISTORY * sites; ++q) s->past_slopes[q] = in[sites + q];
}

#include "smg_state.h"

/* ---- the iteration ---- */

/* Beside this, slopes of a site at rest are nothing: next to it, 0/0 is 0. */
#define SMG_LEAST (smg_real) DBL_MIN

SMG_INLINE smg_real smg_sum_of_sizes(const smg_real *a) { return smg_abs(a[0]) + smg_abs(a[1]) + smg_abs(a[2]); }

/* The new slope of site k from its dH/dw in s->u, where then stands how far it moves w. */
static inline void smg_new_slope(smg_state *s, int64_t k, smg_moved *moved) {
  smg_real *g = s->u + 3 * k, *a = s->slopes + 3 * k, next[3], change[3];
  const smg_real *w = s->w + 3 * k, half = 0.5 * smg_h_over_kappa(&s->c, k, smg_signed_h(s->h)), size = smg_norm(w);
  const smg_real up = smg_kind(&s->c, k) == SMG_R3 ? smg_up(s->scale, w) : 1;
  for (int b = 0; b < 3; ++b) g[b] *= half;
  smg_stage_slope(s->points + 3 * k, g, next);
  for (int b = 0; b < 3; ++b) change[b] = next[b] - a[b];
  for (int b = 0; b < 3; ++b) a[b] = next[b];
  const smg_real by = smg_sum_of_sizes(change), absolute = 2 * up * smg_stage_weight(size) * by;
  moved->relative = smg_max(moved->relative, by / (smg_sum_of_sizes(next) + SMG_LEAST));
  moved->absolute = smg_max(moved->absolute, absolute);
  moved->rounding_scale = smg_max(moved->rounding_scale, 2 * up * size * smg_sum_of_sizes(g));
  g[0] = absolute;
}

static smg_moved smg_sweep_stages(smg_state *s, void *with) {
  (void)with;
  const int64_t sites = smg_sites(&s->c);
  smg_moved moved = {0, 0, 0};
  for (int64_t q = 0; q < 3 * sites; q += 3)
    smg_stage_point(s->w + q, smg_norm(s->w + q), s->slopes + q, s->points + q);
  for (int64_t q = 0; q < 3 * sites; ++q) s->u[q] = 0;
  smg_gradient(&s->c, s->points, s->u);
  smg_respond_all(&s->c, s->points, s->u);
  for (int64_t k = 0; k < sites; ++k) smg_new_slope(s, k, &moved);
  return moved;
}

/* The slopes that it begins with: extrapolated from those of so many steps, or 0. */
static void smg_begin_slopes(smg_state *s, int steps) {
  static const smg_real weights[SMG_HISTORY + 1][SMG_HISTORY] = {{0, 0, 0}, {1, 0, 0}, {2, -1, 0}, {3, -3, 1}};
  const int64_t size = 3 * smg_sites(&s->c);
  for (int64_t q = 0; q < size; ++q) {
    s->slopes[q] = 0;
    for (int j = 0; j < steps; ++j) s->slopes[q] += weights[steps][j] * s->past_slopes[size * j + q];
  }
}

static smg_status smg_solve_stage(smg_state *s) {
  s->report.iterations = 0;
  smg_begin_slopes(s, s->history);
  if (s->history > 0 && smg_sweep_to_rest(s, NULL) == SMG_OK) return SMG_OK;
  smg_begin_slopes(s, 0);
  return smg_sweep_to_rest(s, NULL);
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
  const int64_t size = 3 * smg_sites(&s->c);
  for (int64_t q = SMG_HISTORY * size - 1; q >= size; --q) s->past_slopes[q] = s->past_slopes[q - size];
  for (int64_t q = 0; q < size; ++q) s->past_slopes[q] = s->slopes[q];
  if (s->history < SMG_HISTORY) ++s->history;
}

/* u of all sites, and w + u in s->points; the first that is no number, or -1. */
static int64_t smg_take_increments(smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real *w = s->w + 3 * k;
    smg_real *u = s->u + 3 * k;
    smg_stage_increment(w, smg_norm(w), s->slopes + 3 * k, u);
    if (!smg_is_finite(u)) return k;
    for (int b = 0; b < 3; ++b) s->points[3 * k + b] = w[b] + u[b];
  }
  return -1;
}

/* The first site with a slope for which the method is not defined, or -1. */
static int64_t smg_slope_too_large(const smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    if (!smg_stage_serves(s->slopes + 3 * k)) return k;
  return -1;
}

static smg_status smg_refuse(smg_state *s, smg_status status, int64_t site) {
  s->report.site = site;
  return s->report.status = status;
}

static smg_status smg_step(smg_state *s) {
  s->report.partner = -1;
  s->report.reached = 0;
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, (smg_real)0.5));
#endif
  const smg_status status = smg_solve_stage(s);
  if (status != SMG_OK) return smg_refuse(s, status, smg_most_moved(s));
  const int64_t large = smg_slope_too_large(s);
  if (large >= 0) return smg_refuse(s, SMG_NO_CONVERGENCE, large);
  const int64_t lost = smg_take_increments(s);
  if (lost >= 0) return smg_refuse(s, SMG_NOT_FINITE, lost);
  if (s->history == 0) smg_begin_lengths(s);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_commit_site(s, k, s->points + 3 * k, s->u + 3 * k);
  smg_remember_slopes(s);
  ++s->count;
  return smg_refuse(s, SMG_OK, -1);
}

#include "smg_steps.h"

#endif
