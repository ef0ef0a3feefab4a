/* smidgen runtime: dense systems, LU with partial pivoting.
 *
 * Written so that a constant n unrolls; large n goes by panels of columns, so that each pass
 * over the rest of the matrix does SMG_PANEL updates at once. */
#ifndef SMG_DENSE_H
#define SMG_DENSE_H

#include "smg_arrays.h"

#define SMG_PANEL 8

/* Row of the largest entry of column c, from row c down. */
SMG_INLINE int64_t smg_dense_pivot(int64_t n, const smg_real *A, int64_t c) {
  int64_t best = c;
  for (int64_t i = c + 1; i < n; i++)
    if (smg_abs(A[i * n + c]) > smg_abs(A[best * n + c])) best = i;
  return best;
}

SMG_INLINE void smg_dense_swap(int64_t n, smg_real *A, smg_real *x, int64_t a, int64_t b) {
  for (int64_t j = 0; j < n; j++) {
    const smg_real t = A[a * n + j];
    A[a * n + j] = A[b * n + j], A[b * n + j] = t;
  }
  const smg_real t = x[a];
  x[a] = x[b], x[b] = t;
}

/* True when the pivot of column c is round-off of what was subtracted from the column, whose
 * size the entries of U above it show. */
SMG_INLINE int smg_dense_singular(int64_t n, const smg_real *A, int64_t c) {
  smg_real largest = 0;
  for (int64_t i = 0; i < c; i++) largest = smg_abs(A[i * n + c]) > largest ? smg_abs(A[i * n + c]) : largest;
  return !(smg_abs(A[c * n + c]) > (smg_real)n * SMG_EPS * largest);
}

/* Columns [first, last) of L, and of U from row `first` down; *sign takes part in that of det A. */
SMG_INLINE int64_t smg_dense_panel(int64_t n, smg_real *A, smg_real *x, int64_t first, int64_t last, int *sign) {
  for (int64_t c = first; c < last; c++) {
    const int64_t p = smg_dense_pivot(n, A, c);
    if ((p != c) != (A[p * n + c] < 0)) *sign = -*sign;
    if (p != c) smg_dense_swap(n, A, x, p, c);
    if (smg_dense_singular(n, A, c)) return 1 + c;
    const smg_real reciprocal = 1 / A[c * n + c];
    for (int64_t i = c + 1; i < n; i++) {
      const smg_real l = A[i * n + c] *= reciprocal;
      smg_axpy(A + i * n + c + 1, -l, A + c * n + c + 1, last - c - 1);
    }
  }
  return 0;
}

/* The panel's rows of U to its right: U = L^-1 A. */
SMG_INLINE void smg_dense_panel_rows(int64_t n, smg_real *A, int64_t first, int64_t last) {
  for (int64_t c = first; c < last; c++)
    for (int64_t i = c + 1; i < last; i++) smg_axpy(A + i * n + last, -A[i * n + c], A + c * n + last, n - last);
}

/* The rest: A_ij -= sum of SMG_PANEL products l_ic u_cj. */
SMG_INLINE void smg_dense_rest(int64_t n, smg_real *A, int64_t first) {
  const int64_t last = first + SMG_PANEL;
  const smg_real *u = A + first * n;
  for (int64_t i = last; i < n; i++) {
    const smg_real *l = A + i * n + first;
    smg_real *row = A + i * n;
    for (int64_t j = last; j < n; j++)
      row[j] -= ((l[0] * u[j] + l[1] * u[n + j]) + (l[2] * u[2 * n + j] + l[3] * u[3 * n + j])) +
                ((l[4] * u[4 * n + j] + l[5] * u[5 * n + j]) + (l[6] * u[6 * n + j] + l[7] * u[7 * n + j]));
  }
}

/* P A = L U in place, the rows of x permuted alike, *sign that of det A; returns 0 or 1 + the singular column. */
SMG_INLINE int64_t smg_dense_factor(int64_t n, smg_real *A, smg_real *x, int *sign) {
  *sign = 1;
  if (n <= 2 * SMG_PANEL) return smg_dense_panel(n, A, x, 0, n, sign);
  int64_t first = 0, failed = 0;
  for (; first + SMG_PANEL < n && !failed; first += SMG_PANEL) {
    failed = smg_dense_panel(n, A, x, first, first + SMG_PANEL, sign);
    smg_dense_panel_rows(n, A, first, first + SMG_PANEL);
    smg_dense_rest(n, A, first);
  }
  return failed ? failed : smg_dense_panel(n, A, x, first, n, sign);
}

/* x = U^-1 L^-1 x. */
SMG_INLINE void smg_dense_substitute(int64_t n, const smg_real *A, smg_real *x) {
  for (int64_t i = 1; i < n; i++) {
    smg_real sum = x[i];
    for (int64_t j = 0; j < i; j++) sum -= A[i * n + j] * x[j];
    x[i] = sum;
  }
  for (int64_t i = n - 1; i >= 0; i--) {
    smg_real sum = x[i];
    for (int64_t j = i + 1; j < n; j++) sum -= A[i * n + j] * x[j];
    x[i] = sum / A[i * n + i];
  }
}

/* The sum of abs(A - I) over row i. */
static inline smg_real smg_dense_row_sum(int64_t n, const smg_real *A, int64_t i) {
  const smg_real *row = A + i * n, left = smg_add_sizes(0, i, row, -1) + smg_abs(row[i] - 1);
  return smg_add_sizes(left, n - i - 1, row + i + 1, -1);
}

/* True when x.A x >= x.x/4 for all x, by the Cholesky factors of (A + A^T)/2 - I/4 in place of A. */
static inline int smg_dense_coercive(int64_t n, smg_real *A) {
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j <= i; j++) {
      smg_real sum = (A[i * n + j] + A[j * n + i]) / 2 - (i == j ? (smg_real)0.25 : 0);
      for (int64_t k = 0; k < j; k++) sum -= A[i * n + k] * A[j * n + k];
      if (i == j && !(sum > 0)) return 0;
      A[i * n + j] = i == j ? SMG_MATH(sqrt)(sum) : sum / A[j * n + j];
    }
  return 1;
}

/* Solves A x = b: A (n x n, row-major) is destroyed, x holds b and receives the solution; *sign: that of det A.
 * Returns 0, or 1 + the column at which A is singular to round-off (x is then spoilt). */
SMG_INLINE int64_t smg_dense_solve(int64_t n, smg_real *A, smg_real *x, int *sign) {
  if (n == 2 || n == 3) *sign = (n == 2 ? smg_det2(A) : smg_det3(A)) < 0 ? -1 : 1;
  if (n == 2 || n == 3) return smg_solve_small((int)n, A, x);
  const int64_t failed = smg_dense_factor(n, A, x, sign);
  if (failed) return failed;
  smg_dense_substitute(n, A, x);
  return 0;
}

#endif
