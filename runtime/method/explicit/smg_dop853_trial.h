/* smidgen method: the stages of Dormand and Prince (smg_dop853_stages_template.h) of one state: the i-th vector of
 * s->stages, and the right-hand side for a part of h. */
#ifndef SMG_DOP853_TRIAL_H
#define SMG_DOP853_TRIAL_H

#include "smg_right_side.h"

typedef smg_state smg_trial;

static inline smg_real *smg_vector(const smg_state *s, int i) { return smg_vector_of(s, s->stages, i); }
SMG_INLINE int64_t smg_width(const smg_state *s) { return smg_numbers(s); }

SMG_INLINE void smg_trial_slope(smg_state *s, smg_real part, smg_real size, const smg_real *w, smg_real *k) {
  smg_set_time_at(&s->c, s, part);
  smg_slopes_at(s, size, w, k);
}

#endif
