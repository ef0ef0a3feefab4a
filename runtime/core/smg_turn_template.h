/* smidgen runtime: turns of vectors; a template (smg_template.h):
 *
 *     W = w + 2/(1 + |g|^2) (w x g + (w x g) x g)
 *
 * turns w about g by the angle whose half has the tangent |g|. Each is added to w with its rounding error carried
 * along; a part SMG_RESTORED of what rounding has changed |w| by is taken out again (smg_lengths.h). */
#include "smg_site.h"

/* Part of the error of |w| that a step takes out. What a step adds to it is a small part of an ulp, and the error is
 * known to about one: so a sixteenth leaves less than an ulp of either. */
#define SMG_RESTORED (smg_real)0.0625

/* The part of w by which |w| falls short, times SMG_RESTORED; inverse = 1/|w|^2 where the trajectory begins. */
SMG_INLINE smg_number smg_way_back(smg_real inverse, const smg_number *w) {
  return (smg_real)0.5 * SMG_RESTORED * (1 - inverse * smg_dot(w, w));
}

/* w about g; back: and some of the way back to its length. */
SMG_INLINE void smg_turn_one(const smg_number *g, smg_real inverse, int back, smg_number *w, smg_number *lost) {
  const smg_number more = smg_way_back(inverse, w);
  smg_number moved[3];
  smg_turn_increment(smg_of(1), g, w, moved);
  for (int b = 0; b < 3; ++b) {
    if (back) moved[b] += more * (w[b] + moved[b]);
    smg_add_compensated(w + b, lost + b, moved[b]);
  }
}

/* Both v and w about g = a (one v + other w): with p = v x w that is v x g = a other p and w x g = -a one p, so that
 *
 *     V = v + other q,   W = w - one q,   q = 2 a/(1 + |g|^2) (p + p x g).
 *
 * |g|^2; where that overflows, q is 0. */
SMG_INLINE smg_number smg_turn_both(smg_number a, smg_real one, smg_real other, smg_number *v, smg_number *v_lost,
                                    smg_number *w, smg_number *w_lost) {
  smg_number g[3], p[3], pg[3];
  for (int b = 0; b < 3; ++b) g[b] = a * (one * v[b] + other * w[b]);
  const smg_number square = smg_dot(g, g), scale = 2 / (1 + square) * a;
  smg_cross(p, v, w);
  smg_cross(pg, p, g);
  for (int b = 0; b < 3; ++b) {
    const smg_number q = scale * (p[b] + pg[b]);
    smg_add_compensated(v + b, v_lost + b, other * q);
    smg_add_compensated(w + b, w_lost + b, -(one * q));
  }
  return square;
}
