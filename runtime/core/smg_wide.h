/* smidgen runtime: numbers of more digits than smg_real, for the last evaluation of a step.
 *
 * smg_wide is long double where that has at least 64 bits; else, or with SMG_DOUBLE_DOUBLE, the unevaluated sum
 * hi + lo of two doubles, |lo| <= ulp(hi)/2: 106 bits, and the same bits on every machine. Where smg_real itself is
 * extended (SMG_LONG_DOUBLE, SMG_QUAD) smg_wide is smg_real.
 *
 * A product is exact through fma, or by Veltkamp's splitting. Dekker, "A floating-point technique for extending the
 * available precision", Numer. Math. 18 (1971); Knuth, The Art of Computer Programming 2, 4.2.2; error bounds in
 * Joldes, Muller, Popescu, ACM Trans. Math. Softw. 44 (2017): sums 3 ulp^2 relative to the sum of sizes, products 5,
 * quotients 10, with ulp = 2^-53. */
#ifndef SMG_WIDE_H
#define SMG_WIDE_H

#include "smidgen.h"

#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD)
#define SMG_WIDE_IS_REAL
#elif LDBL_MANT_DIG < 64 && !defined(SMG_DOUBLE_DOUBLE)
#define SMG_DOUBLE_DOUBLE
#endif

#if defined(SMG_WIDE_IS_REAL) || !defined(SMG_DOUBLE_DOUBLE)

#ifdef SMG_WIDE_IS_REAL
typedef smg_real smg_wide;
#define SMG_WIDE_MATH(f) SMG_MATH(f)
#else
typedef long double smg_wide;
#define SMG_WIDE_MATH(f) f##l
#endif

static inline smg_wide smg_wide_of(smg_real a) { return (smg_wide)a; }
static inline smg_real smg_wide_high(smg_wide a) { return (smg_real)a; }
static inline smg_real smg_wide_low(smg_wide a) { return (smg_real)(a - (smg_wide)(smg_real)a); }
static inline smg_wide smg_wide_sum(smg_real a, smg_real b) { return (smg_wide)a + (smg_wide)b; }
static inline smg_wide smg_wide_pair(smg_real hi, smg_real lo) { return (smg_wide)hi + (smg_wide)lo; }
static inline smg_wide smg_wide_neg(smg_wide a) { return -a; }
static inline smg_wide smg_wide_add(smg_wide a, smg_wide b) { return a + b; }
static inline smg_wide smg_wide_sub(smg_wide a, smg_wide b) { return a - b; }
static inline smg_wide smg_wide_mul(smg_wide a, smg_wide b) { return a * b; }
static inline smg_wide smg_wide_div(smg_wide a, smg_wide b) { return a / b; }
static inline smg_wide smg_wide_scale(smg_real a, smg_wide b) { return (smg_wide)a * b; }
static inline int smg_wide_less(smg_wide a, smg_wide b) { return a < b; }
static inline int smg_wide_equal(smg_wide a, smg_wide b) { return !(a < b) && !(a > b); }
static inline smg_wide smg_wide_sqrt(smg_wide a) { return SMG_WIDE_MATH(sqrt)(a); }
static inline smg_wide smg_wide_rsqrt(smg_wide a) { return 1 / SMG_WIDE_MATH(sqrt)(a); }

/* W + compensation = w + compensation + (hi + lo): what W loses to rounding stays in compensation, to twice its
 * digits. */
static inline void smg_wide_commit(smg_real *w, smg_real *compensation, smg_real hi, smg_real lo) {
  const smg_wide y = ((smg_wide)*compensation + (smg_wide)lo) + (smg_wide)hi;
  const smg_real sum = (smg_real)((smg_wide)*w + y);
  *compensation = (smg_real)(y - ((smg_wide)sum - (smg_wide)*w));
  *w = sum;
}

#else

#ifdef __FAST_MATH__
#error "sums of two doubles are no sums under -ffast-math"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD == 2 || FLT_EVAL_METHOD < 0)
#error "sums of two doubles need doubles without excess precision: leave SMG_DOUBLE_DOUBLE out"
#endif

typedef struct smg_wide {
  smg_real hi, lo;
} smg_wide;

/* hi + lo, already of that form */
static inline smg_wide smg_wide_pair(smg_real hi, smg_real lo) {
  const smg_wide s = {hi, lo};
  return s;
}

/* a + b exactly (Knuth) */
static inline smg_wide smg_wide_sum(smg_real a, smg_real b) {
  const smg_real s = a + b, c = s - a;
  return smg_wide_pair(s, (a - (s - c)) + (b - c));
}

/* a + b exactly for |a| >= |b| (Dekker) */
static inline smg_wide smg_wide_ordered(smg_real a, smg_real b) {
  const smg_real s = a + b;
  return smg_wide_pair(s, b - (s - a));
}

/* a b exactly */
static inline smg_wide smg_wide_product(smg_real a, smg_real b) {
  const smg_real p = a * b;
#ifdef FP_FAST_FMA
  return smg_wide_pair(p, fma(a, b, -p));
#else
  const smg_real s = 134217729.0 * a, t = 134217729.0 * b; /* 2^27 + 1 */
  const smg_real ah = s - (s - a), al = a - ah, bh = t - (t - b), bl = b - bh;
  return smg_wide_pair(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl);
#endif
}

static inline smg_wide smg_wide_of(smg_real a) { return smg_wide_pair(a, 0); }
static inline smg_real smg_wide_high(smg_wide a) { return a.hi; }
static inline smg_real smg_wide_low(smg_wide a) { return a.lo; }
static inline smg_wide smg_wide_neg(smg_wide a) { return smg_wide_pair(-a.hi, -a.lo); }

static inline smg_wide smg_wide_add(smg_wide a, smg_wide b) {
  const smg_wide s = smg_wide_sum(a.hi, b.hi);
  return smg_wide_ordered(s.hi, s.lo + (a.lo + b.lo));
}

static inline smg_wide smg_wide_sub(smg_wide a, smg_wide b) { return smg_wide_add(a, smg_wide_neg(b)); }

static inline smg_wide smg_wide_mul(smg_wide a, smg_wide b) {
  const smg_wide p = smg_wide_product(a.hi, b.hi);
  return smg_wide_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline smg_wide smg_wide_scale(smg_real a, smg_wide b) {
  const smg_wide p = smg_wide_product(a, b.hi);
  return smg_wide_ordered(p.hi, p.lo + a * b.lo);
}

/* q, then what is left of a - q b */
static inline smg_wide smg_wide_div(smg_wide a, smg_wide b) {
  const smg_real q = a.hi / b.hi;
  const smg_wide r = smg_wide_sub(a, smg_wide_scale(q, b));
  return smg_wide_ordered(q, (r.hi + r.lo) / b.hi);
}

static inline int smg_wide_less(smg_wide a, smg_wide b) { return a.hi < b.hi || (a.hi <= b.hi && a.lo < b.lo); }
static inline int smg_wide_equal(smg_wide a, smg_wide b) {
  return !smg_wide_less(a, b) && !smg_wide_less(b, a) && a.hi - b.hi == 0;
}

/* One Newton step from the double root: s + (a - s^2)/(2 s). */
static inline smg_wide smg_wide_sqrt(smg_wide a) {
  const smg_real s = sqrt(a.hi);
  if (!(a.hi > 0)) return smg_wide_of(s);
  const smg_wide r = smg_wide_sub(a, smg_wide_product(s, s));
  return smg_wide_ordered(s, (r.hi + r.lo) / (2 * s));
}

/* The same for 1/sqrt(a): q + q (1 - a q^2)/2. */
static inline smg_wide smg_wide_rsqrt(smg_wide a) {
  const smg_real q = 1 / sqrt(a.hi);
  const smg_wide r = smg_wide_sub(smg_wide_of(1), smg_wide_scale(q, smg_wide_scale(q, a)));
  return smg_wide_ordered(q, 0.5 * q * (r.hi + r.lo));
}

/* W + compensation = w + compensation + (hi + lo): what W loses to rounding stays in compensation, to twice its
 * digits. */
static inline void smg_wide_commit(smg_real *w, smg_real *compensation, smg_real hi, smg_real lo) {
  const smg_wide sum = smg_wide_add(smg_wide_sum(*w, hi), smg_wide_sum(*compensation, lo));
  *w = sum.hi;
  *compensation = sum.lo;
}

#endif

static inline smg_wide smg_wide_fabs(smg_wide a) { return smg_wide_less(a, smg_wide_of(0)) ? smg_wide_neg(a) : a; }
static inline smg_wide smg_wide_min(smg_wide a, smg_wide b) { return smg_wide_less(b, a) ? b : a; }
static inline smg_wide smg_wide_max(smg_wide a, smg_wide b) { return smg_wide_less(a, b) ? b : a; }
static inline smg_wide smg_wide_sign(smg_wide a) {
  return smg_wide_of((smg_real)(smg_wide_less(smg_wide_of(0), a) - smg_wide_less(a, smg_wide_of(0))));
}

/* a^n, n >= 1 */
static inline smg_wide smg_wide_power(smg_wide a, int n) {
  smg_wide p = a;
  for (int k = 1; k < n; ++k) p = smg_wide_mul(p, a);
  return p;
}

/* Vectors as pairs: three high parts, then three low parts, in memory of smg_real. */
static inline smg_wide smg_wide_load(const smg_real *v, int axis) { return smg_wide_pair(v[axis], v[axis + 3]); }
static inline void smg_wide_store(smg_real *v, int axis, smg_wide a) {
  v[axis] = smg_wide_high(a);
  v[axis + 3] = smg_wide_low(a);
}
static inline void smg_wide_into(smg_real *v, int axis, smg_wide a) {
  smg_wide_store(v, axis, smg_wide_add(smg_wide_load(v, axis), a));
}
static inline smg_wide smg_wide_dot(const smg_wide *a, const smg_wide *b) {
  return smg_wide_add(smg_wide_add(smg_wide_mul(a[0], b[0]), smg_wide_mul(a[1], b[1])), smg_wide_mul(a[2], b[2]));
}
static inline void smg_wide_cross(smg_wide *c, const smg_wide *a, const smg_wide *b) {
  c[0] = smg_wide_sub(smg_wide_mul(a[1], b[2]), smg_wide_mul(a[2], b[1]));
  c[1] = smg_wide_sub(smg_wide_mul(a[2], b[0]), smg_wide_mul(a[0], b[2]));
  c[2] = smg_wide_sub(smg_wide_mul(a[0], b[1]), smg_wide_mul(a[1], b[0]));
}

#endif
