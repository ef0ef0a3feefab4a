/* smidgen runtime: the leaf of a site, a sphere or a level set of its Casimir. */
#ifndef SMG_LEAF_H
#define SMG_LEAF_H

#include "smg_model.h"

/* v.grad C(v): |v|^2, or 2 C(v) of a Nambu factor, of which C itself is meant. */
static inline smg_real smg_casimir(const smg_coefficients *c, int64_t k, const smg_real *v) {
  smg_real n[3];
  smg_normal(c, k, v, n);
  return smg_kind(c, k) == SMG_NAMBU ? 0.5 * smg_dot(v, n) : smg_dot(v, n);
}

/* What tells the leaf through w: the radius of a sphere, |w| in R^3, C(w) of a Nambu factor. */
static inline smg_real smg_leaf_value_of(const smg_coefficients *c, int64_t k, const smg_real *w) {
  if (smg_kind(c, k) == SMG_SPHERE) return smg_radius(c, k);
  return smg_kind(c, k) == SMG_R3 ? smg_norm(w) : smg_casimir(c, k, w);
}

/* The same of the step under way. */
static inline smg_real smg_leaf_value(const smg_state *s, int64_t k) {
#if SMG_LEAVES
  return smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) : s->leaf_value[k];
#else
  return smg_radius(&s->c, k);
#endif
}

/* How much smaller than others the site k is. */
SMG_INLINE smg_real smg_site_up(const smg_state *s, int64_t k) {
#if SMG_OWN_RADIUS
  if (smg_kind(&s->c, k) == SMG_SPHERE && smg_radius(&s->c, k) < s->scale) return s->scale / smg_radius(&s->c, k);
#endif
  return smg_kind(&s->c, k) == SMG_R3 ? smg_up(s->scale, s->w + 3 * k) : 1;
}

#endif
