/* smidgen method: discrete Moser-Veselov, of the free rigid body: W - w = (h/q) X(mbar), mbar = (w + W)/2,
 * q = (1 + sqrt(1 - h^2 b^2))/2 with b = (1/kappa) dH/dw(mbar). A comparator, symplectic, of order 2. */
#ifndef SMG_MOSER_VESELOV_H
#define SMG_MOSER_VESELOV_H

#define SMG_DIVIDED 1 /* h X is divided by q */

#include "smg_classical_midpoint.h"

/* q, and *root = 2 q - 1; below 0 where there is none. */
static inline smg_real smg_divisor(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *g,
                                   smg_real *root) {
  const smg_real rate = smg_h_over_kappa(c, k, h), square = 1 - rate * rate * smg_dot(g, g);
  *root = 0;
  if (square < 0) return -1;
  *root = SMG_MATH(sqrt)(square);
  return (1 + *root) / 2;
}

/* d(1/q)/dm = (h/kappa)^2 b.B/(2 root q^2), on top of D X; y = B of one column. */
static inline smg_real smg_divisor_slope(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *g,
                                         const smg_real *y, smg_real q, smg_real root) {
  const smg_real rate = smg_h_over_kappa(c, k, h);
  return 0.5 * rate * rate * smg_dot(g, y) / (root * q);
}

#endif
