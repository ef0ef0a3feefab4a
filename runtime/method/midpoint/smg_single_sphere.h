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

/* The square of a Newton change whose remainder is far below round-off: a larger one would leave a drift. */
#define SMG_SMALL (SMG_EPS / 64)
/* The square of a change of a tenth: from a larger one a second iteration here would not settle; Newton with a matrix
 * takes over. */
#define SMG_SECOND (smg_real)0.01
/* Newton iterations in a row: from a tenth the changes are 1e-1, 1e-2, 1e-4, 1e-8, 1e-16, and one more. */
#define SMG_MOST_IN_A_ROW 6
/* The part of the square of a change that the next one may be: those that fall by less than 4 are not Newton's of one
 * solution. */
#define SMG_FALLS (smg_real)0.0625

/* Is det(1 - E) in (7/16, 5)? The eigenvalues 1 +- sqrt(-e2) of J are real where det <= 1, then at least 1 - 3/4: clear
 * of 0 by as much as a contraction with SMG_CONTRACTS is; det < 5 keeps abs(J - 1) below 2, not far from 1. */
SMG_INLINE int smg_clear_of_branches(smg_real det) { return (det > (smg_real)0.4375) & (det < 5); }

/* tr E: 0 of sites that only precess. */
SMG_INLINE smg_real smg_sphere_trace(smg_slope D) {
#if SMG_RESPONDS
  return smg_slope_trace(D);
#else
  return (void)D, (smg_real)0;
#endif
}

/* What stands for det(1 - E) = 1 - t + e2 in smg_clear_of_branches, t = tr E. The eigenvalues of J beside 1, the
 * roots x of x^2 - (2 - t) x + det, are at least 1/4 where they are real, det + t/4 >= 7/16 and t <= 3/2; those of E
 * are below 2 where det + t < 5 and abs(t) < 1. */
SMG_INLINE smg_real smg_sphere_determinant(smg_real det, smg_real t) {
#if SMG_RESPONDS
  return det + t < 5 && smg_abs(t) < 1 ? det + (smg_real)0.25 * t : 0;
#else
  return (void)t, det;
#endif
}

/* The largest row sum of abs(M), which bounds E: det(1 - E) may be moderate where E is not. */
SMG_INLINE smg_real smg_sphere_bound(const smg_coefficients *c, smg_vec m, smg_real q) {
  return smg_vec_largest(smg_slope_sums(smg_derivative(c, m, q)));
}

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

/* Rows beyond these have weights in polynomials of high degree alone. */
#define SMG_FEW_ROWS 7

/* The polynomial of least error through the last increments, one step on; the sum over all but the two newest rows
 * is ready before they are. */
SMG_INLINE smg_vec smg_sphere_predict(smg_state *s, smg_real *q) {
  const smg_real *row = s->rows + 4 * s->row, *a = smg_sphere_weights[s->degree];
  smg_real sum[4];
  for (int i = 0; i < 4; ++i) sum[i] = a[4 * (SMG_FEW_ROWS - 1) + i] * row[4 * (SMG_FEW_ROWS - 1) + i];
  SMG_UNROLL
  for (int j = SMG_FEW_ROWS - 2; j >= 2; --j)
    for (int i = 0; i < 4; ++i) sum[i] += a[4 * j + i] * row[4 * j + i];
  if (s->degree >= SMG_FEW_ROWS)
    for (int j = SMG_FEW_ROWS; j < SMG_HISTORY - 1; ++j)
      for (int i = 0; i < 4; ++i) sum[i] += a[4 * j + i] * row[4 * j + i];
  for (int i = 0; i < 4; ++i) s->older[i] = sum[i];
  *q = (s->older[3] + a[4] * row[7]) + a[0] * row[3];
  return smg_vec_of((s->older[0] + a[4] * row[4]) + a[0] * row[0], (s->older[1] + a[4] * row[5]) + a[0] * row[1],
                    (s->older[2] + a[4] * row[6]) + a[0] * row[2]);
}
#endif

SMG_INLINE smg_vec smg_twice_midpoint(smg_vec w, smg_vec u) {
  return smg_vec_of(2 * w.x + u.x, 2 * w.y + u.y, 2 * w.z + u.z);
}

/* One Newton iteration from (u, q). *size: the square of the change; the new q is off by an eighth of it. */
SMG_INLINE smg_vec smg_sphere_newton(const smg_coefficients *c, smg_vec w, smg_vec u, smg_real *inverse, smg_real *det,
                                     smg_real *size) {
  const smg_real q = *inverse;
  const smg_vec S = smg_twice_midpoint(w, u), m = smg_vec_scale(q, S), g0 = smg_motion(c, m), e = smg_radial(c, m, g0);
  const smg_real eps = 0.5 - smg_vec_dot(S, S) * (0.5 * q * q), mu = smg_vec_dot(m, u);
  const smg_slope D = smg_derivative(c, m, q);
  const smg_real kept = 1 - smg_sphere_trace(D), t = kept + (smg_slope_minors(D) - (q * q) * smg_vec_dot(g0, e)),
                 i = 1 / t;
  const smg_vec g = smg_vec_add(g0, smg_vec_scale(eps, e)), a = smg_vec_add(g, smg_vec_sub(smg_vec_scale(mu, m), u));
  const smg_vec b = smg_slope_times(D, a), d = smg_slope_times(D, b);
  const smg_real ga = smg_vec_dot(g, a), gb = smg_vec_dot(g, b), l = (q * q) * ga;
  const smg_real aa = smg_vec_dot(a, a);
  /* the term in aa is of second order: without it 1/|S + change| is biased, and the energy drifts */
  *inverse = ((q + q * (eps + q * mu)) - (0.5 * q * q * q) * aa) + (q * q * (q * i)) * (kept * ga + gb);
  *det = smg_sphere_determinant(t, 1 - kept);
  *size = aa + eps * eps;
  return smg_vec_add(g, smg_vec_scale(i, smg_vec_add(smg_vec_scale(kept, b), smg_vec_add(d, smg_vec_scale(l, e)))));
}

/* h X(m), m = q S */
SMG_INLINE smg_vec smg_image(const smg_coefficients *c, smg_vec S, smg_real q) {
  return smg_motion(c, smg_vec_scale(q, S));
}

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
  const smg_coefficients *c = &s->c;
  s->u[0] = v.x;
  s->u[1] = v.y;
  s->u[2] = v.z;
  smg_wide_evaluate(s);
  const smg_vec m = smg_vec_load(s->wide_m), d = smg_vec_load(s->wide_d), r = smg_radial(c, m, v);
  const smg_slope D = smg_derivative(c, m, q);
  const smg_vec a = smg_slope_times(D, smg_vec_sub(d, smg_vec_scale(smg_vec_dot(m, d), m)));
  const smg_vec b = smg_slope_times(D, smg_vec_sub(a, smg_vec_scale(smg_vec_dot(m, a), m)));
  const smg_real i = 1 / (1 + (smg_slope_minors(D) - (q * q) * smg_vec_dot(v, r)));
  s->wide_e[0] = i * (a.x + b.x);
  s->wide_e[1] = i * (a.y + b.y);
  s->wide_e[2] = i * (a.z + b.z);
  smg_wide_take(s);
}
#endif
/* W = w + v with its rounding error in compensation; v and q become the newest row of the history. */
SMG_INLINE void smg_sphere_commit(smg_state *s, smg_vec W, smg_vec y, smg_vec v, smg_real q) {
  if (s->row == 0) {
    for (int k = 0; k < 4 * (SMG_HISTORY - 1); ++k) s->rows[4 * (SMG_ROWS - SMG_HISTORY + 1) + k] = s->rows[k];
    s->row = SMG_ROWS - SMG_HISTORY + 1;
  }
  smg_real *row = s->rows + 4 * --s->row;
#if SMG_EXTENDED
  smg_sphere_widen(s, v, q);
  (void)W;
  (void)y;
#if SMG_PLAIN_SUMS
  for (int k = 0; k < 3; ++k) s->w[k] += s->u[k];
#else
  for (int k = 0; k < 3; ++k) smg_wide_commit(&s->w[k], &s->compensation[k], s->u[k], s->low[k]);
#endif
#else
#if SMG_PLAIN_SUMS
  (void)y;
#else
  s->compensation[0] = y.x - (W.x - s->w[0]);
  s->compensation[1] = y.y - (W.y - s->w[1]);
  s->compensation[2] = y.z - (W.z - s->w[2]);
#endif
  s->w[0] = W.x;
  s->w[1] = W.y;
  s->w[2] = W.z;
#endif
  row[0] = v.x;
  row[1] = v.y;
  row[2] = v.z;
#if SMG_COMPOSED
  row[3] = smg_gamma[s->stage] * q;
  smg_stage_done(s);
#else
  row[3] = q;
  ++s->count;
#endif
}

#if !SMG_COMPOSED
/* Which degree would have predicted the newest row best? */
static void smg_sphere_degree(smg_state *s) {
  s->history = smg_rows_known(s, s->count);
  smg_real miss[SMG_HISTORY] = {0};
  for (int i = 0; i < 3; ++i) {
    smg_real row[SMG_HISTORY];
    for (int j = 0; j < s->history; ++j) row[j] = s->rows[4 * (s->row + j) + i];
    smg_add_misses(s->history - 1, row, miss);
  }
  s->degree = smg_best_degree(s->history - 1, miss);
}
#endif

/* One unit of W in its last place; after some tries also some units of u, for near a zero of W the round-off of u
 * is larger than a unit of W. */
SMG_INLINE int smg_within_ulp(smg_real d, smg_real W, smg_real v, int late) {
  return smg_abs(d) <= SMG_EPS * smg_abs(W) || (late && smg_abs(d) <= 8 * SMG_EPS * smg_abs(v));
}

/* One more evaluation, at the midpoint of w + compensation and w + compensation + v: what is left of the iteration
 * would drift. */
SMG_INLINE smg_vec smg_sphere_refine(const smg_state *s, smg_vec v, smg_real q) {
  const smg_vec twice = smg_vec_scale(2, smg_vec_load(s->compensation));
  return smg_image(&s->c, smg_twice_midpoint(smg_vec_load(s->w), smg_vec_add(v, twice)), q);
}

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
  smg_real det = 0, size, most = 0;
  for (int it = 0; it < SMG_MAX_NEWTON; ++it) {
    const smg_vec S = smg_twice_midpoint(w, u);
    smg_real q = 1 / SMG_MATH(sqrt)(smg_vec_dot(S, S));
    const smg_real exact = q;
    const smg_vec v = smg_image(c, S, q), W = smg_vec_add(w, smg_vec_add(v, compensation)), d = smg_vec_sub(v, u);
    const int late = it > 6;
    /* on the way too: another branch may look as calm */
    most = smg_max(most, smg_sphere_bound(c, smg_vec_scale(q, S), q));
    s->report.iterations = it + 1;
    s->report.residual = smg_vec_largest(d);
    if (!(smg_abs(v.x) + smg_abs(v.y) + smg_abs(v.z) <= SMG_MAX)) return SMG_NOT_FINITE;
    const int done = smg_within_ulp(d.x, W.x, v.x, late) && smg_within_ulp(d.y, W.y, v.y, late) &&
                     smg_within_ulp(d.z, W.z, v.z, late);
    const smg_vec next = done && it > 0 ? v : smg_sphere_newton(c, w, u, &q, &det, &size);
    if (done) {
      if (!smg_clear_of_branches(det) || !(most <= SMG_CONTRACTS)) return SMG_WRONG_BRANCH;
      /* twice: what the first leaves of the bias is not small at large h */
      const smg_vec z = smg_sphere_tangential(s, smg_sphere_refine(s, smg_sphere_refine(s, v, exact), exact)),
                    y = smg_vec_add(z, compensation), left = smg_vec_sub(z, v);
      if (!(smg_within_ulp(left.x, W.x, z.x, 1) && smg_within_ulp(left.y, W.y, z.y, 1) &&
            smg_within_ulp(left.z, W.z, z.z, 1)))
        return SMG_NO_CONVERGENCE;
      smg_sphere_commit(s, smg_vec_add(w, y), y, z, exact);
      return SMG_OK;
    }
    u = it % 2 == 1 && smg_vec_largest(d) <= 64 * SMG_EPS * smg_vec_largest(v) ? v : next;
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
      const smg_vec w = smg_vec_load(s->w), v = smg_vec_load(s->u), y = smg_vec_add(v, smg_vec_load(s->compensation)),
                    S = smg_twice_midpoint(w, v);
      smg_sphere_commit(s, smg_vec_add(w, y), y, v, 1 / SMG_MATH(sqrt)(smg_vec_dot(S, S)));
    }
  }
#if !SMG_COMPOSED
  if (status == SMG_OK && (s->count - s->begun <= SMG_HISTORY || s->count % 16 == 0)) smg_sphere_degree(s);
#endif
  s->report.site = status == SMG_OK ? -1 : 0;
  return status;
}

SMG_INLINE int smg_sphere_settled(smg_vec v, smg_vec u, smg_vec W) {
  return smg_abs(v.x - u.x) <= SMG_EPS * smg_abs(W.x) && smg_abs(v.y - u.y) <= SMG_EPS * smg_abs(W.y) &&
         smg_abs(v.z - u.z) <= SMG_EPS * smg_abs(W.z);
}

/* Newton iterations from u, as long as each leaves much less than the one before and something to the next. */
SMG_INLINE smg_vec smg_sphere_converge(smg_state *s, smg_vec w, smg_vec u, smg_real *q, smg_real *det, smg_real *size) {
  for (;;) {
    const smg_real last = *size;
    u = smg_sphere_newton(&s->c, w, u, q, det, size);
    if (++s->report.iterations == SMG_MOST_IN_A_ROW || *size < SMG_SMALL || !(*size <= SMG_FALLS * last)) return u;
  }
}

/* The first iteration, to u = (x, y, z), left more than a unit of W. Where that is round-off of u, near a zero of W,
 * one more evaluation must confirm it; else more Newton iterations, from u. Numbers come in registers, a vector by way
 * of memory: 8 % of a step. */
SMG_COLD static smg_status smg_sphere_again(smg_state *s, smg_real x, smg_real y, smg_real z, smg_real q, smg_real det,
                                            smg_real size) {
  const smg_coefficients *c = &s->c;
  const smg_vec w = smg_vec_load(s->w), compensation = smg_vec_load(s->compensation);
  smg_vec u = smg_vec_of(x, y, z), v;
  int settled = 0;
  s->report.iterations = 1;
  if (!(size < SMG_SMALL)) {
    u = smg_sphere_converge(s, w, u, &q, &det, &size);
    const smg_vec S = smg_twice_midpoint(w, u);
    q = 1 / SMG_MATH(sqrt)(smg_vec_dot(S, S)); /* Newton's own q is biased by what it leaves: a drift */
    v = smg_image(c, S, q);
    settled = smg_sphere_settled(v, u, smg_vec_add(w, v));
  } else v = smg_image(c, smg_twice_midpoint(w, u), q);
  const smg_vec r = smg_sphere_refine(s, v, q), total = smg_vec_add(r, compensation), W = smg_vec_add(w, total);
  if (!settled) /* confirmed? */
    settled = smg_within_ulp(r.x - v.x, W.x, r.x, 1) && smg_within_ulp(r.y - v.y, W.y, r.y, 1) &&
              smg_within_ulp(r.z - v.z, W.z, r.z, 1);
  if (!(settled && smg_clear_of_branches(det) &&
        smg_sphere_bound(c, smg_vec_scale(q, smg_twice_midpoint(w, u)), q) <= SMG_DAMPS && size < SMG_SMALL &&
        smg_vec_largest(r) <= SMG_MAX))
    return smg_sphere_hard(s, r);
  smg_sphere_commit(s, W, total, r, q);
#if !SMG_COMPOSED
  if (s->count % 16 == 0) smg_sphere_degree(s);
#endif
  s->report.residual = smg_vec_largest(smg_vec_sub(r, v));
  return SMG_OK;
}

/* The first iteration changed too much: where the history is too short or too coarse, the explicit start may be near
 * enough. The first step has no solution before it to be near to: it is solved from rest. */
SMG_COLD static smg_status smg_sphere_afresh(smg_state *s) {
  const smg_coefficients *c = &s->c;
  const smg_vec w = smg_vec_load(s->w);
  smg_real q, det, size;
  const smg_vec u = smg_sphere_newton(c, w, smg_sphere_explicit(c, w, &q), &q, &det, &size);
  if (s->count == s->begun || !(size < SMG_SECOND)) return smg_sphere_hard(s, smg_vec_of(0, 0, 0));
  return smg_sphere_again(s, u.x, u.y, u.z, q, det, size);
}

/* One step of the size s->c.h, the time of its midpoint in s->c. */
SMG_INLINE smg_status smg_sphere_step(smg_state *s) {
  const smg_coefficients *c = &s->c;
  const smg_vec w = smg_vec_load(s->w), compensation = smg_vec_load(s->compensation);
  smg_real q, det, size; /* the empty rows of the first steps give q = 0 and a large size */
  const smg_vec p = smg_sphere_predict(s, &q), u = smg_sphere_newton(c, w, p, &q, &det, &size);
  const smg_vec v = smg_image(c, smg_twice_midpoint(w, u), q), y = smg_vec_add(v, compensation), W = smg_vec_add(w, y);
  const smg_real change = smg_abs(v.x - u.x) + smg_abs(v.y - u.y) + smg_abs(v.z - u.z);
  if (!(smg_sphere_settled(v, u, W) && smg_clear_of_branches(det) && size < SMG_SMALL && change <= SMG_MAX)) {
    s->report.status = size < SMG_SECOND ? smg_sphere_again(s, u.x, u.y, u.z, q, det, size) : smg_sphere_afresh(s);
    return s->report.status;
  }
  smg_sphere_commit(s, W, y, v, q);
  s->report.iterations = 1;
  s->report.residual = change;
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
