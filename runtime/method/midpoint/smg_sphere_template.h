/* smidgen method: the arithmetic of smg_single_sphere.h, where its equations are; a template (smg_template.h), of which
 * smg_lane_sphere.h makes several states in lanes. */
#include "smg_sphere_history.h"
#include "smg_vec.h"

/* A Newton iterate: the increment, q = 1/|w + W|, det(1 - E), and the square of the change that led to it; q is off by
 * an eighth of that. */
typedef struct smg_iterate {
  smg_vec u;
  smg_number q, det, size;
} smg_iterate;

/* What a step has found: the increment v, y = v + compensation, W = w + y, q = 1/|w + W|, and the residual. */
typedef struct smg_found {
  smg_vec v, y, W;
  smg_number q, residual;
} smg_found;

/* Is det(1 - E) in (7/16, 5)? The eigenvalues 1 +- sqrt(-e2) of J are real where det <= 1, then at least 1 - 3/4: clear
 * of 0 by as much as a contraction with SMG_CONTRACTS is; det < 5 keeps abs(J - 1) below 2, not far from 1. */
SMG_INLINE smg_test smg_clear_of_branches(smg_number det) {
  return smg_less(smg_of((smg_real)0.4375), det) SMG_AND smg_less(det, smg_of(5));
}

/* tr E: 0 of sites that only precess. */
SMG_INLINE smg_number smg_sphere_trace(SMG_UNUSED smg_slope D) {
#if SMG_RESPONDS
  return smg_slope_trace(D);
#else
  return smg_of(0);
#endif
}

/* What stands for det(1 - E) = 1 - t + e2 in smg_clear_of_branches, t = tr E. The eigenvalues of J beside 1, the
 * roots x of x^2 - (2 - t) x + det, are at least 1/4 where they are real, det + t/4 >= 7/16 and t <= 3/2; those of E
 * are below 2 where det + t < 5 and abs(t) < 1. */
SMG_INLINE smg_number smg_sphere_determinant(smg_number det, SMG_UNUSED smg_number t) {
#if SMG_RESPONDS
  const smg_test known = smg_less(det + t, smg_of(5)) SMG_AND smg_less(smg_abs(t), smg_of(1));
  return smg_select(known, det + (smg_real)0.25 * t, smg_of(0));
#else
  return det;
#endif
}

/* The largest row sum of abs(M), which bounds E: det(1 - E) may be moderate where E is not. */
SMG_INLINE smg_number smg_sphere_bound(const smg_coefficients *c, smg_vec m, smg_number q) {
  return smg_vec_largest(smg_slope_sums(smg_derivative(c, m, q)));
}

SMG_INLINE smg_vec smg_twice_midpoint(smg_vec w, smg_vec u) {
  return smg_vec_of(2 * w.x + u.x, 2 * w.y + u.y, 2 * w.z + u.z);
}

/* h X(m), m = q S */
SMG_INLINE smg_vec smg_image(const smg_coefficients *c, smg_vec S, smg_number q) {
  return smg_motion(c, smg_vec_scale(q, S));
}

/* One Newton iteration from (u, q). */
SMG_INLINE smg_iterate smg_sphere_newton(const smg_coefficients *c, smg_vec w, smg_vec u, smg_number q) {
  smg_iterate next;
  const smg_vec S = smg_twice_midpoint(w, u), m = smg_vec_scale(q, S), g0 = smg_motion(c, m), e = smg_radial(c, m, g0);
  const smg_number eps = 0.5 - smg_vec_dot(S, S) * (0.5 * q * q), mu = smg_vec_dot(m, u);
  const smg_slope D = smg_derivative(c, m, q);
  const smg_number kept = 1 - smg_sphere_trace(D), t = kept + (smg_slope_minors(D) - (q * q) * smg_vec_dot(g0, e)),
                   i = 1 / t;
  const smg_vec g = smg_vec_add(g0, smg_vec_scale(eps, e)), a = smg_vec_add(g, smg_vec_sub(smg_vec_scale(mu, m), u));
  const smg_vec b = smg_slope_times(D, a), d = smg_slope_times(D, b);
  const smg_number ga = smg_vec_dot(g, a), gb = smg_vec_dot(g, b), l = (q * q) * ga;
  const smg_number aa = smg_vec_dot(a, a);
  /* the term in aa is of second order: without it 1/|S + change| is biased, and the energy drifts */
  next.q = ((q + q * (eps + q * mu)) - (0.5 * q * q * q) * aa) + (q * q * (q * i)) * (kept * ga + gb);
  next.det = smg_sphere_determinant(t, 1 - kept);
  next.size = aa + eps * eps;
  next.u = smg_vec_add(g, smg_vec_scale(i, smg_vec_add(smg_vec_scale(kept, b), smg_vec_add(d, smg_vec_scale(l, e)))));
  return next;
}

/* The state that the increment v leads to. */
SMG_INLINE smg_found smg_found_at(smg_vec w, smg_vec compensation, smg_vec v, smg_number q, smg_number residual) {
  const smg_vec y = smg_vec_add(v, compensation);
  const smg_found f = {v, y, smg_vec_add(w, y), q, residual};
  return f;
}

/* The same of one evaluation from the iterate n. */
SMG_INLINE smg_found smg_sphere_evaluate(const smg_coefficients *c, smg_vec w, smg_vec compensation, smg_iterate n) {
  const smg_vec v = smg_image(c, smg_twice_midpoint(w, n.u), n.q);
  return smg_found_at(w, compensation, v, n.q, smg_abs(v.x - n.u.x) + smg_abs(v.y - n.u.y) + smg_abs(v.z - n.u.z));
}

/* Is the change d of an increment within a unit of W in its last place? */
SMG_INLINE smg_test smg_within_ulp(smg_number d, smg_number W) { return smg_at_most(smg_abs(d), SMG_EPS * smg_abs(W)); }
SMG_INLINE smg_test smg_sphere_settled(smg_vec d, smg_vec W) {
  return smg_within_ulp(d.x, W.x) SMG_AND smg_within_ulp(d.y, W.y) SMG_AND smg_within_ulp(d.z, W.z);
}

/* Or within some units of the increment v: near a zero of W its round-off is larger than a unit of W. */
SMG_INLINE smg_test smg_near_zero_settled(smg_number d, smg_number W, smg_number v) {
  return smg_within_ulp(d, W) SMG_OR smg_at_most(smg_abs(d), 8 * SMG_EPS * smg_abs(v));
}
SMG_INLINE smg_test smg_sphere_confirmed(smg_vec d, smg_vec W, smg_vec v) {
  return smg_near_zero_settled(d.x, W.x, v.x) SMG_AND smg_near_zero_settled(d.y, W.y, v.y)
      SMG_AND smg_near_zero_settled(d.z, W.z, v.z);
}

SMG_INLINE smg_test smg_sphere_small(smg_number size) { return smg_less(size, smg_of(SMG_SMALL)); }

/* Is the step done by one iteration and one evaluation? What a small change of u left, its square, is far below
 * round-off: one that is left near a zero of W is that of u. */
SMG_INLINE smg_test smg_sphere_done(smg_found f, smg_iterate n) {
  return smg_sphere_confirmed(smg_vec_sub(f.v, n.u), f.W, f.v) SMG_AND smg_clear_of_branches(n.det)
      SMG_AND smg_sphere_small(n.size) SMG_AND smg_at_most(f.residual, smg_of(SMG_MAX));
}

/* One more evaluation, at the midpoint of w + compensation and w + compensation + v: what is left of the iteration
 * would drift. */
SMG_INLINE smg_vec smg_sphere_refine(const smg_coefficients *c, smg_vec w, smg_vec compensation, smg_vec v,
                                     smg_number q) {
  const smg_vec twice = smg_vec_scale(smg_of(2), compensation);
  return smg_image(c, smg_twice_midpoint(w, smg_vec_add(v, twice)), q);
}

/* Newton iterations where they are wanted, as long as each leaves much less than the one before and something to the
 * next. */
SMG_INLINE void smg_sphere_converge(const smg_coefficients *c, smg_vec w, smg_test wanted, smg_iterate *n,
                                    smg_count *iterations) {
  while (smg_any(wanted)) {
    const smg_number last = n->size;
    const smg_iterate next = smg_sphere_newton(c, w, n->u, n->q);
    n->u = smg_vec_select(wanted, next.u, n->u);
    n->q = smg_select(wanted, next.q, n->q);
    n->det = smg_select(wanted, next.det, n->det);
    n->size = smg_select(wanted, next.size, n->size);
    *iterations = smg_counted(*iterations, wanted);
    const smg_test few = (smg_test)(*iterations < SMG_MOST_IN_A_ROW);
    wanted =
        wanted SMG_AND few SMG_AND smg_not(smg_sphere_small(n->size)) SMG_AND smg_at_most(n->size, SMG_FALLS * last);
  }
}

/* The step from the iterate n where it left more than a unit of W (`left`). If that is round-off of u, near a zero of
 * W, one more evaluation must confirm it; else more Newton iterations come first. Returns where that was enough. */
SMG_INLINE smg_test smg_sphere_again(const smg_coefficients *c, smg_vec w, smg_vec compensation, smg_test left,
                                     smg_iterate n, smg_found *f, smg_count *iterations) {
  const smg_test more = left SMG_AND smg_not(smg_sphere_small(n.size));
  smg_sphere_converge(c, w, more, &n, iterations);
  const smg_vec S = smg_twice_midpoint(w, n.u);
  /* Newton's own q is biased by what it leaves: a drift */
  smg_number q = n.q;
  if (smg_any(more)) q = smg_select(more, 1 / smg_sqrt(smg_vec_dot(S, S)), q);
  const smg_vec v = smg_image(c, S, q), z = smg_sphere_refine(c, w, compensation, v, q), d = smg_vec_sub(z, v);
  *f = smg_found_at(w, compensation, z, q, smg_vec_largest(d));
  const smg_vec before = smg_vec_sub(v, n.u);
  return ((more SMG_AND smg_sphere_settled(before, smg_vec_add(w, v)))SMG_OR smg_sphere_confirmed(
      d, f->W, z))SMG_AND smg_clear_of_branches(n.det)
      SMG_AND smg_at_most(smg_sphere_bound(c, smg_vec_scale(q, S), q), smg_of(SMG_DAMPS))
          SMG_AND smg_sphere_small(n.size) SMG_AND smg_at_most(smg_vec_largest(z), smg_of(SMG_MAX));
}

/* w = W, with its rounding error in compensation. */
SMG_INLINE void smg_sphere_move(smg_number *w, SMG_UNUSED smg_number *compensation, const smg_found *f) {
#if SMG_PLAIN_SUMS
#else
  smg_vec_store(compensation, smg_vec_sub(f->y, smg_vec_sub(f->W, smg_vec_load(w))));
#endif
  smg_vec_store(w, f->W);
}

/* v and q become the newest row of the history; the others are moved back where there is no room before them, in `most`
 * rows. */
SMG_INLINE int smg_sphere_keep(smg_number *rows, int row, int most, smg_vec v, smg_number q) {
  if (row == 0) {
    row = most - SMG_HISTORY + 1;
    for (int k = 4 * (SMG_HISTORY - 1); k-- > 0;) rows[4 * row + k] = rows[k]; /* both places may overlap */
  }
  --row;
  smg_vec_store(rows + 4 * row, v);
  rows[4 * row + 3] = q;
  return row;
}

#if !SMG_COMPOSED
/* miss[d] += the error, squared, of the polynomial of degree d in the newest of the known rows. */
SMG_INLINE void smg_sphere_misses(const smg_number *rows, int known, smg_number *miss) {
  for (int i = 0; i < 3; ++i) {
    smg_number row[SMG_HISTORY];
    for (int j = 0; j < known; ++j) row[j] = rows[4 * j + i];
    smg_add_misses(known - 1, row, miss);
  }
}
#endif
