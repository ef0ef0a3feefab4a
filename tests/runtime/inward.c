/* In: count, then count times y, t, radius. Out: count times whether the midpoint y runs into the centre along t. */
#include "pipe.h"
#include "smg_follow.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real v[7];
    pipe_take(7, v);
    pipe_put(smg_curve_inward(v, v + 3, v[6]));
  }
  return 0;
}
