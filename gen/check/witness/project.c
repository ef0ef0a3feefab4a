/* The projection of a midpoint onto its sphere, its sphere of radius |w|, or its leaf C = c, and its derivative. */
#include "witness.h"

#include <math.h>

/* C(w) = w.(A w)/2; a = A w */
static real casimir(const system_t *s, int64_t i, const real *w, real a[3]) {
  const double *m = s->casimir + 9 * i;
  for (int c = 0; c < 3; c++)
    a[c] = m[3 * c] * w[0] + m[3 * c + 1] * w[1] + m[3 * c + 2] * w[2];
  return (a[0] * w[0] + a[1] * w[1] + a[2] * w[2]) / 2;
}

/* c of the leaf through w_i. The origin is its own leaf; elsewhere c = 0 has no projection. */
int leaf_of(const system_t *s, int64_t i, const real *w, real *c) {
  real a[3];
  *c = isnan(s->leaf[i]) ? casimir(s, i, w, a) : (real)s->leaf[i];
  return *c == 0 && (w[0] != 0 || w[1] != 0 || w[2] != 0) ? OFF_LEAF : OK;
}

/* m = mbar sqrt(c / C(mbar)): on a sphere r mbar/|mbar|, in R^3 |w| mbar/|mbar| */
int project(const system_t *s, int64_t i, const real *mbar, real c, real *m) {
  real a[3];
  const real ratio = c == 0 ? 0 : c / casimir(s, i, mbar, a);
  for (int k = 0; k < 3; k++) m[k] = sqrtl(ratio) * mbar[k];
  return ratio >= 0 && isfinite(ratio) ? OK : NO_SOLUTION;
}

/* dm/dmbar = sqrt(c/C) (1 - mbar (A mbar)^T / (2 C)) */
void project_derivative(const system_t *s, int64_t i, const real *mbar, real c, real dm[9]) {
  real a[3];
  const real q = casimir(s, i, mbar, a), scale = c == 0 ? 0 : sqrtl(c / q);
  for (int e = 0; e < 9; e++)
    dm[e] = c == 0 ? 0 : scale * ((e % 4 == 0) - mbar[e / 3] * a[e % 3] / (2 * q));
}
