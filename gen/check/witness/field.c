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

static void cross(const real a[3], const real b[3], real x[3]) {
  x[0] = a[1] * b[2] - a[2] * b[1];
  x[1] = a[2] * b[0] - a[0] * b[2];
  x[2] = a[0] * b[1] - a[1] * b[0];
}

/* X_i = orientation * (A_i w_i) x b_i */
void turn(const system_t *s, const real *w, const real *b, real *x) {
  for (int64_t i = 0; i < s->sites; i++) {
    real g[3];
    leaf_normal(s, i, w + 3 * i, g);
    cross(g, b + 3 * i, x + 3 * i);
  }
}

/* column k of one site: (A_i w_i) x Db_ik, and for k within the site (A_i e_k) x b_i too */
static void turn_column(const system_t *s, int64_t i, const real g[3], const real *b,
                        double *db, int64_t k) {
  const int64_t rows = 3 * s->sites;
  real column[3], x[3], y[3] = {0, 0, 0}, unit[3] = {0, 0, 0}, normal[3];
  for (int c = 0; c < 3; c++) column[c] = db[(3 * i + c) * rows + k];
  cross(g, column, x);
  if (k / 3 == i) {
    unit[k % 3] = 1;
    leaf_normal(s, i, unit, normal);
    cross(normal, b + 3 * i, y);
  }
  for (int c = 0; c < 3; c++) db[(3 * i + c) * rows + k] = (double)(x[c] + y[c]);
}

/* Db -> DX, in place */
void turn_derivative(const system_t *s, const real *w, const real *b, double *db) {
  for (int64_t i = 0; i < s->sites; i++) {
    real g[3];
    leaf_normal(s, i, w + 3 * i, g);
    for (int64_t k = 0; k < 3 * s->sites; k++) turn_column(s, i, g, b, db, k);
  }
}
