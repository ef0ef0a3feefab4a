/* In: count, then count times w, g. Out: count times status, m. */
#include "pipe.h"
#include "smg_spin.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real w[3], g[3], m[3] = {0, 0, 0};
    pipe_take(3, w), pipe_take(3, g);
    const smg_real r = SMG_MATH(sqrt)(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    pipe_put((double)smg_own_spin(w, r, g, m));
    pipe_give(3, m);
  }
  return 0;
}
