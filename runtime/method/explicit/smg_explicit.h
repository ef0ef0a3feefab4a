/* smidgen method: what explicit methods share: where a site is on the way, and what is remembered of it from step to
 * step.
 *
 * A step is a row of rotations. It moves no w before all of them are done: s->points is where each site is, s->u by how
 * much it has moved, which is added to w in the end, and what w loses to rounding is kept. With SMG_TURNS_ADDED turns
 * are added one by one, and s->u is what s->points has lost; with SMG_LENGTHS_LAST the end of a step brings lengths
 * back, which else the turns do. */
#ifndef SMG_EXPLICIT_H
#define SMG_EXPLICIT_H

#include "smg_lengths.h"

#if SMG_HISTORY != 1 || SMG_EXTENDED || SMG_PLAIN_SUMS
#error "smg_explicit.h: SMG_HISTORY 1, and neither SMG_EXTENDED nor SMG_PLAIN_SUMS"
#endif

#define SMG_NO_DEGREE 0
#ifndef SMG_TURNS_ADDED
#define SMG_TURNS_ADDED 0
#endif
#ifndef SMG_LENGTHS_LAST
#define SMG_LENGTHS_LAST 0
#endif

/* A symmetric splitting of a stage into n parts has 2 n - 1 turns: the parts one after the other for h/2, the last one
 * for h, and back. The part of the k-th turn, and its h. */
SMG_INLINE int64_t smg_there_and_back(int64_t k, int64_t n) { return k < n ? k : 2 * n - 2 - k; }
SMG_INLINE smg_real smg_turn_h(int64_t k, int64_t n, smg_real h) { return k == n - 1 ? h : (smg_real)0.5 * h; }

/* The history: 1/|w|^2 of every site, s->history = 1 once it is known. */
static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)smg_sites(c); }

static inline void smg_save_history(const smg_state *s, smg_real *out) { smg_save_lengths(s, out); }

static inline void smg_restore_history(smg_state *s, const smg_real *in) { smg_copy(s->inverse, in, smg_sites(&s->c)); }

#include "smg_state.h"

#endif
