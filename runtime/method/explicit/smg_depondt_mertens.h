/* smidgen method: the predictor and corrector by rotations of Depondt and Mertens (J. Phys.: Condens. Matter 21 (2009)
 * 336005), of order 2. A comparator: explicit, spheres are kept, and nothing else; not symplectic, not reversible.
 *
 *     k_1 at w             and t
 *     k_2 at exp(k_1) w    and t + h,      W = exp((k_1 + k_2)/2) w,
 *
 * with angle vectors k = h b and thermal noise in both (smg_angles.h): the field of a step is that of its two ends. */
#ifndef SMG_DEPONDT_MERTENS_H
#define SMG_DEPONDT_MERTENS_H

#define SMG_ANGLES 2
#include "smg_angles.h"

/* The step of the size h. */
static void smg_stage(smg_state *s, smg_real h) {
  static const smg_real ahead[2] = {1, 0}, mean[2] = {0.5, 0.5};
  smg_draw_noise(s, h);
  smg_take_turns(s, 1, h, 0);
  smg_turn_points(s, 1, ahead);
  smg_take_turns(s, 2, h, 1);
  smg_turn_points(s, 1, mean);
}

#include "smg_explicit_step.h"

#endif
