/* smidgen runtime: the history of a method of one step, which remembers nothing of the steps before. */
#ifndef SMG_NO_HISTORY_H
#define SMG_NO_HISTORY_H

#include "smg_model.h"

#define SMG_NO_DEGREE 0
#define SMG_REST 0

static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) {
  (void)c;
  return 0;
}

static inline smg_real smg_saved_rest(const smg_state *s) {
  (void)s;
  return 0;
}

static inline void smg_restore_rest(smg_state *s, smg_real rest) {
  (void)s;
  (void)rest;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  (void)s;
  (void)out;
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  (void)s;
  (void)in;
}

#endif
