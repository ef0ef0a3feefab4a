/* smidgen runtime: several numbers at once, in the lanes of a vector register.
 *
 * smg_lanes holds SMG_LANES numbers, a power of 2, as the vectors of gcc and clang do: a + b, c*a with one number c,
 * a/b act lane by lane. Each lane has the bits that the same operations on smg_real have. SMG_LANES is what the
 * registers of the target hold, at most SMG_MOST_LANES. It is 1, and smg_lanes is smg_real, with other compilers, in
 * extended precision, and for models without kernels in lanes (SMG_HAS_LANES). */
#ifndef SMG_LANES_H
#define SMG_LANES_H

#include "smg_template.h"

#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD) || !defined(__GNUC__) || !SMG_HAS_LANES
#undef SMG_LANES
#define SMG_LANES 1
#elif !defined(SMG_LANES)
#if defined(__AVX512F__)
#define SMG_NATIVE_LANES 8
#elif defined(__AVX__)
#define SMG_NATIVE_LANES 4
#else
#define SMG_NATIVE_LANES 2
#endif
#define SMG_LANES (SMG_NATIVE_LANES < SMG_MOST_LANES ? SMG_NATIVE_LANES : SMG_MOST_LANES)
#endif

#if SMG_LANES == 1

typedef smg_real smg_lanes, smg_lanes_anywhere;
typedef int smg_lane_mask;

SMG_INLINE smg_lanes smg_lane_abs(smg_lanes a) { return smg_abs(a); }
SMG_INLINE smg_lane_mask smg_lane_all(int test) { return test; }
SMG_INLINE smg_lane_mask smg_lane_not(smg_lane_mask test) { return !test; }
SMG_INLINE smg_lanes smg_lane_select(smg_lane_mask test, smg_lanes a, smg_lanes b) { return test ? a : b; }
SMG_INLINE smg_lane_mask smg_lane_below(int64_t n) { return n > 0; }
SMG_INLINE smg_lane_mask smg_lane_only(int64_t n) { return n == 0; }

#else

typedef smg_real smg_lanes __attribute__((vector_size(sizeof(smg_real) * SMG_LANES), may_alias));
typedef smg_lanes smg_lanes_anywhere __attribute__((aligned(sizeof(smg_real))));
typedef int64_t smg_lane_mask __attribute__((vector_size(sizeof(smg_real) * SMG_LANES), may_alias));
typedef smg_lane_mask smg_lane_mask_anywhere __attribute__((aligned(sizeof(int64_t))));
typedef uint64_t smg_lane_bits __attribute__((vector_size(sizeof(smg_real) * SMG_LANES), may_alias));

/* a without its signs. */
SMG_INLINE smg_lanes smg_lane_abs(smg_lanes a) { return (smg_lanes)((smg_lane_mask)a & INT64_MAX); }

/* The same test in every lane, and its opposite. */
SMG_INLINE smg_lane_mask smg_lane_all(int test) {
  const smg_lane_mask none = {0};
  return none - (int64_t)(test != 0);
}
SMG_INLINE smg_lane_mask smg_lane_not(smg_lane_mask test) { return ~test; }

/* As a number. */
SMG_INLINE smg_lanes smg_lane_number_of(smg_lane_mask n) {
  smg_lanes x = {0};
  for (int l = 0; l < SMG_LANES; ++l) x[l] = (smg_real)n[l];
  return x;
}

/* One more than n where the test holds. */
SMG_INLINE smg_lane_mask smg_lane_counted(smg_lane_mask n, smg_lane_mask test) { return n - test; }

/* a where the test holds (all bits of its lane are 1), else b. */
SMG_INLINE smg_lanes smg_lane_select(smg_lane_mask test, smg_lanes a, smg_lanes b) {
  return (smg_lanes)((test & (smg_lane_mask)a) | (~test & (smg_lane_mask)b));
}

/* The lanes 0 .. n - 1. */
SMG_INLINE smg_lane_mask smg_lane_below(int64_t n) {
  static const int64_t number[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  smg_lane_mask own;
  for (int l = 0; l < SMG_LANES; ++l) own[l] = number[l];
  return (smg_lane_mask)(own < n);
}

/* The lane n, 0 <= n < SMG_LANES. */
SMG_INLINE smg_lane_mask smg_lane_only(int64_t n) {
  static const int64_t around[16] = {0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0};
  return *(const smg_lane_mask_anywhere *)(around + 8 - n);
}

#endif

/* A kernel of the model for SMG_LANES states by value: unused where there is one lane. */
#if defined(__GNUC__)
#define SMG_LANE_KERNEL static inline __attribute__((unused))
#else
#define SMG_LANE_KERNEL static inline
#endif

/* Arrays begin where lines of the cache do, for the sake of speed alone. */
#if defined(__GNUC__)
#define SMG_LINES __attribute__((aligned(64)))
#else
#define SMG_LINES
#endif

SMG_INLINE smg_lanes smg_lane_load(const smg_real *a) { return *(const smg_lanes *)a; }

/* The same where a may be any number of an array. */
SMG_INLINE smg_lanes smg_lane_take(const smg_real *a) { return *(const smg_lanes_anywhere *)a; }
SMG_INLINE void smg_lane_put(smg_real *a, smg_lanes x) { *(smg_lanes_anywhere *)a = x; }

/* One lane. */
SMG_INLINE smg_real smg_lane_get(const smg_lanes *a, int l) { return ((const smg_real *)a)[l]; }
SMG_INLINE void smg_lane_set(smg_lanes *a, int l, smg_real x) { ((smg_real *)a)[l] = x; }

/* Lane l of n vectors, from n numbers and back. */
SMG_INLINE void smg_lane_insert(smg_lanes *to, int l, const smg_real *from, int n) {
  for (int k = 0; k < n; ++k) smg_lane_set(to + k, l, from[k]);
}
SMG_INLINE void smg_lane_extract(const smg_lanes *from, int l, smg_real *to, int n) {
  for (int k = 0; k < n; ++k) to[k] = smg_lane_get(from + k, l);
}
#if SMG_LANES == 1
SMG_INLINE int smg_lane_holds(smg_lane_mask test, SMG_UNUSED int l) { return test != 0; }
SMG_INLINE int smg_lane_any(smg_lane_mask test) { return test != 0; }
#else
SMG_INLINE int smg_lane_holds(smg_lane_mask test, int l) { return test[l] != 0; }

/* Does the test hold in any lane? */
#if defined(__AVX__) && SMG_LANES >= 4 /* in one test in place of one a lane */
typedef long long smg_lane_four __attribute__((vector_size(32), may_alias));
SMG_INLINE int smg_lane_any(smg_lane_mask test) {
  smg_lane_four any = ((const smg_lane_four *)&test)[0];
#if SMG_LANES == 8
  any |= ((const smg_lane_four *)&test)[1];
#endif
  return !__builtin_ia32_ptestz256(any, any);
}
#else
SMG_INLINE int smg_lane_any(smg_lane_mask test) {
  int64_t any = 0;
  for (int l = 0; l < SMG_LANES; ++l) any |= test[l];
  return any != 0;
}
#endif
#endif

/* x in every lane; x - 0 has the bits of x. */
SMG_INLINE smg_lanes smg_lane_of(smg_real x) {
  const smg_lanes zero = {0};
  return x - zero;
}
SMG_INLINE void smg_lane_put_all(smg_lanes *a, smg_real x) { *a = smg_lane_of(x); }

/* smg_lane_dot, smg_lane_cross, smg_lane_add_compensated; smg_lane_copy and others of arrays. */
#include "smg_in_lanes.h"
#include "smg_arrays_template.h"
#include "smg_triple_template.h"
#include "smg_in_numbers.h"

/* smg_add_step in lanes; what its components have lost is at `lost`, and then at `to`, a pitch apart. */
SMG_INLINE void smg_lane_add_step(int64_t n, smg_lanes *w, SMG_UNUSED const smg_real *lost, SMG_UNUSED smg_real *to,
                                  SMG_UNUSED int64_t pitch, const smg_lanes *u) {
#if SMG_PLAIN_SUMS
  smg_lane_axpy(w, smg_lane_of(1), u, n);
#else
  for (int64_t k = 0; k < n; ++k) {
    smg_lanes carried = smg_lane_take(lost + k * pitch);
    smg_lane_add_compensated(w + k, &carried, u[k]);
    smg_lane_put(to + k * pitch, carried);
  }
#endif
}

/* Numbers of the same exponents as 1/sqrt(x) and 1/x, from the bits of x > 0: off by at most 3.4 and 13 %. C. Lomont,
 * "Fast inverse square root" (2003); of numbers other than doubles, and where lanes are no vectors of them, sqrt and /
 * say it. */
#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD)
SMG_INLINE smg_lanes smg_lane_rough_inverse_root(smg_lanes x) { return 1 / SMG_MATH(sqrt)(x + DBL_MIN); }
SMG_INLINE smg_lanes smg_lane_rough_inverse(smg_lanes x) { return 1 / (x + DBL_MIN); }
#else
#if SMG_LANES == 1
SMG_INLINE smg_lanes smg_lane_of_bits(uint64_t from, smg_lanes x, int shift) { return smg_of_bits(from, x, shift); }
#else
SMG_INLINE smg_lanes smg_lane_of_bits(uint64_t from, smg_lanes x, int shift) {
  return (smg_lanes)(from - ((smg_lane_bits)x >> shift));
}
#endif
SMG_INLINE smg_lanes smg_lane_rough_inverse_root(smg_lanes x) {
  return smg_lane_of_bits(UINT64_C(0x5fe6eb50c7b537a9), x, 1);
}
SMG_INLINE smg_lanes smg_lane_rough_inverse(smg_lanes x) {
  return smg_lane_of_bits(UINT64_C(0x7fde623822fc16e6), x, 0);
}
#endif

/* 1/sqrt(x) to two ulps, by + and * alone, so that every width has its bits: y (1 - r)^(-1/2) with r = 1 - x y^2, to
 * the third power of r. An error e of y becomes 4.4 e^4: 3.4e-2, 6e-6, 6e-21. */
SMG_INLINE smg_lanes smg_lane_inverse_root(smg_lanes x) {
  smg_lanes y = smg_lane_rough_inverse_root(x);
  for (int k = 0; k < 2; ++k) {
    const smg_lanes r = 1 - x * y * y;
    y += y * r * ((smg_real)0.5 + r * ((smg_real)0.375 + r * (smg_real)0.3125));
  }
  return y;
}

/* The smaller and the larger; b where either is not a number. */
SMG_INLINE smg_lanes smg_lane_smaller(smg_lanes a, smg_lanes b) {
  return smg_lane_select((smg_lane_mask)(a < b), a, b);
}
SMG_INLINE smg_lanes smg_lane_larger(smg_lanes a, smg_lanes b) { return smg_lane_select((smg_lane_mask)(a > b), a, b); }

/* smg_min, smg_max and the sign; what is not a number stays so in the first two. */
SMG_INLINE smg_lanes smg_lane_min(smg_lanes a, smg_lanes b) {
  return smg_lane_select((smg_lane_mask)(a <= b) | (smg_lane_mask)(a != a), a, b);
}
SMG_INLINE smg_lanes smg_lane_max(smg_lanes a, smg_lanes b) {
  return smg_lane_select((smg_lane_mask)(a >= b) | (smg_lane_mask)(a != a), a, b);
}
SMG_INLINE smg_lanes smg_lane_sign(smg_lanes a) {
  const smg_lanes zero = {0};
  const smg_lanes positive = smg_lane_select((smg_lane_mask)(a > zero), smg_lane_of(1), zero);
  return smg_lane_select((smg_lane_mask)(a < zero), smg_lane_of(-1), positive);
}

/* Functions of the C library, lane after lane, so that each has its bits. */
#define SMG_LANE_FUNCTION(f)                                                                    \
  static inline smg_lanes smg_lane_##f(smg_lanes a) {                                           \
    for (int l = 0; l < SMG_LANES; ++l) ((smg_real *)&a)[l] = SMG_MATH(f)(((smg_real *)&a)[l]); \
    return a;                                                                                   \
  }
#define SMG_LANE_FUNCTION_2(f)                                                                                       \
  static inline smg_lanes smg_lane_##f(smg_lanes a, smg_lanes b) {                                                   \
    for (int l = 0; l < SMG_LANES; ++l) ((smg_real *)&a)[l] = SMG_MATH(f)(((smg_real *)&a)[l], ((smg_real *)&b)[l]); \
    return a;                                                                                                        \
  }
SMG_LANE_FUNCTION(sqrt)
SMG_LANE_FUNCTION(exp)
SMG_LANE_FUNCTION(log)
SMG_LANE_FUNCTION(sin)
SMG_LANE_FUNCTION(cos)
SMG_LANE_FUNCTION(tan)
SMG_LANE_FUNCTION(asin)
SMG_LANE_FUNCTION(acos)
SMG_LANE_FUNCTION(atan)
SMG_LANE_FUNCTION(sinh)
SMG_LANE_FUNCTION(cosh)
SMG_LANE_FUNCTION(tanh)
SMG_LANE_FUNCTION(floor)
SMG_LANE_FUNCTION_2(atan2)
SMG_LANE_FUNCTION_2(pow)
#undef SMG_LANE_FUNCTION
#undef SMG_LANE_FUNCTION_2

/* The larger of a and b, and the largest lane, where none is negative, by their bits, which are in their order,
 * infinity and NaN last: without a branch; the largest lane of the two halves of a register, then of their halves. */
#if SMG_LANES == 1
SMG_INLINE smg_real smg_lane_largest(smg_lanes a) { return a; }
SMG_INLINE smg_lanes smg_lane_more(smg_lanes a, smg_lanes b) { return b > a || b != b ? b : a; }
#else
SMG_INLINE smg_lanes smg_lane_more(smg_lanes a, smg_lanes b) {
  return smg_lane_select((smg_lane_mask)((smg_lane_mask)a > (smg_lane_mask)b), a, b);
}
typedef int64_t smg_bits_of_4 __attribute__((vector_size(32), may_alias));
typedef int64_t smg_bits_of_2 __attribute__((vector_size(16), may_alias));
SMG_INLINE smg_real smg_lane_largest(smg_lanes a) {
  union {
    smg_lane_mask all;
    smg_bits_of_4 fours[2];
    smg_bits_of_2 twos[4];
    int64_t bits[8];
    smg_real number;
  } most = {(smg_lane_mask)smg_lane_abs(a)};
#if SMG_LANES > 4
  const smg_bits_of_4 above_4 = most.fours[0] > most.fours[1];
  most.fours[0] = (above_4 & most.fours[0]) | (~above_4 & most.fours[1]);
#endif
#if SMG_LANES > 2
  const smg_bits_of_2 above_2 = most.twos[0] > most.twos[1];
  most.twos[0] = (above_2 & most.twos[0]) | (~above_2 & most.twos[1]);
#endif
  most.bits[0] = most.bits[0] > most.bits[1] ? most.bits[0] : most.bits[1];
  return most.number;
}
#endif

/* a, and the three of v, in the lanes 0 .. n - 1; 0 in the others. */
SMG_INLINE smg_lanes smg_lane_first(int64_t n, smg_lanes a) {
  return n < SMG_LANES ? smg_lane_select(smg_lane_below(n), a, smg_lane_of(0)) : a;
}
SMG_INLINE void smg_first_lanes(int64_t n, smg_lanes *v) {
  for (int k = 0; n < SMG_LANES && k < 3; ++k) v[k] = smg_lane_first(n, v[k]);
}

#endif
