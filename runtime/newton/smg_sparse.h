/* smidgen runtime: block-sparse LU with a pattern fixed at compile time.
 *
 * The pattern (gen/compile/plan/ordering.py) is that of L + U with its fill, in the order of elimination:
 * row i has the columns col[rowptr[i]] .. col[rowptr[i+1]-1], ascending, with col[diag[i]] = i.
 * A holds a block for each of them, zero where only fill will stand. */
#ifndef SMG_SPARSE_H
#define SMG_SPARSE_H

#include "smg_block.h"

/* Work space of smg_sparse_solve, in smg_real: one dense block row. */
static inline int64_t smg_sparse_worksize(int64_t n) { return n * SMG_BB; }

/* Row i of the matrix into the dense row. */
SMG_INLINE void smg_sparse_load(int32_t first, int32_t last, const int32_t *col, const smg_real *A, smg_real *row) {
  for (int32_t p = first; p < last; p++) smg_block_copy(row + (int64_t)col[p] * SMG_BB, A + (int64_t)p * SMG_BB);
}

/* row -= L (Uhat of row j), r -= L rhat_j. */
SMG_INLINE void smg_sparse_update(int32_t j, const int32_t *rowptr, const int32_t *col, const int32_t *diag,
                                  const smg_real *A, const smg_real *x, smg_real *row, smg_real *r) {
  const smg_real *L = row + (int64_t)j * SMG_BB;
  for (int32_t p = diag[j] + 1; p < rowptr[j + 1]; p++)
    smg_block_submul(row + (int64_t)col[p] * SMG_BB, L, A + (int64_t)p * SMG_BB);
  smg_block_subapply(r, L, x + (int64_t)j * SMG_BS);
}

/* Uhat = D^-1 U back into the row's place, rhat = D^-1 r. */
SMG_INLINE int smg_sparse_scale(int32_t i, int32_t diag, int32_t last, const int32_t *col, smg_real *A, smg_real *r,
                                const smg_real *row, int *ok) {
  const smg_real *D = row + (int64_t)i * SMG_BB;
  const smg_real b[3] = {r[0], r[1], r[SMG_BS - 1]};
  smg_real inverse[SMG_BB];
  if (smg_block_inverse(inverse, D, smg_block_scale(A + (int64_t)diag * SMG_BB))) return 1;
  smg_block_pivot(ok, D);
  smg_block_apply(r, inverse, b);
  for (int32_t p = diag + 1; p < last; p++)
    smg_block_mul(A + (int64_t)p * SMG_BB, inverse, row + (int64_t)col[p] * SMG_BB);
  return 0;
}

/* x_i = rhat_i - sum Uhat x_c, upwards. */
static inline void smg_sparse_back(int32_t n, const int32_t *rowptr, const int32_t *col, const int32_t *diag,
                                   const smg_real *A, smg_real *x) {
  for (int32_t i = n - 1; i >= 0; i--)
    for (int32_t p = diag[i] + 1; p < rowptr[i + 1]; p++)
      smg_block_subapply(x + (int64_t)i * SMG_BS, A + (int64_t)p * SMG_BB, x + (int64_t)col[p] * SMG_BS);
}

/* Solves A x = b, both in the order of elimination, row by row (up-looking) without pivoting
 * between blocks. A is overwritten; x holds b and receives the solution; work has
 * smg_sparse_worksize(n) reals.
 * Returns 0, or 1 + the row (in that order) whose pivot is singular to round-off.
 * *pivots: 1 when no pivot block has a real eigenvalue <= 0, else 2 or -2, the sign of the determinant. */
static inline int32_t smg_sparse_solve(int32_t n, const int32_t *rowptr, const int32_t *col, const int32_t *diag,
                                       smg_real *A, smg_real *x, smg_real *work, int *pivots) {
  int ok = 1;
  *pivots = 0;
  for (int32_t i = 0; i < n; i++) {
    smg_real *r = x + (int64_t)i * SMG_BS;
    smg_sparse_load(rowptr[i], rowptr[i + 1], col, A, work);
    for (int32_t p = rowptr[i]; p < diag[i]; p++) smg_sparse_update(col[p], rowptr, col, diag, A, x, work, r);
    if (smg_sparse_scale(i, diag[i], rowptr[i + 1], col, A, r, work, &ok)) return 1 + i;
  }
  smg_sparse_back(n, rowptr, col, diag, A, x);
  *pivots = ok;
  return 0;
}

/* The sum of abs(A - I) over a row. */
static inline smg_real smg_sparse_row_sum(const int32_t *rowptr, const int32_t *diag, const smg_real *A, int32_t row) {
  const int32_t i = row / SMG_BS, r = row % SMG_BS;
  smg_real sum = 0;
  for (int32_t p = rowptr[i]; p < rowptr[i + 1]; p++)
    sum = smg_add_sizes(sum, SMG_BS, A + (int64_t)p * SMG_BB + r * SMG_BS, p == diag[i] ? r : -1);
  return sum;
}

/* Where block (i, j) lies. */
static inline int64_t smg_sparse_position(const int32_t *rowptr, const int32_t *col, int32_t i, int32_t j) {
  int32_t p = rowptr[i];
  while (col[p] != j) p++;
  return (int64_t)p * SMG_BB;
}

/* True when x.A x >= x.x/4 for all x: (A + A^T)/2 - I/4 has positive pivots. A and x are spoilt. */
static inline int smg_sparse_coercive(int32_t n, const int32_t *rowptr, const int32_t *col, const int32_t *diag,
                                      smg_real *A, smg_real *x, smg_real *work) {
  int positive = 0;
  for (int32_t i = 0; i < n; i++) {
    for (int32_t p = diag[i]; p < rowptr[i + 1]; p++)
      smg_block_mirror(A + (int64_t)p * SMG_BB, A + smg_sparse_position(rowptr, col, col[p], i));
    smg_block_lower(A + (int64_t)diag[i] * SMG_BB);
  }
  return smg_sparse_solve(n, rowptr, col, diag, A, x, work, &positive) == 0 && positive == 1;
}

#endif
