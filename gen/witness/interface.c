/* What Python calls besides the steps and the flow: doubles in, doubles out. */
#include "step.h"

#include <math.h>
#include <stdlib.h>

typedef int evaluator(const system_t *s, real t, const real *w, real *out);

static int vector_field(const system_t *s, real t, const real *w, real *x) {
  real *b = malloc((size_t)(3 * s->sites) * sizeof(real));
  const int status = b ? field(s, t, w, b) : NO_MEMORY;
  if (status == OK) turn(s, w, b, x);
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

int witness_vector_field(const system_t *s, double t, const double *w, double *x) {
  return through(vector_field, s, t, w, x);
}

/* DX, row-major, and dX/dt */
int witness_jacobian(const system_t *s, double t, const double *w, double *dx, double *x_dt) {
  const int64_t n = 3 * s->sites;
  real *in = malloc((size_t)(4 * n) * sizeof(real));
  if (!in) return NO_MEMORY;
  for (int64_t v = 0; v < n; v++) in[v] = w[v];
  const int status = field_derivative(s, t, in, in + n, dx, in + 2 * n);
  if (status == OK) turn_derivative(s, in, in + n, dx);
  if (status == OK) turn(s, in, in + 2 * n, in + 3 * n);
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

/* max |F(W - w)|: how well a step that someone else took solves the step equation. */
int witness_residual(const system_t *s, int method, double t, double h, const double *w,
                     const double *next, double *most) {
  const int64_t n = 3 * s->sites;
  equation e;
  int status = equation_new(&e, s, method, 0);
  real *in = malloc((size_t)(3 * n) * sizeof(real)), *d = in + n, *f = in + 2 * n;
  if (!in) status = NO_MEMORY;
  for (int64_t v = 0; v < n && status == OK; v++) d[v] = (real)next[v] - (in[v] = w[v]);
  if (status == OK) status = equation_begin(&e, in, t, h);
  if (status == OK) status = equation_residual(&e, d, f);
  *most = 0;
  for (int64_t v = 0; v < n && status == OK; v++)
    if (!(fabsl(f[v]) <= (real)*most)) *most = (double)fabsl(f[v]);
  equation_free(&e);
  free(in);
  return status;
}
