/* In: n, count, then count times A (n*n) and b (n). Out: count times status, x (n). */
#include "pipe.h"
#include "smg_dense.h"

static int64_t solve(int64_t n, smg_real *A, smg_real *x, int *sign) {
  switch (n) {
    case 2: return smg_dense_solve(2, A, x, sign);
    case 3: return smg_dense_solve(3, A, x, sign);
    case 4: return smg_dense_solve(4, A, x, sign);
    case 6: return smg_dense_solve(6, A, x, sign);
    case 8: return smg_dense_solve(8, A, x, sign);
    case 12: return smg_dense_solve(12, A, x, sign);
    default: return smg_dense_solve(n, A, x, sign);
  }
}

int main(void) {
  const int64_t n = pipe_integer(), count = pipe_integer();
  smg_real *A = pipe_room(n * n), *x = pipe_room(n);
  int sign = 0;
  for (int64_t c = 0; c < count; c++) {
    pipe_take(n * n, A), pipe_take(n, x);
    pipe_put((double)solve(n, A, x, &sign));
    pipe_give(n, x);
  }
  free(A), free(x);
  return 0;
}
