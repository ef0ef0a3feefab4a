/* smidgen runtime: three components, products of vectors, turns, the compensated sum; a template (smg_template.h). */
#include "smg_template.h"

SMG_INLINE smg_number smg_dot(const smg_number *a, const smg_number *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c = a x b */
SMG_INLINE void smg_cross(smg_number *c, const smg_number *a, const smg_number *b) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* u = W - w of w turned by the quaternion (q, g), about g by the angle whose half has the tangent |g|/q:
 *     W = w + 2/(q^2 + |g|^2) (q w x g + (w x g) x g). */
SMG_INLINE void smg_turn_increment(smg_number q, const smg_number *g, const smg_number *w, smg_number *u) {
  const smg_number scale = 2 / (q * q + smg_dot(g, g));
  smg_number x[3];
  smg_cross(x, w, g);
  smg_cross(u, x, g);
  for (int b = 0; b < 3; ++b) u[b] = scale * (q * x[b] + u[b]);
}

/* Kahan: w + compensation := w + compensation + u, with the rounding error of w kept in compensation. */
SMG_INLINE void smg_add_compensated(smg_number *w, smg_number *compensation, smg_number u) {
  const smg_number y = u + *compensation, sum = *w + y;
  *compensation = y - (sum - *w);
  *w = sum;
}
