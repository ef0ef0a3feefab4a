/* The residual of the step equation and its derivatives, by the interpreter, and the memory that they need. */
#include "step.h"

#include <math.h>
#include <stdlib.h>

int equation_new(equation *e, const system_t *s, int method, int matrix) {
  const size_t n = (size_t)(3 * s->sites);
  *e = (equation){.s = s, .method = method};
  e->memory = malloc(6 * n * sizeof(real));
  if (matrix) e->dx = malloc(n * n * sizeof(double));
  if (!e->memory || (matrix && !e->dx)) return NO_MEMORY;
  e->mbar = e->memory;
  e->m = e->memory + n;
  e->b = e->memory + 2 * n;
  e->x = e->memory + 3 * n;
  e->b_dt = e->memory + 4 * n;
  e->c = e->memory + 5 * n;
  return OK;
}

void equation_free(equation *e) {
  free(e->memory);
  free(e->dx);
}

int equation_begin(equation *e, const real *w, real t, real h) {
  int status = OK;
  e->w = w;
  e->t = t + h / 2;
  e->h = h;
  for (int64_t i = 0; i < e->s->sites && status == OK; i++)
    if (e->method == SPHERICAL_MIDPOINT) status = leaf_of(e->s, i, w + 3 * i, e->c + i);
  return status;
}

/* mbar = w + d/2 and the point m where the field is taken */
static int midpoint(equation *e, const real *d) {
  int status = OK;
  for (int64_t v = 0; v < 3 * e->s->sites; v++) e->m[v] = e->mbar[v] = e->w[v] + d[v] / 2;
  for (int64_t i = 0; i < e->s->sites && status == OK; i++)
    if (e->method == SPHERICAL_MIDPOINT)
      status = project(e->s, i, e->mbar + 3 * i, e->c[i], e->m + 3 * i);
  return status;
}

/* r = sqrt(1 - h^2 |b|^2); q = (1 + r)/2. NaN where there is no solution. */
static real root(const equation *e, const real *b) {
  return sqrtl(1 - e->h * e->h * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]));
}

/* Moser-Veselov: X -> X/q */
static int shorten(equation *e) {
  int finite = 1;
  for (int64_t v = 0; v < 3 * e->s->sites; v++) {
    const real r = root(e, e->b + 3 * (v / 3));
    e->x[v] /= (1 + r) / 2;
    finite = finite && isfinite(r);
  }
  return finite ? OK : NO_SOLUTION;
}

int equation_residual(equation *e, const real *d, real *f) {
  int status = midpoint(e, d);
  if (status == OK) status = field(e->s, e->t, e->m, e->b);
  if (status != OK) return status;
  turn(e->s, e->m, e->b, e->x);
  status = push(e->s, e->t, e->m, e->x);
  if (status == OK && e->method == MOSER_VESELOV) status = shorten(e);
  for (int64_t v = 0; v < 3 * e->s->sites; v++) f[v] = d[v] - e->h * e->x[v];
  return status;
}

/* DX -> DX P', P' block-diagonal */
static void project_columns(equation *e) {
  const int64_t rows = 3 * e->s->sites;
  for (int64_t i = 0; i < e->s->sites; i++) {
    real dm[9];
    project_derivative(e->s, i, e->mbar + 3 * i, e->c[i], dm);
    for (int64_t k = 0; k < rows; k++) {
      double *a = e->dx + k * rows + 3 * i;
      const real a0 = a[0], a1 = a[1], a2 = a[2];
      for (int c = 0; c < 3; c++)
        a[c] = (double)(a0 * dm[c] + a1 * dm[3 + c] + a2 * dm[6 + c]);
    }
  }
}

/* D(X/q) = DX/q - X Dq/q^2, Dq = -h^2 b.Db/(2 r); db holds Db, dx holds DX of the same rows */
static void shorten_rows(equation *e, const double *db) {
  const int64_t rows = 3 * e->s->sites;
  for (int64_t v = 0; v < rows; v++) {
    const int64_t i = v / 3;
    const real *b = e->b + 3 * i, r = root(e, b), q = (1 + r) / 2;
    for (int64_t k = 0; k < rows; k++) {
      const double *a = db + 3 * i * rows + k;
      const real dq = -e->h * e->h * (b[0] * a[0] + b[1] * a[rows] + b[2] * a[2 * rows]) / (2 * r);
      e->dx[v * rows + k] = (double)(e->dx[v * rows + k] / q - e->x[v] * dq / (q * q));
    }
  }
}

/* Db in dx -> the derivative of Y; copy is room for Db where it is needed twice */
static int derivative_of_y(equation *e, double *copy) {
  const int64_t rows = 3 * e->s->sites;
  for (int64_t k = 0; k < rows * rows; k++) copy[k] = e->dx[k];
  turn(e->s, e->m, e->b, e->x);
  turn_derivative(e->s, e->m, e->b, e->dx);
  const int status = push_derivative(e->s, e->t, e->m, e->dx, NULL);
  if (e->method == SPHERICAL_MIDPOINT) project_columns(e);
  if (e->method == MOSER_VESELOV) shorten_rows(e, copy);
  return status;
}

/* F' = 1 - (h/2) Y' */
int equation_jacobian(equation *e, const real *d, double *jacobian) {
  const int64_t rows = 3 * e->s->sites;
  int status = midpoint(e, d);
  if (status == OK) status = field_derivative(e->s, e->t, e->m, e->b, e->dx, e->b_dt);
  if (status == OK) status = derivative_of_y(e, jacobian);
  if (status != OK) return status;
  for (int64_t k = 0; k < rows * rows; k++)
    jacobian[k] = (k % (rows + 1) == 0) - (double)(e->h / 2) * e->dx[k];
  return OK;
}
