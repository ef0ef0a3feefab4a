/* smidgen method: the history of a method that keeps nothing from step to step. */
#ifndef SMG_NO_HISTORY_H
#define SMG_NO_HISTORY_H

#include "smg_leaf.h"

#define SMG_NO_DEGREE -1 /* there is no predictor */
#ifndef SMG_HISTORY
#define SMG_HISTORY 0
#endif

static inline size_t smg_history_size(const smg_coefficients *c) { return (void)c, 0; }
static inline void smg_save_history(const smg_state *s, smg_real *out) { (void)s, (void)out; }
static inline void smg_restore_history(smg_state *s, const smg_real *in) { (void)s, (void)in; }

#endif
