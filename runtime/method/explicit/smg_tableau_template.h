/* smidgen method: the rows of smg_extrapolation.h for one site in registers; a template (smg_template.h), which
 * smg_lane_extrapolation.h compiles for several states. smg_tableau_at(f, j, m): the coefficients for t + m h/(2j). */
#include "smg_tableau.h"

#include "smg_model.h"
#include "smg_vec.h"

/* D_n of row j; first: k_0. Sums begin at -0, to which compilers know better than to add. */
SMG_INLINE smg_vec smg_tableau_row(smg_tableau_field *f, smg_vec w, smg_vec first, int j) {
  const smg_number zero = smg_of(-(smg_real)0), part = smg_of((smg_real)1 / (smg_real)j);
  smg_vec older = smg_vec_of(zero, zero, zero), newer = smg_vec_scale(smg_of((smg_real)0.5), first);
  for (int m = 1; m < 2 * j; ++m) {
    const smg_coefficients *c = smg_tableau_at(f, j, m);
    const smg_vec next = smg_vec_add(older, smg_motion(c, smg_vec_add(w, smg_vec_scale(part, newer)), smg_of(1)));
    older = newer;
    newer = next;
  }
  return newer;
}

/* u = sum_j W_j/j D_n */
SMG_INLINE smg_vec smg_tableau_increment(smg_tableau_field *f, smg_vec w) {
  const smg_vec first = smg_motion(smg_tableau_at(f, 1, 0), w, smg_of(1));
  smg_vec sum = smg_vec_scale(smg_of(smg_tableau_weights[0]), smg_tableau_row(f, w, first, 1));
  SMG_UNROLL
  for (int j = 2; j <= SMG_TABLEAU_ROWS; ++j)
    sum = smg_vec_add(sum, smg_vec_scale(smg_of(smg_tableau_weights[j - 1]), smg_tableau_row(f, w, first, j)));
  return smg_vec_of(sum.x / smg_tableau_unit, sum.y / smg_tableau_unit, sum.z / smg_tableau_unit);
}
