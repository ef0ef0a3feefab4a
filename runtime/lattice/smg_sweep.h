/* smidgen runtime: sweeps over the coupled sites, tried before Newton: rotations (SMG_ROTATION), each spin exactly in
 * the field of the others, or the plain fixed point. Where they do not settle soon Newton takes over. */
#ifndef SMG_SWEEP_H
#define SMG_SWEEP_H

#include "smg_newton.h"

/* More of them cost more than Newton; of a graph the generator counts it (gen/compile/plan/plan.py). */
#ifndef SMG_TRIED_SWEEPS
#if SMG_MATRIX_FREE
#define SMG_TRIED_SWEEPS 200
#else
#define SMG_TRIED_SWEEPS 12
#endif
#endif

/* mbar = w + u/2 of all sites. */
static inline void smg_set_midpoints(smg_state *s) { smg_waxpy(s->mbar, 0.5, s->u, s->w, 3 * smg_sites(&s->c)); }

#if SMG_ROTATION
/* m = P(w + u/2) of site k. */
static inline smg_real smg_halfway(const smg_state *s, int64_t k, const smg_real *u, smg_real *m) {
  smg_real mbar[3];
  smg_waxpy(mbar, 0.5, u, s->w + 3 * k, 3);
  return smg_project(&s->c, k, smg_leaf_value(s, k), mbar, m);
}
#endif

/* Where the sweeps begin: w + u/2 with u extrapolated; of rotations P of it. */
static void smg_sweep_start(smg_state *s) {
  smg_predict(s, s->degree);
#if SMG_ROTATION
  smg_project_all(s);
#endif
}

#if SMG_ROTATION
/* What a sweep works on. */
typedef struct smg_sweeping {
  smg_state *s;
  smg_real h;
  smg_change change;
} smg_sweeping;

/* The midpoint of one spin whose step is exact in the field g of the others; 0 where it has no step. */
static inline int smg_relaxed(const smg_state *s, smg_real h, int64_t k, smg_real *g, smg_real *next) {
  const smg_coefficients *c = &s->c;
  if (smg_kind(c, k) == SMG_NAMBU) {
    smg_real u[3];
    smg_increment(c, k, h, s->m + 3 * k, g, u);
    (void)smg_halfway(s, k, u, next);
    return 1;
  }
#if SMG_RESPONDS
  smg_real square;
  return smg_own_response(c, k, h, s->w + 3 * k, smg_leaf_value(s, k), g, next, &square);
#else
  smg_scale(g, 0.5 * smg_h_over_kappa(c, k, h), 3);
  return smg_own_spin(s->w + 3 * k, smg_leaf_value(s, k), g, next);
#endif
}

/* One spin solves its own step exactly in the field that the others, as they stand, make at its place. */
static inline void smg_relax(void *context, smg_lattice_site at) {
  smg_sweeping *sweep = (smg_sweeping *)context;
  smg_state *s = sweep->s;
  const int64_t k = at.k;
  const smg_real up = smg_site_up(s, k);
  smg_real g[3] = {0, 0, 0}, next[3], *m = s->m + 3 * k;
#if SMG_FETCHED_AHEAD /* 100,000 sites numbered at random: a step takes about 0.8 of the time */
  SMG_FETCH(s->m + 3 * at.s0);
  SMG_FETCH(s->w + 3 * at.s0);
#endif
  smg_gather(&s->c, at, s->m, m, g);
  if (!smg_relaxed(s, sweep->h, k, g, next)) { /* as the others stand: no step yet, and not settled */
    sweep->change.absolute = smg_max(sweep->change.absolute, up * smg_leaf_value(s, k));
    sweep->change.relative = smg_max(sweep->change.relative, 1);
    return;
  }
  for (int b = 0; b < 3; ++b) smg_change_add(&sweep->change, next[b] - m[b], SMG_MATH(fabs)(next[b]), up);
  smg_copy(m, next, 3);
}

/* One sweep, colour after colour: each site sees the newest values of the others. Apart, so that the loop over sites
 * has all registers: of compositions 3 % fewer instructions. */
SMG_APART static smg_change smg_sweep(smg_state *s, smg_real h) {
  smg_sweeping sweep = {s, h, {0, 0, 0}};
  smg_each_coloured(&s->c, &sweep, smg_relax);
  return sweep.change;
}

/* What the increments after a sweep show: the largest residual of u - h X(m) and of m - P(w + u/2), a bound on the rows
 * of J - I, and the size of the products in h X. */
typedef struct smg_sweep_end {
  smg_state *s;
  smg_real h, residual, row, rounding_scale;
} smg_sweep_end;

/* u = h X(m) of one site. J_ij - I has the factors 1/kappa of its row and s of its column; with the s of the row, as
 * diag(s) (J - I) diag(1/s) has it, the rows are at most (h/2)(1/kappa) s (r sum of norms of B + abs(m.g)/r). */
static inline void smg_end_site(void *context, smg_lattice_site at) {
  smg_sweep_end *end = (smg_sweep_end *)context;
  const smg_state *s = end->s;
  const smg_coefficients *c = &s->c;
  const int64_t k = at.k;
  const smg_real *m = s->m + 3 * k, *w = s->w + 3 * k, leaf = smg_leaf_value(s, k), up = smg_site_up(s, k);
  smg_real g[3] = {0, 0, 0}, u[3], again[3], room[3];
  smg_gather(c, at, s->m, m, g);
  smg_increment(c, k, end->h, m, g, u);
  const smg_real rounding_scale = up * smg_product_scale(c, k, end->h, m, g);
  smg_take(&end->rounding_scale, rounding_scale);
  if (smg_kind(c, k) != SMG_NAMBU) {
    if (rounding_scale > s->scale) {
      smg_copy(again, u, 3);
      smg_reflect(w, m, u);
      smg_take(&end->residual, up * smg_apart_by(u, again));
    }
    if (3 * rounding_scale > s->scale) smg_stretch(w, s->compensation + 3 * k, leaf, smg_respond(c, k, m, g, room), u);
  }
  const smg_real stretch = smg_halfway(s, k, u, again);
  smg_take(&end->residual, up * smg_apart_by(again, m));
  smg_copy(s->u + 3 * k, u, 3);
#if SMG_CONSTANT_HESSIAN
  smg_take(&end->row, stretch * smg_abs(0.5 * smg_h_over_kappa(c, k, end->h)) *
                          smg_respond_norm(c, k, m, g, leaf, smg_hessian_row_norm(c, k)));
#else
  (void)stretch;
#endif
}

/* The increments of the solution that the sweeps left: is the step equation solved to round-off? *row: a bound on the
 * row sums of J - I, where one is known. */
static int smg_end_sweeps(smg_state *s, smg_real h, smg_real *row) {
  smg_sweep_end end = {s, h, 0, 0, 0};
  smg_each(&s->c, &end, smg_end_site);
  s->report.residual = end.residual;
  *row = SMG_CONSTANT_HESSIAN ? end.row : SMG_MAX;
  return smg_swept_to_round_off(end.residual, s->scale + end.rounding_scale) || smg_tolerated(s, end.residual);
}
#else
/* One sweep of the plain fixed point mbar = w + (h/2) X(P(mbar)). */
static smg_change smg_sweep(smg_state *s, smg_real h) {
  const smg_change change = smg_evaluate(s, h);
  smg_set_midpoints(s);
  return change;
}
#endif

/* Sweeps to stagnation. */
static smg_status smg_settle(smg_state *s, smg_real h) {
  smg_change last = {SMG_MAX, SMG_MAX, 0};
  for (int it = 0;; ++it) {
    const smg_change now = smg_sweep(s, h);
    s->report.iterations = it;
    s->report.residual = now.absolute;
    if (!(now.absolute <= SMG_MAX)) return SMG_NOT_FINITE;
    if (smg_settled(&now, &last, s->scale) || smg_tolerated(s, now.absolute)) return SMG_OK;
    if (it == SMG_TRIED_SWEEPS) return SMG_NO_CONVERGENCE;
    last = now;
  }
}

/* Midpoints and frames at the solution that the sweeps left, for the matrix. */
static void smg_sweep_midpoints(smg_state *s, smg_real h) {
  smg_set_midpoints(s);
  (void)smg_evaluate(s, h);
}

/* Do the sweeps' increments solve the step, and on the right branch? Else Newton goes on from their midpoints. */
static int smg_sweeps_solved(smg_state *s, smg_real h) {
#if SMG_ROTATION
  smg_real row;
  const int solved = smg_end_sweeps(s, h, &row);
  if (solved && row < 1) return 1; /* J - I is a contraction */
  smg_sweep_midpoints(s, h);
#if SMG_MATRIX_FREE
  smg_assemble(s, h);
  if (solved && (smg_row_bound(s) < 1 || smg_on_branch(s, h, smg_row_bound(s)))) {
    (void)smg_end_sweeps(s, h, &row); /* the matrix took another evaluation */
    return 1;
  }
#endif
#else
  smg_sweep_midpoints(s, h);
#endif
  return 0;
}

/* Sweeps, while they settle soon; SMG_NO_CONVERGENCE leaves the step to Newton, and the next SMG_NEWTON_STEPS steps
 * with it. */
static smg_status smg_sweeps(smg_state *s, smg_real h) {
  if (s->newton_steps > 0) {
    --s->newton_steps;
    return SMG_NO_CONVERGENCE;
  }
  smg_sweep_start(s);
  const smg_status status = smg_settle(s, h);
  if (status != SMG_OK) {
    s->newton_steps = SMG_NEWTON_STEPS;
    return status;
  }
  return smg_sweeps_solved(s, h) ? SMG_OK : smg_newton(s, h); /* which finds it solved, and checks the branch */
}

#endif
