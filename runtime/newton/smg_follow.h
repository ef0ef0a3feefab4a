/* smidgen runtime: the branch of solutions of a step, followed from W = w at h = 0.
 *
 * The midpoints y of a step of the part p of h solve
 *
 *     F(y, p) = w + (p h/2) X(P(y)) - y = 0,     0 <= p <= 1.
 *
 * Their curve (y, p) begins at (w, 0) and is followed by its arclength in units of w and of the natural step,
 * which moves w by its own size; with the tangent (t, q): J t = q dF/dp, J = -dF/dy. Where q changes its sign the curve
 * turns back: a fold, and beyond it the branch has no solution. Nor has it where a midpoint runs into the centre of its
 * sphere, where P has no direction: there the curve ends. Predictor along the tangent, Newton across it; Allgower and
 * Georg, Numerical Continuation Methods (1990), chapter 6. */
#ifndef SMG_FOLLOW_H
#define SMG_FOLLOW_H

#include "smg_arrays.h"
#include "smg_site.h"

/* The thresholds, and what half and twice do to some 1400 first steps from random starts (docs/thresholds.md): the same
 * are found throughout, but some of the others are refused by another status ("refused otherwise"). */
/* points of a curve: those of the models need less than half; a tenth changes the status of 2 % of first steps */
#define SMG_MAX_POINTS 600
#define SMG_CURVE_WORK 6000000 /* numbers: points times n of a large system; seconds */
/* a correction may be this part of the pace, or of the correction before; half: 4 refused otherwise, twice: 3 */
#define SMG_STRAIGHT (smg_real)0.2
#define SMG_ALONE (smg_real)1e-5 /* and by so much more when y hardly moves; half or twice: the same */
/* least cosine between the tangents of neighbouring points: 18 degrees; half the distance from 1: 11 refused otherwise,
 * twice: 6 */
#define SMG_ALONG (smg_real)0.95
#define SMG_MAX_CORRECTIONS 7 /* of a point, before a smaller pace is tried; half: the same, twice: nothing changes */
#define SMG_FIRST_PACE (smg_real)0.1 /* of the curve; half: 7 refused otherwise, twice: 3 */
#define SMG_SHORTER (smg_real)0.25   /* the next pace, of one that failed; half: 2 refused otherwise, twice: 3 */
/* and of one that took no more corrections than SMG_EASY; half the distance from 1: 5 refused otherwise, twice: 4 */
#define SMG_LONGER (smg_real)1.5
#define SMG_EASY 4 /* half: 7 refused otherwise, twice: nothing changes */
/* the last correction of a point is at most this, or a tenth of the pace; half: 3 refused otherwise, twice: 8 */
#define SMG_ON_CURVE (smg_real)1e-5
#define SMG_ON_END (smg_real)1e-9 /* and of the end this: Newton goes on from there; half or twice: the same */
/* a shorter pace is given up: corrections of SMG_ON_CURVE squared are below it; half or twice: nothing changes */
#define SMG_LEAST_PACE (smg_real)1e-9
/* a midpoint so near the centre, in radii, is there; without it: one case of tests/runtime/test_edges_of_runtime.py */
#define SMG_CENTRE (smg_real)1e-6
/* a midpoint so near the centre, in radii, is there where it moves straight towards it: */
#define SMG_INWARD (smg_real)2e-5
/* it would pass at this part of its distance, which is many of the shortest paces. Half of them: 10 and 2 refused
 * otherwise, twice: none */
#define SMG_MISS (smg_real)0.01
/* a part of h by which p has come back: a fold, no noise; half or twice: nothing changes */
#define SMG_TURNED_BACK (smg_real)1e-6
/* a pace at which p may be taken to rise where it nearly stood still; half or twice: nothing changes */
#define SMG_DIP (smg_real)1e-4
#define SMG_LOW (smg_real)0.25 /* dp/ds near a fold; half or twice: the same */
/* a curve on a Nambu leaf that goes so many times as far as the mean of its ends is too bold to be sure of; half or
 * twice: nothing changes */
#define SMG_FAR 10
/* in units of the state: beyond, the curve has left for infinity; half or twice: nothing changes */
#define SMG_FARTHEST 1e6

/* One curve. `newton` fills a = J^-1 F(y, p) and c = J^-1 dF/dp, n numbers each, and the sign of det J
 * (0: not known), or says why not. */
typedef struct smg_curve {
  void *of;
  smg_status (*newton)(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *c, int *sign);
  /* that sign at the last point, or 0: asked for where `newton` gives 0; NULL: there is none */
  int (*sign_of)(void *of);
  int64_t n;
  const smg_real *w;           /* where it begins */
  smg_real scale;              /* the unit of y */
  smg_real *y, *t, *a, *c, *x; /* the point, its tangent, and room for the next: 5 n numbers from y on */
  smg_real slope, left;        /* dq/ds over the pace before; the last correction of the last point */
  smg_real p, q, span;         /* part of h, its tangent, and how many natural steps h has: p counts in them */
  smg_real reached;            /* the part of h up to which it has a solution: the whole, or up to its first fold */
  int sign;                    /* of det J; 0 where it is not known */
  int64_t site, partner;       /* the two sites that move most where the branch turns back, or -1 */
} smg_curve;

/* A curve of n numbers from w on; room: 5 n numbers. `newton` need not write those of sites that it does not move. */
static inline void smg_begin_curve(smg_curve *f, void *of,
                                   smg_status (*newton)(void *of, smg_real p, const smg_real *y, smg_real *a,
                                                        smg_real *c, int *sign),
                                   int (*sign_of)(void *of), int64_t n, const smg_real *w, smg_real scale,
                                   smg_real *room) {
  f->of = of;
  f->newton = newton;
  f->sign_of = sign_of;
  f->n = n;
  f->w = w;
  f->scale = scale;
  f->y = room;
  f->t = room + n;
  f->a = room + 2 * n;
  f->c = room + 3 * n;
  f->x = room + 4 * n;
  f->p = f->reached = f->slope = f->left = 0;
  f->site = f->partner = -1;
  f->q = 1;
  smg_copy(f->y, w, n);
  smg_zero(f->t, 3 * n); /* and a and c */
}

/* The unit of component k: that of y, or a site's own length where others are longer. */
static inline smg_real smg_curve_scale(const smg_curve *f, int64_t k) {
  const smg_real length = smg_norm(f->w + k - k % 3);
  return length > 0 ? smg_min(f->scale, length) : f->scale;
}

/* (t, q) of unit length along (c, 1), on the side of the tangent before; returns the cosine between them. */
static inline smg_real smg_curve_turn(smg_curve *f) {
  smg_real size = 1, along = f->q;
  for (int64_t k = 0; k < f->n; ++k) {
    const smg_real unit = 1 / (smg_curve_scale(f, k) * f->span);
    size += (f->c[k] * unit) * (f->c[k] * unit);
    along += f->t[k] * f->c[k] * unit;
  }
  const smg_real length = SMG_MATH(sqrt)(size), side = along < 0 ? -1 : 1;
  for (int64_t k = 0; k < f->n; ++k) f->t[k] = side * f->c[k] * (1 / (smg_curve_scale(f, k) * f->span)) / length;
  f->q = side / length;
  return side * along / length;
}

/* Newton from (x, p) across the tangent, or at this p when `fixed`; returns the iterations, 0 when they fail. */
static inline int smg_curve_correct(smg_curve *f, smg_real *p, smg_real pace, int fixed) {
  smg_real last = smg_max(pace * SMG_STRAIGHT, f->left); /* a pace may be shorter than the last point is off */
  for (int it = 1; it <= SMG_MAX_CORRECTIONS; ++it) {
    if (f->newton(f->of, *p, f->x, f->a, f->c, &f->sign) != SMG_OK) return 0;
    smg_real ta = 0, tc = f->q, tt = 0, size = 0;
    for (int64_t k = 0; k < f->n; ++k) {
      const smg_real unit = 1 / smg_curve_scale(f, k);
      ta += f->t[k] * f->a[k] * unit;
      tc += f->t[k] * f->c[k] * (unit / f->span);
      tt += f->t[k] * f->t[k];
    }
    const smg_real dp = fixed ? 0 : -ta / tc; /* in natural steps */
    for (int64_t k = 0; k < f->n; ++k) {
      const smg_real d = f->a[k] + f->c[k] * (dp / f->span), unit = 1 / smg_curve_scale(f, k);
      size += (d * unit) * (d * unit);
      f->x[k] += d;
    }
    *p += dp / f->span;
    const smg_real moved = SMG_MATH(sqrt)(size + dp * dp);
    if (!(moved <= last)) return 0; /* too far for one curve, or not a number */
    /* of y alone, where p runs far */
    if (it == 1 && SMG_MATH(sqrt)(size) > pace * SMG_STRAIGHT * SMG_MATH(sqrt)(tt) + SMG_ALONE) return 0;
    last = moved * SMG_STRAIGHT;
    if (moved > (fixed ? SMG_ON_END : smg_min(SMG_ON_CURVE, smg_max(pace / 10, SMG_LEAST_PACE)))) continue;
    f->left = moved;
    return it;
  }
  return 0;
}

/* May p have fallen between two points at which it rises? There q, as a parabola that begins with the slope before,
 * dips below a quarter of its ends: two folds close to each other lie there, or none. Nor is it seen where q is low and
 * not the same to a factor of two. */
static inline int smg_curve_dips(const smg_curve *f, smg_real q, smg_real s) {
  const smg_real bend = ((f->q - q) / s - f->slope) / s; /* q + slope x + bend x^2 */
  const smg_real least = smg_min(q, f->q);
  if (!(s > SMG_DIP && least > 0)) return 0;
  if (least < SMG_LOW && least < smg_max(q, f->q) / 2) return 1;
  if (!(f->slope < 0 && f->q > q + f->slope * s)) return 0;
  return -f->slope < 2 * bend * s && q - f->slope * f->slope / (4 * bend) < least / 4;
}

/* One pace along the tangent; 0 when it must be shorter. A pace across p = 1 ends at p = 1. */
static inline int smg_curve_pace(smg_curve *f, smg_real pace) {
  const smg_real rate = f->q / f->span;
  const int landing = rate > 0 && f->p + pace * rate >= 1;
  const smg_real s = landing ? (1 - f->p) / rate : pace;
  smg_real p = landing ? 1 : f->p + s * rate;
  const smg_real left = f->left;
  for (int64_t k = 0; k < f->n; ++k) f->x[k] = f->y[k] + s * f->t[k] * smg_curve_scale(f, k);
  const int its = smg_curve_correct(f, &p, s, landing);
  if (its == 0) return 0;
  if (f->sign == 0 && f->sign_of) f->sign = f->sign_of(f->of);
  smg_copy(f->a, f->t, f->n); /* to go back to, when the curve bends too much */
  const smg_real q = f->q;
  /* along one curve det J has the sign of q: otherwise it is another one */
  if (!(smg_curve_turn(f) >= SMG_ALONG) || (f->sign != 0 && (f->sign < 0) != (f->q < 0)) || smg_curve_dips(f, q, s)) {
    smg_copy(f->t, f->a, f->n);
    f->q = q;
    f->left = left;
    return 0;
  }
  smg_copy(f->y, f->x, f->n);
  f->slope = (f->q - q) / s;
  f->p = p;
  return its;
}

/* Does the end of a curve tell what the step has? Then that counts, whatever Newton found elsewhere. */
static inline int smg_curve_tells(smg_status followed) {
  return followed == SMG_OK || followed == SMG_NO_SOLUTION || followed == SMG_WRONG_BRANCH;
}

/* The site that moves most along the tangent, leaving out one. */
static inline int64_t smg_curve_mover(const smg_curve *f, int64_t but) {
  int64_t site = -1;
  smg_real most = 0;
  for (int64_t k = 0; k < f->n; ++k)
    if (k / 3 != but && smg_abs(f->t[k]) > most) {
      most = smg_abs(f->t[k]);
      site = k / 3;
    }
  return site;
}

/* Does the midpoint y of a site of this radius run into the centre, along the tangent t? */
static inline int smg_curve_inward(const smg_real *y, const smg_real *t, smg_real radius) {
  smg_real across[3];
  smg_cross(across, y, t);
  const smg_real rho2 = smg_dot(y, y), miss2 = smg_dot(across, across), speed2 = smg_dot(t, t);
  if (rho2 < SMG_CENTRE * SMG_CENTRE * radius * radius) return 1;
  return rho2 < SMG_INWARD * SMG_INWARD * radius * radius && smg_dot(y, t) <= 0 &&
         miss2 <= SMG_MISS * SMG_MISS * rho2 * speed2;
}

/* Is it there within a small part of the way that p has come? A midpoint like 1/p comes near, but never in. */
static inline int smg_curve_soon(const smg_curve *f, int64_t k) {
  const smg_real *y = f->y + k, *t = f->t + k, far = SMG_MATH(sqrt)(smg_dot(y, y) / smg_dot(t, t));
  return far / smg_curve_scale(f, k) * smg_abs(f->q) <= SMG_MISS * f->p * f->span;
}

/* A curve that no pace can follow any more: does it end in the centre of a sphere? */
static inline smg_status smg_curve_end(smg_curve *f) {
  for (int64_t k = 0; k < f->n; k += 3)
    if (smg_curve_inward(f->y + k, f->t + k, SMG_MATH(sqrt)(smg_dot(f->w + k, f->w + k))) && smg_curve_soon(f, k)) {
      f->site = k / 3;
      f->partner = -1;
      return SMG_NO_SOLUTION;
    }
  return SMG_NO_CONVERGENCE;
}

/* The natural steps in h, at least one: how far h would move w, in units of w, if it were a small step. */
static inline smg_real smg_curve_span(const smg_curve *f) {
  smg_real span = 1;
  for (int64_t k = 0; k < f->n; ++k) smg_take(&span, smg_abs(f->c[k]) / smg_curve_scale(f, k));
  return span;
}

/* Is a midpoint so near the centre of its sphere that paces may jump across it? */
static inline int smg_curve_central(const smg_curve *f) {
  for (int64_t k = 0; k < f->n; k += 3)
    if (smg_dot(f->y + k, f->y + k) < SMG_INWARD * SMG_INWARD * smg_dot(f->w + k, f->w + k)) return 1;
  return 0;
}

/* What a curve that came to p = 1 by places as far as this tells of y. Spheres and R^3 keep abs(y) <= abs(w). */
static inline smg_status smg_curve_arrived(const smg_curve *f, int folded, smg_real far, int central) {
  const smg_real begin = smg_most(f->w, f->n), end = smg_most(f->y, f->n);
  const smg_real mean = SMG_MATH(sqrt)(begin) * SMG_MATH(sqrt)(smg_max(begin, end));
  if (folded) return SMG_WRONG_BRANCH;
  return central || far > SMG_FAR * mean ? SMG_NO_CONVERGENCE : SMG_OK;
}

/* From w: SMG_OK with y the midpoints at p = 1; SMG_NO_SOLUTION when the branch turns back before, and goes
 * back to half the part it reached or gives out, ends in a centre, or leaves for infinity; SMG_WRONG_BRANCH when p = 1
 * lies behind a fold; SMG_NO_CONVERGENCE when it could not be followed, or not surely. */
static inline smg_status smg_follow(smg_curve *f) {
  smg_real pace = SMG_FIRST_PACE, far = 0;
  int folded = 0, turned = 0, central = 0;
  const smg_status begun = f->newton(f->of, 0, f->y, f->a, f->c, &f->sign);
  if (begun != SMG_OK) return begun;
  f->span = smg_curve_span(f);
  (void)smg_curve_turn(f);
  const int64_t points = f->n > SMG_CURVE_WORK / SMG_MAX_POINTS ? 1 + SMG_CURVE_WORK / f->n : SMG_MAX_POINTS;
  for (int64_t point = 0; point < points; ++point) {
    const int its = smg_curve_pace(f, pace);
    if (its == 0) {
      pace *= SMG_SHORTER;
      if (pace < SMG_LEAST_PACE) return turned ? SMG_NO_SOLUTION : smg_curve_end(f);
      continue;
    }
    if (its <= SMG_EASY) pace *= SMG_LONGER;
    if (!folded && f->p > f->reached) f->reached = f->p;
    if (f->q < 0 && !folded) {
      folded = 1;
      f->site = smg_curve_mover(f, -1);
      f->partner = smg_curve_mover(f, f->site);
    }
    turned = turned || (folded && f->p < f->reached * (1 - SMG_TURNED_BACK));
    far = smg_max(far, smg_most(f->y, f->n));
    central = central || smg_curve_central(f);
    if (f->p >= 1) return smg_curve_arrived(f, folded, far, central);
    if (folded && f->p < f->reached / 2) return SMG_NO_SOLUTION;
    if (far > SMG_FARTHEST * f->scale) return SMG_NO_SOLUTION;
  }
  return turned ? SMG_NO_SOLUTION : SMG_NO_CONVERGENCE;
}

#endif
