/* smidgen method: the classical midpoint, W - w = h X((w + W)/2). A comparator: of order 2, not symplectic on
 * spheres. */
#ifndef SMG_CLASSICAL_MIDPOINT_H
#define SMG_CLASSICAL_MIDPOINT_H

#define SMG_BS 3 /* unknowns of Newton a site: mbar itself */
#define SMG_ONTO_LEAF 0

#include "smg_model.h"

/* m = mbar; returns m/mbar = 1. */
static inline smg_real smg_project(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k, SMG_UNUSED smg_real leaf,
                                   const smg_real *mbar, smg_real *m) {
  smg_copy(m, mbar, 3);
  return 1;
}

#include "smg_midpoint.h"

#endif
