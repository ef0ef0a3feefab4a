/* In: count, then count times m, scale. Out: count times |m|, m/|m|, how much smaller than scale m is, its frame (6), and
 * the midpoint of a spin m of its own length with g = (1/2, 0, 0) and its status. */
#include "pipe.h"
#include "smg_site.h"
#include "smg_spin.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    const smg_real g[3] = {(smg_real)0.5, 0, 0};
    smg_real m[4], u[3], frame[6], midpoint[3] = {0, 0, 0};
    pipe_take(4, m);
    smg_unit(m, u);
    smg_frame(m, frame, frame + 3);
    pipe_put((double)smg_norm(m));
    pipe_give(3, u);
    pipe_put((double)smg_up(m[3], m));
    pipe_give(6, frame);
    pipe_put((double)smg_own_spin(m, smg_norm(m), g, midpoint));
    pipe_give(3, midpoint);
  }
  return 0;
}
