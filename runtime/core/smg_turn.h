/* smidgen runtime: turns of vectors, of one or of one in each lane (smg_number.h):
 *
 *     W = w + 2/(1 + |g|^2) (w x g + (w x g) x g)
 *
 * turns w about g by the angle whose half has the tangent |g|. Each is added to w with its rounding error carried
 * along; a part SMG_RESTORED of what rounding has changed |w| by is taken out again (smg_lengths.h). */
#include "smg_site.h"
#include "smg_number.h"

/* Part of the error of |w| that a step takes out. What a step adds to it is a small part of an ulp, and the error is
 * known to about one: so a sixteenth leaves less than an ulp of either. */
#define SMG_RESTORED (smg_real)0.0625

/* The part of w by which |w| falls short, times SMG_RESTORED; inverse = 1/|w|^2 where the trajectory begins. */
SMG_INLINE SMG_NUMBER SMG_OF(way_back)(smg_real inverse, const SMG_NUMBER *w) {
  return (smg_real)0.5 * SMG_RESTORED * (1 - inverse * SMG_OF(dot)(w, w));
}

/* w about g; back: and some of the way back to its length. */
SMG_INLINE void SMG_OF(turn_one)(const SMG_NUMBER *g, smg_real inverse, int back, SMG_NUMBER *w, SMG_NUMBER *lost) {
  const SMG_NUMBER scale = 2 / (1 + SMG_OF(dot)(g, g)), more = SMG_OF(way_back)(inverse, w);
  SMG_NUMBER x[3], xx[3];
  SMG_OF(cross)(x, w, g);
  SMG_OF(cross)(xx, x, g);
  for (int b = 0; b < 3; ++b) {
    SMG_NUMBER moved = scale * (x[b] + xx[b]);
    if (back) moved += more * (w[b] + moved);
    SMG_OF(add_compensated)(w + b, lost + b, moved);
  }
}

/* Both v and w about g = a (one v + other w): with p = v x w that is v x g = a other p and w x g = -a one p, so that
 *
 *     V = v + other q,   W = w - one q,   q = 2 a/(1 + |g|^2) (p + p x g).
 *
 * |g|^2; where that overflows, q is 0. */
SMG_INLINE SMG_NUMBER SMG_OF(turn_both)(SMG_NUMBER a, smg_real one, smg_real other, SMG_NUMBER *v, SMG_NUMBER *v_lost,
                                        SMG_NUMBER *w, SMG_NUMBER *w_lost) {
  SMG_NUMBER g[3], p[3], pg[3];
  for (int b = 0; b < 3; ++b) g[b] = a * (one * v[b] + other * w[b]);
  const SMG_NUMBER square = SMG_OF(dot)(g, g), scale = 2 / (1 + square) * a;
  SMG_OF(cross)(p, v, w);
  SMG_OF(cross)(pg, p, g);
  for (int b = 0; b < 3; ++b) {
    const SMG_NUMBER q = scale * (p[b] + pg[b]);
    SMG_OF(add_compensated)(v + b, v_lost + b, other * q);
    SMG_OF(add_compensated)(w + b, w_lost + b, -(one * q));
  }
  return square;
}
