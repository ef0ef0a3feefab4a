/* smidgen runtime: the scalar type, the statuses, and the report of a step.
 *
 * The code is C11 and C++; it does not allocate memory, has no global variables and does no I/O.
 * Define SMG_LONG_DOUBLE for extended precision, SMG_QUAD for quadruple precision (gcc, -lquadmath). */
#ifndef SMIDGEN_H
#define SMIDGEN_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifdef SMG_LONG_DOUBLE
typedef long double smg_real;
#define SMG_EPS LDBL_EPSILON
#define SMG_MATH(f) f##l
#elif defined(SMG_QUAD)
#include <quadmath.h>
__extension__ typedef __float128 smg_real;
#define SMG_EPS ((smg_real)1.925929944387235853055977942584927319e-34) /* 2^-112 */
#define SMG_MATH(f) f##q
#else
typedef double smg_real;
#define SMG_EPS DBL_EPSILON
#define SMG_MATH(f) f
#endif

typedef enum smg_status {
  SMG_OK = 0,
  SMG_NO_CONVERGENCE = 1, /* no solution was found, or none that could be verified */
  SMG_NO_SOLUTION = 2,    /* the branch of solutions from W = w at h = 0 ends before this h, at a fold, at the centre of
                             a sphere or at infinity */
  SMG_WRONG_BRANCH = 3,   /* a solution was found, but not the one connected to W = w at h = 0 */
  SMG_NOT_FINITE = 4,     /* the state, a parameter or the field is infinite or NaN */
  /* a parameter or a size is out of range (kappa = 0, n < 1, a negative damping, a denormal h, |w| in R^3 not between
   1e-150 and 1e150) */
  SMG_BAD_PARAMETER = 5,
  /* a start is off its sphere by more than 1e-12 (relative; a smaller error is corrected), or c = 0 */
  SMG_OFF_MANIFOLD = 6,
  SMG_SINGULAR = 7 /* the Newton matrix could not be factored */
} smg_status;

/* Report of the last step. After a failure, site is the site at which it failed and partner a second site involved, -1
 * if there is none; reached is the fraction of h up to which solutions exist, 0 if unknown. Among sites that are solved
 * separately, the one whose solutions end first is reported. */
typedef struct smg_report {
  smg_status status;
  int iterations;
  smg_real residual; /* max norm of the step equation's residual, in units of w */
  int64_t site, partner;
  smg_real reached;
} smg_report;

static inline const char *smg_message(smg_status status) {
  static const char *const text[] = {"ok",
                                     "the step equation did not converge",
                                     "the branch of solutions from this state ends before this step",
                                     "the solution found is not connected to the state as h goes to 0",
                                     "a value is not finite",
                                     "a parameter or a size is out of range",
                                     "the start is off its sphere or leaf",
                                     "the Newton matrix is singular"};
  return (unsigned)status < sizeof text / sizeof *text ? text[status] : "unknown status";
}

#endif
