/* smidgen runtime: the coupled step as a curve of solutions from W = w at h = 0, followed by its arclength. */
#ifndef SMG_BRANCH_H
#define SMG_BRANCH_H

#include "smg_newton.h"

/* One step as a curve: s and the h at its end. */
typedef struct smg_whole {
  smg_state *s;
  smg_real h;
} smg_whole;

/* Newton's correction a of the midpoints y for the part p of h, and slope, how they change with p. */
SMG_RARE static smg_status smg_curve_newton(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *slope,
                                            int *sign) {
  const smg_whole *whole = (const smg_whole *)of;
  smg_state *s = whole->s;
  const smg_real h = whole->h;
  smg_real bound;
  smg_copy(s->mbar, y, 3 * smg_sites(&s->c));
  if (!(smg_evaluate(s, p * h).absolute <= SMG_MAX)) return SMG_NOT_FINITE;
  if (smg_correction(s, p * h, a, &bound, sign) > 0) return SMG_SINGULAR;
  smg_increments(s, 0.5 * h, s->r);
  return smg_correction(s, p * h, slope, &bound, sign) > 0 ? SMG_SINGULAR : SMG_OK;
}

#if SMG_MATRIX_FREE
SMG_RARE static int smg_curve_sign(void *of) { return smg_sign(((smg_whole *)of)->s); }
#else
#define smg_curve_sign NULL
#endif

/* The solution connected to W = w at h = 0, by its whole curve; or why there is none. */
SMG_RARE static smg_status smg_follow_branch(smg_state *s, smg_real h) {
  smg_whole whole = {s, h};
  smg_curve f;
#if SMG_MATRIX_FREE
  SMG_PRODUCTS_LEFT(s) = SMG_MAX; /* its own bounds are those of the curve */
#endif
  smg_begin_curve(&f, &whole, smg_curve_newton, smg_curve_sign, 3 * smg_sites(&s->c), s->w, s->scale, s->curve);
  smg_status status = smg_follow(&f);
  s->report.reached = f.reached;
  if (status != SMG_OK) {
    s->report.site = f.site;
    s->report.partner = f.partner;
    return status;
  }
  smg_copy(s->mbar, f.y, f.n);
  const int iterations = s->report.iterations;
  status = smg_newton(s, h);
  if (iterations > 0) s->report.iterations = iterations; /* those of Newton before its solution was checked */
  return status == SMG_WRONG_BRANCH ? SMG_OK : status;   /* the curve shows it to be right */
}

#endif
