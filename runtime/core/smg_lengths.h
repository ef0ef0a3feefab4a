/* smidgen method: the lengths of w, for methods whose step is made of rotations.
 *
 * A rotation keeps |w|; its rounded sine and cosine do not quite, and where the angle is the same in every step what
 * they change |w| by is of one sign: 5e-13 after 1e6 steps of a spin in a constant field. So s->inverse remembers
 * 1/|w|^2, and every step takes a part of what has come up since out again: 2e-16. */
#ifndef SMG_LENGTHS_H
#define SMG_LENGTHS_H

#include "smg_model.h"
#include "smg_turn_template.h"

/* 1/|w|^2 where the trajectory begins, on a sphere by its radius. A site of R^3 that is 0 stays so. */
SMG_COLD static void smg_begin_lengths(smg_state *s) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    const smg_real radius = smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) : 0;
    const smg_real square = radius > 0 ? radius * radius : smg_dot(s->w + 3 * k, s->w + 3 * k);
    s->inverse[k] = square > 0 ? 1 / square : 0;
  }
}

/* Those of a saved state: none before the first step. */
static inline void smg_save_lengths(const smg_state *s, smg_real *out) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) out[k] = s->history > 0 ? s->inverse[k] : 0;
}

/* Is an increment a number? An angle so large that tau^2 overflows leaves NaN. */
SMG_INLINE int smg_is_finite(const smg_real *u) { return smg_abs(u[0]) + smg_abs(u[1]) + smg_abs(u[2]) <= SMG_MAX; }

/* w of site k along itself back to the length that it had at the start, by the part SMG_RESTORED of the way: a part of
 * an ulp, to be added with the next turn. */
SMG_INLINE void smg_restore_length(smg_state *s, int64_t k) {
  const smg_real *w = s->w + 3 * k, back = smg_way_back(s->inverse[k], w);
  smg_axpy(s->compensation + 3 * k, back, w, 3);
}

/* w + u of site k, and along v = w + u back to the length that it had at the start, by the part SMG_RESTORED of the
 * way. */
SMG_INLINE void smg_commit_site(smg_state *s, int64_t k, const smg_real *v, const smg_real *u) {
  smg_real *w = s->w + 3 * k;
  const smg_real back = smg_way_back(s->inverse[k], w);
  if (!(smg_moves(&s->c, k) > 0)) return;
  for (int b = 0; b < 3; ++b) smg_add_compensated(w + b, &s->compensation[3 * k + b], u[b] + back * v[b]);
}

#endif
