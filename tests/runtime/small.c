/* In: count, then count times A (9 numbers). Out: count times det A and the size of its terms, of the 3 x 3 matrix A and of the 2 x 2
 * matrix of its first four numbers. */
#include "pipe.h"
#include "smg_small.h"

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real A[9];
    pipe_take(9, A);
    pipe_put((double)smg_det3(A));
    pipe_put((double)smg_scale3(A));
    pipe_put((double)(A[0] * A[3] - A[1] * A[2]));
    pipe_put((double)smg_scale2(A));
  }
  return 0;
}
