/* smidgen method: Dormand and Prince of order 8, explicit, with a step of h, whatever its error; it is no symplectic
 * method: energy and leaves drift.
 *
 * The stages and the increment are those of smg_dop853.h, without its estimates of the error:
 *     k_i = h f(t + c_i h, w + sum_(j<i) a_ij k_j),   i = 1 .. 12,   u = sum_i b_i k_i.
 * Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5.
 *
 * Of the model it needs smg_gradient or smg_motion; and beside w, compensation and u the array s->stages, 36 numbers a
 * site. Nothing is remembered from step to step. */
#ifndef SMG_DORMAND_PRINCE_H
#define SMG_DORMAND_PRINCE_H

#define SMG_ONTO_LEAF 0
#define SMG_LEAVES_DRIFT 1

#if SMG_COMPOSED || SMG_EXTENDED || SMG_PLAIN_SUMS
#error "smg_dormand_prince.h: no composition, for it is not symmetric; and neither SMG_EXTENDED nor SMG_PLAIN_SUMS"
#endif

#include "smg_no_history.h"
#include "smg_dop853_trial.h"
#include "smg_dop853_stages_template.h"

static inline void smg_solve_increment(smg_state *s) {
  const int64_t n = smg_width(s);
  smg_trial_slope(s, 0, 1, smg_spins(s), smg_vector(s, 0));
  smg_later_stages(s, 0, 1, smg_spins(s));
  for (int64_t q = 0; q < n; ++q) s->u[q] = smg_weighted(smg_dop853_b, SMG_STAGES_USED, smg_vector(s, 0) + q, n);
}

#include "smg_increment_step.h"

#endif
