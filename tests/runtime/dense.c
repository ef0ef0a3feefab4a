/* In: n, count, then count times A (n*n) and b (n). Out: count times status, x (n). */
#include "pipe.h"
#include "smg_dense.h"

static int64_t solve(int64_t n, smg_real *A, smg_real *x) {
  switch (n) {
    case 2: return smg_dense_solve(2, A, x);
    case 3: return smg_dense_solve(3, A, x);
    case 4: return smg_dense_solve(4, A, x);
    case 6: return smg_dense_solve(6, A, x);
    case 8: return smg_dense_solve(8, A, x);
    case 12: return smg_dense_solve(12, A, x);
    default: return smg_dense_solve(n, A, x);
  }
}

int main(void) {
  const int64_t n = pipe_integer(), count = pipe_integer();
  smg_real *A = pipe_room(n * n), *x = pipe_room(n);
  for (int64_t c = 0; c < count; c++) {
    pipe_take(n * n, A), pipe_take(n, x);
    pipe_put((double)solve(n, A, x));
    pipe_give(n, x);
  }
  free(A), free(x);
  return 0;
}
