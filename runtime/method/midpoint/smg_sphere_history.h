/* smidgen method: the history of a single sphere, SMG_ROWS rows of (u, 1/|w + W|) in one array (of a composition (u,
 * gamma/|w + W|)); s->row is the newest. */
#ifndef SMG_SPHERE_HISTORY_H
#define SMG_SPHERE_HISTORY_H

#include "smg_model.h"
#include "smg_tolerances.h"

#define SMG_NO_DEGREE 0
#ifndef SMG_ROWS
#define SMG_ROWS 64 /* rows before they are moved back; members in lanes keep fewer */
#endif

#define SMG_OWN_BLANK_HISTORY 1
static inline void smg_blank_history(smg_state *s) {
  s->degree = SMG_NO_DEGREE;
  s->begun = s->count;
  s->row = SMG_ROWS - SMG_HISTORY;
  smg_zero(s->older, 4);
#if SMG_COMPOSED
  s->stage = 0;
#endif
}

/* The rows of the first steps are 0. */
#define SMG_HISTORY_ARRAYS 1
static inline void smg_forget_arrays(smg_state *s) { smg_zero(s->rows, 4 * SMG_ROWS); }

/* Rows of the history that are of steps taken, `count` of them in all; those of a composition are counted as they
 * come. */
static inline int smg_rows_known(const smg_state *s, SMG_UNUSED int64_t count) {
#if SMG_COMPOSED
  return s->history;
#else
  return count - s->begun < SMG_HISTORY ? (int)(count - s->begun) : SMG_HISTORY;
#endif
}

/* Numbers of the history. */
static inline size_t smg_history_size(SMG_UNUSED const smg_coefficients *c) { return 4 * SMG_HISTORY; }

/* The increment of site k in the step just taken. */
static inline const smg_real *smg_last_increment(const smg_state *s, SMG_UNUSED int64_t k) {
  return s->rows + 4 * s->row;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  smg_copy(out, s->rows + 4 * s->row, 4 * SMG_HISTORY);
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  s->begun = s->count - s->history;
#if SMG_COMPOSED
  s->stage = 0;
#endif
  smg_copy(s->rows + 4 * s->row, in, 4 * SMG_HISTORY);
}

#endif
