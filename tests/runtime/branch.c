/* In: n, count, then count times A (n*n). Out: count times whether A is coercive, the sign of det A, the bound. */
#include "pipe.h"
#include "smg_dense.h"

int main(void) {
  const int64_t n = pipe_integer(), count = pipe_integer();
  smg_real *A = pipe_room(n * n), *copy = pipe_room(n * n);
  for (int64_t c = 0; c < count; c++) {
    pipe_take(n * n, A);
    for (int64_t k = 0; k < n * n; k++) copy[k] = A[k];
    const smg_real bound = smg_dense_bound(n, A);
    const int sign = smg_dense_sign(n, copy);
    pipe_put((double)smg_dense_coercive(n, A));
    pipe_put((double)sign);
    pipe_put((double)bound);
  }
  free(A), free(copy);
  return 0;
}
