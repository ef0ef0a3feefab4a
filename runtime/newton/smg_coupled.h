/* smidgen runtime: the step equation of sites that are solved together: residual, predictor, and the words of Newton's
 * loop. */
#ifndef SMG_COUPLED_H
#define SMG_COUPLED_H

#include "smg_follow.h"
#include "smg_midpoint.h"
#include "smg_predictor.h"
#include "smg_rules.h"

/* Midpoints for the first iterate: w + u/2 with u extrapolated (degree < 0: u = 0). */
static void smg_predict(smg_state *s, int degree) {
  const int64_t n = 3 * smg_sites(&s->c);
  int64_t k = 0;
  for (; k + SMG_LANES <= n; k += SMG_LANES)
    smg_lane_put(s->mbar + k, smg_lane_take(s->w + k) + (smg_real)0.5 * smg_extrapolate_some(s, k, degree));
  for (; k < n; ++k) s->mbar[k] = s->w[k] + 0.5 * smg_extrapolate(s, k, degree);
}

/* m = P(mbar) of every coupled site, and g = 0. */
static inline void smg_project_all(smg_state *s) {
  SMG_UNROLL_FEW
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    s->s[k] = smg_project(&s->c, k, smg_leaf_value(s, k), s->mbar + 3 * k, s->m + 3 * k);
    s->g[3 * k] = s->g[3 * k + 1] = s->g[3 * k + 2] = 0;
  }
}

/* h X(m) of every coupled site, by its dH/dw in s->g. */
static inline void smg_increments(const smg_state *s, smg_real h, smg_real *u) {
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    smg_increment(&s->c, k, h, s->m + 3 * k, s->g + 3 * k, u + 3 * k);
  }
}

/* m = P(mbar), g = dH/dw(m), u = h X(m) and the residual r = w + u/2 - mbar of the step equation. */
static smg_change smg_evaluate(smg_state *s, smg_real h) {
  const smg_coefficients *c = &s->c;
  smg_change change = {0, 0, 0};
  smg_project_all(s);
  smg_coupled_gradient(c, s->m, s->g);
  SMG_UNROLL_FEW
  for (int64_t row = 0; row < smg_coupled(c); ++row) {
    const int64_t k = smg_site(c, row);
    smg_increment(c, k, h, s->m + 3 * k, s->g + 3 * k, s->u + 3 * k);
    smg_residual(s, k, s->mbar + 3 * k, s->u + 3 * k, smg_product_scale(c, k, h, s->m + 3 * k, s->g + 3 * k),
                 s->r + 3 * k, &change);
  }
  return change;
}

/* One more evaluation, at the midpoint of w + compensation: what is left of the iteration would drift. */
static smg_change smg_refine(smg_state *s, smg_real h) {
  smg_middle(3 * smg_sites(&s->c), s->w, s->compensation, s->u, s->mbar);
  return smg_evaluate(s, h);
}

/* Where the step equation is farthest from solved. */
static int64_t smg_worst_site(const smg_state *s) {
  int64_t worst = 0;
  smg_real most = -1;
  for (int64_t k = 0; k < 3 * smg_sites(&s->c) && !(most != most); ++k) {
    const smg_real r = SMG_MATH(fabs)(s->r[k]);
    if (r > most || r != r) {
      most = r;
      worst = k / 3;
    }
  }
  return worst;
}

#endif
