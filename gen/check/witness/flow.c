/* The flow of X by GSL's odeiv2: an explicit and two implicit methods of high order. */
#include "witness.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <stdlib.h>

#define FARTHEST 200000 /* steps of GSL to one output: a flow that needs more is not resolved, and no reference */

typedef struct flow {
  const system_t *s;
  real *memory, *w, *b, *x;
  double *derivative;
  int status;
} flow;

static int rate(double t, const double *y, double *dydt, void *to) {
  flow *f = to;
  const int64_t n = 3 * f->s->sites;
  for (int64_t v = 0; v < n; v++) f->w[v] = y[v];
  f->status = field(f->s, t, f->w, f->b);
  turn(f->s, f->w, f->b, f->x);
  if (f->status == OK) f->status = push(f->s, t, f->w, f->x);
  for (int64_t v = 0; v < n; v++) dydt[v] = (double)f->x[v];
  return f->status == OK ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* X_t = (A w) x b_t */
static int rate_derivative(double t, const double *y, double *dfdy, double *dfdt, void *to) {
  flow *f = to;
  const int64_t n = 3 * f->s->sites;
  real *b_dt = f->memory + 3 * n;
  for (int64_t v = 0; v < n; v++) f->w[v] = y[v];
  f->status = field_derivative(f->s, t, f->w, f->b, dfdy, b_dt);
  turn_derivative(f->s, f->w, f->b, dfdy);
  turn(f->s, f->w, b_dt, f->x);
  if (f->status == OK) f->status = push_derivative(f->s, t, f->w, dfdy, f->x);
  for (int64_t v = 0; v < n; v++) dfdt[v] = (double)f->x[v];
  return f->status == OK ? GSL_SUCCESS : GSL_EBADFUNC;
}

static const gsl_odeiv2_step_type *stepper(int integrator) {
  if (integrator == 0) return gsl_odeiv2_step_rk8pd;
  return integrator == 1 ? gsl_odeiv2_step_bsimp : gsl_odeiv2_step_msbdf;
}

static int march(flow *f, gsl_odeiv2_driver *d, double t, double *y, const double *times,
                 int64_t count, double *out) {
  const int64_t n = 3 * f->s->sites;
  for (int64_t k = 0; k < count; k++) {
    if (times[k] != t && gsl_odeiv2_driver_apply(d, &t, times[k], y))
      return f->status != OK ? f->status : NO_CONVERGENCE;
    for (int64_t v = 0; v < n; v++) out[k * n + v] = y[v];
  }
  return OK;
}

/* The largest component, by which errors of small ones are measured; 1 where all are 0. */
static double largest_of(const double *y, size_t n) {
  double found = 0;
  for (size_t v = 0; v < n; v++) found = fmax(found, fabs(y[v]));
  return found > 0 ? found : 1;
}

/* States at the `count` times (monotone from t0), error per step below tol (relative to each component and to the
 * largest one). `y` holds the start and is overwritten. integrator: 0 rk8pd, 1 bsimp, 2 msbdf. */
int witness_flow(const system_t *s, int integrator, double tol, double t0, double *y,
                 const double *times, int64_t count, double *out) {
  const size_t n = (size_t)(3 * s->sites);
  flow f = {.s = s, .status = OK, .memory = malloc(4 * n * sizeof(real))};
  gsl_odeiv2_system ode = {rate, rate_derivative, n, &f};
  const double first = count > 0 && times[count - 1] < t0 ? -1e-3 : 1e-3;
  gsl_set_error_handler_off();
  gsl_odeiv2_driver *d = gsl_odeiv2_driver_alloc_y_new(&ode, stepper(integrator), first, tol * largest_of(y, n), tol);
  int status = d && f.memory ? OK : NO_MEMORY;
  if (status == OK) {
    f.w = f.memory;
    f.b = f.memory + n;
    f.x = f.memory + 2 * n;
    gsl_odeiv2_driver_set_nmax(d, FARTHEST);
    status = march(&f, d, t0, y, times, count, out);
  }
  if (d) gsl_odeiv2_driver_free(d);
  free(f.memory);
  return status;
}
