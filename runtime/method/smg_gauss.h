/* smidgen method: Gauss collocation of SMG_STAGES = s = 1 .. 8 stages, of order 2s, in the variables z in C^2 of every site
 * (McLachlan, Modin, Verdier, Collective symplectic integrators): symplectic on spheres and in R^3.
 *
 * w_k = z* sigma_k z, |w| = |z|^2, sigma the Pauli matrices. w' = w x b, b = (1/kappa) dH/dw, is the image of
 *
 *     z' = F(z) = (i/2) (b(w).sigma) z,
 *
 * a Hamiltonian system with H(w(z)). Gauss collocation keeps |z|^2, so |w|, and commutes with the phase of z, so it is a method
 * for w. One step, with L_j = h b_j F(Z_j) and the shares a_ij/b_j:
 *
 *     Z_i = z + sum_j (a_ij/b_j) L_j,     dz = sum_j L_j,     u = W - w = 2 B(z + dz/2, dz),
 *
 * B(z, z) = w(z) bilinear: no difference of nearby numbers is taken. Z_i and L_i are found by fixed-point iteration.
 *
 * H is taken as its formula has it off the sphere too: |w(Z_i)| differs from |w| by (h b)^2. Vortices d apart, whose b along w is
 * as large as 1/d^2, therefore need an h below about d^3.
 *
 * Of the model it needs SMG_STAGES, SMG_HISTORY 1, and beside w, compensation and u one array, s->stages, of (8 s + 11) numbers a site:
 * three of the points w(Z_i) of one stage, for all sites; then site by site z, Z_i, the L_j, and the L_j of the step before. */
#ifndef SMG_GAUSS_H
#define SMG_GAUSS_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"
#include "smg_gauss_table.h"

#if !(SMG_STAGES >= 1 && SMG_STAGES <= 8) || SMG_HISTORY != 1 || SMG_EXTENDED
#error "smg_gauss.h: SMG_STAGES 1 to 8, SMG_HISTORY 1, and no SMG_EXTENDED"
#endif

#define SMG_NO_DEGREE 0
#define SMG_NEWTON_STEPS 0

#define SMG_STAGE_NUMBERS (4 * SMG_STAGES) /* the L_j of a site */
#define SMG_STAGE_SITE (8 * SMG_STAGES + 8)

/* The iteration must contract: from its first change on, times the slack for what grows before it falls, each sweep must leave
 * no more than this part of the one before. Then its solution is the one connected to Z_i = z at h = 0. */
#define SMG_CONTRACTION (smg_real)0.75
#define SMG_SLACK 32
#define SMG_MOST_SWEEPS 500
/* The formula of the field may carry so much round-off, relative to the state: below it changes that have found no new least
 * for some sweeps are taken for that. */
#define SMG_FIELD_NOISE (4194304 * SMG_EPS)
#define SMG_PATIENCE 8

/* ---- arrays ------------------------------------------------------------------------------- */

/* The points w(Z_i) of the stage under way, and a site's z, its Z_i, the L_j, and those of the step before. */
static inline smg_real *smg_stage_points(const smg_state *s) { return s->stages; }
static inline smg_real *smg_own_z(const smg_state *s, int64_t k) { return s->stages + 3 * smg_sites(&s->c) + SMG_STAGE_SITE * k; }
static inline smg_real *smg_own_stage(const smg_state *s, int64_t k) { return smg_own_z(s, k) + 4; }
static inline smg_real *smg_own_slopes(const smg_state *s, int64_t k) { return smg_own_z(s, k) + 8; }
static inline smg_real *smg_past_slopes(const smg_state *s, int64_t k) { return smg_own_slopes(s, k) + SMG_STAGE_NUMBERS; }

/* The history: the L_j of the step before, s->history = 1 once there are any. */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)(SMG_STAGE_NUMBERS * smg_sites(c)); }

static inline smg_real smg_saved_newton_steps(const smg_state *s) {
  (void)s;
  return 0;
}

static inline void smg_restore_newton_steps(smg_state *s, smg_real steps) {
  (void)s;
  (void)steps;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int q = 0; q < SMG_STAGE_NUMBERS; ++q) out[SMG_STAGE_NUMBERS * k + q] = smg_past_slopes(s, k)[q];
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int q = 0; q < SMG_STAGE_NUMBERS; ++q) smg_past_slopes(s, k)[q] = in[SMG_STAGE_NUMBERS * k + q];
}

#include "smg_state.h"

/* ---- one site: z = (z[0] + i z[1], z[2] + i z[3]) ------------------------------------------- */

/* w = 2 B(y, d), 2 B(z, z) = 2 w(z): w_1 + i w_2 = 2 conj(z_0) z_1, w_3 = |z_0|^2 - |z_1|^2, made bilinear and symmetric. */
SMG_INLINE void smg_collect(const smg_real *y, const smg_real *d, smg_real *w) {
  w[0] = 2 * ((y[0] * d[2] + y[2] * d[0]) + (y[1] * d[3] + y[3] * d[1]));
  w[1] = 2 * ((y[0] * d[3] + y[3] * d[0]) - (y[1] * d[2] + y[2] * d[1]));
  w[2] = 2 * ((y[0] * d[0] + y[1] * d[1]) - (y[2] * d[2] + y[3] * d[3]));
}

/* v = w(z). */
SMG_INLINE void smg_point(const smg_real *z, smg_real *v) {
  v[0] = 2 * (z[0] * z[2] + z[1] * z[3]);
  v[1] = 2 * (z[0] * z[3] - z[1] * z[2]);
  v[2] = (z[0] * z[0] + z[1] * z[1]) - (z[2] * z[2] + z[3] * z[3]);
}

/* A z with w(z) = w: the larger of z_0, z_1 is real and positive, sqrt((|w| + |w_3|)/2); nothing cancels. */
static inline void smg_lift(const smg_real *w, smg_real *z) {
  const smg_real large = SMG_MATH(sqrt)(0.5 * (smg_norm(w) + smg_abs(w[2])));
  const smg_real re = large > 0 ? 0.5 * w[0] / large : 0, im = large > 0 ? 0.5 * w[1] / large : 0;
  const int south = w[2] < 0;
  z[0] = south ? re : large;
  z[1] = south ? -im : 0;
  z[2] = south ? large : re;
  z[3] = south ? 0 : im;
}

/* l = i (a.sigma) z. */
SMG_INLINE void smg_turn(const smg_real *a, const smg_real *z, smg_real *l) {
  l[0] = a[1] * z[2] - a[0] * z[3] - a[2] * z[1];
  l[1] = a[0] * z[2] + a[1] * z[3] + a[2] * z[0];
  l[2] = a[2] * z[3] - a[0] * z[1] - a[1] * z[0];
  l[3] = a[0] * z[0] - a[1] * z[1] - a[2] * z[2];
}

/* to = from (conj(y).x)/size, a phase: |x|^2 = |y|^2 = size and x = e^(i phi) y. What belongs to y then belongs to x. */
static inline void smg_turn_phase(const smg_real *y, const smg_real *x, smg_real size, const smg_real *from, smg_real *to) {
  const smg_real re = (y[0] * x[0] + y[1] * x[1] + (y[2] * x[2] + y[3] * x[3])) / size;
  const smg_real im = (y[0] * x[1] - y[1] * x[0] + (y[2] * x[3] - y[3] * x[2])) / size;
  for (int q = 0; q < SMG_STAGE_NUMBERS; q += 2) {
    to[q] = re * from[q] - im * from[q + 1];
    to[q + 1] = re * from[q + 1] + im * from[q];
  }
}

/* ---- the iteration ------------------------------------------------------------------------ */

/* z of every site, and the L_j it begins with: the polynomial through those of the step before, or 0, from where the first sweep
 * goes on by L_i = h b_i F(z + what is known). */
static void smg_begin_stages(const smg_state *s, int extrapolated) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real *past = smg_past_slopes(s, k);
    smg_real *slopes = smg_own_slopes(s, k);
    smg_lift(s->w + 3 * k, smg_own_z(s, k));
    for (int i = 0; i < SMG_STAGES; ++i)
      for (int b = 0; b < 4; ++b) {
        smg_real sum = 0;
        for (int j = 0; extrapolated && j < SMG_STAGES; ++j) sum += smg_gauss_ahead[i][j] * past[4 * j + b];
        slopes[4 * i + b] = sum;
      }
  }
}

/* Z_i = z + sum_j (a_ij/b_j) L_j and w(Z_i) of every site; its gradient ends up in s->u. */
static void smg_stage_field(smg_state *s, int i) {
  const int64_t sites = smg_sites(&s->c);
  for (int64_t k = 0; k < sites; ++k) {
    const smg_real *z = smg_own_z(s, k), *slopes = smg_own_slopes(s, k);
    smg_real *stage = smg_own_stage(s, k);
    for (int b = 0; b < 4; ++b) {
      smg_real sum = 0;
      for (int j = 0; j < SMG_STAGES; ++j) sum += smg_gauss_share[i][j] * slopes[4 * j + b];
      stage[b] = z[b] + sum;
    }
    smg_point(stage, smg_stage_points(s) + 3 * k);
    for (int b = 0; b < 3; ++b) s->u[3 * k + b] = 0;
  }
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, smg_gauss_node[i]));
#endif
  smg_gradient(&s->c, smg_stage_points(s), s->u);
}

/* L_i = h b_i (i/2) (b.sigma) Z_i of site k; its change is measured in w, as 2 |Z| |change of L|, next to the products in it. */
static void smg_new_slope(smg_state *s, int64_t k, int i, smg_real h, smg_change *change) {
  const smg_real half = 0.5 * smg_h_over_kappa(&s->c, k, h * smg_gauss_weight[i]), *g = s->u + 3 * k, *stage = smg_own_stage(s, k);
  const smg_real a[3] = {half * g[0], half * g[1], half * g[2]};
  const smg_real size = smg_max(smg_largest(stage), smg_abs(stage[3]));
  const smg_real own = 2 * size * size * (smg_abs(a[0]) + smg_abs(a[1]) + smg_abs(a[2]));
  const smg_real up = smg_kind(&s->c, k) == SMG_R3 ? smg_up(s->scale, s->w + 3 * k) : 1, before = change->absolute;
  smg_real *slope = smg_own_slopes(s, k) + 4 * i, next[4];
  smg_turn(a, stage, next);
  for (int b = 0; b < 4; ++b) {
    smg_change_add(change, 2 * size * (next[b] - slope[b]), own, up);
    slope[b] = next[b];
  }
  change->rounding_scale = smg_max(change->rounding_scale, up * own);
  if (change->absolute > before || (before == before && change->absolute != change->absolute)) s->report.site = k;
}

/* One sweep: stage after stage, each from the newest L of the others. */
static smg_change smg_sweep_stages(smg_state *s, smg_real h) {
  smg_change change = {0, 0, 0};
  s->report.site = -1;
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_stage_field(s, i);
    for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_new_slope(s, k, i, h, &change);
  }
  return change;
}

/* What a run of sweeps has shown: the change before, the least one and how long ago it was, and the most a contraction allows. */
typedef struct smg_watch {
  smg_change last;
  smg_real least, most;
  int since;
} smg_watch;

/* Stagnation, as smg_settled has it but for every contraction that is allowed; or the round-off of the field. */
static int smg_stages_settled(const smg_change *now, const smg_watch *watch, smg_real size) {
  if (now->relative <= SMG_EPS) return 1;
  if (now->absolute <= 8 * SMG_EPS * size && now->relative >= SMG_CONTRACTION * watch->last.relative) return 1;
  return now->absolute <= SMG_FIELD_NOISE * size && watch->since >= SMG_PATIENCE;
}

/* Takes in a change that has not settled; is the iteration a contraction as far as can be seen? */
static int smg_contracts(smg_watch *watch, const smg_change *now, smg_real size) {
  const int first = watch->most < 0, falls = first || now->absolute <= SMG_CONTRACTION * watch->least;
  watch->since = falls ? 0 : watch->since + 1;
  if (falls) watch->least = now->absolute;
  watch->most = first ? SMG_SLACK * now->absolute : SMG_CONTRACTION * watch->most;
  watch->last = *now;
  return now->absolute <= smg_max(watch->most, SMG_FIELD_NOISE * size);
}

/* Sweeps until nothing moves, and an eighth as many again: what was left is of one sign along many an orbit, a drift. */
static smg_status smg_settle_stages(smg_state *s, smg_real h) {
  smg_watch watch = {{0, 0, 0}, 0, -1, 0};
  watch.last.relative = SMG_MAX;
  for (int n = 0; n < SMG_MOST_SWEEPS; ++n) {
    const smg_change now = smg_sweep_stages(s, h);
    const smg_real size = smg_max(s->scale, now.rounding_scale);
    ++s->report.iterations;
    s->report.residual = now.absolute;
    if (!(now.absolute <= SMG_MAX)) return SMG_NOT_FINITE;
    if (smg_stages_settled(&now, &watch, size)) {
      for (int more = n / 8; more > 0; --more) (void)smg_sweep_stages(s, h);
      return SMG_OK;
    }
    if (!smg_contracts(&watch, &now, size)) break;
  }
  return SMG_NO_CONVERGENCE;
}

/* The stages of the step: from the polynomial of the step before; when that fails, or there is none, from rest. */
static smg_status smg_solve_stages(smg_state *s, smg_real h) {
  s->report.iterations = 0;
  if (s->history > 0) {
    smg_begin_stages(s, 1);
    if (smg_settle_stages(s, h) == SMG_OK) return SMG_OK;
  }
  smg_begin_stages(s, 0);
  return smg_settle_stages(s, h);
}

/* ---- the step ----------------------------------------------------------------------------- */

/* w + u of site k, with the rounding error of w carried along. */
static inline void smg_add_to_site(smg_state *s, int64_t k) {
  for (int64_t q = 3 * k; q < 3 * k + 3; ++q) {
#if SMG_PLAIN_SUMS
    s->w[q] += s->u[q];
#else
    smg_add_compensated(&s->w[q], &s->compensation[q], s->u[q]);
#endif
  }
}

/* u = 2 B(z + dz/2, dz) and the state after the step; the L_j stay, with the phase of the next step's z. */
static void smg_commit_site(smg_state *s, int64_t k) {
  const smg_real *z = smg_own_z(s, k), *slopes = smg_own_slopes(s, k);
  smg_real dz[4], middle[4], end[4], next[4];
  for (int b = 0; b < 4; ++b) {
    dz[b] = 0;
    for (int j = 0; j < SMG_STAGES; ++j) dz[b] += slopes[4 * j + b];
    middle[b] = z[b] + 0.5 * dz[b];
    end[b] = z[b] + dz[b];
  }
  smg_collect(middle, dz, s->u + 3 * k);
  smg_add_to_site(s, k);
  const smg_real size = smg_norm(s->w + 3 * k);
  smg_lift(s->w + 3 * k, next);
  if (size > 0) smg_turn_phase(end, next, size, slopes, smg_past_slopes(s, k));
}

static smg_status smg_step(smg_state *s) {
  s->report.partner = -1;
  s->report.reached = 0;
  s->report.status = smg_solve_stages(s, smg_signed_h(s->h));
  if (s->report.status != SMG_OK) return s->report.status;
  s->report.site = -1;
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_commit_site(s, k);
  s->history = 1;
  ++s->count;
  return SMG_OK;
}

static smg_status smg_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  while (count-- > 0 && status == SMG_OK) status = smg_step(s);
  return status;
}

#endif
