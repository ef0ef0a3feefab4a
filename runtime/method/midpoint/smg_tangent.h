/* smidgen method: the tangent map of a midpoint step W = w + h X(m), m = P(mbar; leaf(w)), mbar = (w + W)/2. For a
 * tangent vector dw of w
 *     dm = P' d + z,   d = dw + (h/2) DX(m) dm,   dW = 2 d - dw,
 * with z = (dP/dleaf) dleaf: J d = dw + (h/2) DX z with the matrix J = I - (h/2) DX(m) P' of the step. With n = grad
 * C(m), g = dH/dw(m) and the Hessian B of H: DX dm = (1/kappa) (grad C(dm) x g + n x (B dm)). */
#ifndef SMG_TANGENT_H
#define SMG_TANGENT_H

#if SMG_COMPOSED
#include "smg_composition.h"
#elif SMG_SINGLE_SPHERE
#include "smg_single_sphere.h"
#else
#include "smg_step.h"
#endif
#include "smg_report.h"
#include "smg_saved.h"
#if SMG_BY_ROWS
#include "smg_row_tangent.h"
#endif

/* Does the leaf of a site move with w? */
static inline int smg_lifted(const smg_coefficients *c, int64_t k) {
  return SMG_ONTO_LEAF && smg_kind(c, k) != SMG_SPHERE;
}

/* P' d = s (d - m (n.d)/(n.m)), or d where P is none. */
static inline void smg_project_change(const smg_coefficients *c, int64_t k, const smg_real *m, smg_real s,
                                      const smg_real *d, smg_real *out) {
  smg_real n[3];
  smg_normal(c, k, m, n);
  const smg_real a = SMG_ONTO_LEAF ? smg_dot(n, d) / smg_dot(n, m) : 0;
  for (int b = 0; b < 3; ++b) out[b] = SMG_ONTO_LEAF ? s * (d[b] - a * m[b]) : d[b];
}

/* w, the site k before the step (part = 1), or on the way back to it. */
static inline void smg_before_step(const smg_state *s, smg_real part, int64_t k, smg_real *w) {
  smg_waxpy(w, -part, smg_last_increment(s, k), s->w + 3 * k, 3);
}

/* dW = 2 d - dw in place of dw. */
SMG_INLINE void smg_push_through(smg_real *v, const smg_real *d) {
  smg_scale(v, -1, 3);
  smg_axpy(v, 2, d, 3);
}

/* z = m (grad C(w).dw)/(n.m), w the state before the step, where the leaf moves with w; else 0, and so returned. */
static inline int smg_lift_column(const smg_state *s, int64_t k, const smg_real *m, const smg_real *dw, smg_real *z) {
  smg_real w[3], before[3], n[3];
  smg_zero(z, 3);
  if (!smg_lifted(&s->c, k)) return 0;
  smg_before_step(s, 1, k, w);
  smg_normal(&s->c, k, w, before);
  smg_normal(&s->c, k, m, n);
  smg_multiple(z, smg_dot(before, dw) / smg_dot(n, m), m, 3);
  return 1;
}

/* out = h DX dm from dm and y = B dm. */
static inline void smg_vary(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *m, const smg_real *g,
                            const smg_real *dm, const smg_real *y, smg_real *out) {
  const smg_real rate = smg_h_over_kappa(c, k, h);
  smg_respond_vary(c, k, m, g, dm, y, out);
#if SMG_DIVIDED
  /* u = h X/q: on top of h DX dm/q comes h X d(1/q) */
  smg_real n[3], X[3], root;
  const smg_real q = smg_divisor(c, k, h, g, &root), slope = smg_divisor_slope(c, k, h, g, y, q, root);
  smg_normal(c, k, m, n);
  smg_cross(X, n, g);
  for (int b = 0; b < 3; ++b) out[b] = rate * (out[b] + slope * X[b]) / q;
#else
  smg_scale(out, rate, 3);
#endif
}

#if SMG_HAS_ALONE
/* Solves (1 - (h/2) DX P') d = r for one site; d holds r. 0, or not where it is singular. */
static inline int smg_solve_change(const smg_state *s, smg_real h, int64_t k, const smg_real *m, smg_real scale,
                                   const smg_real *g, smg_real *d) {
  smg_real J[9];
  for (int l = 0; l < 3; ++l) {
    const smg_real e[3] = {(smg_real)(l == 0), (smg_real)(l == 1), (smg_real)(l == 2)};
    smg_real dm[3], y[3] = {0, 0, 0}, column[3];
    smg_project_change(&s->c, k, m, scale, e, dm);
    smg_site_hessian_vector(&s->c, smg_at(k), s->m, m, dm, y);
    smg_vary(&s->c, k, h, m, g, dm, y, column);
    for (int b = 0; b < 3; ++b) J[3 * b + l] = e[b] - 0.5 * column[b];
  }
  return smg_solve_small(3, J, d);
}

/* One site alone; a tracer is moved by the coupled ones, whose d and dm are in mem. */
static smg_status smg_push_alone(smg_state *s, smg_real h, int64_t k, smg_real *v, const smg_real *mem) {
  const smg_coefficients *c = &s->c;
  const smg_real *dm = SMG_HAS_COUPLED ? mem + 3 * smg_sites(c) : NULL;
  smg_real m[3], mbar[3], g[3] = {0, 0, 0}, y[3] = {0, 0, 0}, z[3], d[3];
  smg_before_step(s, 0.5, k, mbar);
  const smg_real scale = smg_project(c, k, smg_leaf_value(s, k), mbar, m);
  smg_gather(c, smg_at(k), s->m, m, g);
  if (smg_lift_column(s, k, m, v + 3 * k, z)) smg_site_hessian_vector(c, smg_at(k), s->m, m, z, y);
  smg_bend(c, smg_at(k), s->m, m, dm, y);
  smg_vary(c, k, h, m, g, z, y, d);
  smg_waxpy(d, 0.5, d, v + 3 * k, 3);
  if (smg_solve_change(s, h, k, m, scale, g, d)) return smg_end_report(s, SMG_SINGULAR, k);
  smg_push_through(v + 3 * k, d);
  return SMG_OK;
}
#endif

#if SMG_HAS_COUPLED
/* A column under way: dw, d and dm of all sites. */
typedef struct smg_variation {
  smg_state *s;
  smg_real h, *v, *d, *dm;
} smg_variation;

#if SMG_COUPLED_LIFTED
/* r = dw + (h/2) DX z of one site; dm holds z of all. */
static inline void smg_load_change(void *of, smg_lattice_site at) {
  smg_variation *q = (smg_variation *)of;
  smg_state *s = q->s;
  const int64_t k = at.k;
  smg_real y[3] = {0, 0, 0}, *r = s->r + 3 * k;
  smg_bend(&s->c, at, s->m, s->m + 3 * k, q->dm, y);
  smg_site_hessian_vector(&s->c, at, s->m, s->m + 3 * k, q->dm + 3 * k, y);
  smg_vary(&s->c, k, q->h, s->m + 3 * k, s->g + 3 * k, q->dm + 3 * k, y, r);
  smg_waxpy(r, 0.5, r, q->v + 3 * k, 3);
}

#endif

/* The right-hand sides r of all coupled sites. */
static void smg_load_changes(smg_variation *q) {
  smg_state *s = q->s;
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    smg_copy(s->r + 3 * k, q->v + 3 * k, 3);
    (void)smg_lift_column(s, k, s->m + 3 * k, q->v + 3 * k, q->dm + 3 * k);
  }
#if SMG_COUPLED_LIFTED
  smg_each(&s->c, q, smg_load_change);
#endif
}

/* dm = P' d + z of a coupled site, for the tracers that it moves. */
static inline void smg_midpoint_change(smg_variation *q, int64_t k) {
  const smg_state *s = q->s;
  smg_real z[3];
  smg_project_change(&s->c, k, s->m + 3 * k, s->s[k], q->d + 3 * k, q->dm + 3 * k);
  if (smg_lift_column(s, k, s->m + 3 * k, q->v + 3 * k, z)) smg_axpy(q->dm + 3 * k, 1, z, 3);
}

/* J d = r in the frames of the tangent planes, and dW = 2 d - dw. */
static smg_status smg_push_coupled(smg_variation *q, smg_real *keep) {
  smg_state *s = q->s;
  smg_load_changes(q);
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    smg_real own[SMG_BB];
    smg_row_frame(s, q->h, row, own);
  }
  if (smg_singular(s, smg_solve_kept(s, keep))) return SMG_SINGULAR;
  smg_correct_all(s, q->h, q->d);
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    if (SMG_HAS_ALONE) smg_midpoint_change(q, k);
    smg_push_through(q->v + 3 * k, q->d + 3 * k);
  }
  return SMG_OK;
}

/* The matrix of the step at its solution, factored where that serves all columns. */
static smg_status smg_tangent_matrix(smg_state *s, smg_real h, smg_real *keep) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_before_step(s, 0.5, k, s->mbar + 3 * k);
  (void)smg_evaluate(s, h);
  smg_assemble(s, h);
  return smg_singular(s, smg_keep_matrix(s, keep)) ? SMG_SINGULAR : SMG_OK;
}
#endif

/* Is every number of a column finite? */
static smg_status smg_finite_column(smg_state *s, const smg_real *v) {
  for (int64_t k = 0; k < 3 * smg_sites(&s->c); ++k)
    if (!(smg_abs(v[k]) <= SMG_MAX)) return smg_end_report(s, SMG_NOT_FINITE, k / 3);
  return SMG_OK;
}

/* One column; mem: d and dm of all sites, then what the matrix keeps. */
static smg_status smg_push_column(smg_state *s, smg_real h, smg_real *v, smg_real *mem) {
  smg_status status = smg_finite_column(s, v);
#if SMG_HAS_COUPLED
  const int64_t size = 3 * smg_sites(&s->c);
  smg_variation q = {s, h, v, mem, mem + size};
  if (status == SMG_OK) status = smg_push_coupled(&q, mem + 2 * size);
#endif
#if SMG_HAS_ALONE
  for (int64_t n = 0; n < smg_alone(&s->c) && status == SMG_OK; ++n)
    status = smg_push_alone(s, h, smg_alone_site(&s->c, n), v, mem);
#endif
  return status == SMG_OK ? smg_finite_column(s, v) : status;
}

static size_t smg_step_tangent_memory(SMG_UNUSED const smg_model *model) {
#if SMG_BY_ROWS || SMG_HAS_COUPLED
  smg_coefficients c;
  c.model = model;
#if SMG_BY_ROWS /* more than steps by sites need, whose matrix keeps at most its permutation */
  return sizeof(smg_real) * smg_row_push_size(&c);
#else
  return sizeof(smg_real) * (size_t)(6 * smg_sites(&c) + smg_kept_size(&c));
#endif
#else
  return 0;
#endif
}

#if SMG_LEAVES
/* The leaf that a site was on before the step just taken. */
static smg_status smg_leaf_before(smg_state *s, int64_t k) {
  smg_real w[3];
  if (!smg_lifted(&s->c, k)) return SMG_OK;
  smg_before_step(s, 1, k, w);
  s->leaf_value[k] = smg_leaf_value_of(&s->c, k, w);
  if (smg_kind(&s->c, k) != SMG_R3) return SMG_OK;
  s->report.site = k; /* m = |w| mbar/|mbar| has no derivative at w = 0 */
  return s->leaf_value[k] > 0 ? SMG_OK : SMG_SINGULAR;
}
#endif

#if SMG_BY_ROWS
/* The same of all columns where steps go by rows. */
static smg_status smg_push_rows(smg_state *s, smg_real h, smg_real *v, int64_t columns, smg_real *mem) {
  const int64_t size = 3 * smg_sites(&s->c);
  smg_status status = SMG_OK;
  smg_besides known;
  smg_row_push q;
  smg_begin_push(s, h, &known, mem, &q);
  for (int64_t j = 0; j < columns && status == SMG_OK; ++j) {
    status = smg_push_row_column(&q, v + size * j);
    if (status != SMG_NO_CONVERGENCE) status = smg_finite_column(s, v + size * j);
  }
  return status;
}
#endif

/* The columns through the step of the size h that has led to s->w by the newest increment, the time of its midpoint in
 * s->c. */
static smg_status smg_push_step(smg_state *s, smg_real h, smg_real *v, int64_t columns, smg_real *mem) {
  const int64_t sites = smg_sites(&s->c);
  smg_status status = SMG_OK;
#if SMG_BY_ROWS
  if (s->rows) return smg_push_rows(s, h, v, columns, mem);
#endif
#if SMG_LEAVES
  for (int64_t k = 0; k < sites && status == SMG_OK; ++k) status = smg_leaf_before(s, k);
#endif
#if SMG_HAS_COUPLED
  if (status == SMG_OK) status = smg_tangent_matrix(s, h, mem + 6 * sites);
#endif
  for (int64_t j = 0; j < columns && status == SMG_OK; ++j) status = smg_push_column(s, h, v + 3 * sites * j, mem);
  return status;
}

#if SMG_COMPOSED
#include "smg_composed_tangent.h"
#else
static size_t smg_tangent_memory(const smg_model *model) { return smg_step_tangent_memory(model); }

static smg_status smg_push_forward(smg_state *s, smg_real *v, int64_t columns, void *mem) {
  const smg_report report = s->report;
  smg_status status = smg_steps_known(s) > 0 ? SMG_OK : SMG_BAD_PARAMETER;
  smg_set_time_at(&s->c, s, (smg_real)-0.5);
  if (status == SMG_OK) status = smg_push_step(s, smg_signed_h(s->h), v, columns, (smg_real *)mem);
  if (status == SMG_OK) s->report = report;
  s->report.status = status;
  return status;
}
#endif

#endif
