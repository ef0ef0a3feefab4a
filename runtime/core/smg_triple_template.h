/* smidgen runtime: three components, products of vectors, and the compensated sum; a template (smg_template.h). */
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

/* Kahan: w + compensation := w + compensation + u, with the rounding error of w kept in compensation. */
SMG_INLINE void smg_add_compensated(smg_number *w, smg_number *compensation, smg_number u) {
  const smg_number y = u + *compensation, sum = *w + y;
  *compensation = y - (sum - *w);
  *w = sum;
}
