/* smidgen runtime: has a dense real matrix a real eigenvalue <= 0?
 *
 * The Jacobian of the step equation on the branch connected to h = 0 has none; a positive
 * determinant does not tell, since two of them may hide in it. */
#ifndef SMG_EIGEN_H
#define SMG_EIGEN_H

#include "smg_small.h"

#define SMG_EIGEN_PATIENCE 60 /* QR sweeps per eigenvalue; about 3 is usual */

/* Two cheap proofs first: the spectrum lies in the disc |z - 1| <= ||A - I|| < 1, */
static inline int smg_dense_contracts(int64_t n, const smg_real *A) {
  smg_real sum = 0;
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < n; j++) {
      const smg_real e = A[i * n + j] - (smg_real)(i == j);
      sum += e * e;
    }
  return sum < 1;
}

/* or in the right half plane, because A + A^T is positive definite (Cholesky in work). */
static inline int smg_positive_real(int64_t n, const smg_real *A, smg_real *work) {
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j <= i; j++) {
      smg_real s = A[i * n + j] + A[j * n + i];
      for (int64_t c = 0; c < j; c++) s -= work[i * n + c] * work[j * n + c];
      if (j < i) work[i * n + j] = s / work[j * n + j];
      else if (!(s > SMG_ROUNDOFF * smg_abs(A[i * n + i]))) return 0;
      else work[i * n + i] = SMG_MATH(sqrt)(s);
    }
  return 1;
}

/* The vector v of a reflection I - v v^T/beta that sends (x0, .., x_(m-1)), m <= 3, to a
 * multiple of the first axis, in place; returns beta, 0 when there is nothing to reflect. */
SMG_INLINE smg_real smg_reflector(int m, smg_real *x) {
  smg_real most = 0, norm = 0;
  for (int e = 0; e < m; e++) most = smg_abs(x[e]) > most ? smg_abs(x[e]) : most;
  if (!(most > 0)) return 0;
  for (int e = 0; e < m; e++) x[e] /= most, norm += x[e] * x[e];
  norm = SMG_MATH(sqrt)(norm);
  x[0] += x[0] < 0 ? -norm : norm;
  return norm * smg_abs(x[0]);
}

/* H = P H P with P = I - v v^T/beta on the rows and columns k .. k+m-1, within l .. hi. */
static inline void smg_reflect(int64_t n, smg_real *H, int64_t k, int m, const smg_real *v,
                               smg_real beta, int64_t l, int64_t hi) {
  const int64_t left = k > l ? k - 1 : l, low = k + 3 < hi ? k + 3 : hi;
  for (int64_t j = left; j <= hi; j++) {
    smg_real s = 0;
    for (int e = 0; e < m; e++) s += v[e] * H[(k + e) * n + j];
    s /= beta;
    for (int e = 0; e < m; e++) H[(k + e) * n + j] -= s * v[e];
  }
  for (int64_t i = l; i <= low; i++) {
    smg_real s = 0;
    for (int e = 0; e < m; e++) s += v[e] * H[i * n + k + e];
    s /= beta;
    for (int e = 0; e < m; e++) H[i * n + k + e] -= s * v[e];
  }
}

/* H = G H G^T, the rotation of rows and columns i-1, i that makes H[i][c] vanish. */
static inline void smg_rotate(int64_t n, smg_real *H, int64_t i, int64_t c) {
  const smg_real a = H[(i - 1) * n + c], b = H[i * n + c], most = smg_abs(a) > smg_abs(b) ? smg_abs(a) : smg_abs(b);
  if (!(smg_abs(b) > 0)) return;
  const smg_real p = a / most, q = b / most, r = SMG_MATH(sqrt)(p * p + q * q), co = p / r, si = q / r;
  for (int64_t j = 0; j < n; j++) {
    const smg_real u = H[(i - 1) * n + j], w = H[i * n + j];
    H[(i - 1) * n + j] = co * u + si * w, H[i * n + j] = co * w - si * u;
  }
  for (int64_t j = 0; j < n; j++) {
    const smg_real u = H[j * n + i - 1], w = H[j * n + i];
    H[j * n + i - 1] = co * u + si * w, H[j * n + i] = co * w - si * u;
  }
}

/* Similarity to upper Hessenberg form. */
static inline void smg_hessenberg(int64_t n, smg_real *H) {
  for (int64_t c = 0; c + 2 < n; c++)
    for (int64_t i = n - 1; i > c + 1; i--) {
      smg_rotate(n, H, i, c);
      H[i * n + c] = 0;
    }
}

/* Diagonal similarity by powers of two until rows and columns are of like size (Osborne 1960):
 * strengths that differ by many decades would drown the small eigenvalues otherwise. */
static inline int smg_balance_site(int64_t n, smg_real *H, int64_t i) {
  smg_real row = 0, column = 0, f = 1;
  for (int64_t j = 0; j < n; j++)
    if (j != i) row += smg_abs(H[i * n + j]), column += smg_abs(H[j * n + i]);
  if (!(row > 0) || !(column > 0) || !(row + column - row - column == 0)) return 0;
  while (column * f * f < row / 2 && f < (smg_real)1e100) f *= 2;
  while (column * f * f > row * 2 && f > (smg_real)1e-100) f /= 2;
  for (int64_t j = 0; j < n; j++) H[i * n + j] /= f;
  for (int64_t j = 0; j < n; j++) H[j * n + i] *= f;
  return f < 1 || f > 1;
}

static inline void smg_balance(int64_t n, smg_real *H) {
  int moved = 1;
  for (int pass = 0; moved && pass < 100; pass++) {
    moved = 0;
    for (int64_t i = 0; i < n; i++) moved |= smg_balance_site(n, H, i);
  }
}

/* First row of the unreduced Hessenberg block that ends at row hi. */
static inline int64_t smg_block_start(int64_t n, const smg_real *H, int64_t hi) {
  int64_t l = hi;
  for (; l > 0; l--) {
    const smg_real size = smg_abs(H[l * n + l]) + smg_abs(H[(l - 1) * n + l - 1]);
    if (smg_abs(H[l * n + l - 1]) <= SMG_EPS * size) break;
  }
  return l;
}

/* One implicit double-shift QR sweep of rows l .. hi (Francis 1961; Golub, Van Loan, Matrix
 * Computations, 7.5): the shifts have sum s and product t. */
static inline void smg_francis(int64_t n, smg_real *H, int64_t l, int64_t hi, smg_real s, smg_real t) {
  const smg_real *a = H + l * n + l, *b = a + n, *c = b + n;
  smg_real v[3] = {a[0] * a[0] + a[1] * b[0] - s * a[0] + t, b[0] * (a[0] + b[1] - s), b[0] * c[1]};
  for (int64_t k = l; k < hi; k++) {
    const int m = k + 2 <= hi ? 3 : 2;
    const smg_real beta = smg_reflector(m, v);
    if (beta > 0) smg_reflect(n, H, k, m, v, beta, l, hi);
    for (int e = 1; k > l && e < m; e++) H[(k + e) * n + k - 1] = 0;
    for (int e = 0; e < 3 && k + 1 + e <= hi; e++) v[e] = H[(k + 1 + e) * n + k];
  }
}

/* Shifts from the last 2x2 block; now and then others, so that no cycle lasts. */
static inline void smg_qr_sweep(int64_t n, smg_real *H, int64_t l, int64_t hi, int sweep) {
  const smg_real *a = H + (hi - 1) * n + hi - 1, *b = a + n;
  const smg_real odd = smg_abs(b[0]) + smg_abs(H[(hi - 1) * n + hi - 2]);
  if (sweep % 10 == 9) smg_francis(n, H, l, hi, (smg_real)1.5 * odd, odd * odd);
  else smg_francis(n, H, l, hi, a[0] + b[1], a[0] * b[1] - a[1] * b[0]);
}

/* True when none of the real eigenvalues of H (Hessenberg; spoilt) is <= 0. */
static inline int smg_qr_positive(int64_t n, smg_real *H) {
  int sweep = 0;
  for (int64_t hi = n - 1; hi >= 0;) {
    const int64_t l = smg_block_start(n, H, hi);
    if (l < hi - 1) {
      if (sweep == SMG_EIGEN_PATIENCE) return 0;
      smg_qr_sweep(n, H, l, hi, sweep++);
      continue;
    }
    const smg_real *a = H + l * n + l;
    const smg_real D[4] = {a[0], l < hi ? a[1] : 0, l < hi ? a[n] : 0, l < hi ? a[n + 1] : 1};
    if (!smg_positive2(D)) return 0;
    hi = l - 1, sweep = 0;
  }
  return 1;
}

/* Work space of smg_dense_positive, in smg_real. */
static inline int64_t smg_dense_worksize(int64_t n) { return n * n; }

/* True when the real n x n matrix A has no real eigenvalue <= 0 (to round-off of the balanced
 * matrix); false otherwise, for a NaN, and if the QR iteration does not end. O(n^3); work has
 * smg_dense_worksize(n) reals. */
static inline int smg_dense_positive(int64_t n, const smg_real *A, smg_real *work) {
  if (n == 2) return smg_positive2(A);
  if (n == 3) return smg_positive3(A);
  if (smg_dense_contracts(n, A) || smg_positive_real(n, A, work)) return 1;
  smg_real finite = 0;
  for (int64_t e = 0; e < n * n; e++) work[e] = A[e], finite += A[e] - A[e];
  if (!(finite >= 0)) return 0;
  smg_balance(n, work);
  smg_hessenberg(n, work);
  return smg_qr_positive(n, work);
}

#endif
