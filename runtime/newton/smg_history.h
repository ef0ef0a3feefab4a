/* smidgen runtime: the history of a state, the increments of its last steps, newest first in s->past. */
#ifndef SMG_HISTORY_H
#define SMG_HISTORY_H

#include "smg_model.h"
#include "smg_tolerances.h"

#define SMG_NO_DEGREE -1 /* of the predictor, before the first step */

#define SMG_OWN_BLANK_HISTORY 1
static inline void smg_blank_history(smg_state *s) {
  s->degree = SMG_NO_DEGREE;
  s->newton_steps = 0;
#if SMG_COMPOSED
  s->stage = 0;
#endif
}

/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)(SMG_HISTORY * 3 * smg_sites(c)); }

/* The increments lie one after the other from mem + used; returns how many numbers are used then. */
static inline size_t smg_place_history(smg_state *s, smg_real *mem, size_t used) {
  const size_t n3 = (size_t)(3 * smg_sites(&s->c));
  for (int j = 0; j < SMG_HISTORY; ++j, used += n3) s->past[j] = mem ? mem + used : NULL;
#if SMG_COMPOSED
  for (int j = 0; j < SMG_HISTORY; ++j, used += n3) s->spare[j] = mem ? mem + used : NULL;
#endif
  return used;
}

/* The increments at *newest join a history of `most` steps, and take the room of the oldest. */
static inline void smg_remember(smg_state *s, int most, smg_real **newest) {
  smg_real *oldest = s->past[most - 1];
  for (int j = most - 1; j > 0; --j) s->past[j] = s->past[j - 1];
  s->past[0] = *newest;
  *newest = oldest;
  if (s->history < most) ++s->history;
  if (s->degree < 0) s->degree = 0;
}

/* The increment of site k in the step just taken. */
static inline const smg_real *smg_last_increment(const smg_state *s, int64_t k) { return s->past[0] + 3 * k; }

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  const int64_t n3 = 3 * smg_sites(&s->c);
  for (int j = 0; j < SMG_HISTORY; ++j) smg_copy(out + j * n3, s->past[j], n3);
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  const int64_t n3 = 3 * smg_sites(&s->c);
#if SMG_COMPOSED
  s->stage = 0;
#endif
  for (int j = 0; j < SMG_HISTORY; ++j) smg_copy(s->past[j], in + j * n3, n3);
}

#endif
