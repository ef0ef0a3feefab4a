/* smidgen runtime: elementary functions of smg_wide.
 *
 * Of a long double (or where smg_real is extended) they are the C library's. Of a pair of doubles each starts from
 * the C library's double, or reduces its argument to a Taylor series; errors are below 1e-29 of the larger of 1 and
 * the result (relative to the result for exp, sin, cos, tan, atan near 0), for |a| < 1e9 in sin, cos and tan. */
#ifndef SMG_WIDE_MATH_H
#define SMG_WIDE_MATH_H

#include "smg_wide.h"

#if defined(SMG_WIDE_IS_REAL) || !defined(SMG_DOUBLE_DOUBLE)

#define SMG_WIDE_LIFT(f) \
  static inline smg_wide smg_wide_##f(smg_wide a) { return SMG_WIDE_MATH(f)(a); }
SMG_WIDE_LIFT(exp)
SMG_WIDE_LIFT(log)
SMG_WIDE_LIFT(sin)
SMG_WIDE_LIFT(cos)
SMG_WIDE_LIFT(tan)
SMG_WIDE_LIFT(asin)
SMG_WIDE_LIFT(acos)
SMG_WIDE_LIFT(atan)
SMG_WIDE_LIFT(sinh)
SMG_WIDE_LIFT(cosh)
SMG_WIDE_LIFT(tanh)
SMG_WIDE_LIFT(floor)
#undef SMG_WIDE_LIFT
static inline smg_wide smg_wide_atan2(smg_wide y, smg_wide x) { return SMG_WIDE_MATH(atan2)(y, x); }
static inline smg_wide smg_wide_pow(smg_wide a, smg_wide b) { return SMG_WIDE_MATH(pow)(a, b); }

#else

static inline smg_wide smg_wide_half(smg_wide a) { return smg_wide_pair(0.5 * a.hi, 0.5 * a.lo); }
static inline smg_wide smg_wide_over(smg_wide a, double n) { return smg_wide_div(a, smg_wide_of(n)); }

static inline smg_wide smg_wide_floor(smg_wide a) {
  const double f = floor(a.hi);
  return f < a.hi ? smg_wide_of(f) : smg_wide_ordered(f, floor(a.lo));
}

/* sum of x^n/n! over n = first, first + step, .., with the sign of each next term times `sign` */
static inline smg_wide smg_wide_series(smg_wide x, int first, int step, int sign) {
  smg_wide term = smg_wide_of(1), sum;
  for (int n = 1; n <= first; ++n) term = smg_wide_over(smg_wide_mul(term, x), n);
  sum = term;
  for (int n = first + step; n < 40; n += step) {
    for (int k = n - step + 1; k <= n; ++k) term = smg_wide_over(smg_wide_mul(term, x), k);
    sum = sign < 0 && (n - first) / step % 2 ? smg_wide_sub(sum, term) : smg_wide_add(sum, term);
    if (fabs(term.hi) <= 1e-33 * fabs(sum.hi)) break;
  }
  return sum;
}

/* e^a = 2^k (1 + p)^512, p = e^r - 1, r = (a - k log 2)/512; (1 + p)^2 - 1 = 2p + p^2 */
static inline smg_wide smg_wide_exp(smg_wide a) {
  const double k = floor(a.hi / 0.6931471805599453 + 0.5);
  if (!(a.hi > -708 && a.hi < 709)) return smg_wide_of(exp(a.hi));
  smg_wide r = smg_wide_sub(a, smg_wide_scale(k, smg_wide_pair(0.6931471805599453, 2.3190468138462996e-17)));
  r = smg_wide_pair(r.hi / 512, r.lo / 512);
  smg_wide p = smg_wide_series(r, 1, 1, 1);
  for (int n = 0; n < 9; ++n) p = smg_wide_add(smg_wide_pair(2 * p.hi, 2 * p.lo), smg_wide_mul(p, p));
  p = smg_wide_add(p, smg_wide_of(1));
  return smg_wide_pair(ldexp(p.hi, (int)k), ldexp(p.lo, (int)k));
}

/* Newton for e^y = a: y + a e^-y - 1 */
static inline smg_wide smg_wide_log(smg_wide a) {
  const double y = log(a.hi);
  if (!(a.hi > 0 && a.hi <= DBL_MAX)) return smg_wide_of(y);
  const smg_wide rest = smg_wide_sub(smg_wide_mul(a, smg_wide_exp(smg_wide_of(-y))), smg_wide_of(1));
  return smg_wide_add(smg_wide_of(y), rest);
}

/* a = k pi/2 + r, |r| <= pi/4; returns k mod 4. pi/2 to 159 bits. */
static inline int smg_wide_quarter(smg_wide a, smg_wide *r) {
  const double k = floor(a.hi / 1.5707963267948966 + 0.5);
  smg_wide b = smg_wide_sub(a, smg_wide_product(k, 1.5707963267948966));
  b = smg_wide_sub(b, smg_wide_product(k, 6.123233995736766e-17));
  *r = smg_wide_sub(b, smg_wide_product(k, -1.4973849048591698e-33));
  return (int)(k - 4 * floor(k / 4));
}

static inline void smg_wide_sincos(smg_wide a, smg_wide *s, smg_wide *c) {
  smg_wide r;
  const int q = smg_wide_quarter(a, &r);
  const smg_wide sine = smg_wide_series(r, 1, 2, -1), cosine = smg_wide_series(r, 0, 2, -1);
  *s = q % 2 ? cosine : sine;
  *c = q % 2 ? sine : cosine;
  if (q >= 2) *s = smg_wide_neg(*s);
  if (q == 1 || q == 2) *c = smg_wide_neg(*c);
}

static inline smg_wide smg_wide_sin(smg_wide a) {
  smg_wide s, c;
  smg_wide_sincos(a, &s, &c);
  return s;
}

static inline smg_wide smg_wide_cos(smg_wide a) {
  smg_wide s, c;
  smg_wide_sincos(a, &s, &c);
  return c;
}

static inline smg_wide smg_wide_tan(smg_wide a) {
  smg_wide s, c;
  smg_wide_sincos(a, &s, &c);
  return smg_wide_div(s, c);
}

/* t + tan(angle - t), t the double angle of (x, y): tan = (y cos t - x sin t)/(x cos t + y sin t) */
static inline smg_wide smg_wide_atan2(smg_wide y, smg_wide x) {
  const smg_wide t = smg_wide_of(atan2(y.hi, x.hi));
  smg_wide s, c;
  smg_wide_sincos(t, &s, &c);
  const smg_wide above = smg_wide_sub(smg_wide_mul(y, c), smg_wide_mul(x, s));
  const smg_wide below = smg_wide_add(smg_wide_mul(x, c), smg_wide_mul(y, s));
  return below.hi > 0 && below.hi <= DBL_MAX ? smg_wide_add(t, smg_wide_div(above, below)) : t;
}

static inline smg_wide smg_wide_atan(smg_wide a) { return smg_wide_atan2(a, smg_wide_of(1)); }

/* sqrt(1 - a^2) */
static inline smg_wide smg_wide_cosine_of(smg_wide a) {
  return smg_wide_sqrt(smg_wide_mul(smg_wide_sub(smg_wide_of(1), a), smg_wide_add(smg_wide_of(1), a)));
}

static inline smg_wide smg_wide_asin(smg_wide a) { return smg_wide_atan2(a, smg_wide_cosine_of(a)); }
static inline smg_wide smg_wide_acos(smg_wide a) { return smg_wide_atan2(smg_wide_cosine_of(a), a); }

static inline smg_wide smg_wide_sinh(smg_wide a) {
  if (fabs(a.hi) < 0.5) return smg_wide_series(a, 1, 2, 1);
  return smg_wide_half(smg_wide_sub(smg_wide_exp(a), smg_wide_exp(smg_wide_neg(a))));
}

static inline smg_wide smg_wide_cosh(smg_wide a) {
  return smg_wide_half(smg_wide_add(smg_wide_exp(a), smg_wide_exp(smg_wide_neg(a))));
}

static inline smg_wide smg_wide_tanh(smg_wide a) {
  if (fabs(a.hi) > 40) return smg_wide_of(a.hi > 0 ? 1.0 : -1.0);
  return smg_wide_div(smg_wide_sinh(a), smg_wide_cosh(a));
}

/* e^(b log |a|), negative for a negative base and an odd exponent */
static inline smg_wide smg_wide_pow(smg_wide a, smg_wide b) {
  const double p = pow(a.hi, b.hi);
  if (!(p - p == 0) || !(fabs(p) > 0)) return smg_wide_of(p);
  const smg_wide q = smg_wide_exp(smg_wide_mul(b, smg_wide_log(smg_wide_fabs(a))));
  return p < 0 ? smg_wide_neg(q) : q;
}

#endif

#endif
