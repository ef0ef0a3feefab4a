/* In: count, then count times a, b as pairs hi, lo, both in (0, 1).
 * Out, per pair of numbers, each as hi, lo: exp, log, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, floor of
 * a; the same of 9 b - 4 but for log, asin and acos, which stay with b; atan2(a, b - 1/2), a^(9 b - 4). */
#include "pipe.h"
#include "smg_wide_math.h"

static void put(smg_wide a) {
  pipe_put((double)smg_wide_high(a));
  pipe_put((double)smg_wide_low(a));
}

static void functions(smg_wide a, smg_wide part) {
  put(smg_wide_exp(a));
  put(smg_wide_log(part));
  put(smg_wide_sin(a));
  put(smg_wide_cos(a));
  put(smg_wide_tan(a));
  put(smg_wide_asin(part));
  put(smg_wide_acos(part));
  put(smg_wide_atan(a));
  put(smg_wide_sinh(a));
  put(smg_wide_cosh(a));
  put(smg_wide_tanh(a));
  put(smg_wide_floor(a));
}

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real v[4];
    pipe_take(4, v);
    const smg_wide a = smg_wide_pair(v[0], v[1]), b = smg_wide_pair(v[2], v[3]);
    const smg_wide wide = smg_wide_sub(smg_wide_scale(9, b), smg_wide_of(4));
    functions(a, a);
    functions(wide, b);
    put(smg_wide_atan2(a, smg_wide_sub(b, smg_wide_of((smg_real)0.5))));
    put(smg_wide_pow(a, wide));
  }
  /* edges: exp beyond its range on both sides, log 0, tanh far out, floor of a whole number less a hair, (-2)^3, 0^2 */
  put(smg_wide_exp(smg_wide_of(800)));
  put(smg_wide_exp(smg_wide_of(-800)));
  put(smg_wide_log(smg_wide_of(0)));
  put(smg_wide_tanh(smg_wide_of(50)));
  put(smg_wide_tanh(smg_wide_of(-50)));
  put(smg_wide_floor(smg_wide_pair(3, (smg_real)-1e-17)));
  put(smg_wide_pow(smg_wide_of(-2), smg_wide_of(3)));
  put(smg_wide_pow(smg_wide_of(0), smg_wide_of(2)));
  put(smg_wide_atan2(smg_wide_of(0), smg_wide_of(0)));
  return 0;
}
