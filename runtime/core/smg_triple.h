/* smidgen runtime: three components, of one vector or of one in each lane (smg_number.h). */
#include "smg_small.h"
#include "smg_number.h"

SMG_INLINE SMG_NUMBER SMG_OF(dot)(const SMG_NUMBER *a, const SMG_NUMBER *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c = a x b */
SMG_INLINE void SMG_OF(cross)(SMG_NUMBER *c, const SMG_NUMBER *a, const SMG_NUMBER *b) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Kahan: w + compensation := w + compensation + u, with the rounding error of w kept in compensation. */
SMG_INLINE void SMG_OF(add_compensated)(SMG_NUMBER *w, SMG_NUMBER *compensation, SMG_NUMBER u) {
  const SMG_NUMBER y = u + *compensation, sum = *w + y;
  *compensation = y - (sum - *w);
  *w = sum;
}
