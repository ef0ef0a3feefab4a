/* The witness: interprets the terms of a spec and differentiates them by itself.
 *
 * All of it computes in extended precision; nothing here knows how smidgen derives or
 * emits code. Arrays belong to the caller. A state has 3*sites numbers.
 *
 *   X_i = orientation * grad C_i(w_i) x b_i,   b_i = (1/kappa_i) dH/dw_i,   C_i = w.(A_i w)/2
 *
 * Damped sites (on spheres, of radius r) turn about R in place of b:
 *
 *   X_i = w x b + s (alpha/r) w x (w x b) over 1 (Landau and Lifshitz) or 1 + alpha^2 (Gilbert), s the sign of kappa
 *       = orientation * w x R,   R = share (b + orientation s (alpha/r) w x b)
 */
#ifndef WITNESS_H
#define WITNESS_H

#include <stddef.h>
#include <stdint.h>

typedef long double real;

enum { OK = 0, NO_CONVERGENCE = 1, NO_SOLUTION = 2, NOT_FINITE = 4, BAD_ELEMENT = 5,
       OFF_LEAF = 6, SINGULAR = 7, NO_MEMORY = 8 };

/* One instruction: its result is the register of the same number. */
typedef struct instruction {
  int32_t op, a, b, c; /* operation and the registers (or positions) it reads */
  double number;       /* the value of a constant */
} instruction;

/* A term: straight code, run once for each instance of its index family. */
typedef struct program {
  int64_t length, slots, columns, instances;
  const instruction *code;  /* length */
  const int64_t *site;      /* instances x slots: the site of each spin of the term */
  const double *data;       /* instances x columns: index values and weights */
  const double *table;      /* entries of the arrays, one after the other */
  const uint8_t *feels;     /* slots: 1 when the term acts on that spin */
} program;

/* One component of a torque: the value of a term, at the site that it moves in each instance. */
typedef struct pushes {
  program value;
  const int64_t *moved; /* instances */
  int64_t component;
} pushes;

typedef struct system {
  int64_t sites, effects, torques;
  const program *effect;
  const pushes *torque;
  const double *kappa;   /* sites */
  const double *casimir; /* sites x 9: A_i */
  const double *leaf;    /* sites: C on the leaf if it is fixed (r^2/2), else NaN */
  const double *alpha;   /* sites: damping, 0 for none */
  const double *share;   /* sites: 1, or 1/(1 + alpha^2); 0 where a site does not move */
  const double *lag;     /* sites: 1 where damping acts on torques too (Gilbert's), else 0 */
  double orientation;
} system_t;

/* Receives the Hessian block d2H/dw_i dw_j of one instance, row-major. */
typedef void (*block_sink)(void *to, int64_t i, int64_t j, const real block[9]);

/* term.c: value, gradient and Hessian of a term, summed over its instances; of a component of a torque its values and slopes, at the sites that they
 * move */
int term_value(const program *p, real t, const real *w, real *sum);
int term_gradient(const program *p, real t, const real *w, real *gradient);
int term_values(const program *p, real t, const real *w, const int64_t *moved, int64_t component, real *T);
int term_slopes(const program *p, real t, const real *w, const int64_t *moved, int64_t component, int64_t rows,
                double *slopes, real *T_dt);
int term_hessian(const program *p, real t, const real *w, real *gradient, real *gradient_dt,
                 block_sink sink, void *to);

/* field.c: b, X and their derivatives; dense matrices of 3*sites rows, row-major */
int field(const system_t *s, real t, const real *w, real *b);
int field_derivative(const system_t *s, real t, const real *w, real *b, double *db,
                     real *b_dt);
void turning(const system_t *s, int64_t i, const real *w, const real *b, real R[3]);
void turn(const system_t *s, const real *w, const real *b, real *x);
void cross(const real a[3], const real b[3], real x[3]);
real gilbert_loss(const system_t *s, int64_t i);
void turn_derivative(const system_t *s, const real *w, const real *b, double *db);

/* torque.c: x += what torques do, and its derivatives; x_dt may be NULL */
int push(const system_t *s, real t, const real *w, real *x);
int push_derivative(const system_t *s, real t, const real *w, double *dx, real *x_dt);

/* project.c: from the midpoint to the point where the field is taken */
int leaf_of(const system_t *s, int64_t i, const real *w, real *c);
int project(const system_t *s, int64_t i, const real *mbar, real c, real *m);
void project_derivative(const system_t *s, int64_t i, const real *mbar, real c, real dm[9]);

/* step.c: one step of a method; d = W - w, found by Newton's method */
enum { SPHERICAL_MIDPOINT = 0, CLASSICAL_MIDPOINT = 1, MOSER_VESELOV = 2 };

#endif
