/* smidgen method: the exact rotation of a site by an angle vector a. The motion w' = w x a for a time 1 turns w about a
 * by the angle |a|,
 *
 *     W = w + (sin |a|/|a|) w x a + ((1 - cos |a|)/|a|^2) (w x a) x a                     (Rodrigues)
 *       = w + s c w x a + (s^2/2) (w x a) x a,   c = cos(|a|/2),  s = sin(|a|/2)/(|a|/2):
 *
 * in half the angle no difference of nearby numbers is taken. */
#ifndef SMG_ROTATION_H
#define SMG_ROTATION_H

#include "smg_site.h"

/* sin x/x. */
SMG_INLINE smg_real smg_sinc(smg_real x) { return smg_abs(x) > 0 ? SMG_MATH(sin)(x) / x : 1; }

/* v turns by a, and u moves with it. */
SMG_INLINE void smg_turn_by(const smg_real *a, smg_real *v, smg_real *u) {
  const smg_real half = 0.5 * smg_norm(a), s = smg_sinc(half), c = SMG_MATH(cos)(half);
  smg_real x[3], xx[3];
  smg_cross(x, v, a);
  smg_cross(xx, x, a);
  for (int b = 0; b < 3; ++b) {
    const smg_real moved = s * (c * x[b] + 0.5 * s * xx[b]);
    v[b] += moved;
    u[b] += moved;
  }
}

#endif
