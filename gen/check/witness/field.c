/* The field b = (1/kappa) dH/dw, how it and torques turn each site, and the derivatives of both. */
#include "witness.h"

#include <math.h>
#include <string.h>

/* b_i = (1/kappa_i) dH/dw_i, in place */
static int divide_by_strength(const system_t *s, real *b) {
  int finite = 1;
  for (int64_t v = 0; v < 3 * s->sites; v++) {
    b[v] /= s->kappa[v / 3];
    finite = finite && isfinite(b[v]);
  }
  return finite ? OK : NOT_FINITE;
}

int field(const system_t *s, real t, const real *w, real *b) {
  int status = OK;
  memset(b, 0, (size_t)(3 * s->sites) * sizeof(real));
  for (int64_t e = 0; e < s->effects && status == OK; e++)
    status = term_gradient(&s->effect[e], t, w, b);
  return status == OK ? divide_by_strength(s, b) : status;
}

typedef struct dense { double *at; int64_t rows; const double *kappa; } dense;

/* Db_ij += (1/kappa_i) d2H/dw_i dw_j */
static void add_block(void *to, int64_t i, int64_t j, const real block[9]) {
  const dense *m = to;
  for (int e = 0; e < 9; e++)
    m->at[(3 * i + e / 3) * m->rows + 3 * j + e % 3] += (double)(block[e] / m->kappa[i]);
}

int field_derivative(const system_t *s, real t, const real *w, real *b, double *db,
                     real *b_dt) {
  int status = OK;
  const int64_t rows = 3 * s->sites;
  dense m = {db, rows, s->kappa};
  memset(b, 0, (size_t)rows * sizeof(real));
  memset(b_dt, 0, (size_t)rows * sizeof(real));
  memset(db, 0, (size_t)(rows * rows) * sizeof(double));
  for (int64_t e = 0; e < s->effects && status == OK; e++)
    status = term_hessian(&s->effect[e], t, w, b, b_dt, add_block, &m);
  if (status == OK) status = divide_by_strength(s, b_dt);
  return status == OK ? divide_by_strength(s, b) : status;
}

/* g = orientation * grad C_i = orientation * A_i w_i */
static void leaf_normal(const system_t *s, int64_t i, const real *w, real g[3]) {
  const double *a = s->casimir + 9 * i;
  for (int c = 0; c < 3; c++)
    g[c] = s->orientation * (a[3 * c] * w[0] + a[3 * c + 1] * w[1] + a[3 * c + 2] * w[2]);
}

void cross(const real a[3], const real b[3], real x[3]) {
  x[0] = a[1] * b[2] - a[2] * b[1];
  x[1] = a[2] * b[0] - a[0] * b[2];
  x[2] = a[0] * b[1] - a[1] * b[0];
}

/* orientation s alpha/r, r^2/2 the value of C; r = 1 where no leaf is fixed, in R^3 */
static real loss(const system_t *s, int64_t i) {
  const real r = isnan(s->leaf[i]) ? 1 : sqrtl(2 * (real)s->leaf[i]);
  return s->alpha[i] == 0 ? 0 : s->orientation * copysign(s->alpha[i], s->kappa[i]) / r;
}

/* what torques lose with the motion: under Gilbert's damping alone */
real gilbert_loss(const system_t *s, int64_t i) { return s->lag[i] * loss(s, i); }

/* R = share (b + loss w x b) of one site */
void turning(const system_t *s, int64_t i, const real *w, const real *b, real R[3]) {
  real across[3];
  const real c = loss(s, i);
  cross(w, b, across);
  for (int k = 0; k < 3; k++) R[k] = s->share[i] * (c == 0 ? b[k] : b[k] + c * across[k]);
}

/* X_i = orientation * (A_i w_i) x R_i */
void turn(const system_t *s, const real *w, const real *b, real *x) {
  for (int64_t i = 0; i < s->sites; i++) {
    real g[3], R[3];
    leaf_normal(s, i, w + 3 * i, g);
    turning(s, i, w + 3 * i, b + 3 * i, R);
    cross(g, R, x + 3 * i);
  }
}

/* column k of one site: (A_i w_i) x DR_ik, and for k within the site (A_i e_k) x R_i too;
 * DR = share (Db + loss w x Db), and for k within the site share loss e_k x b too */
static void turn_column(const system_t *s, int64_t i, const real *w, const real g[3], const real *b,
                        double *db, int64_t k) {
  const int64_t rows = 3 * s->sites;
  const real lost = s->share[i] * loss(s, i);
  real column[3], R[3], x[3], y[3] = {0, 0, 0}, unit[3] = {0, 0, 0}, normal[3], own[3];
  for (int c = 0; c < 3; c++) column[c] = db[(3 * i + c) * rows + k];
  turning(s, i, w + 3 * i, column, R);
  if (k / 3 == i) {
    unit[k % 3] = 1;
    cross(unit, b + 3 * i, own);
    for (int c = 0; c < 3; c++) R[c] += lost * own[c];
  }
  cross(g, R, x);
  if (k / 3 == i) {
    leaf_normal(s, i, unit, normal);
    turning(s, i, w + 3 * i, b + 3 * i, R);
    cross(normal, R, y);
  }
  for (int c = 0; c < 3; c++) db[(3 * i + c) * rows + k] = (double)(x[c] + y[c]);
}

/* Db -> DX, in place */
void turn_derivative(const system_t *s, const real *w, const real *b, double *db) {
  for (int64_t i = 0; i < s->sites; i++) {
    real g[3];
    leaf_normal(s, i, w + 3 * i, g);
    for (int64_t k = 0; k < 3 * s->sites; k++) turn_column(s, i, w, g, b, db, k);
  }
}
