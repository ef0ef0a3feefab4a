/* smidgen method: the right-hand side of w' = f(t, w) = (1/kappa) grad C(w) x dH/dw, for methods that know no more of
 * the equation. */
#ifndef SMG_RIGHT_SIDE_H
#define SMG_RIGHT_SIDE_H

#include "smg_respond.h"
#include "smg_state.h"

/* k = p f of every site, p the part `size` of h; one that is alone has it in fewer operations. */
#if SMG_HAS_MOTION
static inline void smg_right_side(const smg_coefficients *c, smg_real size, const smg_real *w, smg_real *k) {
  smg_vec_store(k, smg_motion(c, smg_vec_load(w), size));
}
#else
/* (p/kappa) grad C(w) x dH/dw; sums begin at -0, to which compilers know better than to add. */
static inline void smg_right_side(const smg_coefficients *c, smg_real size, const smg_real *SMG_RESTRICT w,
                                  smg_real *SMG_RESTRICT k) {
  const int64_t sites = smg_sites(c);
  for (int64_t q = 0; q < 3 * sites; ++q) k[q] = -(smg_real)0;
  smg_gradient(c, w, k);
  smg_respond_all(c, w, k);
  for (int64_t i = 0; i < sites; ++i) {
    smg_real n[3], f[3];
    smg_normal(c, i, w + 3 * i, n);
    smg_cross(f, n, k + 3 * i);
    smg_multiple(k + 3 * i, smg_h_over_kappa(c, i, c->h * size), f, 3);
  }
}
#endif

#endif
