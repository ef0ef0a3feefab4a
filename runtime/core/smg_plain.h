/* smidgen runtime: what a model of one family of unit spheres with kappa = 1, all solved together, says of its sites.
 *
 * A model whose own version differs defines it, and SMG_OWN_<NAME> as 1. gen/compile/assemble/plain.py has the same
 * functions as trees; a test compares them. */
#ifndef SMG_PLAIN_H
#define SMG_PLAIN_H

#include "smg_model.h"

static inline int64_t smg_sites(const smg_coefficients *c);
static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g);

/* ---- parameters and time ---------------------------------------------------------------- */
#if !SMG_OWN_PREPARE
static inline int smg_prepare(smg_model *model) { return (void)model, 1; }
#endif

#if !SMG_OWN_SET_STEP
static inline void smg_set_step(smg_coefficients *c, smg_real h) { c->h = h; }
#endif

#if !SMG_OWN_SET_TIME
static inline void smg_set_time(smg_coefficients *c, smg_real t) { c->t = t; }
#endif

/* ---- numbers of sites ------------------------------------------------------------------- */
#if !SMG_OWN_COUPLED
static inline int64_t smg_coupled(const smg_coefficients *c) { return smg_sites(c); }
#endif

#if !SMG_OWN_FAMILY_END
static inline int64_t smg_family_end(const smg_coefficients *c, int f) { return (void)f, smg_sites(c); }
#endif

#if !SMG_OWN_SITE
static inline int64_t smg_site(const smg_coefficients *c, int64_t row) { return (void)c, row; }
#endif

#if !SMG_OWN_ROW
static inline int64_t smg_row(const smg_coefficients *c, int64_t k) { return (void)c, k; }
#endif

#if !SMG_OWN_TRACER
static inline int smg_tracer(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, 0; }
#endif

/* ---- a site: w.w = 1, kappa = 1 ---------------------------------------------------------- */
#if !SMG_OWN_KIND
static inline int smg_kind(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, SMG_SPHERE; }
#endif

#if !SMG_OWN_KAPPA
static inline smg_real smg_kappa(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, (smg_real)1; }
#endif

#if !SMG_OWN_PRESENT
static inline smg_real smg_present(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, (smg_real)1; }
#endif

#if !SMG_OWN_MOVES
static inline smg_real smg_moves(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, (smg_real)1; }
#endif

#if !SMG_OWN_H_OVER_KAPPA
static inline smg_real smg_h_over_kappa(const smg_coefficients *c, int64_t k, smg_real h) {
  return (void)c, (void)k, h;
}
#endif

#if !SMG_OWN_RADIUS
static inline smg_real smg_radius(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, (smg_real)1; }
#endif

#if !SMG_OWN_NORMAL
static inline void smg_normal(const smg_coefficients *c, int64_t k, const smg_real *v, smg_real *n) {
  (void)c, (void)k;
  n[0] = v[0];
  n[1] = v[1];
  n[2] = v[2];
}
#endif

/* ---- gradients: all sites are coupled ---------------------------------------------------- */
#if !SMG_OWN_COUPLED_GRADIENT
static inline void smg_coupled_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  smg_gradient(c, w, g);
}
#endif

/* ---- rows of a lattice with one site in a cell, in no field ------------------------------- */
#if !SMG_OWN_SHIFT
static inline int64_t smg_shift(int64_t sub) { return (void)sub, 0; }
#endif

#if !SMG_OWN_RANK
static inline int64_t smg_rank(int64_t sub) { return (void)sub, 0; }
#endif

#if !SMG_OWN_PLACE
static inline int64_t smg_place(int64_t colour, int64_t rank) { return (void)colour, rank; }
#endif

#if !SMG_OWN_REST_FIELD_NORM
static inline smg_real smg_rest_field_norm(const smg_coefficients *c, int64_t k) { return (void)c, (void)k, 0; }
#endif

#endif
