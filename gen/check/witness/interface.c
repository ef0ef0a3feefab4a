/* What Python calls besides the steps and the flow: doubles in, doubles out. */
#include "step.h"

#include <math.h>
#include <stdlib.h>

typedef int evaluator(const system_t *s, real t, const real *w, real *out);

static int vector_field(const system_t *s, real t, const real *w, real *x) {
  real *b = malloc((size_t)(3 * s->sites) * sizeof(real));
  int status = b ? field(s, t, w, b) : NO_MEMORY;
  if (status == OK) turn(s, w, b, x);
  if (status == OK) status = push(s, t, w, x);
  free(b);
  return status;
}

static int through(evaluator *f, const system_t *s, double t, const double *w, double *out) {
  const int64_t n = 3 * s->sites;
  real *in = malloc((size_t)(2 * n) * sizeof(real));
  if (!in) return NO_MEMORY;
  for (int64_t v = 0; v < n; v++) in[v] = w[v];
  const int status = f(s, t, in, in + n);
  for (int64_t v = 0; v < n && status == OK; v++) out[v] = (double)in[n + v];
  free(in);
  return status;
}

int witness_field(const system_t *s, double t, const double *w, double *b) {
  return through(field, s, t, w, b);
}

/* R += orientation (x w)/(w.w) of what torques do, x: w x R = orientation x, since x is across w. */
static int turn_by_torques(const system_t *s, real t, const real *w, real *R) {
  real *x = calloc((size_t)(3 * s->sites), sizeof(real));
  const int status = x ? push(s, t, w, x) : NO_MEMORY;
  for (int64_t i = 0; i < s->sites && status == OK; i++) {
    const real *v = w + 3 * i, square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    real across[3];
    cross(x + 3 * i, v, across);
    for (int k = 0; k < 3; k++) R[3 * i + k] += s->orientation * across[k] / square;
  }
  free(x);
  return status;
}

static int turnings(const system_t *s, real t, const real *w, real *R) {
  const int status = field(s, t, w, R);
  for (int64_t i = 0; i < s->sites && status == OK; i++) {
    const real b[3] = {R[3 * i], R[3 * i + 1], R[3 * i + 2]};
    turning(s, i, w + 3 * i, b, R + 3 * i);
  }
  return status == OK && s->torques > 0 ? turn_by_torques(s, t, w, R) : status;
}

int witness_turning(const system_t *s, double t, const double *w, double *R) {
  return through(turnings, s, t, w, R);
}

int witness_vector_field(const system_t *s, double t, const double *w, double *x) {
  return through(vector_field, s, t, w, x);
}

/* DX, row-major, and dX/dt */
int witness_jacobian(const system_t *s, double t, const double *w, double *dx, double *x_dt) {
  const int64_t n = 3 * s->sites;
  real *in = malloc((size_t)(4 * n) * sizeof(real));
  if (!in) return NO_MEMORY;
  for (int64_t v = 0; v < n; v++) in[v] = w[v];
  int status = field_derivative(s, t, in, in + n, dx, in + 2 * n);
  if (status == OK) turn_derivative(s, in, in + n, dx);
  if (status == OK) turn(s, in, in + 2 * n, in + 3 * n);
  if (status == OK) status = push_derivative(s, t, in, dx, in + 3 * n);
  for (int64_t v = 0; v < n && status == OK; v++) x_dt[v] = (double)in[3 * n + v];
  free(in);
  return status;
}

/* The sum of one term over its instances. */
int witness_sum(const program *p, int64_t sites, double t, const double *w, double *sum) {
  real total = 0;
  real *in = malloc((size_t)(3 * sites) * sizeof(real));
  if (!in) return NO_MEMORY;
  for (int64_t v = 0; v < 3 * sites; v++) in[v] = w[v];
  const int status = term_value(p, t, in, &total);
  *sum = (double)total;
  free(in);
  return status;
}

/* F(W - w) of every step of states w_0, .., w_count that someone else took: count x 3*sites numbers. The time
 * of a midpoint is t0 + (k + 1/2) h in double, as the states are. */
int witness_residuals(const system_t *s, int method, double t0, double h, int64_t count, const double *states,
                      double *out) {
  const int64_t n = 3 * s->sites;
  equation e;
  int status = equation_new(&e, s, method, 0);
  real *in = malloc((size_t)(3 * n) * sizeof(real)), *d = in + n, *f = in + 2 * n;
  if (!in) status = NO_MEMORY;
  for (int64_t k = 0; k < count && status == OK; k++, states += n) {
    const double middle = t0 + ((double)k + 0.5) * h;
    for (int64_t v = 0; v < n; v++) d[v] = (real)states[n + v] - (in[v] = states[v]);
    status = equation_begin(&e, in, (real)middle - (real)h / 2, h);
    if (status == OK) status = equation_residual(&e, d, f);
    for (int64_t v = 0; v < n && status == OK; v++) *out++ = (double)f[v];
  }
  equation_free(&e);
  free(in);
  return status;
}

/* F(d) of the step equation from w, and its derivative in d, row-major. */
int witness_equation(const system_t *s, int method, double t, double h, const double *w, const double *d, double *f,
                     double *jacobian) {
  const int64_t n = 3 * s->sites;
  equation e;
  int status = equation_new(&e, s, method, 1);
  real *in = malloc((size_t)(3 * n) * sizeof(real)), *move = in + n, *out = in + 2 * n;
  if (!in) status = NO_MEMORY;
  for (int64_t v = 0; v < n && status == OK; v++) {
    in[v] = w[v];
    move[v] = d[v];
  }
  if (status == OK) status = equation_begin(&e, in, t, h);
  if (status == OK) status = equation_residual(&e, move, out);
  for (int64_t v = 0; v < n && status == OK; v++) f[v] = (double)out[v];
  if (status == OK) status = equation_jacobian(&e, move, jacobian);
  equation_free(&e);
  free(in);
  return status;
}
