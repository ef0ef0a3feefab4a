/* smidgen method: the last evaluation of a midpoint step in extended precision (double-double).
 *
 * The model adds smg_wide_prepare(wide, c) and smg_wide_set_time(s), its coefficients to all digits;
 * smg_wide_h_over_kappa(c, wide, k) = h/kappa, smg_wide_radius(c, wide, k), smg_wide_normal(c, wide, k, v, n);
 * smg_wide_gradient(s), s->wide_g += dH/dw at s->wide_m; and smg_wide_hessian_vector(s), s->wide_y += d2H/dw2 s->wide_d
 * in double. */
#ifndef SMG_EXTENDED_H
#define SMG_EXTENDED_H

#include "smg_respond.h"
#include "smg_wide.h"

#define SMG_WIDE_TERMS 40
#define SMG_WIDE_SMALL (SMG_EPS / 16777216) /* 2^-24: a leftover, all of one sign, that 1e8 steps do not show */

/* s of m = P(mbar) = s mbar. */
static inline smg_wide smg_wide_scale_of(SMG_UNUSED const smg_state *s, SMG_UNUSED int64_t k,
                                         SMG_UNUSED const smg_wide *w, SMG_UNUSED const smg_wide *mbar) {
#if SMG_ONTO_LEAF
  const smg_coefficients *c = &s->c;
  const smg_wide_coefficients *wide = &s->wide;
  if (smg_kind(c, k) == SMG_NAMBU) {
    smg_wide n[3], N[3];
    smg_wide_normal(c, wide, k, w, n);
    smg_wide_normal(c, wide, k, mbar, N);
    return smg_wide_sqrt(smg_wide_div(smg_wide_dot(w, n), smg_wide_dot(mbar, N)));
  }
  const smg_wide square = smg_wide_dot(mbar, mbar);
  if (smg_kind(c, k) == SMG_R3) /* the square is 0 only at w = 0, which stays */
    return smg_wide_high(square) > 0 ? smg_wide_sqrt(smg_wide_div(smg_wide_dot(w, w), square)) : smg_wide_of(0);
#if SMG_UNIT_RADIUS
  return smg_wide_rsqrt(square);
#else
  return smg_wide_mul(smg_wide_radius(c, wide, k), smg_wide_rsqrt(square));
#endif
#else
  return smg_wide_of(1);
#endif
}

/* m = P(mbar), mbar = w + compensation + u/2, of one site. */
static inline void smg_wide_midpoint(smg_state *s, int64_t k) {
  smg_wide w[3], mbar[3];
  for (int b = 0; b < 3; ++b) {
    w[b] = smg_wide_sum(s->w[3 * k + b], s->compensation[3 * k + b]);
    mbar[b] = smg_wide_add(w[b], smg_wide_of(0.5 * s->u[3 * k + b]));
  }
  const smg_wide scale = smg_wide_scale_of(s, k, w, mbar);
#if !SMG_SINGLE_SPHERE
  s->wide_s[k] = smg_wide_high(scale);
#endif
  for (int b = 0; b < 3; ++b) {
    smg_wide_store(s->wide_m + 6 * k, b, smg_wide_mul(scale, mbar[b]));
    smg_wide_store(s->wide_g + 6 * k, b, smg_wide_of(0));
  }
}

/* v = h X(m) = (h/kappa) grad C(m) x g, and what u lacks of it. */
static inline void smg_wide_increment(smg_state *s, int64_t k) {
  const smg_wide_coefficients *wide = &s->wide;
  smg_wide m[3], g[3], n[3], u[3], rate = smg_wide_h_over_kappa(&s->c, wide, k);
  for (int b = 0; b < 3; ++b) {
    m[b] = smg_wide_load(s->wide_m + 6 * k, b);
    g[b] = smg_wide_load(s->wide_g + 6 * k, b);
  }
  smg_wide_normal(&s->c, wide, k, m, n);
#if SMG_DIVIDED
  const smg_wide square = smg_wide_sub(smg_wide_of(1), smg_wide_mul(smg_wide_mul(rate, rate), smg_wide_dot(g, g)));
  /* q = (1 + sqrt)/2 */
  rate = smg_wide_div(smg_wide_scale(2, rate), smg_wide_add(smg_wide_of(1), smg_wide_sqrt(square)));
#endif
  smg_wide_cross(u, n, g);
  for (int b = 0; b < 3; ++b) {
    u[b] = smg_wide_mul(rate, u[b]);
    smg_wide_store(s->wide_v + 6 * k, b, u[b]);
    s->wide_d[3 * k + b] = smg_wide_high(smg_wide_sub(u[b], smg_wide_of(s->u[3 * k + b])));
  }
}

/* v = h X(m) of all sites at m = P(w + compensation + u/2), and d = v - u. */
static void smg_wide_evaluate(smg_state *s) {
#if SMG_WIDE_TIMED
  smg_wide_set_time(s);
#endif
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_wide_midpoint(s, k);
  smg_wide_gradient(s);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_wide_increment(s, k);
}

/* v += e. Where v is not finite, for a product on the way overflowed, u stays as it is. */
static void smg_wide_take(smg_state *s) {
  const int64_t sites = smg_sites(&s->c);
  smg_real sum = 0;
  for (int64_t k = 0; k < 6 * sites; ++k) sum += 0 * s->wide_v[k];
  for (int64_t k = 0; k < sites; ++k)
    for (int b = 0; b < 3; ++b) {
      const smg_wide v = smg_wide_add(smg_wide_load(s->wide_v + 6 * k, b), smg_wide_of(s->wide_e[3 * k + b]));
      s->low[3 * k + b] = sum == 0 ? smg_wide_low(v) : 0;
      if (sum == 0) s->u[3 * k + b] = smg_wide_high(v);
    }
}

#if !SMG_SINGLE_SPHERE
/* d <- the change of m that goes with the change d of u: d P(mbar) d/2 = (s/2) (d - m (n.d)/(n.m)), n = grad C(m). */
static inline void smg_wide_turn(smg_state *s, int64_t k) {
  smg_real *d = s->wide_d + 3 * k;
#if SMG_ONTO_LEAF
  smg_real n[3];
  const smg_real *m = s->wide_m + 6 * k, half = 0.5 * s->wide_s[k];
  smg_normal(&s->c, k, m, n);
  const smg_real square = smg_dot(n, m), along = square != 0 ? smg_dot(n, d) / square : 0;
  smg_axpy(d, -along, m, 3);
  smg_scale(d, half, 3);
#else
  smg_scale(d, 0.5, 3);
#endif
  smg_zero(s->wide_y + 3 * k, 3);
}

/* d <- the change of h X(m) when m changes by d and dH/dw by y; joins v. */
static inline void smg_wide_follow(smg_state *s, int64_t k) {
  smg_real *d = s->wide_d + 3 * k;
  smg_respond_vary(&s->c, k, s->wide_m + 6 * k, s->wide_g + 6 * k, d, s->wide_y + 3 * k, d);
  smg_scale(d, smg_h_over_kappa(&s->c, k, s->c.h), 3);
}

/* d <- E d, E = d(h X(P(w + u/2)))/du; returns the largest component. */
static smg_real smg_wide_linear(smg_state *s) {
  const int64_t sites = smg_sites(&s->c);
  for (int64_t k = 0; k < sites; ++k) smg_wide_turn(s, k);
  smg_wide_hessian_vector(s);
  for (int64_t k = 0; k < sites; ++k) smg_wide_follow(s, k);
  return smg_most(s->wide_d, 3 * sites);
}

/* The solution to the digits of smg_wide: (u, low) = v + e, e = E d + E^2 d + .., d = v - u, where u solves the step
 * equation to the digits of smg_real. d is so small that its own digits are plenty; a series that does not fall, at
 * steps where E is large, is left out. */
static void smg_widen(smg_state *s) {
  const int64_t n3 = 3 * smg_sites(&s->c);
  smg_real last = SMG_MAX;
  smg_wide_evaluate(s);
  smg_zero(s->wide_e, n3);
  for (int n = 0; n < SMG_WIDE_TERMS; ++n) {
    const smg_real most = smg_wide_linear(s);
    if (!(most < last)) {
      smg_zero(s->wide_e, n3);
      break;
    }
    smg_axpy(s->wide_e, 1, s->wide_d, n3);
    if (most <= SMG_WIDE_SMALL * s->scale) break;
    last = most;
  }
  smg_wide_take(s);
}
#endif

#endif
