/* smidgen method: the spherical midpoint of one unit sphere alone, in registers.
 *
 * Unknowns u = W - w and q = 1/|S|, S = w + W = 2w + u; m = q S; the step equation is
 * u = h X(m), X = (1/kappa) m x dH/dw. With e = h DX(m) m, eps = (1 - q^2 |S|^2)/2 and g = h X(m) + eps e, Newton's
 * pair is
 *     (1 - E) d = g - u,   E = M (1 - m m^T),   M = h q DX(m),   q <- q (1 + eps - q m.d).
 * As m.X = 0: m.M v = -q g.v, E m = 0, t = tr E = tr M; as div X = 0 where sites only precess, t = 0 there. With
 * a = (1 - m m^T)(g - u):
 *     E (g - u) = M a =: c,   E c = M c + q^2 (g.a) e,   det(1 - E) = 1 - t + e2(M) - q^2 g.e,
 * e2 the sum of the principal minors, and by Cayley and Hamilton (1 - E)^-1 = 1 + ((1 - t) E + E^2)/det(1 - E): no
 * matrix is factored. J = 1 - E has for t = 0 the eigenvalues 1, 1 +- sqrt(-e2(E)); one of them is real and <= 0
 * exactly when det(1 - E) <= 0. A determinant in (7/16, 5) keeps all of them clear of 0, where branches meet, and J
 * not far from 1; any other solution is checked by following its branch from h = 0.
 *
 * The model adds: smg_motion(c, m) = h X(m); smg_radial(c, m, g) = e; smg_derivative(c, m, q) = M, of type smg_slope
 * with smg_slope_times(M, v), smg_slope_minors(M) = e2(M) and smg_slope_sums(M), the row sums of abs(M). */
#ifndef SMG_SINGLE_SPHERE_H
#define SMG_SINGLE_SPHERE_H

#include "smg_alone.h"
#if SMG_EXTENDED
#include "smg_extended.h"
#endif
#include "smg_polynomial.h"
#include "smg_sphere_history.h"
#include "smg_state.h"
#include "smg_vec.h"

#include "smg_sphere_template.h"

#if SMG_COMPOSED
#include "smg_stage_predictor.h"
#else
/* The highest degree that smg_sphere_degree finds in so many rows. */
#define SMG_MOST_DEGREE(history) ((history) > 2 ? (history)-2 : 0)

/* The polynomial of degree d through the last d + 1 rows, one step on: weights (-1)^j C(d+1, j+1), four times each. */
static const smg_real smg_sphere_weights[SMG_HISTORY][4 * SMG_HISTORY] = {
    {1, 1, 1, 1},
    {2, 2, 2, 2, -1, -1, -1, -1},
    {3, 3, 3, 3, -3, -3, -3, -3, 1, 1, 1, 1},
    {4, 4, 4, 4, -6, -6, -6, -6, 4, 4, 4, 4, -1, -1, -1, -1},
    {5, 5, 5, 5, -10, -10, -10, -10, 10, 10, 10, 10, -5, -5, -5, -5, 1, 1, 1, 1},
    {6, 6, 6, 6, -15, -15, -15, -15, 20, 20, 20, 20, -15, -15, -15, -15, 6, 6, 6, 6, -1, -1, -1, -1},
    {7, 7, 7, 7, -21, -21, -21, -21, 35, 35, 35, 35, -35, -35, -35, -35, 21, 21, 21, 21, -7, -7, -7, -7, 1, 1, 1, 1},
    {8,  8,  8,  8,  -28, -28, -28, -28, 56, 56, 56, 56, -70, -70, -70, -70,
     56, 56, 56, 56, -28, -28, -28, -28, 8,  8,  8,  8,  -1,  -1,  -1,  -1},
    {9,   9,   9,   9,   -36, -36, -36, -36, 84, 84, 84, 84, -126, -126, -126, -126, 126, 126,
     126, 126, -84, -84, -84, -84, 36,  36,  36, 36, -9, -9, -9,   -9,   1,    1,    1,   1},
    {10,   10,   10,   10,   -45, -45, -45, -45, 120, 120, 120, 120, -210, -210, -210, -210, 252, 252, 252, 252,
     -210, -210, -210, -210, 120, 120, 120, 120, -45, -45, -45, -45, 10,   10,   10,   10,   -1,  -1,  -1,  -1}};

/* The polynomial of least error through the last increments, one step on; the sum over all but the two newest rows
 * is ready before they are. */
SMG_INLINE smg_vec smg_sphere_predict(smg_state *s, smg_real *q) {
  const smg_real *row = s->rows + 4 * s->row, *a = smg_sphere_weights[s->degree];
  smg_real sum[4];
  for (int i = 0; i < 4; ++i) sum[i] = a[4 * (SMG_HISTORY - 2) + i] * row[4 * (SMG_HISTORY - 2) + i];
  SMG_UNROLL
  for (int j = SMG_HISTORY - 3; j >= 2; --j)
    for (int i = 0; i < 4; ++i) sum[i] += a[4 * j + i] * row[4 * j + i];
  smg_copy(s->older, sum, 4);
  *q = (s->older[3] + a[4] * row[7]) + a[0] * row[3];
  return smg_vec_of((s->older[0] + a[4] * row[4]) + a[0] * row[0], (s->older[1] + a[4] * row[5]) + a[0] * row[1],
                    (s->older[2] + a[4] * row[6]) + a[0] * row[2]);
}
#endif

/* h X at the midpoint of w and w + h X(w), and once more with that increment, off by O(h^4); its q by three terms of
 * the roots of |S|^2 = 4 + |h X|^2 and 4 - |u|^2, which Newton makes good. On a free body (h = 2) off by 0.004, where
 * polynomials are by 0.2. */
SMG_INLINE smg_vec smg_sphere_explicit(const smg_coefficients *c, smg_vec w, smg_real *q) {
  smg_vec u = smg_motion(c, w);
  smg_real part = -smg_vec_dot(u, u) / 8;
  for (int k = 0; k < 2; ++k) {
    *q = (smg_real)0.5 * (1 + part * (1 + (smg_real)1.5 * part));
    u = smg_image(c, smg_twice_midpoint(w, u), *q);
    part = smg_vec_dot(u, u) / 8;
  }
  *q = (smg_real)0.5 * (1 + part * (1 + (smg_real)1.5 * part));
  return u;
}
#if SMG_EXTENDED
/* The solution to the digits of smg_wide: (u, low) = V + e, V = h X(m) at m = P(w + compensation + v/2), e = E d/(1 -
 * E) = (E + E^2) d/det(1 - E), d = V - v. d is so small that its own digits are plenty. */
SMG_INLINE void smg_sphere_widen(smg_state *s, smg_vec v, smg_real q) {
  smg_vec_store(s->u, v);
  smg_wide_evaluate(s);
  const smg_vec m = smg_vec_load(s->wide_m), d = smg_vec_load(s->wide_d), r = smg_radial(&s->c, m, v);
  const smg_slope D = smg_derivative(&s->c, m, q);
  const smg_vec a = smg_slope_times(D, smg_vec_sub(d, smg_vec_scale(smg_vec_dot(m, d), m)));
  const smg_vec b = smg_slope_times(D, smg_vec_sub(a, smg_vec_scale(smg_vec_dot(m, a), m)));
  const smg_real i = 1 / (1 + (smg_slope_minors(D) - (q * q) * smg_vec_dot(v, r)));
  smg_vec_store(s->wide_e, smg_vec_scale(i, smg_vec_add(a, b)));
  smg_wide_take(s);
}
#endif
/* The step found becomes the state, and its increment the newest row of the history. */
SMG_INLINE void smg_sphere_commit(smg_state *s, const smg_found *f) {
#if SMG_COMPOSED
  const smg_real q = smg_gamma[s->stage] * f->q;
#else
  const smg_real q = f->q;
#endif
  s->row = smg_sphere_keep(s->rows, s->row, SMG_ROWS, f->v, q);
#if SMG_EXTENDED
  smg_sphere_widen(s, f->v, f->q);
#if SMG_PLAIN_SUMS
  smg_axpy(s->w, 1, s->u, 3);
#else
  for (int k = 0; k < 3; ++k) smg_wide_commit(&s->w[k], &s->compensation[k], s->u[k], s->low[k]);
#endif
#else
  smg_sphere_move(s->w, s->compensation, f);
#endif
#if SMG_COMPOSED
  smg_stage_done(s);
#else
  ++s->count;
#endif
}

#if !SMG_COMPOSED
/* Which degree would have predicted the newest row best? */
static void smg_sphere_degree(smg_state *s) {
  smg_real miss[SMG_HISTORY] = {0};
  s->history = smg_rows_known(s, s->count);
  smg_sphere_misses(s->rows + 4 * s->row, s->history, miss);
  s->degree = smg_best_degree(s->history - 1, miss);
}
#endif

/* u without its part along the midpoint of w + compensation and w + compensation + u: then abs(W) = abs(w). */
SMG_INLINE smg_vec smg_sphere_tangential(const smg_state *s, smg_vec u) {
  const smg_vec S =
      smg_twice_midpoint(smg_vec_load(s->w), smg_vec_add(u, smg_vec_scale(2, smg_vec_load(s->compensation))));
  return smg_vec_sub(u, smg_vec_scale(smg_vec_dot(u, S) / smg_vec_dot(S, S), S));
}

/* Newton to stagnation with honest square roots, from the guess u. At round-off plain evaluation and Newton take
 * turns. */
SMG_COLD static smg_status smg_sphere_iterate(smg_state *s, smg_vec u) {
  const smg_coefficients *c = &s->c;
  const smg_vec w = smg_vec_load(s->w), compensation = smg_vec_load(s->compensation);
  smg_iterate n;
  smg_real most = 0;
  n.u = u;
  n.det = 0;
  for (int it = 0; it < SMG_MAX_NEWTON; ++it) {
    const smg_vec S = smg_twice_midpoint(w, n.u);
    n.q = 1 / SMG_MATH(sqrt)(smg_vec_dot(S, S));
    smg_found f = smg_sphere_evaluate(c, w, compensation, n);
    const smg_vec d = smg_vec_sub(f.v, n.u);
    /* on the way too: another branch may look as calm */
    most = smg_max(most, smg_sphere_bound(c, smg_vec_scale(n.q, S), n.q));
    s->report.iterations = it + 1;
    s->report.residual = smg_vec_largest(d);
    if (!(smg_abs(f.v.x) + smg_abs(f.v.y) + smg_abs(f.v.z) <= SMG_MAX)) return SMG_NOT_FINITE;
    /* after some tries round-off of the increment is left to it */
    const int done = smg_sphere_settled(d, f.W) || (it > 6 && smg_sphere_confirmed(d, f.W, f.v));
    const int plain = it % 2 == 1 && smg_vec_largest(d) <= 64 * SMG_EPS * smg_vec_largest(f.v);
    if (!done || it == 0) n = smg_sphere_newton(c, w, n.u, n.q);
    if (plain) n.u = f.v;
    if (!done) continue;
    if (!smg_clear_of_branches(n.det) || !(most <= SMG_CONTRACTS)) return SMG_WRONG_BRANCH;
    /* twice: what the first leaves of the bias is not small at large h */
    const smg_vec z = smg_sphere_tangential(
        s, smg_sphere_refine(c, w, compensation, smg_sphere_refine(c, w, compensation, f.v, f.q), f.q));
    if (!smg_sphere_confirmed(smg_vec_sub(z, f.v), f.W, z)) return SMG_NO_CONVERGENCE;
    f = smg_found_at(w, compensation, z, f.q, f.residual);
    smg_sphere_commit(s, &f);
    return SMG_OK;
  }
  return SMG_NO_CONVERGENCE;
}

/* What a few Newton iterations did not settle: iterate; when that fails, from rest; then continuation in h. */
SMG_COLD static smg_status smg_sphere_hard(smg_state *s, smg_vec u) {
  smg_status status = smg_sphere_iterate(s, u);
  if (status != SMG_OK && status != SMG_WRONG_BRANCH) status = smg_sphere_iterate(s, smg_vec_of(0, 0, 0));
  if (status != SMG_OK) {
    status = smg_site_solve(s, s->c.h, 0);
    if (status == SMG_OK) {
      const smg_vec w = smg_vec_load(s->w), v = smg_vec_load(s->u), S = smg_twice_midpoint(w, v);
      const smg_real q = 1 / SMG_MATH(sqrt)(smg_vec_dot(S, S));
      const smg_found f = smg_found_at(w, smg_vec_load(s->compensation), v, q, 0);
      smg_sphere_commit(s, &f);
    }
  }
#if !SMG_COMPOSED
  if (status == SMG_OK && (s->count - s->begun <= SMG_HISTORY || s->count % 16 == 0)) smg_sphere_degree(s);
#endif
  s->report.site = status == SMG_OK ? -1 : 0;
  return status;
}

/* The first iteration, to u = (x, y, z), left too much. Numbers come in registers, a vector by way of memory: 8 % of a
 * step. */
SMG_COLD static smg_status smg_sphere_resume(smg_state *s, smg_real x, smg_real y, smg_real z, smg_real q, smg_real det,
                                             smg_real size) {
  const smg_vec w = smg_vec_load(s->w), compensation = smg_vec_load(s->compensation);
  const smg_iterate n = {{x, y, z}, q, det, size};
  smg_found f;
  int iterations = 1;
  const int good = smg_sphere_again(&s->c, w, compensation, 1, n, &f, &iterations);
  s->report.iterations = iterations;
  if (!good) return smg_sphere_hard(s, f.v);
  smg_sphere_commit(s, &f);
#if !SMG_COMPOSED
  if (s->count % 16 == 0) smg_sphere_degree(s);
#endif
  s->report.residual = f.residual;
  return SMG_OK;
}

/* The first iteration changed too much: where the history is too short or too coarse, the explicit start may be near
 * enough. The first step has no solution before it to be near to: it is solved from rest. */
SMG_COLD static smg_status smg_sphere_afresh(smg_state *s) {
  const smg_vec w = smg_vec_load(s->w);
  smg_real q;
  const smg_vec p = smg_sphere_explicit(&s->c, w, &q);
  const smg_iterate n = smg_sphere_newton(&s->c, w, p, q);
  if (s->count == s->begun || !(n.size < SMG_SECOND)) return smg_sphere_hard(s, smg_vec_of(0, 0, 0));
  return smg_sphere_resume(s, n.u.x, n.u.y, n.u.z, n.q, n.det, n.size);
}

/* One step of the size s->c.h, the time of its midpoint in s->c. */
SMG_INLINE smg_status smg_sphere_step(smg_state *s) {
  const smg_vec w = smg_vec_load(s->w);
  smg_real q; /* the empty rows of the first steps give q = 0 and a large size */
  const smg_vec p = smg_sphere_predict(s, &q);
  const smg_iterate n = smg_sphere_newton(&s->c, w, p, q);
  const smg_found f = smg_sphere_evaluate(&s->c, w, smg_vec_load(s->compensation), n);
  if (!smg_sphere_done(f, n)) {
    s->report.status =
        n.size < SMG_SECOND ? smg_sphere_resume(s, n.u.x, n.u.y, n.u.z, n.q, n.det, n.size) : smg_sphere_afresh(s);
    return s->report.status;
  }
  smg_sphere_commit(s, &f);
  s->report.iterations = 1;
  s->report.residual = f.residual;
  s->report.status = SMG_OK;
  return SMG_OK;
}

#if !SMG_COMPOSED
static smg_status smg_step(smg_state *s) {
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, (smg_real)0.5));
#endif
  return smg_sphere_step(s);
}

#include "smg_steps.h"
#endif

#endif
