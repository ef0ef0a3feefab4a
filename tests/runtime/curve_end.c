/* In: count, then count times y, t, radius, q, p. Out: count times the status of a curve of one site that ends there. */
#include "pipe.h"
#include "smg_follow.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real v[9], w[3] = {0, 0, 0};
    smg_curve f = {0};
    pipe_take(9, v);
    w[2] = v[6];
    f.n = 3, f.w = w, f.y = v, f.t = v + 3, f.q = v[7], f.p = v[8], f.scale = v[6], f.span = 4;
    pipe_put(smg_curve_end(&f));
  }
  return 0;
}
