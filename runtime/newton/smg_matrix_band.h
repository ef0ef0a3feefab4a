/* smidgen runtime: Newton's matrix of a chain, a band of blocks, SMG_BAND on either side; SMG_CYCLIC where the chain
 * closes. */
#ifndef SMG_MATRIX_BAND_H
#define SMG_MATRIX_BAND_H

#include "smg_band.h"
#include "smg_matrix_unkept.h"
#include "smg_model.h"

static inline void smg_clear(const smg_state *s) { smg_zero(s->A, SMG_BB * (2 * SMG_BAND + 1) * smg_coupled(&s->c)); }

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  int64_t d = column - row;
  if (SMG_CYCLIC && d > SMG_BAND) d -= smg_coupled(&s->c);
  if (SMG_CYCLIC && d < -SMG_BAND) d += smg_coupled(&s->c);
  smg_block_add(s->A + (row * (2 * SMG_BAND + 1) + d + SMG_BAND) * SMG_BB, block);
}

/* s->x = J^-1 s->x; 0, or 1 + the place of a singular pivot. *sign: that of det J. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  return smg_band_solve(smg_coupled(&s->c), SMG_BAND, SMG_CYCLIC, s->A, s->x, s->work, sign);
}

/* The sum of abs(J - I) over a row. */
static inline smg_real smg_row_sum(const smg_state *s, int64_t row) { return smg_band_row_sum(SMG_BAND, s->A, row); }

/* Is x.J x >= x.x/4 for every x? */
static inline int smg_coercive(const smg_state *s) {
  return smg_band_coercive(smg_coupled(&s->c), SMG_BAND, SMG_CYCLIC, s->A, s->x, s->work);
}

/* The matrix for many right-hand sides: each factors it anew, and leaves it as it is. */
static inline int64_t smg_solve_kept(const smg_state *s, SMG_UNUSED const smg_real *keep) {
  int sign;
  return smg_factor(s, &sign);
}

#endif
