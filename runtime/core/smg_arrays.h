/* smidgen runtime: arrays of n numbers. */
#ifndef SMG_ARRAYS_H
#define SMG_ARRAYS_H

#include "smg_small.h"

SMG_INLINE void smg_copy(smg_real *to, const smg_real *from, int64_t n) {
  for (int64_t k = 0; k < n; ++k) to[k] = from[k];
}

SMG_INLINE void smg_zero(smg_real *y, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] = 0;
}

SMG_INLINE void smg_scale(smg_real *y, smg_real a, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] *= a;
}

/* y += a x. */
SMG_INLINE void smg_axpy(smg_real *y, smg_real a, const smg_real *x, int64_t n) {
  for (int64_t k = 0; k < n; ++k) y[k] += a * x[k];
}

/* The largest size, and NaN where there is one. */
SMG_INLINE smg_real smg_most(const smg_real *y, int64_t n) {
  smg_real most = 0;
  for (int64_t k = 0; k < n; ++k) most = smg_max(most, smg_abs(y[k]));
  return most;
}

#endif
