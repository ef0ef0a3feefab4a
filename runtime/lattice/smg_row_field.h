/* smidgen runtime: how strong the fields of a state are whose steps go by rows. */
#ifndef SMG_ROW_FIELD_H
#define SMG_ROW_FIELD_H

#include "smg_model.h"

/* x^2 (B r + F0)^2, a bound on |g|^2, g = (h/2kappa) dH/dw: x = |h/2kappa|, B a bound on the norms of the Hessian in a
 * row, F0 of the field of no spins. */
static inline smg_real smg_row_field(const smg_coefficients *c, smg_real h) {
  const smg_real g = smg_abs((smg_real)0.5 * smg_h_over_kappa(c, 0, h)) *
                     (smg_hessian_row_norm(c, 0) * smg_radius(c, 0) + smg_rest_field_norm(c, 0));
  return g * g;
}

#endif
