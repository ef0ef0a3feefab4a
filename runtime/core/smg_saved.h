/* smidgen runtime: a saved state, all that decides later bits: this head, then w and compensation, then the history,
 * newest first. What is not in it (scratch, values of the parameters) decides none. */
#ifndef SMG_SAVED_HEADER
#define SMG_SAVED_HEADER

#include "smg_report.h"
#include "smg_set_state.h"

enum {
  SMG_SAVED_SIZE,
  SMG_SAVED_PAST,
  SMG_SAVED_T0,
  SMG_SAVED_H,
  SMG_SAVED_COUNT_HIGH,
  SMG_SAVED_COUNT_LOW,
  SMG_SAVED_HISTORY,
  SMG_SAVED_DEGREE,
  SMG_SAVED_NEWTON_STEPS,
  SMG_SAVED_SCALE,
  SMG_SAVED_TOLERANCE,
#if SMG_THERMAL
  SMG_SAVED_SEED_HIGH,
  SMG_SAVED_SEED_LOW,
  SMG_SAVED_MEMBER,
  SMG_SAVED_HALVED,
#endif
  SMG_SAVED_HEAD
};

/* Numbers before the history. */
SMG_RARE static size_t smg_saved_past(const smg_coefficients *c) { return SMG_SAVED_HEAD + (size_t)(6 * smg_sites(c)); }

SMG_RARE static size_t smg_saved_size(const smg_coefficients *c) { return smg_saved_past(c) + smg_history_size(c); }

/* Steps that stay with Newton: models that try something else first count them. By rows, as a number below 0: the
 * passes of a step that are not watched. */
#if SMG_BY_ROWS && !SMG_ROW_TURNS
#define SMG_SAVED_MOST_STEPS SMG_NEWTON_STEPS
static inline int smg_newton_steps(const smg_state *s) { return s->rows ? -(int)s->row_from : s->newton_steps; }
static inline void smg_set_newton_steps(smg_state *s, int steps) {
  if (s->rows) s->row_from = steps < 0 ? -steps : 0;
  else s->newton_steps = steps > 0 ? steps : 0;
}
#define SMG_SAVED_LEAST_STEPS -SMG_SAVED_MOST_STEPS
#elif SMG_SWEPT || SMG_FEW_IN_LANES
#define SMG_SAVED_MOST_STEPS SMG_NEWTON_STEPS
static inline int smg_newton_steps(const smg_state *s) { return s->newton_steps; }
static inline void smg_set_newton_steps(smg_state *s, int steps) { s->newton_steps = steps; }
#else
#define SMG_SAVED_MOST_STEPS 0
static inline int smg_newton_steps(SMG_UNUSED const smg_state *s) { return 0; }
static inline void smg_set_newton_steps(SMG_UNUSED smg_state *s, SMG_UNUSED int steps) {}
#endif
#ifndef SMG_SAVED_LEAST_STEPS
#define SMG_SAVED_LEAST_STEPS 0
#endif

/* What a step has lost to rounding, and the increments before it, site by site. */
SMG_RARE static void smg_save_sites(const smg_state *s, smg_real *lost, smg_real *past) {
#if SMG_BY_ROWS
  if (s->rows) {
    smg_save_rows(s, lost, past);
    return;
  }
#endif
  smg_copy(lost, s->compensation, 3 * smg_sites(&s->c));
  smg_save_history(s, past);
}

SMG_RARE static void smg_restore_sites(smg_state *s, const smg_real *lost, const smg_real *past) {
#if SMG_BY_ROWS
  if (s->rows) {
    smg_restore_rows(s, lost, past);
    return;
  }
#endif
  smg_copy(s->compensation, lost, 3 * smg_sites(&s->c));
  smg_restore_history(s, past);
}

#define SMG_SAVED_STALE -1 /* in place of the steps that the history remembers: parameters were changed since */

/* Steps that the history remembers. */
static inline int smg_steps_known(const smg_state *s) {
#if SMG_SINGLE_SPHERE
  return smg_rows_known(s, s->count);
#else
  return s->history;
#endif
}

#if SMG_THERMAL
/* Which noise it has. */
SMG_RARE static void smg_save_noise(const smg_state *s, smg_real *out) {
  out[SMG_SAVED_SEED_HIGH] = (smg_real)(s->seed >> 32);
  out[SMG_SAVED_SEED_LOW] = (smg_real)(s->seed & 0xFFFFFFFFu);
  out[SMG_SAVED_MEMBER] = (smg_real)s->member;
  out[SMG_SAVED_HALVED] = (smg_real)s->halved;
}

SMG_RARE static void smg_restore_noise(smg_state *s, const smg_real *in) {
  s->seed = (uint64_t)in[SMG_SAVED_SEED_HIGH] << 32 | (uint64_t)in[SMG_SAVED_SEED_LOW];
  s->member = (uint32_t)in[SMG_SAVED_MEMBER];
  s->halved = (int64_t)in[SMG_SAVED_HALVED];
}
#endif

SMG_RARE static void smg_save_state(const smg_state *s, smg_real *out) {
  const int64_t n3 = 3 * smg_sites(&s->c), from = 3 * smg_own_from(&s->c);
#if SMG_LAYERS_APART
  if (!out) smg_move_saved(s, SMG_TO_LAYERS);
  if (!out) return;
#endif
  out[SMG_SAVED_SIZE] = (smg_real)smg_saved_size(&s->c);
#if SMG_LAYERS_APART
  if (smg_is_divided() && smg_layers_held != s) out[SMG_SAVED_SIZE] = 0; /* which restore refuses */
#endif
  out[SMG_SAVED_PAST] = (smg_real)smg_saved_past(&s->c);
  out[SMG_SAVED_T0] = (smg_real)s->t0;
  out[SMG_SAVED_H] = (smg_real)s->h;
  out[SMG_SAVED_COUNT_HIGH] = (smg_real)(s->count / 4294967296); /* 2^32: a double holds no count beyond 2^53 */
  out[SMG_SAVED_COUNT_LOW] = (smg_real)(s->count % 4294967296);
  out[SMG_SAVED_HISTORY] = (smg_real)(smg_is_stale(s) ? SMG_SAVED_STALE : smg_steps_known(s));
  out[SMG_SAVED_DEGREE] = (smg_real)s->degree;
  out[SMG_SAVED_NEWTON_STEPS] = (smg_real)smg_newton_steps(s);
  out[SMG_SAVED_SCALE] = s->scale;
  out[SMG_SAVED_TOLERANCE] = s->tolerance;
#if SMG_THERMAL
  smg_save_noise(s, out);
#endif
  smg_copy(out + SMG_SAVED_HEAD + from, s->w + from, 3 * smg_own_to(&s->c) - from);
  smg_save_sites(s, out + SMG_SAVED_HEAD + n3, out + smg_saved_past(&s->c));
}

SMG_RARE static int smg_integer_in(smg_real x, smg_real least, smg_real most) {
  return x >= least && x <= most && x == (smg_real)(int64_t)x;
}

/* The highest degree of the predictor with so many steps known; methods without one have SMG_NO_DEGREE. */
#ifndef SMG_MOST_DEGREE
#define SMG_MOST_DEGREE(history) ((void)(history), SMG_NO_DEGREE)
#endif

/* A degree that the predictor may have. Of no history it is not read: a state that forgets its history keeps it. */
static inline int smg_good_degree(smg_real degree, smg_real history) {
  const int known = history > 0 ? (int)history : SMG_HISTORY;
  return smg_integer_in(degree, history > 0 ? smg_min(0, SMG_MOST_DEGREE(known)) : SMG_NO_DEGREE,
                        SMG_MOST_DEGREE(known));
}

/* Steps from which time would no longer be known: t0 + count h is found in doubles, and no run gets there. */
#define SMG_MOST_COUNT_HIGH 1073741823 /* count < 2^62: as many steps again do not overflow it */

#define SMG_MOST_LOST (smg_real)1e-9 /* part of w that it may have lost to rounding, by far */

/* The part of the radius by which steps may have moved w off its sphere: none in the beginning; then by far more than
 * round-off and tolerance do, and half of it at most. Methods that do not keep leaves (SMG_LEAVES_DRIFT) go
 * anywhere. */
static inline smg_real smg_saved_off_sphere(SMG_UNUSED const smg_real *in) {
#if SMG_LEAVES_DRIFT
  return SMG_MAX;
#else
  const smg_real count = in[SMG_SAVED_COUNT_HIGH] * 4294967296 + in[SMG_SAVED_COUNT_LOW];
  return smg_min((smg_real)0.5, SMG_OFF_SPHERE + count * ((smg_real)1e-9 + 8 * in[SMG_SAVED_TOLERANCE]));
#endif
}

#if SMG_THERMAL
SMG_RARE static int smg_good_noise(const smg_real *in) {
  const smg_real most = 4294967295;
  return smg_integer_in(in[SMG_SAVED_SEED_HIGH], 0, most) && smg_integer_in(in[SMG_SAVED_SEED_LOW], 0, most) &&
         smg_integer_in(in[SMG_SAVED_MEMBER], 0, most) && smg_integer_in(in[SMG_SAVED_HALVED], 0, 281474976710656);
}
#else
#define smg_good_noise(in) 1
#endif

/* Are the numbers of the head within their ranges? */
SMG_RARE static int smg_good_head(const smg_coefficients *c, const smg_real *in) {
  return in[SMG_SAVED_PAST] == (smg_real)smg_saved_past(c) &&
         smg_integer_in(in[SMG_SAVED_COUNT_HIGH], 0, SMG_MOST_COUNT_HIGH) &&
         smg_integer_in(in[SMG_SAVED_COUNT_LOW], 0, 4294967295) &&
         smg_integer_in(in[SMG_SAVED_HISTORY], SMG_SAVED_STALE, SMG_HISTORY) &&
         smg_good_degree(in[SMG_SAVED_DEGREE], in[SMG_SAVED_HISTORY]) &&
         smg_integer_in(in[SMG_SAVED_NEWTON_STEPS], SMG_SAVED_LEAST_STEPS, SMG_SAVED_MOST_STEPS) &&
         in[SMG_SAVED_TOLERANCE] >= 0 && in[SMG_SAVED_TOLERANCE] < 1 && smg_good_noise(in);
}

#define SMG_SAVED_SCALES 4 /* what turns and half a radius change the largest component by, at most: 3/2 sqrt(3) */

/* May the largest component of the start be this one? Of sites that go anywhere, or that others know, it may be any. */
SMG_RARE static int smg_good_scale(const smg_coefficients *c, const smg_real *in) {
  const smg_real scale = in[SMG_SAVED_SCALE], *w = in + SMG_SAVED_HEAD;
  smg_real most = smg_saved_off_sphere(in) < 1 ? 0 : SMG_MAX;
  for (int64_t k = smg_own_from(c); k < smg_own_to(c); ++k)
    smg_take(&most, smg_present(c, k) * (smg_kind(c, k) == SMG_NAMBU ? SMG_MAX : smg_largest(w + 3 * k)));
  return smg_is_divided() || most >= SMG_MAX ? scale >= 0
                                             : scale <= SMG_SAVED_SCALES * most && most <= SMG_SAVED_SCALES * scale;
}

/* Is this a saved state of a model with these sizes, by all that can be seen? Times, h and w are judged as init does
 * it. */
SMG_RARE static smg_status smg_check_saved(const smg_coefficients *c, const smg_real *in, int64_t *site) {
  const size_t size = smg_saved_size(c);
  const smg_real *w = in + SMG_SAVED_HEAD;
  if (!(in[SMG_SAVED_SIZE] == (smg_real)size)) return SMG_BAD_PARAMETER;
  for (size_t k = 0; k < size; k = smg_next_saved(c, k, SMG_SAVED_HEAD))
    if (!(SMG_MATH(fabs)(in[k]) <= SMG_MAX)) return SMG_NOT_FINITE;
  if (!smg_good_head(c, in) || !smg_good_scale(c, in)) return SMG_BAD_PARAMETER;
  const smg_status times = smg_check_times((double)in[SMG_SAVED_T0], (double)in[SMG_SAVED_H]);
  if (times != SMG_OK) return times;
  for (*site = smg_own_from(c); *site < smg_own_to(c); ++*site)
    if (!(smg_largest(w + 3 * (smg_sites(c) + *site)) <= SMG_MOST_LOST * smg_largest(w + 3 * *site)))
      return SMG_BAD_PARAMETER;
  return smg_check_state(c, w, NULL, smg_saved_off_sphere(in), site);
}

/* The head. */
SMG_RARE static void smg_restore_head(smg_state *s, const smg_real *in) {
  s->t0 = (double)in[SMG_SAVED_T0];
  s->h = (double)in[SMG_SAVED_H];
  s->count = (int64_t)in[SMG_SAVED_COUNT_HIGH] * 4294967296 + (int64_t)in[SMG_SAVED_COUNT_LOW];
  s->history = in[SMG_SAVED_HISTORY] > 0 ? (int)in[SMG_SAVED_HISTORY] : 0;
  s->degree = s->history > 0 ? (int)in[SMG_SAVED_DEGREE] : SMG_NO_DEGREE;
  s->scale = in[SMG_SAVED_SCALE];
  (void)smg_set_tolerance(s, (double)in[SMG_SAVED_TOLERANCE]); /* 0: that of the method */
#if SMG_THERMAL
  smg_restore_noise(s, in);
#endif
}

SMG_RARE static smg_status smg_restore_state(smg_state *s, const smg_real *in) {
  int64_t site = 0;
  const smg_status found = s->w && in ? smg_check_saved(&s->c, in, &site) : SMG_BAD_PARAMETER,
                   status = smg_status_of_ranks(found, &site);
  if (status != SMG_OK) return status;
  const int64_t n3 = 3 * smg_sites(&s->c), from = 3 * smg_own_from(&s->c);
  smg_restore_head(s, in);
  if (!smg_may_begin(s)) return s->report.status = SMG_BAD_PARAMETER;
  smg_begin_arrays(s, s->w, 3 * smg_sites(&s->c));
  if (in[SMG_SAVED_HISTORY] < 0) --s->version;
  smg_set_newton_steps(s, (int)in[SMG_SAVED_NEWTON_STEPS]);
  smg_copy(s->w + from, in + SMG_SAVED_HEAD + from, 3 * smg_own_to(&s->c) - from);
  smg_share_ends(&s->c, s->w);
  smg_restore_sites(s, in + SMG_SAVED_HEAD + n3, in + smg_saved_past(&s->c));
  return smg_end_report(s, SMG_OK, -1); /* a member of an ensemble that has failed takes steps again */
}

#endif
