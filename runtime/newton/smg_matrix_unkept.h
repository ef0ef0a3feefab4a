/* smidgen runtime: a matrix of which nothing is kept between right-hand sides. */
#ifndef SMG_MATRIX_UNKEPT_H
#define SMG_MATRIX_UNKEPT_H

#include "smg_model.h"

static inline int64_t smg_kept_size(const smg_coefficients *c) {
  (void)c;
  return 0;
}

static inline int64_t smg_keep_matrix(smg_state *s, smg_real *keep) {
  (void)s, (void)keep;
  return 0;
}

#endif
