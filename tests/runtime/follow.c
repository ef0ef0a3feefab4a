/* Curves that are known: the first component goes from w0 to w0 + x with p = (c1 x + c2 x^2 + c3 x^3)/(1 + d x), the
 * first of the second site by half of x, all others stay. Past x = limit no Newton matrix can be factored.
 * In: n, w0, c1, c2, c3, d, limit. Out: status, reached, site, partner, x, half of x. */
#include "pipe.h"
#include "smg_follow.h"

typedef struct known {
  smg_real w0, c1, c2, c3, d, limit;
  int64_t n;
} known;

/* F = p - f(x), J = f'(x) for the first; (x/2) - y3 for the second site; w - y for the others. */
static smg_status newton(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *c, int *sign) {
  const known *k = (const known *)of;
  const smg_real x = y[0] - k->w0, below = 1 + k->d * x, top = ((k->c3 * x + k->c2) * x + k->c1) * x;
  const smg_real slope = ((3 * k->c3 * x + 2 * k->c2) * x + k->c1 - k->d * top / below) / below;
  if (x > k->limit) return SMG_SINGULAR;
  for (int64_t e = 0; e < k->n; e++) {
    a[e] = -y[e];
    c[e] = 0;
  }
  a[0] = (p - top / below) / slope;
  c[0] = 1 / slope;
  a[3] = (x + a[0]) / 2 - y[3];
  c[3] = c[0] / 2;
  *sign = slope < 0 ? -1 : 1;
  return SMG_OK;
}

int main(void) {
  known k;
  smg_curve f;
  k.n = pipe_integer();
  smg_real *w = pipe_room(k.n), *room = pipe_room(5 * k.n);
  pipe_take(1, &k.w0), pipe_take(1, &k.c1), pipe_take(1, &k.c2), pipe_take(1, &k.c3), pipe_take(1, &k.d);
  pipe_take(1, &k.limit);
  for (int64_t e = 0; e < k.n; e++) w[e] = e == 0 ? k.w0 : 0;
  f.of = &k;
  f.newton = newton;
  f.n = k.n;
  f.w = w;
  f.scale = 1;
  f.y = room, f.t = room + k.n, f.a = room + 2 * k.n, f.c = room + 3 * k.n, f.x = room + 4 * k.n;
  pipe_put(smg_follow(&f));
  pipe_put((double)f.reached);
  pipe_put((double)f.site);
  pipe_put((double)f.partner);
  pipe_put((double)(f.y[0] - k.w0));
  pipe_put((double)f.y[3]);
  free(w), free(room);
  return 0;
}
