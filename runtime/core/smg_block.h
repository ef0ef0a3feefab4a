/* smidgen runtime: arithmetic of the small square blocks of a Newton matrix.
 *
 * A block is SMG_BS x SMG_BS, row-major; SMG_BS is 2 (tangent unknowns of the spherical
 * midpoint) or 3 (classical midpoint), one value per translation unit, set before inclusion. */
#ifndef SMG_BLOCK_H
#define SMG_BLOCK_H

#include "smg_arrays.h"

#ifndef SMG_BS
#define SMG_BS 2
#endif
#define SMG_BB (SMG_BS * SMG_BS)

SMG_INLINE void smg_block_copy(smg_real *C, const smg_real *A) { smg_copy(C, A, SMG_BB); }

/* C += A. */
SMG_INLINE void smg_block_add(smg_real *C, const smg_real *A) { smg_axpy(C, 1, A, SMG_BB); }

/* Sum of absolute entries. */
SMG_INLINE smg_real smg_block_norm(const smg_real *A) {
  smg_real sum = 0;
  for (int e = 0; e < SMG_BB; e++) sum += smg_abs(A[e]);
  return sum;
}

#if SMG_BS == 2
#define smg_block_det smg_det2
#define smg_block_scale smg_scale2
#define smg_block_adjugate smg_adjugate2
#define smg_block_positive smg_positive2
#elif SMG_BS == 3
#define smg_block_det smg_det3
#define smg_block_scale smg_scale3
#define smg_block_adjugate smg_adjugate3
#define smg_block_positive smg_positive3
#else
#error "SMG_BS must be 2 or 3"
#endif
#define smg_block_solve(A, x) smg_solve_small(SMG_BS, A, x)

/* A row by a column whose entries are `step` apart. */
SMG_INLINE smg_real smg_block_dot(const smg_real *a, const smg_real *b, int step) {
#if SMG_BS == 2
  return a[0] * b[0] + a[1] * b[step];
#else
  return a[0] * b[0] + a[1] * b[step] + a[2] * b[2 * step];
#endif
}

/* C = A B, C -= A B; C is none of A, B. */
SMG_INLINE void smg_block_mul(smg_real *C, const smg_real *A, const smg_real *B) {
  SMG_UNROLL
  for (int e = 0; e < SMG_BB; e++) C[e] = smg_block_dot(A + e - e % SMG_BS, B + e % SMG_BS, SMG_BS);
}
SMG_INLINE void smg_block_submul(smg_real *C, const smg_real *A, const smg_real *B) {
  SMG_UNROLL
  for (int e = 0; e < SMG_BB; e++) C[e] -= smg_block_dot(A + e - e % SMG_BS, B + e % SMG_BS, SMG_BS);
}

/* y = A x, y -= A x; y is not x. */
SMG_INLINE void smg_block_apply(smg_real *y, const smg_real *A, const smg_real *x) {
  SMG_UNROLL
  for (int r = 0; r < SMG_BS; r++) y[r] = smg_block_dot(A + SMG_BS * r, x, 1);
}
SMG_INLINE void smg_block_subapply(smg_real *y, const smg_real *A, const smg_real *x) {
  SMG_UNROLL
  for (int r = 0; r < SMG_BS; r++) y[r] -= smg_block_dot(A + SMG_BS * r, x, 1);
}

/* C = D^-1; `before` is the scale of the block before elimination touched it. Returns 0, or 1
 * when D is singular up to round-off: of its own terms, or of what was subtracted from it. */
SMG_INLINE int smg_block_inverse(smg_real *C, const smg_real *D, smg_real before) {
  const smg_real det = smg_block_det(D);
  if (smg_vanishes(det, smg_block_scale(D) + before)) return 1;
  smg_block_adjugate(C, D);
  smg_scale(C, 1 / det, SMG_BB);
  return 0;
}

/* Takes a pivot block into *pivots: 1 while no pivot has a real eigenvalue <= 0; after one that has, 2 or -2 by the
 * sign of the determinant so far. */
SMG_INLINE void smg_block_pivot(int *pivots, const smg_real *D) {
  if (!smg_block_positive(D) && *pivots == 1) *pivots = 2;
  if (!(smg_block_det(D) > 0)) *pivots = -*pivots;
}

/* A and its mirror image B become their common mean: A = B^T. */
SMG_INLINE void smg_block_mirror(smg_real *A, smg_real *B) {
  for (int r = 0; r < SMG_BS; r++)
    for (int e = 0; e < SMG_BS; e++)
      A[r * SMG_BS + e] = B[e * SMG_BS + r] = (A[r * SMG_BS + e] + B[e * SMG_BS + r]) / 2;
}

/* A - I/4 of a diagonal block. */
SMG_INLINE void smg_block_lower(smg_real *A) {
  for (int r = 0; r < SMG_BS; r++) A[r * SMG_BS + r] -= (smg_real)0.25;
}

#endif
