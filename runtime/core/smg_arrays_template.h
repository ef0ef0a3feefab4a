/* smidgen runtime: arrays of n numbers; a template (smg_template.h). */
#include "smg_template.h"

SMG_INLINE void smg_copy(smg_number *to, const smg_number *from, int64_t n) {
  for (int64_t k = 0; k < n; ++k) to[k] = from[k];
}

SMG_INLINE void smg_zero(smg_number *y, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] = smg_of(0);
}

/* y *= a. */
SMG_INLINE void smg_scale(smg_number *y, smg_number a, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] *= a;
}

/* y /= a. */
SMG_INLINE void smg_divide(smg_number *y, smg_number a, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] /= a;
}

/* y = a x. */
SMG_INLINE void smg_multiple(smg_number *y, smg_number a, const smg_number *x, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] = a * x[k];
}

/* y += a x. */
SMG_INLINE void smg_axpy(smg_number *y, smg_number a, const smg_number *x, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] += a * x[k];
}

/* w = a x + y. */
SMG_INLINE void smg_waxpy(smg_number *w, smg_number a, const smg_number *x, const smg_number *y, int64_t n) {
  for (int64_t k = 0; k < n; ++k) w[k] = a * x[k] + y[k];
}

/* v = a where the test holds, else b. */
SMG_INLINE void smg_choose(smg_number *v, smg_test test, const smg_number *a, const smg_number *b, int64_t n) {
  for (int64_t k = 0; k < n; ++k) v[k] = smg_select(test, a[k], b[k]);
}
