/* smidgen runtime: Newton's matrix of a graph, sparse blocks in the elimination order smg_block_rows that the
 * generator found; its pattern is smg_rows, smg_columns, smg_diagonal. */
#ifndef SMG_MATRIX_SPARSE_H
#define SMG_MATRIX_SPARSE_H

#include "smg_model.h"
#include "smg_sparse.h"

static inline int64_t smg_kept_size(SMG_UNUSED const smg_coefficients *c) {
  return (int64_t)SMG_BB * smg_rows[SMG_ORDER];
}

static inline void smg_clear(const smg_state *s) { smg_zero(s->A, smg_kept_size(&s->c)); }

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  smg_block_add(s->A + smg_sparse_position(smg_rows, smg_columns, smg_block_rows[row], smg_block_rows[column]), block);
}

/* s->x = J^-1 s->x; 0, or 1 + the place of a singular pivot. *sign: that of det J. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  return smg_sparse_solve(SMG_ORDER, smg_rows, smg_columns, smg_diagonal, s->A, s->x, s->work, sign);
}

/* The sum of abs(J - I) over a row. */
static inline smg_real smg_row_sum(const smg_state *s, int64_t row) {
  return smg_sparse_row_sum(smg_rows, smg_diagonal, s->A, (int32_t)row);
}

/* Is x.J x >= x.x/4 for every x? */
static inline int smg_coercive(const smg_state *s) {
  return smg_sparse_coercive(SMG_ORDER, smg_rows, smg_columns, smg_diagonal, s->A, s->x, s->work);
}

/* The matrix for many right-hand sides: a copy, for each destroys it. */
static inline int64_t smg_keep_matrix(smg_state *s, smg_real *keep) {
  smg_copy(keep, s->A, smg_kept_size(&s->c));
  return 0;
}

static inline int64_t smg_solve_kept(const smg_state *s, const smg_real *keep) {
  int sign;
  smg_copy(s->A, keep, smg_kept_size(&s->c));
  return smg_factor(s, &sign);
}

#endif
