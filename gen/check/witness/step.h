/* The equation of one step in the increment d = W - w, and its derivative.
 *
 *   F(d) = d - h Y(w + d/2),   Y = X o P for the spherical, X for the classical midpoint,
 *   Y = X / q, q = (1 + sqrt(1 - h^2 |b|^2))/2 for discrete Moser-Veselov (free body);
 *   every field is taken at the time t + h/2. */
#ifndef STEP_H
#define STEP_H

#include "witness.h"

typedef struct equation {
  const system_t *s;
  int method;
  real t, h;     /* time of the field, step */
  const real *w; /* state */
  real *c, *mbar, *m, *b, *x, *b_dt, *memory;
  double *dx;    /* 3*sites x 3*sites, NULL when only residuals are asked for */
  int status;
} equation;

int equation_new(equation *e, const system_t *s, int method, int matrix);
void equation_free(equation *e);
int equation_begin(equation *e, const real *w, real t, real h);
int equation_residual(equation *e, const real *d, real *f);
int equation_jacobian(equation *e, const real *d, double *jacobian);

#endif
