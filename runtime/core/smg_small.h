/* smidgen runtime: closed forms for 2x2 and 3x3 matrices (row-major).
 *
 * Determinants are compared with the size of their own terms, so every test is unchanged
 * when rows and columns are scaled. */
#ifndef SMG_SMALL_H
#define SMG_SMALL_H

#include "smidgen.h"

#ifndef SMG_INLINE
#if defined(__GNUC__)
#define SMG_INLINE static inline __attribute__((always_inline))
#else
#define SMG_INLINE static inline
#endif
#endif

/* An argument that not every answer to a contract, or not every model, needs. */
#if defined(__GNUC__)
#define SMG_UNUSED __attribute__((unused))
#else
#define SMG_UNUSED
#endif

/* A function that stays out of its callers. */
#if defined(__GNUC__)
#define SMG_APART __attribute__((noinline))
#else
#define SMG_APART
#endif

/* Functions off the usual path: kept out of it, so that it stays in registers. */
#define SMG_COLD SMG_APART

/* What a run does once, or hardly ever: compiled for size, in less time. */
#if defined(__GNUC__)
#define SMG_RARE __attribute__((cold))
#else
#define SMG_RARE
#endif

/* Before a loop of constant length: asks gcc for its full unrolling (clang does it unasked). */
#if defined(__GNUC__) && !defined(__clang__)
#define SMG_UNROLL _Pragma("GCC unroll 16")
#else
#define SMG_UNROLL
#endif

/* Before a loop over sites of which there may be few (SMG_FEW_STAGED): where their number is known, each has its copy
 * of the body. */
#if defined(__GNUC__)
#define SMG_UNROLL_SITES _Pragma("GCC unroll 4")
#else
#define SMG_UNROLL_SITES
#endif

/* A pointer that a loop finds anew each time: else gcc keeps it, and those at distances from it, in more registers than
 * there are. */
#if defined(__GNUC__)
#define SMG_ANEW(pointer) __asm__("" : "+r"(pointer))
#else
#define SMG_ANEW(pointer) (void)0
#endif

/* What stands there will soon be asked for. */
#if defined(__GNUC__)
#define SMG_FETCH(pointer) __builtin_prefetch(pointer)
#else
#define SMG_FETCH(pointer) (void)0
#endif

/* Of a pointer: what it points to is written through no other. */
#if defined(__GNUC__)
#define SMG_RESTRICT __restrict
#else
#define SMG_RESTRICT
#endif

#ifdef SMG_LONG_DOUBLE
#define SMG_MAX LDBL_MAX
#else
#define SMG_MAX DBL_MAX
#endif

/* A determinant below this fraction of its own terms is round-off: of its own dozen of operations, and of its
 * entries'. */
#define SMG_ROUNDOFF (64 * SMG_EPS)

#if !defined(SMG_LONG_DOUBLE) && !defined(SMG_QUAD)
/* The number whose bits are `from` less those of x. */
SMG_INLINE smg_real smg_of_bits(uint64_t from, smg_real x, int shift) {
  union {
    smg_real number;
    uint64_t bits;
  } both = {x};
  both.bits = from - (both.bits >> shift);
  return both.number;
}
#endif

SMG_INLINE smg_real smg_abs(smg_real a) { return SMG_MATH(fabs)(a); }

/* The smaller and the larger; what is not a number stays so. */
SMG_INLINE smg_real smg_min(smg_real a, smg_real b) { return a <= b || a != a ? a : b; }
SMG_INLINE smg_real smg_max(smg_real a, smg_real b) { return a >= b || a != a ? a : b; }
SMG_INLINE void smg_take(smg_real *most, smg_real x) { *most = smg_max(*most, x); }

/* |a|, also where the squares leave the range of a double; within 1e+-280 they have all their digits. */
SMG_INLINE smg_real smg_norm(const smg_real *a) {
  const smg_real square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  if (square > (smg_real)1e-280 && square < (smg_real)1e280) return SMG_MATH(sqrt)(square);
  smg_real most = 0;
  for (int k = 0; k < 3; k++) most = smg_abs(a[k]) > most ? smg_abs(a[k]) : most;
  if (!(square - square == 0) && !(most > 0 && most - most == 0)) return square; /* NaN, infinity */
  if (!(most > 0)) return 0;
  const smg_real x = a[0] / most, y = a[1] / most, z = a[2] / most;
  return most * SMG_MATH(sqrt)(x * x + y * y + z * z);
}

/* sum, and the sizes of n entries of a row of A - I more; own: which of them is on the diagonal, -1: none. */
SMG_INLINE smg_real smg_add_sizes(smg_real sum, int64_t n, const smg_real *row, int64_t own) {
  for (int64_t l = 0; l < n; ++l) sum += smg_abs(row[l] - (l == own));
  return sum;
}

/* sums[r] += sum_l |B_rl| of an n x n block. */
SMG_INLINE void smg_row_sums(int n, const smg_real *B, smg_real *sums) {
  for (int r = 0; r < n; ++r) sums[r] = smg_add_sizes(sums[r], n, B + n * r, -1);
}

/* The same of D - I into `rows`, and of (D + D^T)/2 - I into `mean`, D a diagonal block. */
SMG_INLINE void smg_diagonal_sums(int n, const smg_real *D, smg_real *rows, smg_real *mean) {
  for (int r = 0; r < n; ++r)
    for (int l = 0; l < n; ++l) {
      rows[r] += smg_abs(D[n * r + l] - (r == l));
      mean[r] += smg_abs((D[n * r + l] + D[n * l + r]) / 2 - (r == l));
    }
}

/* det A. */
SMG_INLINE smg_real smg_det2(const smg_real *A) { return A[0] * A[3] - A[1] * A[2]; }

/* Rows of cofactors by cross products: det A = a . (b x c) with the rows a, b, c. */
SMG_INLINE smg_real smg_det3(const smg_real *A) {
  return A[0] * (A[4] * A[8] - A[5] * A[7]) + A[1] * (A[5] * A[6] - A[3] * A[8]) + A[2] * (A[3] * A[7] - A[4] * A[6]);
}

/* perm |A|: the size of the terms of det A, scaled by rows and columns as det A is. */
SMG_INLINE smg_real smg_scale2(const smg_real *A) { return smg_abs(A[0] * A[3]) + smg_abs(A[1] * A[2]); }

SMG_INLINE smg_real smg_scale3(const smg_real *A) {
  return smg_abs(A[0]) * (smg_abs(A[4] * A[8]) + smg_abs(A[5] * A[7])) +
         smg_abs(A[1]) * (smg_abs(A[5] * A[6]) + smg_abs(A[3] * A[8])) +
         smg_abs(A[2]) * (smg_abs(A[3] * A[7]) + smg_abs(A[4] * A[6]));
}

/* True when a determinant is NaN or no more than round-off of terms of the size `scale`. */
SMG_INLINE int smg_vanishes(smg_real det, smg_real scale) { return !(smg_abs(det) > SMG_ROUNDOFF * scale); }

/* True when the real 2x2 matrix D has no real eigenvalue <= 0: det D > 0, and not both
 * eigenvalues real and negative (tr^2 - 4 det = (a-d)^2 + 4bc >= 0 and tr <= 0). */
SMG_INLINE int smg_positive2(const smg_real *D) {
  const smg_real gap = D[0] - D[3];
  const int negative_pair = (D[0] + D[3] <= 0) & (gap * gap + 4 * (D[1] * D[2]) >= 0);
  return (smg_det2(D) > 0) & !negative_pair;
}

/* True when q(s) = s^3 + a s^2 + b s + c is positive for all s >= 0: q(0) > 0, and where q
 * has a local minimum at s > 0, s = (-a + sqrt(a^2 - 3b))/3, q is positive there too. */
static inline int smg_cubic_positive(smg_real a, smg_real b, smg_real c) {
  const smg_real disc = a * a - 3 * b;
  if (!(c > 0)) return 0;
  if ((a >= 0 && b >= 0) || disc <= 0) return 1;
  const smg_real s = (SMG_MATH(sqrt)(disc) - a) / 3;
  return s <= 0 || ((s + a) * s + b) * s + c > 0;
}

/* The same for a real 3x3 matrix: q(s) = det(s I + D) has no root s >= 0. */
SMG_INLINE int smg_positive3(const smg_real *D) {
  const smg_real minors = (D[0] * D[4] - D[1] * D[3]) + (D[0] * D[8] - D[2] * D[6]) + (D[4] * D[8] - D[5] * D[7]);
  return smg_cubic_positive(D[0] + D[4] + D[8], minors, smg_det3(D));
}

/* The largest row sum of abs(A - I). */
SMG_INLINE smg_real smg_bound(int n, const smg_real *A) {
  smg_real most = 0;
  for (int r = 0; r < n; r++) most = smg_max(most, smg_add_sizes(0, n, A + n * r, r));
  return most;
}

/* C = det(A) A^-1, so that A C = det(A) I. */
SMG_INLINE void smg_adjugate2(smg_real *C, const smg_real *A) {
  C[0] = A[3], C[1] = -A[1];
  C[2] = -A[2], C[3] = A[0];
}

SMG_INLINE void smg_adjugate3(smg_real *C, const smg_real *A) {
  C[0] = A[4] * A[8] - A[5] * A[7];
  C[1] = A[2] * A[7] - A[1] * A[8];
  C[2] = A[1] * A[5] - A[2] * A[4];
  C[3] = A[5] * A[6] - A[3] * A[8];
  C[4] = A[0] * A[8] - A[2] * A[6];
  C[5] = A[2] * A[3] - A[0] * A[5];
  C[6] = A[3] * A[7] - A[4] * A[6];
  C[7] = A[1] * A[6] - A[0] * A[7];
  C[8] = A[0] * A[4] - A[1] * A[3];
}

/* Solves A x = b in place (x holds b) by cofactors, n = 2 or 3; returns 0, or n when singular. */
SMG_INLINE int smg_solve_small(int n, const smg_real *A, smg_real *x) {
  const smg_real b[3] = {x[0], x[1], x[n - 1]}, det = n == 2 ? smg_det2(A) : smg_det3(A);
  smg_real C[9];
  if (smg_vanishes(det, n == 2 ? smg_scale2(A) : smg_scale3(A))) return n;
  if (n == 2) smg_adjugate2(C, A);
  else smg_adjugate3(C, A);
  for (int r = 0; r < n; r++) {
    const smg_real *row = C + n * r, two = row[0] * b[0] + row[1] * b[1];
    x[r] = (n == 2 ? two : two + row[2] * b[2]) / det;
  }
  return 0;
}

#endif
