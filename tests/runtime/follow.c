/* Curves that are known: one component goes from w0 to w0 + s x, s = 1 or -1, with p = (c1 x + c2 x^2 + c3 x^3)/(1 + d x),
 * the one three places before or after by half of that, from 1; all others stay, at 0 in
 * the site of the first, else at 1, and Newton writes nothing of sites beyond the second. Past x = limit no Newton matrix can be factored. In: n, the component, s, w0, c1, c2, c3, d, limit. Out: status, reached, site, partner, s x, and how
 * far the other went. */
#include "pipe.h"
#include "smg_follow.h"

typedef struct known {
  smg_real w0, c1, c2, c3, d, limit;
  int64_t n, own, other;
  int side;
} known;

static smg_real rest(const known *k, int64_t e) { return e / 3 == k->own / 3 ? 0 : 1; }

/* s F = p - f(x), J = f'(x) for the one; F = 1 + s x/2 - y for the other, and they stay. */
static smg_status newton(void *of, smg_real p, const smg_real *y, smg_real *a, smg_real *c, int *sign) {
  const known *k = (const known *)of;
  const smg_real x = (smg_real)k->side * (y[k->own] - k->w0), below = 1 + k->d * x, top = ((k->c3 * x + k->c2) * x + k->c1) * x;
  const smg_real slope = ((3 * k->c3 * x + 2 * k->c2) * x + k->c1 - k->d * top / below) / below;
  if (x > k->limit) return SMG_SINGULAR;
  for (int64_t e = 0; e < 6; e++) {
    a[e] = rest(k, e) - y[e];
    c[e] = 0;
  }
  a[k->own] = (smg_real)k->side * (p - top / below) / slope;
  c[k->own] = (smg_real)k->side / slope;
  a[k->other] = 1 + ((smg_real)k->side * x + a[k->own]) / 2 - y[k->other];
  c[k->other] = c[k->own] / 2;
  *sign = slope < 0 ? -1 : 1;
  return SMG_OK;
}

int main(void) {
  known k;
  smg_curve f;
  k.n = pipe_integer(), k.own = pipe_integer(), k.side = (int)pipe_integer();
  k.other = k.own < 3 ? k.own + 3 : k.own - 3;
  smg_real *w = pipe_room(k.n), *room = pipe_room(5 * k.n);
  pipe_take(1, &k.w0), pipe_take(1, &k.c1), pipe_take(1, &k.c2), pipe_take(1, &k.c3), pipe_take(1, &k.d);
  pipe_take(1, &k.limit);
  for (int64_t e = 0; e < 5 * k.n; e++) room[e] = 7; /* as steps before may leave it */
  for (int64_t e = 0; e < k.n; e++) w[e] = e == k.own ? k.w0 : rest(&k, e);
  smg_begin_curve(&f, &k, newton, NULL, k.n, w, 1, room);
  pipe_put(smg_follow(&f));
  pipe_put((double)f.reached);
  pipe_put((double)f.site);
  pipe_put((double)f.partner);
  pipe_put((double)(f.y[k.own] - k.w0));
  pipe_put((double)(f.y[k.other] - 1));
  free(w), free(room);
  return 0;
}
