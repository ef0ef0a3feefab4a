/* smidgen runtime: Newton's matrix, dense. */
#ifndef SMG_MATRIX_DENSE_H
#define SMG_MATRIX_DENSE_H

#include "smg_dense.h"
#include "smg_model.h"

static inline int64_t smg_order(const smg_state *s) { return SMG_BS * smg_coupled(&s->c); }

static inline void smg_clear(const smg_state *s) { smg_zero(s->A, smg_order(s) * smg_order(s)); }

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  smg_real *at = s->A + SMG_BS * (row * smg_order(s) + column);
  for (int r = 0; r < SMG_BS; ++r) smg_axpy(at + r * smg_order(s), 1, block + SMG_BS * r, SMG_BS);
}

/* s->x = J^-1 s->x; 0, or 1 + the place of a singular pivot. *sign: that of det J. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  const int64_t bad = smg_dense_solve(smg_order(s), s->A, s->x, sign);
  return bad > 0 ? 1 + (bad - 1) / SMG_BS : 0;
}

/* The sum of abs(J - I) over a row. */
static inline smg_real smg_row_sum(const smg_state *s, int64_t row) {
  return smg_dense_row_sum(smg_order(s), s->A, row);
}

/* Is x.J x >= x.x/4 for every x? */
static inline int smg_coercive(const smg_state *s) { return smg_dense_coercive(smg_order(s), s->A); }

/* The matrix for many right-hand sides: factored, `keep` its permutation of the rows; 0, or 1 + a singular place. */
static inline int64_t smg_kept_size(const smg_coefficients *c) { return SMG_BS * smg_coupled(c); }

static inline int64_t smg_keep_matrix(smg_state *s, smg_real *keep) {
  int sign;
  for (int64_t k = 0; k < smg_order(s); ++k) keep[k] = (smg_real)k;
  const int64_t bad = smg_dense_factor(smg_order(s), s->A, keep, &sign);
  return bad > 0 ? 1 + (bad - 1) / SMG_BS : 0;
}

static inline int64_t smg_solve_kept(const smg_state *s, const smg_real *keep) {
  const int64_t order = smg_order(s);
  smg_copy(s->work, s->x, order);
  for (int64_t k = 0; k < order; ++k) s->x[k] = s->work[(int64_t)keep[k]];
  smg_dense_substitute(order, s->A, s->x);
  return 0;
}

#endif
