/* smidgen runtime: Newton's matrix of a graph, sparse blocks in the elimination order smg_lattice_site that the
 * generator found; its pattern is smg_rows, smg_columns, smg_diagonal. */
#ifndef SMG_MATRIX_SPARSE_H
#define SMG_MATRIX_SPARSE_H

#include "smg_model.h"
#include "smg_sparse.h"

static inline int64_t smg_block_row(int64_t row) { return smg_block_rows[row]; }

static inline void smg_clear(const smg_state *s) {
  for (int64_t k = 0; k < (int64_t)SMG_BS * SMG_BS * smg_rows[SMG_ORDER]; ++k) s->A[k] = 0;
}

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  const int place = smg_block_rows[row], other = smg_block_rows[column];
  int at = smg_rows[place];
  while (smg_columns[at] != other) ++at;
  for (int k = 0; k < SMG_BS * SMG_BS; ++k) s->A[(int64_t)at * SMG_BS * SMG_BS + k] += block[k];
}

static inline void smg_assembled(const smg_state *s) { (void)s; }

/* s->x = J^-1 s->x; 0, or 1 + the place of a singular pivot. *sign, when asked for: that of det J. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  int pivots = 0;
  const int64_t bad = smg_sparse_solve(SMG_ORDER, smg_rows, smg_columns, smg_diagonal, s->A, s->x, s->work, &pivots);
  if (sign) *sign = pivots < 0 ? -1 : 1;
  return bad;
}

/* The largest row sum of abs(J - I), and that of one site. */
static inline smg_real smg_row_bound(const smg_state *s) {
  return smg_sparse_bound(SMG_ORDER, smg_rows, smg_diagonal, s->A);
}

static inline smg_real smg_site_row_sum(const smg_state *s, int64_t place) {
  smg_real most = 0;
  for (int64_t r = SMG_BS * place; r < SMG_BS * (place + 1); ++r)
    most = smg_max(most, smg_sparse_row_sum(smg_rows, smg_diagonal, s->A, (int32_t)r));
  return most;
}

/* Is x.J x >= x.x/4 for every x? */
static inline int smg_coercive(const smg_state *s) {
  return smg_sparse_coercive(SMG_ORDER, smg_rows, smg_columns, smg_diagonal, s->A, s->x, s->work);
}

/* The matrix for many right-hand sides: a copy, for each destroys it. */
static inline int64_t smg_kept_size(const smg_coefficients *c) {
  (void)c;
  return (int64_t)SMG_BS * SMG_BS * smg_rows[SMG_ORDER];
}

static inline int64_t smg_keep_matrix(smg_state *s, smg_real *keep) {
  for (int64_t k = 0; k < smg_kept_size(&s->c); ++k) keep[k] = s->A[k];
  return 0;
}

static inline int64_t smg_solve_kept(const smg_state *s, const smg_real *keep) {
  for (int64_t k = 0; k < smg_kept_size(&s->c); ++k) s->A[k] = keep[k];
  return smg_factor(s, NULL);
}

#endif
