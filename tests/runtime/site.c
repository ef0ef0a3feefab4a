/* In: count, then count times a, b, then as many integers x, n.
 * Out: the lengths of the messages of the statuses -1 .. 9; per pair: min, max, the largest of (a, b, a), the
 * change after a and then b of sizes 1 and 2 (relative, absolute), settled after it, the sum and compensation of a + b,
 * and what has taken in a and then b;
 * per pair of integers: wrap, remainder, quotient. */
#include <string.h>

#include "pipe.h"
#include "smg_site.h"

static void pair(smg_real a, smg_real b) {
  const smg_real three[3] = {a, b, a};
  smg_change change = {0, 0, 0}, last = {1, 1, 0};
  smg_real w = a, compensation = 0, most = a;
  pipe_put((double)smg_min(a, b));
  pipe_put((double)smg_max(a, b));
  pipe_put((double)smg_largest(three));
  smg_change_add(&change, a, 1, 1);
  smg_change_add(&change, b, 2, 1);
  pipe_put((double)change.relative);
  pipe_put((double)change.absolute);
  pipe_put(smg_settled(&change, &last, 1));
  smg_add_compensated(&w, &compensation, b);
  pipe_put((double)w);
  pipe_put((double)compensation);
  smg_take(&most, b);
  pipe_put((double)most);
}

int main(void) {
  const int64_t count = pipe_integer();
  for (int k = -1; k < 10; k++) pipe_put((double)strlen(smg_message((smg_status)k)));
  for (int64_t c = 0; c < count; c++) {
    smg_real v[2];
    pipe_take(2, v);
    pair(v[0], v[1]);
  }
  for (int64_t c = 0; c < count; c++) {
    const int64_t x = pipe_integer(), n = pipe_integer();
    pipe_put((double)smg_wrap(x, n));
    pipe_put((double)smg_mod(x, n));
    pipe_put((double)smg_quotient(x, n));
  }
  return 0;
}
