/* What the matrix of a step shows of its branch: bound, coercive, and what the pivots say.
 * In: 0, A (BS*BS), or 1, n, k, wrap, A (n*(2k+1)*BS*BS), or
 * 2, n, blocks, rowptr (n+1), col (blocks), diag (n), A (blocks*BS*BS). Out: bound, coercive, pivots. */
#include "pipe.h"
#include "smg_band.h"
#include "smg_dense.h"
#include "smg_sparse.h"

static void say(smg_real bound, int coercive, int pivots) {
  pipe_put((double)bound);
  pipe_put(coercive);
  pipe_put(pivots);
}

static void block(void) {
  smg_real A[SMG_BB];
  int pivots = 1;
  pipe_take(SMG_BB, A);
  smg_block_pivot(&pivots, A);
  const smg_real bound = smg_bound(SMG_BS, A);
  say(bound, smg_dense_coercive(SMG_BS, A), pivots);
}

static smg_real *copied(int64_t count, const smg_real *A) {
  smg_real *B = pipe_room(count);
  for (int64_t e = 0; e < count; e++) B[e] = A[e];
  return B;
}

static void band(void) {
  const int64_t n = pipe_integer(), k = pipe_integer(), wrap = pipe_integer(), size = n * (2 * k + 1) * SMG_BB;
  smg_real *A = pipe_room(size), *x = pipe_room(n * SMG_BS), *work = pipe_room(smg_band_worksize(n, (int)k));
  int pivots = 0;
  pipe_take(size, A);
  for (int64_t e = 0; e < n * SMG_BS; e++) x[e] = 1;
  smg_real *B = copied(size, A), *y = copied(n * SMG_BS, x);
  (void)smg_band_solve(n, (int)k, (int)wrap, A, x, work, &pivots);
  smg_real bound = 0;
  for (int64_t row = 0; row < n * SMG_BS; row++) bound = smg_max(bound, smg_band_row_sum((int)k, A, row));
  say(bound, smg_band_coercive(n, (int)k, (int)wrap, B, y, work), pivots);
  free(A), free(B), free(x), free(y), free(work);
}

static int32_t *table(int64_t count) {
  int32_t *t = (int32_t *)malloc((size_t)count * sizeof *t);
  if (!t) exit(72);
  for (int64_t e = 0; e < count; e++) t[e] = (int32_t)pipe_integer();
  return t;
}

static void sparse(void) {
  const int32_t n = (int32_t)pipe_integer(), blocks = (int32_t)pipe_integer();
  int32_t *rowptr = table(n + 1), *col = table(blocks), *diag = table(n);
  smg_real *A = pipe_room(blocks * SMG_BB), *x = pipe_room(n * SMG_BS), *work = pipe_room(smg_sparse_worksize(n));
  int pivots = 0;
  pipe_take(blocks * SMG_BB, A);
  for (int64_t e = 0; e < n * SMG_BS; e++) x[e] = 1;
  smg_real *B = copied(blocks * SMG_BB, A), *y = copied(n * SMG_BS, x);
  smg_real bound = 0;
  for (int32_t row = 0; row < n * SMG_BS; row++) bound = smg_max(bound, smg_sparse_row_sum(rowptr, diag, A, row));
  (void)smg_sparse_solve(n, rowptr, col, diag, A, x, work, &pivots);
  say(bound, smg_sparse_coercive(n, rowptr, col, diag, B, y, work), pivots);
  free(rowptr), free(col), free(diag), free(A), free(B), free(x), free(y), free(work);
}

int main(void) {
  switch (pipe_integer()) {
    case 0: block(); break;
    case 1: band(); break;
    default: sparse(); break;
  }
  return 0;
}
