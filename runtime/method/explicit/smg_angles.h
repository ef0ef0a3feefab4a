/* smidgen method: angle vectors of all sites, for explicit methods that turn sites by sums of some of them.
 *
 * k_i = h b, b = (1/kappa) dH/dw (smg_respond.h), is taken at s->points and at a time within the step. Where a method
 * has thermal noise in its step (SMG_NOISE_WITHIN), not around it (smg_thermal.h), every k_i of a step has the same
 * Gaussian vector more, whose components have the variance 2 D h, D = smg_diffusion: one path of Brownian motion on the
 * sphere, in the sense of Stratonovich.
 *
 * Of the model it needs smg_gradient; and beside w, compensation and u the arrays s->points, 3 numbers a site,
 * s->turns, 3 SMG_ANGLES, and s->inverse, 1. */
#ifndef SMG_ANGLES_H
#define SMG_ANGLES_H

#define SMG_ONTO_LEAF 1

#include "smg_model.h"
#include "smg_respond.h"
#include "smg_rotation.h"
#include "smg_explicit.h"

#if SMG_COMPOSED
#error "smg_angles.h is for methods that are not symmetric, so that symmetric compositions of them raise no order"
#endif

/* k_i of all sites. */
SMG_INLINE smg_real *smg_turns(const smg_state *s, int i) { return s->turns + 3 * smg_sites(&s->c) * (i - 1); }

#if SMG_THERMAL && SMG_NOISE_WITHIN
#include "smg_random.h"

/* The noise of a step, kept in s->unturned: its points need it more than once. */
static void smg_draw_noise(smg_state *s, smg_real h) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real deviation = SMG_MATH(sqrt)(2 * smg_diffusion(&s->c, k) * smg_abs(h));
    double theta[3];
    smg_three_normals(smg_philox_of(smg_counter(s->count, k, SMG_USE_NOISE, s->member), s->seed), theta);
    for (int b = 0; b < 3; ++b) s->unturned[3 * k + b] = deviation * theta[b];
  }
}

static void smg_add_noise(const smg_state *s, smg_real *k) { smg_axpy(k, 1, s->unturned, 3 * smg_sites(&s->c)); }
#else
SMG_INLINE void smg_draw_noise(SMG_UNUSED smg_state *s, SMG_UNUSED smg_real h) {}
SMG_INLINE void smg_add_noise(SMG_UNUSED const smg_state *s, SMG_UNUSED smg_real *k) {}
#endif

/* k_i = h b at s->points, the time t + part h. */
static void smg_take_turns(smg_state *s, int i, smg_real h, smg_real part) {
  const int64_t sites = smg_sites(&s->c);
  smg_real *k = smg_turns(s, i);
  smg_set_time_at(&s->c, s, part);
  smg_zero(k, 3 * sites);
  smg_gradient(&s->c, s->points, k);
  smg_respond_all(&s->c, s->points, k);
  for (int64_t q = 0; q < 3 * sites; ++q) k[q] *= smg_h_over_kappa(&s->c, q / 3, h);
  smg_add_noise(s, k);
}

/* All sites: s->points turn by a_1 k_1 + a_2 k_2 + .., from where they are or from w; s->u moves with them. A k_i
 * without a share is not looked at: it may be one that a refused step has left. */
static inline void smg_turn_points(smg_state *s, int from_w, const smg_real *a) {
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); q += 3) {
    smg_real turn[3];
    for (int b = 0; b < 3; ++b) {
      turn[b] = 0;
      for (int i = 1; i <= SMG_ANGLES; ++i)
        if (a[i - 1] != 0) turn[b] += a[i - 1] * smg_turns(s, i)[q + b];
      if (from_w) s->points[q + b] = s->w[q + b];
      if (from_w) s->u[q + b] = 0;
    }
    smg_turn_by(turn, s->points + q, s->u + q);
  }
}

#endif
