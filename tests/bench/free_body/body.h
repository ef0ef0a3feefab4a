/* Hand-written steps of the spherical midpoint method for the free rigid body
 *
 *     W - w = h m x I^-1 m,   m = mbar/|mbar|,   mbar = (w + W)/2,   |w| = 1.
 *
 * With S = w + W the equation is u = W - w = h (S x I^-1 S)/|S|^2, free of square roots.
 * No status, no branch check, no compensation: the lower bound that generated code is held against.
 * Stop: no component of W changes any more, or every change is at most one unit in its last place. */
#ifndef FREE_BODY_H
#define FREE_BODY_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define ROWS 64 /* increments kept before the window is moved back to the top */
#define MAX_DEGREE 15
#define CAP 60 /* iteration limit, never reached here */

typedef struct body_params {
  double h, inverse_moment[3];
} body_params;

/* u[k..] holds the increments of the last steps, newest first, and in the fourth lane what a design
 * extrapolates beside them: 1/|S|^2, 1/|S|, or 1/|S|^2 - 1/(4|w|^2). */
typedef struct body {
  double w[3];
  int64_t k, count;
  body_params p;
  double u[ROWS][4];
} body;

typedef struct design {
  const char *name;
  void (*steps)(void *s, int64_t n);
} design;

void body_start(body *s, const body_params *p, const double w[3]);
extern const design hand_designs[];
extern const int hand_count;

#endif
