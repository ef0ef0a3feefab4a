/* smidgen runtime: how strong the fields of a state are whose steps go by rows. */
#ifndef SMG_ROW_FIELD_H
#define SMG_ROW_FIELD_H

#include "smg_respond.h"

/* B of site k, at all times: that of sweeps from site to site, unless theirs is for one time. */
#if SMG_ROW_HESSIAN
#define SMG_HESSIAN_EVER smg_row_hessian_norm
#else
#define SMG_HESSIAN_EVER smg_hessian_row_norm
#endif

/* The largest of a bound at all sites, one of each family where all are alike. */
#if SMG_SITE_VALUES || SMG_FAMILIES > 1
static smg_real smg_at_all_sites(const smg_coefficients *c, smg_real (*bound)(const smg_coefficients *c, int64_t k)) {
  smg_real most = 0;
  for (int64_t k = 0; k < smg_sites(c); k += SMG_SITE_VALUES ? 1 : smg_sites(c) / SMG_FAMILIES)
    smg_take(&most, bound(c, k));
  return most;
}
#else
#define smg_at_all_sites(c, bound) bound(c, 0)
#endif

#if SMG_TOLD
/* The largest |f|, |q|, |F0| and |Q0| of a response at all sites. */
typedef struct smg_law_sizes {
  smg_real f, q, F0, Q0;
} smg_law_sizes;

static smg_law_sizes smg_law_sizes_of(const smg_coefficients *c) {
  smg_law_sizes most = {0, 0, 0, 0};
  for (int64_t k = 0; k < (SMG_LAW_BY_SITE ? smg_sites(c) : 1); ++k) {
    smg_real r[SMG_RESPONSE_SIZE];
    smg_law(c, k, r);
    smg_take(&most.f, smg_abs(r[0]));
    smg_take(&most.q, smg_abs(r[1]));
    smg_take(&most.F0, smg_norm(r + SMG_RESPONSE_F0));
    smg_take(&most.Q0, smg_norm(r + SMG_RESPONSE_Q0));
  }
  return most;
}
#endif

/* x^2 (B r + F0)^2, a bound on |g|^2, g = (h/2kappa) dH/dw: x = |h/2kappa|, B a bound on the norms of the Hessian in a
 * row, F0 of the field of no spins. With a response |G|^2 + 2 r |P|: then w - r^2 P has a square of at least
 * r^2 (1 - 2 r |P|), and where the sum is below 1, s is more than r |P| and rho = s + m.P positive
 * (smg_own_response.h). */
static inline smg_real smg_row_field(const smg_coefficients *c, smg_real h) {
  const smg_real x = smg_abs((smg_real)0.5 * smg_h_over_kappa(c, 0, h));
  const smg_real g = x * (smg_at_all_sites(c, SMG_HESSIAN_EVER) * smg_at_all_sites(c, smg_radius) +
                          smg_at_all_sites(c, smg_rest_field_norm));
#if SMG_TOLD
  const smg_law_sizes law = smg_law_sizes_of(c);
  const smg_real G = law.f * g + x * law.F0, P = law.q * g + x * law.Q0;
  return G * G + 2 * smg_at_all_sites(c, smg_radius) * P;
#else
  return g * g;
#endif
}

/* sqrt(f^2 + r^2 q^2): how much m x (f y + q m x y) is larger than r |y|, at most. */
static inline smg_real smg_row_gain(SMG_UNUSED const smg_coefficients *c) {
#if SMG_TOLD
  const smg_law_sizes law = smg_law_sizes_of(c);
  return SMG_MATH(sqrt)(law.f * law.f +
                        smg_at_all_sites(c, smg_radius) * smg_at_all_sites(c, smg_radius) * law.q * law.q);
#else
  return (smg_real)1;
#endif
}

#endif
