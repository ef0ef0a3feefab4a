/* smidgen runtime: the step of sites that are solved alone, each by Newton on its own midpoint, in the field of its
 * neighbours where it is a tracer. */
#ifndef SMG_ALONE_H
#define SMG_ALONE_H

#include "smg_follow.h"
#include "smg_midpoint.h"
#if SMG_ALONE_NEWTON
#include "smg_noise.h"
#endif
#if !SMG_SINGLE_SPHERE
#include "smg_predictor.h"
#endif
#include "smg_report.h"
#include "smg_rules.h"

#if SMG_ALONE_LINEAR
/* The midpoint of a site in the field of the gradient g; 0 where it has none. *square: that of (h/2 kappa) g. */
static inline int smg_own_midpoint(const smg_state *s, smg_real h, int64_t k, const smg_real *g, smg_real *m,
                                   smg_real *square) {
  const smg_real *w = s->w + 3 * k, r = smg_leaf_value(s, k);
#if SMG_RESPONDS
  return smg_own_response(&s->c, k, h, w, r, g, m, square);
#else
  smg_real half[3];
  smg_multiple(half, 0.5 * smg_h_over_kappa(&s->c, k, h), g, 3);
  if (!(smg_dot(half, half) <= SMG_MAX)) smg_shorten(half);
  *square = smg_dot(half, half);
  return smg_own_spin(w, r, half, m);
#endif
}

/* The part of h up to which it has steps; across its field a spin has them below h |b| = 2. */
static inline smg_real smg_end_of_steps(const smg_state *s, smg_real h, int64_t k, const smg_real *g) {
#if SMG_RESPONDS
  return smg_own_reach(&s->c, k, h, s->w + 3 * k, smg_leaf_value(s, k), g);
#else
  return 2 / smg_abs(smg_h_over_kappa(&s->c, k, h) * smg_norm(g));
#endif
}

/* A linear field turns each site exactly: the step equation in closed form. */
static smg_status smg_solve_linear(smg_state *s, smg_real h, int64_t k) {
  const smg_coefficients *c = &s->c;
  smg_real g[3] = {0, 0, 0}, m[3], room[3], square, *u = s->u + 3 * k;
  smg_gather(c, smg_at(k), s->m, s->w + 3 * k, g);
  s->report.iterations = 0;
  s->report.residual = 0;
  if (!smg_own_midpoint(s, h, k, g, m, &square)) {
    s->report.reached = smg_end_of_steps(s, h, k, g);
    return smg_end_report(s, SMG_NO_SOLUTION, k);
  }
  smg_increment(c, k, h, m, g, u);
  if (square >= 1) smg_reflect(s->w + 3 * k, m, u);
  if (square >= 0.25 && smg_leaf_value(s, k) > 0)
    smg_stretch(s->w + 3 * k, s->compensation + 3 * k, smg_leaf_value(s, k), smg_respond(c, k, m, g, room), u);
  if (SMG_MATH(fabs)(u[0]) + SMG_MATH(fabs)(u[1]) + SMG_MATH(fabs)(u[2]) <= SMG_MAX) return SMG_OK;
  s->report.reached = 0; /* that of a curve before */
  return smg_end_report(s, SMG_NOT_FINITE, k);
}
#endif

#if SMG_ALONE_NEWTON
/* The step equation of one site at one midpoint: m = s mbar, g = dH/dw, the residual r, Newton's J and right-hand side
 * a, and curved = B S; of a method that divides h X by q, rate = h/q and root, with which q is found. */
typedef struct smg_site_equation {
  smg_real rate, q, root;
  smg_real s, m[3], g[3], r[3], S[3 * SMG_BS], J[SMG_BB], a[SMG_BS], curved[3 * SMG_BS];
} smg_site_equation;

/* m = P(mbar), g there, and u = h X(m). */
SMG_INLINE void smg_site_field(const smg_state *s, smg_real h, int64_t k, const smg_real *mbar, smg_site_equation *e,
                               smg_real *u) {
  e->g[0] = e->g[1] = e->g[2] = 0;
  e->s = smg_project(&s->c, k, smg_leaf_value(s, k), mbar, e->m);
  smg_gather(&s->c, smg_at(k), s->m, e->m, e->g);
  smg_increment(&s->c, k, h, e->m, e->g, u);
}

/* The increment of the method at mbar; 0 where it has none. */
SMG_INLINE int smg_site_evaluate(const smg_state *s, smg_real h, int64_t k, const smg_real *mbar, smg_site_equation *e,
                                 smg_real *u) {
  smg_site_field(s, h, k, mbar, e, u);
  e->rate = h;
#if SMG_DIVIDED
  e->q = smg_divisor(&s->c, k, h, e->g, &e->root);
  e->rate = h / e->q;
  if (e->q < 0) return 0;
  smg_divide(u, e->q, 3);
#endif
  return 1;
}

/* The frame of one site and its Newton matrix J, with the right-hand side a of the residual r. */
SMG_INLINE void smg_site_matrix(const smg_state *s, smg_real h, int64_t k, smg_site_equation *e) {
  smg_real G[3 * SMG_BS];
  smg_newton_frame(&s->c, k, h, e->m, e->s, e->g, e->r, G, e->S, e->J, e->a);
  for (int l = 0; l < SMG_BS; ++l) {
    smg_real *y = e->curved + 3 * l;
    y[0] = y[1] = y[2] = 0;
    smg_site_hessian_vector(&s->c, smg_at(k), s->m, e->m, e->S + 3 * l, y);
    for (int n = 0; n < SMG_BS; ++n) e->J[SMG_BS * n + l] += smg_dot(G + 3 * n, y);
  }
}

/* Is the residual e->r of this size? u = h X(m), of which the noise is measured where the terms alone do not explain
 * it; twice that, for a formula rounds each product a few times. */
static int smg_site_is_round_off(const smg_state *s, smg_real h, int64_t k, const smg_site_equation *e,
                                 const smg_real *u, smg_real bound) {
  const smg_real size = smg_largest(s->w + 3 * k), products = smg_product_scale(&s->c, k, h, e->m, e->g),
                 r = smg_largest(e->r);
  if (r <= smg_round_off(size, products, bound, 0, s->scale)) return 1;
  return r <= smg_round_off(size, products, bound, 2 * smg_site_noise(s, h, k, e->m, u), s->scale);
}

/* What round-off is measured by. C(w) = w.grad C(w)/2 cancels near its cone, and P divides by it. */
SMG_INLINE smg_real smg_site_size(const smg_state *s, int64_t k) {
  const smg_real *w = s->w + 3 * k;
  smg_real n[3];
  if (!SMG_ONTO_LEAF || smg_kind(&s->c, k) != SMG_NAMBU) return s->scale;
  smg_normal(&s->c, k, w, n);
  return s->scale * (smg_norm(w) * smg_norm(n) / SMG_MATH(fabs)(smg_dot(w, n)));
}

/* The end of a contractive step: evaluations at the midpoint of w + compensation, until a twentieth of the round-off of
 * the iteration is left, which would drift. They move u by round-off alone, but where its field jumps. */
static smg_status smg_site_refine(smg_state *s, smg_real h, int64_t k, smg_real *mbar, smg_real *u, smg_real bound) {
  const smg_real size = smg_kind(&s->c, k) == SMG_NAMBU ? s->scale : smg_min(s->scale, smg_leaf_value(s, k));
  smg_site_equation e;
  smg_real left = 1, next[3];
  for (int n = 0; smg_refines(n, left); ++n) {
    smg_middle(3, s->w + 3 * k, s->compensation + 3 * k, u, mbar);
    (void)smg_site_evaluate(s, h, k, mbar, &e, next);
    for (int b = 0; b < 3; ++b) { /* where the method ends, too, it jumps */
      if (smg_abs(next[b] - u[b]) > SMG_NEARLY * size) return SMG_NO_CONVERGENCE;
      u[b] = next[b];
    }
    left *= smg_contracts(bound) ? bound : 0; /* more of them would enlarge it */
  }
  smg_tangential(&s->c, k, s->w + 3 * k, s->compensation + 3 * k, u); /* else the Casimirs of Nambu leaves drift */
  return smg_largest(u) <= SMG_MAX ? SMG_OK : SMG_NOT_FINITE;
}

/* Newton's matrix of the method at e; returns the largest row sum of abs(J - I). */
SMG_INLINE smg_real smg_site_linearise(const smg_state *s, SMG_UNUSED smg_real h, int64_t k,
                                       SMG_UNUSED const smg_real *u, smg_site_equation *e) {
  smg_site_matrix(s, e->rate, k, e);
#if SMG_DIVIDED
  for (int l = 0; l < SMG_BS; ++l) {
    const smg_real slope = smg_divisor_slope(&s->c, k, h, e->g, e->curved + 3 * l, e->q, e->root);
    for (int n = 0; n < SMG_BS; ++n) e->J[SMG_BS * n + l] -= 0.5 * u[n] * slope;
  }
#endif
  return smg_bound(SMG_BS, e->J);
}

/* The end of a non-contractive step: h X would enlarge what is left, so the midpoint tells u; is it right to its
 * round-off? */
SMG_COLD static int smg_site_refine_by_newton(const smg_state *s, smg_real rate, int64_t k, smg_real *mbar, smg_real *u,
                                              smg_real bound) {
  const smg_real *w = s->w + 3 * k, *compensation = s->compensation + 3 * k;
  smg_site_equation e;
  smg_real x[3];
  smg_waxpy(u, -1, w, mbar, 3);
  smg_scale(u, 2, 3);
  smg_tangential(&s->c, k, w, compensation, u);
  smg_middle(3, w, compensation, u, mbar);
  smg_site_field(s, rate, k, mbar, &e, x);
  smg_waxpy(e.r, -1, u, x, 3);
  return smg_site_is_round_off(s, rate, k, &e, x, bound);
}

/* One site alone: Newton on mbar. *sure: the solution is shown to be connected to W = w at h = 0. */
static smg_status smg_site_newton(smg_state *s, smg_real h, int64_t k, smg_real *mbar, smg_real *u, int *sure) {
  const smg_coefficients *c = &s->c;
  smg_change last = {SMG_MAX, SMG_MAX, 0};
  smg_real bound = 0, most = 0;
  for (int it = 0;; ++it) {
    smg_site_equation e;
    if (!smg_site_evaluate(s, h, k, mbar, &e, u)) return SMG_NO_CONVERGENCE; /* of this iterate: no proof */
    smg_change now = {0, 0, 0};
    smg_residual(s, k, mbar, u, smg_product_scale(c, k, h, e.m, e.g), e.r, &now);
    s->report.iterations = it;
    s->report.residual = now.absolute;
    if (!(now.absolute <= SMG_MAX)) return SMG_NOT_FINITE;
    const smg_real size = smg_site_size(s, k);
    /* near the cone C = 0 no digit of P is left */
    if (smg_kind(c, k) == SMG_NAMBU && !smg_shown(size, s->scale)) return SMG_NO_CONVERGENCE;
    const int done = smg_stagnates(&now, &last, size, it, bound) || smg_tolerated(s, now.absolute) ||
                     (smg_stalls(&now, &last, s->scale, it) && smg_site_is_round_off(s, e.rate, k, &e, u, bound));
    int noncontractive = smg_strong_field(&now, size) || !smg_plain_end_serves(bound);
    if (done && it > 0 && !noncontractive) return s->tolerance > 0 ? SMG_OK : smg_site_refine(s, h, k, mbar, u, bound);
    if (it == SMG_MAX_NEWTON) return SMG_NO_CONVERGENCE;
    if (smg_kind(c, k) == SMG_R3 && !(smg_leaf_value(s, k) > 0)) {
      *sure = 1;
      return SMG_OK;
    }
    bound = smg_site_linearise(s, h, k, u, &e);
    noncontractive = noncontractive || !smg_plain_end_serves(bound);
    most = smg_max(most, bound); /* a contraction on the way too: another branch may look as calm */
    *sure = smg_contracts(most);
    if (smg_block_solve(e.J, e.a)) return SMG_SINGULAR;
    if (done && !noncontractive) continue; /* begun at the solution */
    smg_newton_correct(c, k, h, e.m, e.s, e.g, e.r, e.S, e.a, mbar);
    if (done && smg_site_refine_by_newton(s, e.rate, k, mbar, u, bound)) return SMG_OK;
    last = now;
  }
}

#if !SMG_DIVIDED
/* One step of one site as a curve. */
typedef struct smg_site_whole {
  smg_state *s;
  smg_real h;
  int64_t k;
} smg_site_whole;

/* Newton's correction a of the midpoint y for the part p of h, and slope, how it changes with p. */
static smg_status smg_site_curve_newton(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *slope,
                                        int *sign) {
  const smg_site_whole *whole = (const smg_site_whole *)of;
  smg_state *s = whole->s;
  const int64_t k = whole->k;
  const smg_real h = p * whole->h;
  smg_real u[3];
  smg_site_equation e;
  smg_site_field(s, whole->h, k, y, &e, u);
  for (int which = 0; which < 2; ++which) {
    smg_real *out = which == 0 ? a : slope;
    for (int b = 0; b < 3; ++b) e.r[b] = which == 0 ? s->w[3 * k + b] + 0.5 * p * u[b] - y[b] : 0.5 * u[b];
    if (!(smg_largest(e.r) <= SMG_MAX)) return SMG_NOT_FINITE;
    smg_site_matrix(s, h, k, &e);
    *sign = smg_block_det(e.J) < 0 ? -1 : 1;
    if (smg_block_solve(e.J, e.a)) return SMG_SINGULAR;
    out[0] = out[1] = out[2] = 0;
    smg_newton_correct(&s->c, k, h, e.m, e.s, e.g, e.r, e.S, e.a, out);
  }
  return SMG_OK;
}

/* The solution connected to W = w at h = 0, by its whole curve; or why there is none. */
SMG_RARE static smg_status smg_site_follow(smg_state *s, smg_real h, int64_t k, smg_real *mbar) {
  smg_site_whole whole = {s, h, k};
  smg_real room[15];
  smg_curve f;
  smg_begin_curve(&f, &whole, smg_site_curve_newton, NULL, 3, s->w + 3 * k, s->scale, room);
  const smg_status status = smg_follow(&f);
  s->report.reached = f.reached;
  smg_copy(mbar, f.y, 3);
  return status;
}

/* What Newton found with `status` may be another branch's: follow the right one, and solve again at its end. */
SMG_COLD SMG_RARE static smg_status smg_site_branch(smg_state *s, smg_real h, int64_t k, smg_real *mbar,
                                                    smg_status status) {
  int sure;
  const smg_status followed = smg_site_follow(s, h, k, mbar);
  if (followed == SMG_OK) return smg_site_newton(s, h, k, mbar, s->u + 3 * k, &sure);
  return smg_curve_tells(followed) || status == SMG_OK ? followed : status;
}
#else
/* The solution from W = w at h = 0 by stages of h. */
SMG_COLD SMG_RARE static smg_status smg_site_branch(smg_state *s, smg_real h, int64_t k, smg_real *mbar,
                                                    smg_status status) {
  const smg_real *w = s->w + 3 * k;
  smg_real *u = s->u + 3 * k;
  int sure;
  smg_copy(mbar, w, 3);
  for (int n = 1; n <= SMG_CONTINUATION_STEPS; ++n) {
    status = smg_site_newton(s, h * (smg_real)n / SMG_CONTINUATION_STEPS, k, mbar, u, &sure);
    if (status != SMG_OK) break;
    if (n < SMG_CONTINUATION_STEPS)
      for (int b = 0; b < 3; ++b) mbar[b] = w[b] + 0.5 * u[b] * (smg_real)(n + 1) / (smg_real)n;
  }
  return status;
}
#endif

/* From the extrapolated start, or from rest where that of a single sphere has failed; when this fails or may be on
 * another branch, by the branch from rest. */
static smg_status smg_site_solve(smg_state *s, smg_real h, int64_t k) {
  smg_real mbar[3];
  int sure = 0;
#if SMG_SINGLE_SPHERE
  smg_copy(mbar, s->w, 3);
#else
  for (int b = 0; b < 3; ++b) mbar[b] = s->w[3 * k + b] + 0.5 * smg_extrapolate(s, 3 * k + b, s->degree);
#endif
  smg_status status = smg_site_newton(s, h, k, mbar, s->u + 3 * k, &sure);
  if (status == SMG_OK && sure) return SMG_OK;
  status = smg_site_branch(s, h, k, mbar, status);
  if (status != SMG_OK) s->report.site = k;
  return status;
}
#endif

#if !SMG_SINGLE_SPHERE
/* One site, in closed form where its field does not depend on it. */
static smg_status smg_solve_alone(smg_state *s, smg_real h, int64_t k) {
#if SMG_ALONE_LINEAR && SMG_ALONE_NEWTON
  return smg_is_linear(&s->c, k) ? smg_solve_linear(s, h, k) : smg_site_solve(s, h, k);
#elif SMG_ALONE_LINEAR
  return smg_solve_linear(s, h, k);
#else
  return smg_site_solve(s, h, k);
#endif
}

/* The step has failed; of the sites from the n-th on that fail too, the report is that of the one whose solutions end
 * first. */
SMG_COLD static smg_status smg_first_end(smg_state *s, smg_real h, int64_t n, smg_status status) {
  smg_report first = s->report;
  for (; n < smg_alone(&s->c) && first.reached > 0; ++n) {
    const int64_t k = smg_alone_site(&s->c, n);
    if (smg_tracer(&s->c, k)) continue;
    s->report.reached = 0;
    const smg_status alone = smg_solve_alone(s, h, k);
    if (alone == SMG_OK || !(s->report.reached < first.reached)) continue;
    status = alone;
    first = s->report;
    first.partner = -1;
  }
  s->report = first;
  return status;
}

/* Is the n-th site solved already, with others (smg_alone_lanes.h)? */
#if SMG_ALONE_IN_LANES
#define SMG_SOLVED_ALREADY(s, h, n, solved) smg_solved_in_lanes(s, h, n, solved)
#else
#define SMG_SOLVED_ALREADY(s, h, n, solved) ((void)(solved), 0)
#endif

static inline void smg_take_report(const smg_state *s, int *iterations, smg_real *residual) {
  *iterations = s->report.iterations > *iterations ? s->report.iterations : *iterations;
  smg_take(residual, s->report.residual);
}

/* Each site alone: tracers in the field of the midpoints that the step of the others found, so after them; the rest
 * whether or not the others have a step. The report has the most iterations, and the largest residual, of any site. */
static smg_status smg_solve_all_alone(smg_state *s, smg_real h, smg_status status) {
  int iterations = SMG_HAS_COUPLED ? s->report.iterations : 0;
  smg_real residual = SMG_HAS_COUPLED ? s->report.residual : 0;
  uint64_t solved = 0;
  int64_t n = 0;
  for (; n < smg_alone(&s->c) && status == SMG_OK; ++n) {
    const int already = SMG_SOLVED_ALREADY(s, h, n, &solved);
    if (SMG_ALONE_IN_LANES) smg_take_report(s, &iterations, &residual); /* of a block */
    if (already) continue;
    status = smg_solve_alone(s, h, smg_alone_site(&s->c, n));
    smg_take_report(s, &iterations, &residual);
  }
  if (status != SMG_OK) return smg_first_end(s, h, n, status);
  s->report.iterations = iterations;
  s->report.residual = residual;
  return SMG_OK;
}
#endif

#endif
