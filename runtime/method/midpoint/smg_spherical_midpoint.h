/* smidgen method: the spherical midpoint, W - w = h X(m) with m = P(mbar), mbar = (w + W)/2.
 *
 * P puts mbar onto the leaf of w: onto the sphere of its radius, in R^3 onto the sphere through w, of a Nambu factor
 * onto C = C(w). Symplectic, of order 2. McLachlan, Modin and Verdier, "A minimal-variable symplectic integrator on
 * spheres". */
#ifndef SMG_SPHERICAL_MIDPOINT_H
#define SMG_SPHERICAL_MIDPOINT_H

#define SMG_BS 2        /* unknowns of Newton a site: coordinates in the tangent plane of its leaf */
#define SMG_ONTO_LEAF 1 /* P is a projection, along mbar */

#include "smg_leaf.h"

/* m = s mbar on the leaf; returns s. */
static inline smg_real smg_project(const smg_coefficients *c, int64_t k, smg_real leaf, const smg_real *mbar,
                                   smg_real *m) {
  smg_real s;
  if (smg_kind(c, k) == SMG_NAMBU) s = SMG_MATH(sqrt)(leaf / smg_casimir(c, k, mbar));
  else if (smg_kind(c, k) == SMG_R3) {
    const smg_real rho = smg_norm(mbar);
    s = rho > 0 ? leaf / rho : 0;
  } else {
    const smg_real rho2 = smg_dot(mbar, mbar);
    s = rho2 > 0 ? leaf / SMG_MATH(sqrt)(rho2) : 0;
  }
  smg_multiple(m, s, mbar, 3);
  return s;
}

#include "smg_midpoint.h"

#endif
