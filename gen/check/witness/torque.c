/* Torques: T_i, three terms of an effect, moves a site by itself, without kappa or orientation.
 *
 * What it has along w is left out: T - w (w.T)/(w.w). Gilbert's damping takes the rest to share (T + loss w x T); that of Landau and Lifshitz leaves
 * it as it is. */
#include "witness.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* T of all sites. */
static int sum_torques(const system_t *s, real t, const real *w, real *T) {
  int status = OK;
  memset(T, 0, (size_t)(3 * s->sites) * sizeof(real));
  for (int64_t e = 0; e < s->torques && status == OK; e++)
    status = term_values(&s->torque[e].value, t, w, s->torque[e].moved, s->torque[e].component, T);
  return status;
}

/* x += the torque of one site without its part along w, and as damping leaves it. */
static void settled(const system_t *s, int64_t i, const real *w, const real *T, real *x) {
  const real along = (w[0] * T[0] + w[1] * T[1] + w[2] * T[2]) / (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  real across[3], side[3];
  for (int k = 0; k < 3; k++) across[k] = T[k] - along * w[k];
  cross(w, across, side);
  for (int k = 0; k < 3; k++) x[k] += s->share[i] * (across[k] + gilbert_loss(s, i) * side[k]);
}

int push(const system_t *s, real t, const real *w, real *x) {
  if (s->torques == 0) return OK;
  real *T = malloc((size_t)(3 * s->sites) * sizeof(real));
  int status = T ? sum_torques(s, t, w, T) : NO_MEMORY;
  for (int64_t i = 0; i < s->sites && status == OK; i++) settled(s, i, w + 3 * i, T + 3 * i, x + 3 * i);
  for (int64_t v = 0; v < 3 * s->sites && status == OK; v++) status = isfinite(x[v]) ? OK : NOT_FINITE;
  free(T);
  return status;
}

/* The derivative of `settled` where w changes by d (0 but within the site) and T by dT. */
static void settled_change(const system_t *s, int64_t i, const real *w, const real *T, const real *d, const real *dT, real *x) {
  const real ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], wT = w[0] * T[0] + w[1] * T[1] + w[2] * T[2];
  real moved = 0, grown = 0, across[3], change[3], turned[3], side[3];
  for (int k = 0; k < 3; k++) {
    moved += d[k] * T[k] + w[k] * dT[k];
    grown += 2 * w[k] * d[k];
  }
  const real along = wT / ww, lent = (moved - along * grown) / ww;
  for (int k = 0; k < 3; k++) {
    across[k] = T[k] - along * w[k];
    change[k] = dT[k] - lent * w[k] - along * d[k];
  }
  cross(w, change, turned);
  cross(d, across, side);
  for (int k = 0; k < 3; k++) x[k] += s->share[i] * (change[k] + gilbert_loss(s, i) * (turned[k] + side[k]));
}

/* dx += the derivative of what `push` adds, slopes that of T, row-major. */
static void push_columns(const system_t *s, const real *w, const real *T, const double *slopes, double *dx) {
  const int64_t rows = 3 * s->sites;
  for (int64_t i = 0; i < s->sites; i++)
    for (int64_t k = 0; k < rows; k++) {
      real d[3] = {0, 0, 0}, dT[3], x[3] = {0, 0, 0};
      if (k / 3 == i) d[k % 3] = 1;
      for (int c = 0; c < 3; c++) dT[c] = slopes[(3 * i + c) * rows + k];
      settled_change(s, i, w + 3 * i, T + 3 * i, d, dT, x);
      for (int c = 0; c < 3; c++) dx[(3 * i + c) * rows + k] += (double)x[c];
    }
}

int push_derivative(const system_t *s, real t, const real *w, double *dx, real *x_dt) {
  const int64_t rows = 3 * s->sites;
  const real none[3] = {0, 0, 0};
  if (s->torques == 0) return OK;
  real *T = malloc((size_t)(2 * rows) * sizeof(real)), *T_dt = T ? T + rows : NULL;
  double *slopes = calloc((size_t)(rows * rows), sizeof(double));
  int status = T && slopes ? sum_torques(s, t, w, T) : NO_MEMORY;
  if (status == OK) memset(T_dt, 0, (size_t)rows * sizeof(real));
  for (int64_t e = 0; e < s->torques && status == OK; e++)
    status = term_slopes(&s->torque[e].value, t, w, s->torque[e].moved, s->torque[e].component, rows, slopes, T_dt);
  if (status == OK) push_columns(s, w, T, slopes, dx);
  for (int64_t i = 0; i < s->sites && status == OK && x_dt; i++)
    settled_change(s, i, w + 3 * i, T + 3 * i, none, T_dt + 3 * i, x_dt + 3 * i);
  free(T);
  free(slopes);
  return status;
}
