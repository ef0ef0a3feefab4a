/* smidgen runtime: a matrix of which nothing is kept between right-hand sides. */
#ifndef SMG_MATRIX_UNKEPT_H
#define SMG_MATRIX_UNKEPT_H

#include "smg_model.h"

static inline int64_t smg_kept_size(SMG_UNUSED const smg_coefficients *c) { return 0; }

static inline int64_t smg_keep_matrix(SMG_UNUSED smg_state *s, SMG_UNUSED smg_real *keep) { return 0; }

#endif
