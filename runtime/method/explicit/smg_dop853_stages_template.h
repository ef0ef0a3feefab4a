/* smidgen method: the twelve stages of Dormand and Prince of order 8, whose equations are in smg_dop853.h; a template
 * (smg_template.h).
 *
 * Who includes it gives, before: smg_trial, a state or several, with the member u; smg_vector(f, i), the i-th vector of
 * its numbers, of smg_width(f) each; smg_trial_slope(f, part, size, z, k), k = p f(t, z), p the part `size` of h and t
 * at the part `part` of it. */
#include "smg_dop853_table.h"
#include "smg_model.h"
#include "smg_vec.h"

/* sum_j a_j k_j at one component, j < count, n components to a stage. The compiler knows `a` and `count`: weights that
 * are 0 are not there. */
SMG_INLINE smg_number smg_weighted(const smg_real *a, int count, const smg_number *k, int64_t n) {
  smg_number sum = smg_of(-(smg_real)0);
  SMG_UNROLL
  for (int j = 0; j < count; ++j)
    if (a[j] != 0) sum += a[j] * k[j * n];
  return sum;
}

/* z = y + sum_j a_ij k_j, j < i: only the last term waits for the stage before. What y has lost to rounding is less
 * than what z loses. */
SMG_INLINE void smg_dop853_point(int i, const smg_number *y, const smg_number *k, int64_t n,
                                 smg_number *SMG_RESTRICT z) {
  for (int64_t q = 0; q < n; ++q) {
    smg_number older = y[q];
    if (i > 1) older += smg_weighted(smg_dop853_a[i], i - 1, k + q, n);
    z[q] = older + smg_dop853_a[i][i - 1] * k[(i - 1) * n + q];
  }
}

/* k_(i+1), i = 1 .. 11, of the step of the size `size` from y, at the part `from` of h. */
SMG_INLINE void smg_dop853_stage(smg_trial *f, smg_number from, smg_number size, const smg_number *y, int i) {
  smg_dop853_point(i, y, smg_vector(f, 0), smg_width(f), f->u);
  smg_trial_slope(f, from + smg_dop853_c[i] * size, size, f->u, smg_vector(f, i));
}

/* k_2 .. k_12 */
SMG_INLINE void smg_later_stages(smg_trial *f, smg_number from, smg_number size, const smg_number *y) {
  smg_dop853_stage(f, from, size, y, 1);
  smg_dop853_stage(f, from, size, y, 2);
  smg_dop853_stage(f, from, size, y, 3);
  smg_dop853_stage(f, from, size, y, 4);
  smg_dop853_stage(f, from, size, y, 5);
  smg_dop853_stage(f, from, size, y, 6);
  smg_dop853_stage(f, from, size, y, 7);
  smg_dop853_stage(f, from, size, y, 8);
  smg_dop853_stage(f, from, size, y, 9);
  smg_dop853_stage(f, from, size, y, 10);
  smg_dop853_stage(f, from, size, y, 11);
}
