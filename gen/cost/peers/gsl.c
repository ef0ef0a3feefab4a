/* GSL's odeiv2: rk8pd, and the multistep methods msadams and msbdf in their variable-order form. */
#include "rate.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

typedef struct peer {
  void *model;
  gsl_odeiv2_system ode;
  gsl_odeiv2_driver *d;
  double first, *point;
} peer;

static int right_side(double t, const double *y, double *dydt, void *to) {
  return rate(((peer *)to)->model, t, y, dydt) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* By differences, with the step sqrt(eps) that balances rounding and truncation; msbdf alone asks for it, now and then. */
static int derivative(double t, const double *y, double *dfdy, double *dfdt, void *to) {
  peer *p = (peer *)to;
  const size_t n = p->ode.dimension;
  const double e = 1.4901161193847656e-8; /* 2^-26 */
  double *at = p->point, *f = at + n, *g = f + n;
  rate(p->model, t, y, f);
  memcpy(at, y, n * sizeof *y);
  for (size_t j = 0; j < n; ++j) {
    at[j] = y[j] + e;
    rate(p->model, t, at, g);
    at[j] = y[j];
    for (size_t i = 0; i < n; ++i) dfdy[i * n + j] = (g[i] - f[i]) / e;
  }
  rate(p->model, t + e, y, g);
  for (size_t i = 0; i < n; ++i) dfdt[i] = (g[i] - f[i]) / e;
  return GSL_SUCCESS;
}

static const gsl_odeiv2_step_type *stepper(int kind) {
  if (kind == 0) return gsl_odeiv2_step_rk8pd;
  return kind == 1 ? gsl_odeiv2_step_msadams : gsl_odeiv2_step_msbdf;
}

void *peer_new(void *model, int kind, double tol, double first) {
  peer *p = (peer *)calloc(1, sizeof *p);
  gsl_set_error_handler_off();
  if (!p) return NULL;
  const gsl_odeiv2_system ode = {right_side, derivative, numbers(model), p};
  p->model = model;
  p->ode = ode;
  p->first = first;
  p->point = (double *)malloc(3 * ode.dimension * sizeof(double));
  p->d = gsl_odeiv2_driver_alloc_y_new(&p->ode, stepper(kind), first, tol, tol);
  if (p->d && p->point) {
    gsl_odeiv2_driver_set_nmax(p->d, MOST_STEPS);
    return p;
  }
  peer_free(p);
  return NULL;
}

int64_t peer_run(void *at, double t0, double *y, const double *times, int64_t count, double *out) {
  peer *p = (peer *)at;
  const size_t n = p->ode.dimension;
  double t = t0;
  gsl_odeiv2_driver_reset_hstart(p->d, p->first);
  gsl_odeiv2_driver_reset(p->d);
  for (int64_t k = 0; k < count; ++k) {
    if (gsl_odeiv2_driver_apply(p->d, &t, times[k], y) != GSL_SUCCESS || p->d->e->count > MOST_STEPS) return -1;
    memcpy(out + (size_t)k * n, y, n * sizeof *y);
  }
  return (int64_t)p->d->e->count;
}

void peer_free(void *at) {
  peer *p = (peer *)at;
  if (p && p->d) gsl_odeiv2_driver_free(p->d);
  if (p) free(p->point);
  free(p);
}
