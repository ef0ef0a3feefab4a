/* In: n, k, periodic, count, then count times A (n*(2k+1)*BS*BS) and b (n*BS).
 * Out: count times status, pivots_ok, x (n*BS). */
#include "pipe.h"
#include "smg_band.h"

static int64_t solve(int64_t n, int64_t k, int periodic, const smg_real *A, smg_real *x, smg_real *work,
                     int *ok) {
  switch (k) {
    case 1: return smg_band_solve(n, 1, periodic, A, x, work, ok);
    case 2: return smg_band_solve(n, 2, periodic, A, x, work, ok);
    default: return smg_band_solve(n, (int)k, periodic, A, x, work, ok);
  }
}

int main(void) {
  const int64_t n = pipe_integer(), k = pipe_integer(), periodic = pipe_integer(), count = pipe_integer();
  const int64_t blocks = n * (2 * k + 1) * SMG_BB;
  smg_real *A = pipe_room(blocks), *x = pipe_room(n * SMG_BS);
  smg_real *work = pipe_room(smg_band_worksize(n, (int)k));
  for (int64_t c = 0; c < count; c++) {
    int ok = -1;
    pipe_take(blocks, A), pipe_take(n * SMG_BS, x);
    pipe_put((double)solve(n, k, (int)periodic, A, x, work, &ok));
    pipe_put(ok == 1);
    pipe_give(n * SMG_BS, x);
  }
  free(A), free(x), free(work);
  return 0;
}
