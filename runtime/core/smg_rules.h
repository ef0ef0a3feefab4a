/* smidgen runtime: what the loops of solvers decide, each rule once; a single sphere (smg_single_sphere.h) takes its
 * bounds from smg_tolerances.h. `bound` is the largest row sum of abs(J - I). */
#ifndef SMG_RULES_H
#define SMG_RULES_H

#include "smg_model.h"
#include "smg_tolerances.h"

/* Is J - I a contraction? Then no eigenvalue of J is near 0, where branches meet, and plain evaluations damp what is
 * left. */
SMG_INLINE int smg_contracts(smg_real bound) { return bound <= SMG_CONTRACTS; }

/* May plain evaluations end the step? They at most double what is left. Of a site alone: they then end it with less
 * round-off than Newton's correction does. */
SMG_INLINE int smg_plain_end_serves(smg_real bound) { return bound <= SMG_DAMPS; }

/* Do increments that turn spins far, by a field much stronger than the state, bring more round-off than mbar? */
static inline int smg_strong_field(const smg_change *now, smg_real size) {
  return now->rounding_scale > SMG_STRONG_FIELD * size;
}

/* Stagnation of the iteration `it`; from SMG_LATE on the residual may keep the round-off that J - I makes of that of
 * mbar. */
static inline int smg_stagnates(const smg_change *now, const smg_change *last, smg_real size, int it, smg_real bound) {
  return smg_settled(now, last, size * (1 + (it < SMG_LATE ? 0 : bound)));
}

/* Has the iteration come down to where it shrinks no more, though not to the round-off of its terms? Then that of the
 * field may be larger. */
static inline int smg_stalls(const smg_change *now, const smg_change *last, smg_real scale, int it) {
  return it > 2 * SMG_LATE && now->absolute <= SMG_NEARLY * scale && smg_slowed(now->relative, last->relative);
}

/* The tolerance that was asked for, a part of the state; is a change, or a residual, within it? */
SMG_INLINE smg_real smg_allowed(const smg_state *s) { return s->tolerance * s->scale; }
SMG_INLINE int smg_tolerated(const smg_state *s, smg_real change) { return change <= smg_allowed(s); }

/* Is the residual that settled sweeps left round-off of the state and of products of this size? */
static inline int smg_swept_to_round_off(smg_real residual, smg_real size) {
  return residual <= SMG_SWEEP_ULPS * SMG_EPS * size;
}

/* Does stagnation by the round-off of this size still tell something of the state? */
static inline int smg_shown(smg_real size, smg_real scale) { return SMG_STILL * SMG_EPS * size <= SMG_BLIND * scale; }

/* Is another plain evaluation due after n of them, which left the part `left` of the round-off of the iteration? */
static inline int smg_refines(int n, smg_real left) { return n < SMG_REFINEMENTS && left > SMG_LEFT; }

/* The residual that round-off may leave a site of this size: that of its own terms, and the noise of its field where
 * that is known. */
static inline smg_real smg_round_off(smg_real size, smg_real rounding_scale, smg_real bound, smg_real noise,
                                     smg_real scale) {
  return smg_min(SMG_ULPS * SMG_EPS * ((1 + bound) * size + rounding_scale) + noise, SMG_BLIND * scale);
}

#endif
