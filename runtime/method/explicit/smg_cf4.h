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
 *     W = exp((-k_1 + 2 k_2 + 2 k_3 + 3 k_4)/12) exp((3 k_1 + 2 k_2 + 2 k_3 - k_4)/12) w.
 *
 * Of the model it needs smg_gradient; and beside w, compensation and u the arrays s->points, 3 numbers a site,
 * s->turns, 12, and s->inverse, 1. */
#ifndef SMG_CF4_H
#define SMG_CF4_H

#define SMG_ONTO_LEAF 1

#include "smg_model.h"
#include "smg_respond.h"
#include "smg_rotation.h"
#include "smg_explicit.h"

#if SMG_COMPOSED
#error "smg_cf4.h is not symmetric, so that symmetric compositions of it raise no order"
#endif

/* k_i of all sites. */
SMG_INLINE smg_real *smg_turns(const smg_state *s, int i) { return s->turns + 3 * smg_sites(&s->c) * (i - 1); }

/* k_i = h b at s->points, the time t + part h. */
static void smg_take_turns(smg_state *s, int i, smg_real h, smg_real part) {
  const int64_t sites = smg_sites(&s->c);
  smg_real *k = smg_turns(s, i);
  smg_set_time_at(&s->c, s, part);
  for (int64_t q = 0; q < 3 * sites; ++q) k[q] = 0;
  smg_gradient(&s->c, s->points, k);
  smg_respond_all(&s->c, s->points, k);
  for (int64_t q = 0; q < 3 * sites; ++q) k[q] *= smg_h_over_kappa(&s->c, q / 3, h);
}

/* All sites: s->points turn by a_1 k_1 + .. + a_4 k_4, from where they are or from w; s->u moves with them. A k_i
 * without a share is not looked at: it may be one that a refused step has left. */
static void smg_turn_points(smg_state *s, int from_w, const smg_real *a) {
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); q += 3) {
    smg_real turn[3];
    for (int b = 0; b < 3; ++b) {
      turn[b] = 0;
      for (int i = 1; i <= 4; ++i)
        if (a[i - 1] != 0) turn[b] += a[i - 1] * smg_turns(s, i)[q + b];
      if (from_w) s->points[q + b] = s->w[q + b];
      if (from_w) s->u[q + b] = 0;
    }
    smg_turn_by(turn, s->points + q, s->u + q);
  }
}

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
