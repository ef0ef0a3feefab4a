/* In: flat, count, then count times w, g, rho of the sweep before. Out: count times rho corrected. */
#include "pipe.h"
#include "smg_row_spin.h"

int main(void) {
  const int flat = (int)pipe_integer();
  const int64_t count = pipe_integer();
  for (int64_t n = 0; n < count; n++) {
    smg_real one[3][3];
    smg_lanes w[3], g[3];
    for (int k = 0; k < 3; k++) pipe_take(3, one[k]);
    for (int k = 0; k < 3; k++) w[k] = one[0][k] + smg_lane_of(0), g[k] = one[1][k] + smg_lane_of(0);
    const smg_lanes rho = smg_lane_corrected_rho(smg_lane_of(1), w, g, smg_lane_of(one[2][0]), 1, 0, flat);
    pipe_put((double)smg_lane_largest(rho));
  }
  return 0;
}
