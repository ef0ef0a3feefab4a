/* A curve followed with a Newton correction that is not quite one: the first component goes by s p + b p^2 from 1, all
 * others stay at 1; each correction takes the part `part` of the way, and the sign of det J is said to be `sign`.
 * In: n, s, b, part, sign. Out: status, reached, how far the first component went. */
#include "pipe.h"
#include "smg_follow.h"

typedef struct bent {
  smg_real s, b, part;
  int64_t n;
  int sign;
} bent;

static smg_status newton(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *c, int *sign) {
  const bent *k = (const bent *)of;
  for (int64_t e = 0; e < k->n; e++) {
    a[e] = k->part * (1 - y[e]);
    c[e] = 0;
  }
  a[0] += k->part * (k->s * p + k->b * p * p);
  c[0] = k->s + 2 * k->b * p;
  *sign = k->sign;
  return SMG_OK;
}

int main(void) {
  bent k;
  smg_curve f;
  k.n = pipe_integer();
  pipe_take(1, &k.s), pipe_take(1, &k.b), pipe_take(1, &k.part);
  k.sign = (int)pipe_integer();
  smg_real *room = pipe_room(6 * k.n);
  for (int64_t e = 0; e < k.n; e++) room[e] = 1;
  smg_begin_curve(&f, &k, newton, NULL, k.n, room, 1, room + k.n);
  pipe_put(smg_follow(&f));
  pipe_put((double)f.reached);
  pipe_put((double)(f.y[0] - 1));
  free(room);
  return 0;
}
