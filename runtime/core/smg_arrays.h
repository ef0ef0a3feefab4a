/* smidgen runtime: arrays of n numbers. */
#ifndef SMG_ARRAYS_H
#define SMG_ARRAYS_H

#include "smg_arrays_template.h"

/* The largest size, and NaN where there is one. */
SMG_INLINE smg_real smg_most(const smg_real *y, int64_t n) {
  smg_real most = 0;
  for (int64_t k = 0; k < n; ++k) most = smg_max(most, smg_abs(y[k]));
  return most;
}

#endif
