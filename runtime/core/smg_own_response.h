/* smidgen runtime: the spherical midpoint of one spin in a frozen field that does more than turn it, in closed form. */
#ifndef SMG_OWN_RESPONSE_H
#define SMG_OWN_RESPONSE_H

#include "smg_respond.h"
#include "smg_spin.h"

#if SMG_RESPONDS
/* Does a step by the part p <= 1 of h come to u.G = 0 with |G| >= |u|, u = w - r^2 P? There s = 0, and midpoints jump
 * to the other side. */
SMG_INLINE int smg_response_ends(const smg_real *w, smg_real r, const smg_real *G, const smg_real *P) {
  const smg_real part = smg_dot(w, G) / (r * r * smg_dot(P, G));
  smg_real u[3];
  if (!(part > 0 && part <= 1)) return 0;
  smg_waxpy(u, -part * r * r, P, w, 3);
  return part * part * smg_dot(G, G) >= smg_dot(u, u);
}

/* The midpoint m, |m| = |w| = r, of a spin whose F and Q do not depend on it. With G = (h/2 kappa) F, P = (h/2 kappa) Q
 * and w + W = 2 rho m, m.m = r^2 turns w + m x G + m x (m x P) = rho m into
 *
 *     s m - m x G = u,   u = w - r^2 P,   s = rho - m.P:
 *
 * the equation of a spin u that precesses, in units of its own length. *square: |G|^2 + r^2 |P|^2. Returns 0
 * when the step has no solution. */
static inline int smg_own_response(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *w, smg_real r,
                                   const smg_real *g, smg_real *m, smg_real *square) {
  const smg_real half = (smg_real)0.5 * smg_h_over_kappa(c, k, h);
  smg_real G[3], P[3], u[3];
  smg_respond_parts(c, k, g, G, P);
  smg_scale(G, half, 3);
  smg_scale(P, half, 3);
  smg_waxpy(u, -r * r, P, w, 3);
  smg_copy(m, w, 3);
  *square = smg_dot(G, G) + r * r * smg_dot(P, P);
  if (!(r > 0)) return 1;
  const smg_real size = smg_norm(u), scale = r / size;
  if (smg_response_ends(w, r, G, P) || size == 0) return 0;
  smg_scale(G, scale, 3);
  if (!smg_own_spin(u, size, G, m)) return 0;
  smg_scale(m, scale, 3);
  return !(smg_dot(w, m) <= 0); /* r^2 rho */
}

/* The part of h up to which such a spin has steps. */
static inline smg_real smg_own_reach(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *w, smg_real r,
                                     const smg_real *g) {
  smg_real from = 0, to = 1, m[3], square;
  for (int n = 0; n < 50; ++n) {
    const smg_real part = (smg_real)0.5 * (from + to);
    if (smg_own_response(c, k, part * h, w, r, g, m, &square)) from = part;
    else to = part;
  }
  return from;
}

#endif

#endif
