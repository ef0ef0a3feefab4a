/* smidgen runtime: from the gradient g = dH/dw of a site to its motion:
 *
 *     W - w = (h/kappa) (m x F + m x (m x Q)) = (h/kappa) m x R,   R = F + m x Q,   F = f g + F0,   Q = q g + Q0.
 *
 * Sites that precess in their field and do nothing else have R = g, and nothing of this is compiled. Others
 * (SMG_RESPONDS) have a function smg_response(c, k, r) in their model, r = f, q, F0, Q0, which depend on no vector: so
 * the step of one spin in the field of others keeps its closed form (smg_own_response.h). */
#ifndef SMG_RESPOND_H
#define SMG_RESPOND_H

#include "smg_model.h"

/* SMG_TOLD: do sites in lanes have a response? It is that of those that move, smg_law(c, k, r), which a model has
 * (SMG_LAW) where some stand still: their gradient is 0 in lanes (smg_slot_gradient). SMG_ALL_OR_NOTHING: the only
 * response is that some do. SMG_LAW_BY_SITE: which of r differ from site to site, as bits: those stand in arrays by
 * slots (smg_told_at of smg_row_end.h). */
#if SMG_RESPONDS && !SMG_ALL_OR_NOTHING
#define SMG_TOLD 1
#else
#define SMG_TOLD 0
#endif
#if !SMG_LAW
#define smg_law smg_response
#endif

#if SMG_RESPONDS
enum { SMG_RESPONSE_F0 = 2, SMG_RESPONSE_Q0 = 5, SMG_RESPONSE_SIZE = 8 };

static inline void smg_response(const smg_coefficients *c, int64_t k, smg_real *r);

typedef smg_real smg_told_number; /* of a response */
#include "smg_respond_template.h"

/* F and Q. */
SMG_INLINE void smg_respond_parts(const smg_coefficients *c, int64_t k, const smg_real *g, smg_real *F, smg_real *Q) {
  smg_real r[SMG_RESPONSE_SIZE];
  smg_response(c, k, r);
  smg_told_parts(r, g, F, Q);
}

/* R = F + m x Q, in `room`. */
SMG_INLINE const smg_real *smg_respond(const smg_coefficients *c, int64_t k, const smg_real *m, const smg_real *g,
                                       smg_real *room) {
  smg_real r[SMG_RESPONSE_SIZE];
  smg_response(c, k, r);
  return smg_told_respond(r, m, g, room);
}

/* The change f y + q m x y of R, y that of g, in `room`. */
SMG_INLINE const smg_real *smg_respond_change(const smg_coefficients *c, int64_t k, const smg_real *m,
                                              const smg_real *y, smg_real *room) {
  smg_real r[SMG_RESPONSE_SIZE];
  smg_response(c, k, r);
  return smg_told_change(r, m, y, room);
}

/* The same for a row v of a matrix: v.(m x (f y + q m x y)) = x.y, x = f v x m + q (v x m) x m in place of v x m. */
SMG_INLINE void smg_respond_row(const smg_coefficients *c, int64_t k, const smg_real *m, smg_real *row) {
  smg_real r[SMG_RESPONSE_SIZE], x[3];
  smg_response(c, k, r);
  smg_cross(x, row, m);
  smg_scale(row, r[0], 3);
  smg_axpy(row, r[1], x, 3);
}

/* turned += m x (d x Q), the change of m x R with m in R by d. */
SMG_INLINE void smg_respond_turn(const smg_coefficients *c, int64_t k, const smg_real *m, const smg_real *g,
                                 const smg_real *d, smg_real *turned) {
  smg_real r[SMG_RESPONSE_SIZE];
  smg_response(c, k, r);
  smg_told_turn(r, m, g, d, turned);
}

/* (kappa/h) times a bound on a row of the derivative of h X, where the norms of the Hessian in it add up to `norm`: of
 * m x (f y + q m x y) and, of m itself in m x F and m x (m x Q), m.F/r and m.Q. */
SMG_INLINE smg_real smg_respond_norm(const smg_coefficients *c, int64_t k, const smg_real *m, const smg_real *g,
                                     smg_real radius, smg_real norm) {
  smg_real r[SMG_RESPONSE_SIZE], F[3], Q[3];
  smg_response(c, k, r);
  smg_respond_parts(c, k, g, F, Q);
  return (smg_abs(r[0]) + radius * smg_abs(r[1])) * norm * radius + smg_abs(smg_dot(m, F)) / radius +
         smg_abs(smg_dot(m, Q));
}

/* R of all sites in place of g, at the points w. */
static inline void smg_respond_all(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  for (int64_t k = 0; k < smg_sites(c); ++k) {
    smg_real room[3];
    (void)smg_respond(c, k, w + 3 * k, g + 3 * k, room);
    smg_copy(g + 3 * k, room, 3);
  }
}

#else
SMG_INLINE const smg_real *smg_respond(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k,
                                       SMG_UNUSED const smg_real *m, const smg_real *g, SMG_UNUSED smg_real *room) {
  return g;
}

SMG_INLINE const smg_real *smg_respond_change(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k,
                                              SMG_UNUSED const smg_real *m, const smg_real *y,
                                              SMG_UNUSED smg_real *room) {
  return y;
}

SMG_INLINE void smg_respond_row(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k,
                                SMG_UNUSED const smg_real *m, SMG_UNUSED smg_real *row) {}

SMG_INLINE void smg_respond_turn(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k,
                                 SMG_UNUSED const smg_real *m, SMG_UNUSED const smg_real *g,
                                 SMG_UNUSED const smg_real *d, SMG_UNUSED smg_real *turned) {}

SMG_INLINE smg_real smg_respond_norm(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k, const smg_real *m,
                                     const smg_real *g, smg_real radius, smg_real norm) {
  return norm * radius + smg_abs(smg_dot(m, g)) / radius;
}

SMG_INLINE void smg_respond_all(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED const smg_real *w,
                                SMG_UNUSED smg_real *g) {}
#endif

/* DX dm without its factor h/kappa: grad C(dm) x R + grad C(m) x R', R' the change of R with m by dm and with the
 * gradient by y. */
SMG_INLINE void smg_respond_vary(const smg_coefficients *c, int64_t k, const smg_real *m, const smg_real *g,
                                 const smg_real *dm, const smg_real *y, smg_real *out) {
  smg_real n[3], dn[3], turned[3], room[3], change[3];
  smg_normal(c, k, m, n);
  smg_normal(c, k, dm, dn);
  smg_cross(turned, dn, smg_respond(c, k, m, g, room));
  smg_respond_turn(c, k, m, g, dm, turned);
  smg_cross(out, n, smg_respond_change(c, k, m, y, change));
  smg_axpy(out, 1, turned, 3);
}

#endif
