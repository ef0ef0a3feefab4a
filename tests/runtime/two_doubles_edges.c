/* Pairs of doubles beyond the numbers. In: a, b. Out: log a, a^b, atan2(a, b), the series of sin at a. */
#define SMG_DOUBLE_DOUBLE
#include "pipe.h"
#include "smg_wide_math.h"

int main(void) {
  const smg_wide a = smg_wide_of((smg_real)pipe_number()), b = smg_wide_of((smg_real)pipe_number());
  pipe_put((double)smg_wide_high(smg_wide_log(a)));
  pipe_put((double)smg_wide_high(smg_wide_pow(a, b)));
  pipe_put((double)smg_wide_high(smg_wide_atan2(a, b)));
  pipe_put((double)smg_wide_high(smg_wide_series(a, 1, 2, -1)));
  return 0;
}
