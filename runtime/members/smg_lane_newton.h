/* smidgen method: the iterations of smg_sphere_template.h for SMG_LANES states of a single unit sphere at once, of a
 * step (smg_lane_sphere.h) or of a stage (smg_lane_composition.h).
 *
 * The model adds the kernels that smg_single_sphere.h asks for, in lanes: smg_lane_motion, smg_lane_radial,
 * smg_lane_derivative, smg_lane_slope_times, smg_lane_slope_minors, smg_lane_slope_sums. */
#ifndef SMG_LANE_NEWTON_H
#define SMG_LANE_NEWTON_H

#if !SMG_COMPOSED
#include "smg_lane_misses.h"
#endif
#include "smg_lane_vec.h"
#include "smg_single_sphere.h"

#if SMG_LANES > 1

#define smg_iterate smg_lane_iterate
#define smg_found smg_lane_found
#define smg_clear_of_branches smg_lane_clear_of_branches
#define smg_within_ulp smg_lane_within_ulp
#define smg_near_zero_settled smg_lane_near_zero_settled
#define smg_twice_midpoint smg_lane_twice_midpoint
#define smg_image smg_lane_image
#define smg_sphere_trace smg_lane_sphere_trace
#define smg_sphere_determinant smg_lane_sphere_determinant
#define smg_sphere_bound smg_lane_sphere_bound
#define smg_sphere_newton smg_lane_sphere_newton
#define smg_found_at smg_lane_found_at
#define smg_sphere_evaluate smg_lane_sphere_evaluate
#define smg_sphere_settled smg_lane_sphere_settled
#define smg_sphere_confirmed smg_lane_sphere_confirmed
#define smg_sphere_small smg_lane_sphere_small
#define smg_sphere_done smg_lane_sphere_done
#define smg_sphere_refine smg_lane_sphere_refine
#define smg_sphere_converge smg_lane_sphere_converge
#define smg_sphere_again smg_lane_sphere_again
#define smg_sphere_move smg_lane_sphere_move
#define smg_sphere_keep smg_lane_sphere_keep
#define smg_sphere_misses smg_lane_sphere_misses
#define smg_add_misses smg_lane_add_misses
#include "smg_in_lanes.h"
#include "smg_sphere_template.h"
#include "smg_in_numbers.h"

/* The lanes `left`, which one Newton iteration has not settled; f: what it found, and then what more of them have.
 * Returns those that are left to smg_step(). */
SMG_COLD static smg_lane_mask smg_lanes_again(const smg_lane_coefficients *c, const smg_lanes *at,
                                              const smg_lanes *compensated, smg_lane_mask left,
                                              const smg_lane_iterate *n, smg_lane_found *f, smg_lane_mask *iterations) {
  const smg_lane_mask near = left & (smg_lane_mask)(n->size < SMG_SECOND);
  if (!smg_lane_any(near)) return left;
  const smg_lane_vec w = smg_lane_vec_load(at), compensation = smg_lane_vec_load(compensated);
  smg_lane_found again;
  const smg_lane_mask good = smg_lane_sphere_again(c, w, compensation, near, *n, &again, iterations);
  *f = smg_lane_found_at(w, compensation, smg_lane_vec_select(near, again.v, f->v),
                         smg_lane_select(near, again.q, f->q), smg_lane_select(near, again.residual, f->residual));
  return left & ~(near & good);
}

#endif
#endif
