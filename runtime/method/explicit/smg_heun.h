/* smidgen method: Heun's method with projection onto the spheres, of order 2, with thermal noise of weak order 1 in
 * general, in the sense of Stratonovich (Garcia-Palacios and Lazaro, Phys. Rev. B 58 (1998) 14937; predicted points are
 * projected too, as by Evans and others, J. Phys.: Condens. Matter 26 (2014) 103202). A comparator: explicit; not
 * symplectic, not reversible.
 *
 *     x_1 = w x k_1                 k_1 at w and t
 *     x_2 = w_1 x k_2               k_2 at w_1 = P(w + x_1) and t + h,      W = P(w + (x_1 + x_2)/2),
 *
 * P brings a vector to the length of w, k = h b and thermal noise in both (smg_angles.h). */
#ifndef SMG_HEUN_H
#define SMG_HEUN_H

#define SMG_ANGLES 2
#include "smg_angles.h"

/* s->points = P(w + x_1), or P(w + (x_1 + x_2)/2); s->u is by how much they have moved. */
static void smg_heun_points(smg_state *s, int both) {
  for (int64_t k = 0, q = 0; k < smg_sites(&s->c); ++k, q += 3) {
    smg_real *v = s->points + q, x[3], y[3];
    smg_cross(x, s->w + q, smg_turns(s, 1) + q);
    smg_cross(y, v, smg_turns(s, both ? 2 : 1) + q);
    for (int b = 0; b < 3; ++b) v[b] = s->w[q + b] + (both ? (smg_real)0.5 * (x[b] + y[b]) : x[b]);
    const smg_real square = s->inverse[k] * smg_dot(v, v);
    const smg_real size = square > 0 && square <= SMG_MAX ? SMG_MATH(sqrt)(square) : 1 + (square - square); /* or NaN */
    smg_divide(v, size, 3);
    smg_waxpy(s->u + q, -1, s->w + q, v, 3);
  }
}

/* The step of the size h. */
static void smg_stage(smg_state *s, smg_real h) {
  smg_draw_noise(s, h);
  smg_take_turns(s, 1, h, 0);
  smg_heun_points(s, 0);
  smg_take_turns(s, 2, h, 1);
  smg_heun_points(s, 1);
}

#include "smg_explicit_step.h"

#endif
