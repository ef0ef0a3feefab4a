/* smidgen method: CF4, the explicit commutator-free Lie-group method of Celledoni, Marthinsen and Owren
 * (Commutator-free Lie group methods, Future Generation Computer Systems 19 (2003)), of order 4: the classical
 * Runge-Kutta method with exact rotations in place of sums. A comparator: spheres are kept, and nothing else; not
 * symplectic, not reversible.
 *
 * Every site turns by angle vectors, exp(a) w (smg_rotation.h); k_i = h b, b = (1/kappa) dH/dw, at the stages and their
 * times:
 *
 *     k_1 at w                             and t
 *     k_2 at exp(k_1/2) w                  and t + h/2
 *     k_3 at exp(k_2/2) w                  and t + h/2
 *     k_4 at exp(k_3 - k_1/2) exp(k_1/2) w and t + h
 *
 *     W = exp((-k_1 + 2 k_2 + 2 k_3 + 3 k_4)/12) exp((3 k_1 + 2 k_2 + 2 k_3 - k_4)/12) w. */
#ifndef SMG_CF4_H
#define SMG_CF4_H

#define SMG_ANGLES 4
#include "smg_angles.h"

/* The step of the size h. */
static void smg_stage(smg_state *s, smg_real h) {
  static const smg_real half1[4] = {0.5, 0, 0, 0}, half2[4] = {0, 0.5, 0, 0}, third[4] = {-0.5, 0, 1, 0};
  const smg_real first[4] = {(smg_real)3 / 12, (smg_real)2 / 12, (smg_real)2 / 12, (smg_real)-1 / 12};
  const smg_real last[4] = {first[3], first[1], first[2], first[0]};
  smg_take_turns(s, 1, h, 0);
  smg_turn_points(s, 1, half1);
  smg_take_turns(s, 2, h, (smg_real)0.5);
  smg_turn_points(s, 1, half2);
  smg_take_turns(s, 3, h, (smg_real)0.5);
  smg_turn_points(s, 1, half1);
  smg_turn_points(s, 0, third);
  smg_take_turns(s, 4, h, 1);
  smg_turn_points(s, 1, first);
  smg_turn_points(s, 0, last);
}

#include "smg_explicit_step.h"

#endif
