/* In: n, blocks, rowptr (n+1), col (blocks), diag (n), A (blocks*BS*BS), b (n*BS), in the order
 * of elimination. Out: status, pivots_ok, x (n*BS). */
#include "pipe.h"
#include "smg_sparse.h"

static int32_t *table(int64_t count) {
  int32_t *t = (int32_t *)malloc((size_t)count * sizeof *t);
  if (!t) exit(72);
  for (int64_t e = 0; e < count; e++) t[e] = (int32_t)pipe_integer();
  return t;
}

int main(void) {
  const int64_t n = pipe_integer(), blocks = pipe_integer();
  int32_t *rowptr = table(n + 1), *col = table(blocks), *diag = table(n);
  smg_real *A = pipe_room(blocks * SMG_BB), *x = pipe_room(n * SMG_BS);
  smg_real *work = pipe_room(smg_sparse_worksize(n));
  int ok = -1;
  pipe_take(blocks * SMG_BB, A), pipe_take(n * SMG_BS, x);
  pipe_put((double)smg_sparse_solve((int32_t)n, rowptr, col, diag, A, x, work, &ok));
  pipe_put(ok == 1);
  pipe_give(n * SMG_BS, x);
  free(rowptr), free(col), free(diag), free(A), free(x), free(work);
  return 0;
}
