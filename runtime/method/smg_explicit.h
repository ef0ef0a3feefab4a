/* smidgen method: what explicit splittings share: where a site is on the way, and what is remembered of it from step to step.
 *
 * A step is a row of rotations. It moves no w before all of them are done: s->points is where each site is, s->u by how much it
 * has moved, which is added to w in the end, and what w loses to rounding is kept. A rotation keeps |w|; its rounded sine and cosine do
 * not quite, and where the angle is the same in every step what they change |w| by is of one sign: 5e-13 after 1e6 steps of a spin
 * in a constant field. So s->inverse remembers 1/|w|^2 of the start, and every step takes a part of what has come up since out again:
 * 2e-16. */
#ifndef SMG_EXPLICIT_H
#define SMG_EXPLICIT_H

#include "smg_model.h"

#if SMG_HISTORY != 1 || SMG_EXTENDED || SMG_PLAIN_SUMS
#error "smg_explicit.h: SMG_HISTORY 1, and neither SMG_EXTENDED nor SMG_PLAIN_SUMS"
#endif

#define SMG_NO_DEGREE 0

/* Part of the error of |w| that a step takes out. What a step adds to it is a small part of an ulp, and the error is known to
 * about one: so a sixteenth leaves less than an ulp of either. */
#define SMG_RESTORED (smg_real)0.0625

/* The history: 1/|w|^2 of every site, s->history = 1 once it is known. */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)smg_sites(c); }

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) out[k] = s->inverse[k];
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) s->inverse[k] = in[k];
}

#include "smg_state.h"

#endif
