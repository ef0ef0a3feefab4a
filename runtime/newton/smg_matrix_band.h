/* smidgen runtime: Newton's matrix of a chain, a band of blocks, SMG_BAND on either side; SMG_CYCLIC where the chain
 * closes. */
#ifndef SMG_MATRIX_BAND_H
#define SMG_MATRIX_BAND_H

#include "smg_band.h"
#include "smg_matrix_unkept.h"
#include "smg_model.h"

static inline int64_t smg_block_row(int64_t row) { return row; }

static inline void smg_clear(const smg_state *s) {
  const int64_t size = SMG_BS * SMG_BS * (2 * SMG_BAND + 1) * smg_coupled(&s->c);
  for (int64_t k = 0; k < size; ++k) s->A[k] = 0;
}

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  int64_t d = column - row;
  if (SMG_CYCLIC && d > SMG_BAND) d -= smg_coupled(&s->c);
  if (SMG_CYCLIC && d < -SMG_BAND) d += smg_coupled(&s->c);
  smg_real *at = s->A + (row * (2 * SMG_BAND + 1) + d + SMG_BAND) * SMG_BS * SMG_BS;
  for (int k = 0; k < SMG_BS * SMG_BS; ++k) at[k] += block[k];
}

static inline void smg_assembled(const smg_state *s) { (void)s; }

/* s->x = J^-1 s->x; 0, or 1 + the place of a singular pivot. *sign, when asked for: that of det J. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  int pivots = 0;
  const int64_t bad = smg_band_solve(smg_coupled(&s->c), SMG_BAND, SMG_CYCLIC, s->A, s->x, s->work, &pivots);
  if (sign) *sign = pivots < 0 ? -1 : 1;
  return bad;
}

/* The largest row sum of abs(J - I), and that of one site. */
static inline smg_real smg_row_bound(const smg_state *s) { return smg_band_bound(smg_coupled(&s->c), SMG_BAND, s->A); }

static inline smg_real smg_site_row_sum(const smg_state *s, int64_t place) {
  smg_real most = 0;
  for (int64_t r = SMG_BS * place; r < SMG_BS * (place + 1); ++r)
    most = smg_max(most, smg_band_row_sum(SMG_BAND, s->A, r));
  return most;
}

/* Is x.J x >= x.x/4 for every x? */
static inline int smg_coercive(const smg_state *s) {
  return smg_band_coercive(smg_coupled(&s->c), SMG_BAND, SMG_CYCLIC, s->A, s->x, s->work);
}

/* The matrix for many right-hand sides: each factors it anew, and leaves it as it is. */
static inline int64_t smg_solve_kept(const smg_state *s, const smg_real *keep) {
  (void)keep;
  return smg_factor(s, NULL);
}

#endif
