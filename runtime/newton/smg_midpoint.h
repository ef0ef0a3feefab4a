/* smidgen method: what the midpoint methods share, one site at a time. They solve W - w = h X(m), m = P(mbar),
 * mbar = (w + W)/2, with a P of their own (smg_project) and X(m) = (1/kappa) grad C(m) x R,
 * R = dH/dw(m) where sites only precess (smg_respond.h). */
#ifndef SMG_MIDPOINT_H
#define SMG_MIDPOINT_H

#include "smg_leaf.h"
#include "smg_own_response.h"
#include "smg_spin.h"

/* blocks of SMG_BS, which the method or the model has said */
#include "smg_block.h"

/* The site k where it stands on no lattice. */
static inline smg_lattice_site smg_at(int64_t k) {
  const smg_lattice_site at = {k, 0, 0, 0, 0, 0};
  return at;
}

/* u = h X(m) = (h/kappa) grad C(m) x R, g = dH/dw. */
static inline void smg_increment(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *m, const smg_real *g,
                                 smg_real *u) {
  smg_real n[3], room[3];
  smg_normal(c, k, m, n);
  /* the rate last: pairs of spins with equal rates then turn each other by exactly opposite amounts */
  smg_cross(u, n, smg_respond(c, k, m, g, room));
  smg_scale(u, smg_h_over_kappa(c, k, h), 3);
}

/* r = w + u/2 - mbar, the residual of the step equation at site k, and how large it and the products are that u is made
 * of. */
SMG_INLINE void smg_residual(const smg_state *s, int64_t k, const smg_real *mbar, const smg_real *u, smg_real products,
                             smg_real *r, smg_change *change) {
  const smg_real *w = s->w + 3 * k, up = smg_site_up(s, k);
  for (int b = 0; b < 3; ++b) {
    r[b] = w[b] + 0.5 * u[b] - mbar[b];
    smg_change_add(change, r[b], SMG_MATH(fabs)(w[b]) + 0.5 * SMG_MATH(fabs)(u[b]), up);
  }
  smg_take(&change->rounding_scale, up * products);
}

/* Takes from u its part along grad C at the midpoint of w + compensation, which is round-off of the product h X. */
static inline void smg_tangential(const smg_coefficients *c, int64_t k, const smg_real *w, const smg_real *compensation,
                                  smg_real *u) {
  smg_real mbar[3], n[3];
  smg_middle(3, w, compensation, u, mbar);
  smg_normal(c, k, mbar, n);
  smg_unit(n, n);
  smg_across(n, u);
}

/* The size of the products that u is made of. */
static inline smg_real smg_product_scale(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *m,
                                         const smg_real *g) {
  smg_real n[3], room[3];
  if (smg_kind(c, k) == SMG_NAMBU) smg_normal(c, k, m, n);
  else smg_copy(n, m, 3);
  return smg_abs(smg_h_over_kappa(c, k, h)) * smg_largest(n) * smg_largest(smg_respond(c, k, m, g, room));
}

/* Tangent vectors E of the leaf at m, and dual rows F: F.E = 1, F.m = 0; without a leaf those of all of R^3. */
static inline void smg_tangent_frame(const smg_coefficients *c, int64_t k, const smg_real *m, const smg_real *n,
                                     smg_real *E, smg_real *F) {
  if (!SMG_ONTO_LEAF)
    for (int q = 0; q < 3 * SMG_BS; ++q) E[q] = F[q] = q % 4 == 0;
  else if (smg_kind(c, k) == SMG_NAMBU) smg_leaf_frame(m, n, E, F);
  else {
    smg_frame(m, E, E + 3);
    smg_copy(F, E, 6);
  }
}

/* Rows G and columns S of Newton's matrix, J = I - (h/2) DX(m) P'(mbar), in the tangent frame of the leaf (or all of
 * R^3):
 *   J_ij = delta_ij + G_i (d2H/dw_i dw_j) S_j^T,  G = -(h/2)(1/kappa) F x grad C(m),  S = s E.
 * own: delta and the part of the diagonal block from the curvature of C, -(h/2)(1/kappa) F.(grad C(S) x g). rhs =
 * F.res. */
static inline void smg_newton_frame(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *m, smg_real s,
                                    const smg_real *g, const smg_real *res, smg_real *G, smg_real *S, smg_real *own,
                                    smg_real *rhs) {
  const smg_real rate = -0.5 * smg_h_over_kappa(c, k, h);
  smg_real E[3 * SMG_BS], F[3 * SMG_BS], n[3], room[3];
  const smg_real *R = smg_respond(c, k, m, g, room);
  smg_normal(c, k, m, n);
  smg_tangent_frame(c, k, m, n, E, F);
  for (int l = 0; l < SMG_BS; ++l) {
    smg_real dn[3], turned[3], row[3];
    smg_normal(c, k, E + 3 * l, dn);
    smg_cross(turned, dn, R);
    smg_respond_turn(c, k, m, g, E + 3 * l, turned);
    smg_cross(row, F + 3 * l, n);
    smg_respond_row(c, k, m, row);
    smg_multiple(S + 3 * l, s, E + 3 * l, 3);
    smg_multiple(G + 3 * l, rate, row, 3);
    for (int r = 0; r < SMG_BS; ++r) own[SMG_BS * r + l] = rate * s * smg_dot(F + 3 * r, turned) + (r == l);
    rhs[l] = smg_dot(F + 3 * l, res);
  }
}

/* G B S^T for the Hessian block B of one term, y = B S^T. */
SMG_INLINE void smg_frame_block(const smg_real *G, const smg_real *y, smg_real *block) {
  for (int l = 0; l < SMG_BS; ++l)
    for (int r = 0; r < SMG_BS; ++r) block[SMG_BS * r + l] = smg_dot(G + 3 * r, y + 3 * l);
}

/* mbar += E a + gamma m, Newton's correction from its coordinates a in the tangent frame:
 * gamma = N.res + (h/2)(1/kappa) N.(grad C(S a) x g), N = n/(n.m), n = grad C(m). */
static inline void smg_newton_correct(const smg_coefficients *c, int64_t k, smg_real h, const smg_real *m, smg_real s,
                                      const smg_real *g, const smg_real *res, const smg_real *S, const smg_real *a,
                                      smg_real *mbar) {
  if (!SMG_ONTO_LEAF) {
    smg_axpy(mbar, 1, a, 3);
    return;
  }
  const smg_real rate = 0.5 * smg_h_over_kappa(c, k, h);
  smg_real n[3], v[3], dn[3], turned[3], room[3];
  smg_normal(c, k, m, n);
  for (int b = 0; b < 3; ++b) v[b] = S[b] * a[0] + S[3 + b] * a[1];
  smg_normal(c, k, v, dn);
  smg_cross(turned, dn, smg_respond(c, k, m, g, room));
  const int unit = smg_kind(c, k) == SMG_R3; /* m may be too small to be squared */
  if (unit && !(s > 0)) return;
  if (unit) smg_unit(m, n);
  const smg_real *along = unit ? n : m,
                 gamma = (smg_dot(n, res) + rate * smg_dot(n, turned)) / (unit ? 1 : smg_dot(m, n));
  for (int b = 0; b < 3; ++b) mbar[b] += v[b] / s + gamma * along[b];
}

#endif
