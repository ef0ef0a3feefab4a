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

/* The vectors of such a method: by slots of a lattice, or of 3 numbers a site. */
#if SMG_ROW_FIELDS
#include "smg_field_rows.h"
#else
SMG_INLINE int64_t smg_numbers(const smg_state *s) { return 3 * smg_sites(&s->c); }
SMG_INLINE smg_real *smg_vector_of(const smg_state *s, smg_real *array, int64_t i) {
  return array + i * smg_numbers(s);
}
SMG_INLINE smg_real *smg_spins(const smg_state *s) { return s->w; }
SMG_INLINE smg_real *smg_spins_lost(const smg_state *s) { return s->compensation; }
SMG_INLINE void smg_slopes_at(smg_state *s, smg_real size, const smg_real *w, smg_real *k) {
  smg_right_side(&s->c, size, w, k);
}

/* The first site with numbers of a vector that are none, or -1. */
static inline int64_t smg_lost_in(const smg_state *s, const smg_real *v) {
  for (int64_t q = 0; q < smg_numbers(s); ++q)
    if (!(smg_abs(v[q]) <= SMG_MAX)) return q / 3;
  return -1;
}
#endif

#endif
