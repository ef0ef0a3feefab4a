/* In: count, then count times m, n. Out: count times the frame of m (6), the leaf frame at m with
 * normal n (6) and its dual (6). */
#include "pipe.h"
#include "smg_site.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real m[3], n[3], frame[6], E[6], F[6];
    pipe_take(3, m), pipe_take(3, n);
    smg_frame(m, frame, frame + 3);
    smg_leaf_frame(m, n, E, F);
    pipe_give(6, frame), pipe_give(6, E), pipe_give(6, F);
  }
  return 0;
}
