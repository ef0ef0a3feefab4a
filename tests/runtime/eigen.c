/* In: n, count, then count times A (n*n). Out: count times the verdict. */
#include "pipe.h"
#include "smg_eigen.h"

int main(void) {
  const int64_t n = pipe_integer(), count = pipe_integer();
  smg_real *A = pipe_room(n * n), *work = pipe_room(n * n);
  for (int64_t c = 0; c < count; c++) {
    pipe_take(n * n, A);
    pipe_put((double)smg_dense_positive(n, A, work));
  }
  free(A), free(work);
  return 0;
}
