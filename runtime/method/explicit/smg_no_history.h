/* smidgen method: the history of a method that keeps nothing from step to step. */
#ifndef SMG_NO_HISTORY_H
#define SMG_NO_HISTORY_H

#include "smg_leaf.h"

#define SMG_NO_DEGREE -1 /* there is no predictor */
#ifndef SMG_HISTORY
#define SMG_HISTORY 0
#endif

static inline size_t smg_history_size(SMG_UNUSED const smg_coefficients *c) { return 0; }
static inline void smg_save_history(SMG_UNUSED const smg_state *s, SMG_UNUSED smg_real *out) {}
static inline void smg_restore_history(SMG_UNUSED smg_state *s, SMG_UNUSED const smg_real *in) {}

#endif
