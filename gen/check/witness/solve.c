/* The step equation solved: GSL's Newton method from the predictor d = h X(w), continuation
 * in h where that fails, and Newton updates with the residual in extended precision until
 * they stagnate, so that the result is right to the last bit of a double. */
#include "step.h"

#include <float.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multiroots.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NEWTON_LIMIT = 40, POLISH_LIMIT = 20, HALVINGS = 10 };
static const real COARSE = 1e-9L, FINE = 1e-16L;

typedef struct solver {
  equation e;
  gsl_multiroot_function_fdf f;
  gsl_multiroot_fdfsolver *newton;
  gsl_matrix *matrix;
  gsl_permutation *order;
  gsl_vector *x, *y;
  real *w, *d, *r, *guess;
  real scale; /* max |w| */
} solver;

static int f_only(const gsl_vector *x, void *to, gsl_vector *f) {
  solver *z = to;
  for (size_t k = 0; k < x->size; k++) z->guess[k] = gsl_vector_get(x, k);
  z->e.status = equation_residual(&z->e, z->guess, z->r);
  for (size_t k = 0; k < x->size; k++) gsl_vector_set(f, k, (double)z->r[k]);
  return z->e.status == OK ? GSL_SUCCESS : GSL_EBADFUNC;
}

static int df_only(const gsl_vector *x, void *to, gsl_matrix *j) {
  solver *z = to;
  for (size_t k = 0; k < x->size; k++) z->guess[k] = gsl_vector_get(x, k);
  z->e.status = equation_jacobian(&z->e, z->guess, j->data);
  return z->e.status == OK ? GSL_SUCCESS : GSL_EBADFUNC;
}

static int f_and_df(const gsl_vector *x, void *to, gsl_vector *f, gsl_matrix *j) {
  const int status = f_only(x, to, f);
  return status == GSL_SUCCESS ? df_only(x, to, j) : status;
}

static int solver_new(solver *z, const system_t *s, int method) {
  const size_t n = (size_t)(3 * s->sites);
  memset(z, 0, sizeof *z);
  const int status = equation_new(&z->e, s, method, 1);
  z->f = (gsl_multiroot_function_fdf){f_only, df_only, f_and_df, n, z};
  z->newton = gsl_multiroot_fdfsolver_alloc(gsl_multiroot_fdfsolver_newton, n);
  z->matrix = gsl_matrix_alloc(n, n);
  z->order = gsl_permutation_alloc(n);
  z->x = gsl_vector_alloc(n);
  z->y = gsl_vector_alloc(n);
  z->w = malloc(4 * n * sizeof(real));
  if (!z->newton || !z->matrix || !z->order || !z->x || !z->y || !z->w) return NO_MEMORY;
  z->d = z->w + n;
  z->r = z->w + 2 * n;
  z->guess = z->w + 3 * n;
  return status;
}

static void solver_free(solver *z) {
  equation_free(&z->e);
  if (z->newton) gsl_multiroot_fdfsolver_free(z->newton);
  if (z->matrix) gsl_matrix_free(z->matrix);
  if (z->order) gsl_permutation_free(z->order);
  if (z->x) gsl_vector_free(z->x);
  if (z->y) gsl_vector_free(z->y);
  free(z->w);
}

static real largest(const real *a, size_t n) {
  real most = 0;
  for (size_t k = 0; k < n; k++)
    if (!(fabsl(a[k]) <= most)) most = fabsl(a[k]); /* a NaN is the largest */
  return most;
}

static int failure(const solver *z) { return z->e.status != OK ? z->e.status : NO_CONVERGENCE; }

/* GSL's Newton from z->d to a residual of 1e-9 |w|; always at least one iteration */
static int newton(solver *z) {
  const size_t n = z->x->size;
  real residual = INFINITY;
  for (size_t k = 0; k < n; k++) gsl_vector_set(z->x, k, (double)z->d[k]);
  if (gsl_multiroot_fdfsolver_set(z->newton, &z->f, z->x)) return failure(z);
  for (int k = 0; k < NEWTON_LIMIT && !(residual <= COARSE * z->scale); k++) {
    if (gsl_multiroot_fdfsolver_iterate(z->newton)) return failure(z);
    residual = largest(z->r, n);
  }
  for (size_t k = 0; k < n; k++) z->d[k] = gsl_vector_get(z->newton->x, k);
  return residual <= COARSE * z->scale ? OK : NO_CONVERGENCE;
}

static int factor(solver *z) {
  int sign;
  const int status = equation_jacobian(&z->e, z->d, z->matrix->data);
  if (status != OK) return status;
  return gsl_linalg_LU_decomp(z->matrix, z->order, &sign) ? SINGULAR : OK;
}

/* d -= F'^-1 F, F in extended precision; *change is max |update| */
static int update(solver *z, real *change) {
  const size_t n = z->x->size;
  const int status = equation_residual(&z->e, z->d, z->r);
  if (status != OK) return status;
  for (size_t k = 0; k < n; k++) gsl_vector_set(z->x, k, (double)z->r[k]);
  if (gsl_linalg_LU_solve(z->matrix, z->order, z->x, z->y)) return SINGULAR;
  for (size_t k = 0; k < n; k++) z->r[k] = gsl_vector_get(z->y, k);
  *change = largest(z->r, n);
  for (size_t k = 0; k < n; k++) z->d[k] -= z->r[k];
  return isfinite(*change) ? OK : NOT_FINITE;
}

static int polish(solver *z) {
  real change = INFINITY, before = INFINITY;
  int status = factor(z);
  for (int k = 0; k < POLISH_LIMIT && status == OK; k++) {
    before = change;
    status = update(z, &change);
    if (change <= LDBL_EPSILON * z->scale || (k > 1 && change >= before)) break;
  }
  if (status == OK && !(change <= FINE * z->scale)) return NO_CONVERGENCE;
  return status;
}

static int attempt(solver *z) {
  const int status = newton(z);
  return status == OK ? polish(z) : status;
}

/* d = h X(w) */
static int predict(solver *z) {
  const int status = field(z->e.s, z->e.t, z->w, z->e.b);
  turn(z->e.s, z->w, z->e.b, z->d);
  for (size_t k = 0; k < z->x->size; k++) z->d[k] *= z->e.h;
  return status;
}

/* The solution connected to d = 0 at h = 0: the equation for lambda h, lambda from 0 to 1. */
static int continuation(solver *z, real h) {
  const size_t n = z->x->size;
  real reached = 0, stride = 0.5L;
  real *kept = calloc(n, sizeof(real));
  int status = kept ? OK : NO_MEMORY;
  while (kept && reached < 1) {
    const real next = reached + stride < 1 ? reached + stride : 1;
    z->e.h = next * h;
    for (size_t k = 0; k < n; k++) z->d[k] = reached > 0 ? kept[k] * next / reached : 0;
    status = attempt(z);
    if (status == OK) {
      memcpy(kept, z->d, n * sizeof(real));
      reached = next;
      stride *= 2;
    } else if ((stride /= 2) < ldexpl(1, -HALVINGS)) {
      break;
    }
  }
  free(kept);
  return status;
}

/* w -> w + d, at time t */
static int one_step(solver *z, real t, real h) {
  const size_t n = z->x->size;
  z->scale = largest(z->w, n) > 0 ? largest(z->w, n) : 1;
  int status = equation_begin(&z->e, z->w, t, h);
  if (status == OK) status = predict(z);
  if (status != OK) return status;
  status = attempt(z);
  if (status != OK) status = continuation(z, h);
  for (size_t k = 0; k < n && status == OK; k++) z->w[k] += z->d[k];
  return status;
}

/* `count` steps from w at t0; every `every`-th state is appended to out, the start first.
 * The state between steps is kept in extended precision. *done: steps that succeeded. */
int witness_steps(const system_t *s, int method, const double *w, double t0, double h,
                  int64_t count, int64_t every, double *out, int64_t *done) {
  const int64_t n = 3 * s->sites;
  solver z;
  gsl_set_error_handler_off();
  int status = solver_new(&z, s, method);
  *done = 0;
  for (int64_t v = 0; v < n && status == OK; v++) out[v] = (double)(z.w[v] = w[v]);
  while (*done < count && status == OK) {
    status = one_step(&z, (real)t0 + (real)*done * h, h);
    if (status != OK) break;
    if (++*done % every) continue;
    for (int64_t v = 0; v < n; v++) out[*done / every * n + v] = (double)z.w[v];
  }
  solver_free(&z);
  return status;
}
