/* In: n, count, then count times A (n*n). Out: count times whether A is coercive, the sign of det A, the largest row sum of abs(A - I). */
#include "pipe.h"
#include "smg_dense.h"

int main(void) {
  const int64_t n = pipe_integer(), count = pipe_integer();
  smg_real *A = pipe_room(n * n), *copy = pipe_room(n * n), *x = pipe_room(n);
  for (int64_t c = 0; c < count; c++) {
    pipe_take(n * n, A);
    for (int64_t k = 0; k < n * n; k++) copy[k] = A[k];
    smg_real bound = 0;
    int sign = 0;
    for (int64_t k = 0; k < n; k++) bound = smg_max(bound, smg_dense_row_sum(n, A, k)), x[k] = 1;
    (void)smg_dense_solve(n, copy, x, &sign);
    pipe_put((double)smg_dense_coercive(n, A));
    pipe_put((double)sign);
    pipe_put((double)bound);
  }
  free(A), free(copy), free(x);
  return 0;
}
