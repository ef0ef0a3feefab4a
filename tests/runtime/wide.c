/* In: count, then count times a, b as pairs hi, lo; a > 0.
 * Out, per pair of numbers, each as hi, lo: a + b, a - b, a b, a/b, a.hi b, sqrt a, 1/sqrt a, abs b, min, max,
 * the sign of b, a^3, (a, b, b).(b, a, a), the three of (a, b, b) x (b, a, b), and w + compensation with
 * w = a.hi, compensation = a.lo after b is added; then less, equal, and a equal to itself. */
#include "pipe.h"
#include "smg_wide.h"

static void put(smg_wide a) {
  pipe_put((double)smg_wide_high(a));
  pipe_put((double)smg_wide_low(a));
}

static void arithmetic(smg_wide a, smg_wide b) {
  put(smg_wide_add(a, b));
  put(smg_wide_sub(a, b));
  put(smg_wide_mul(a, b));
  put(smg_wide_div(a, b));
  put(smg_wide_scale(smg_wide_high(a), b));
  put(smg_wide_sqrt(a));
  put(smg_wide_rsqrt(a));
  put(smg_wide_fabs(b));
  put(smg_wide_min(a, b));
  put(smg_wide_max(a, b));
  put(smg_wide_sign(b));
  put(smg_wide_power(a, 3));
}

static void vectors(smg_wide a, smg_wide b) {
  const smg_wide u[3] = {a, b, b}, v[3] = {b, a, a}, q[3] = {b, a, b};
  smg_wide c[3];
  put(smg_wide_dot(u, v));
  smg_wide_cross(c, u, q);
  for (int e = 0; e < 3; e++) put(c[e]);
}

static void committed(const smg_real *v) {
  smg_real w = v[0], compensation = v[1], sum[6] = {0};
  smg_wide_commit(&w, &compensation, v[2], v[3]);
  pipe_put((double)w);
  pipe_put((double)compensation);
  smg_wide_into(sum, 1, smg_wide_sum(v[0], v[2]));
  smg_wide_into(sum, 1, smg_wide_of(v[1]));
  put(smg_wide_load(sum, 1));
}

int main(void) {
  const int64_t count = pipe_integer();
  for (int64_t c = 0; c < count; c++) {
    smg_real v[4];
    pipe_take(4, v);
    const smg_wide a = smg_wide_pair(v[0], v[1]), b = smg_wide_pair(v[2], v[3]);
    arithmetic(a, b);
    vectors(a, b);
    committed(v);
    pipe_put(smg_wide_less(a, b));
    pipe_put(smg_wide_equal(a, b));
    pipe_put(smg_wide_equal(a, a));
    put(smg_wide_neg(smg_wide_sqrt(smg_wide_of(0))));
  }
  return 0;
}
