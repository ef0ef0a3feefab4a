/* smidgen method: extrapolation of Gragg, Bulirsch and Stoer, explicit, of order 12. A step is h, whatever its error;
 * it is no symplectic method: energy and leaves drift.
 *
 * w' = f(t, w) = (1/kappa) grad C(w) x dH/dw. Row j = 1 .. 6 goes from y_0 = w through h in n = 2j steps of the
 * explicit midpoint rule,
 *     y_1 = y_0 + (h/n) f(t, y_0),   y_(m+1) = y_(m-1) + (2h/n) f(t + m h/n, y_m).
 * For even n the error of y_n is a series in powers of 1/n^2 (Gragg 1965), so that polynomials in 1/n^2 through all
 * rows give at 0
 *     W = sum_j W_j y_n,   W_j = prod_(i != j) j^2/(j^2 - i^2) = 2 (-1)^j j^12/((6 - j)! (6 + j)!),   sum_j W_j = 1,
 * of order 12, without a smoothing step. Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.9.
 *
 * Weights of both signs, up to 12, would enlarge what is lost to rounding. So a row adds D_m = j (y_m - w), which takes
 * no coefficient:
 *     D_1 = k_0/2,   D_(m+1) = D_(m-1) + k_m,   k_m = h f(t + m h/n, w + D_m/j),
 * and W_j/j is an integer over 19958400 = 12!/24: what is left is of random sign.
 *
 * Of the model it needs smg_gradient or smg_motion; and beside w, compensation and u the array s->tableau, 15 numbers a
 * site. Nothing is remembered from step to step. */
#ifndef SMG_EXTRAPOLATION_H
#define SMG_EXTRAPOLATION_H

#include "smg_leaf.h"

#define SMG_ONTO_LEAF 0
#define SMG_LEAVES_DRIFT 1

#if SMG_COMPOSED || SMG_EXTENDED || SMG_PLAIN_SUMS
#error "smg_extrapolation.h: no composition, for it is not symmetric; and neither SMG_EXTENDED nor SMG_PLAIN_SUMS"
#endif

#include "smg_no_history.h"
#include "smg_right_side.h"
#include "smg_tableau.h"

/* ---- the increment
 * --------------------------------------------------------------------------------------------------------- */
#if SMG_HAS_MOTION
typedef smg_state smg_tableau_field;

SMG_INLINE const smg_coefficients *smg_tableau_at(smg_state *s, int j, int m) {
  smg_set_time_at(&s->c, s, smg_tableau_part(j, m));
  return &s->c;
}

#include "smg_tableau_template.h"

static inline void smg_solve_increment(smg_state *s) {
  smg_vec_store(s->u, smg_tableau_increment(s, smg_vec_load(s->w)));
}
#else
/* s->tableau: five vectors of 3 numbers a site. D_m stands in SMG_D or, of odd m, in SMG_D_ODD. */
enum { SMG_FIRST, SMG_SLOPE, SMG_POINT, SMG_D, SMG_D_ODD };

static inline smg_real *smg_tableau_vector(const smg_state *s, int i) { return smg_vector_of(s, s->tableau, i); }

/* D_(m+1), where D_(m-1) is. */
static void smg_tableau_step(smg_state *s, int j, int m, smg_real *D, const smg_real *newer) {
  const int64_t n = smg_numbers(s);
  smg_real *point = smg_tableau_vector(s, SMG_POINT), *k = smg_tableau_vector(s, SMG_SLOPE);
  smg_waxpy(point, (smg_real)1 / (smg_real)j, newer, smg_spins(s), n);
  smg_set_time_at(&s->c, s, smg_tableau_part(j, m));
  smg_slopes_at(s, 1, point, k);
  smg_axpy(D, 1, k, n);
}

/* u += W_j/j D_n, times smg_tableau_unit. */
static void smg_add_tableau_row(smg_state *s, int j) {
  const int64_t n = smg_numbers(s);
  smg_real *even = smg_tableau_vector(s, SMG_D), *odd = smg_tableau_vector(s, SMG_D_ODD);
  smg_zero(even, n);
  smg_multiple(odd, (smg_real)0.5, smg_tableau_vector(s, SMG_FIRST), n);
  for (int m = 1; m < 2 * j; ++m) smg_tableau_step(s, j, m, m % 2 ? even : odd, m % 2 ? odd : even);
  smg_axpy(s->u, smg_tableau_weights[j - 1], even, n);
}

static inline void smg_solve_increment(smg_state *s) {
  smg_set_time_at(&s->c, s, 0);
  smg_slopes_at(s, 1, smg_spins(s), smg_tableau_vector(s, SMG_FIRST));
  smg_zero(s->u, smg_numbers(s));
  for (int j = 1; j <= SMG_TABLEAU_ROWS; ++j) smg_add_tableau_row(s, j);
  smg_divide(s->u, smg_tableau_unit, smg_numbers(s));
}
#endif

#include "smg_increment_step.h"

#endif
