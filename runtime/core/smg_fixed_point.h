/* smidgen runtime: fixed-point iteration over the stages of all sites together: when it has settled, and whether it
 * contracts.
 *
 * A method defines smg_begin_stages(s, with, extrapolated), the stages to begin with, by the polynomial of the steps
 * before or at rest, and smg_sweep_stages(s, with), one sweep; `with` is what it works with, or NULL. A sweep says what
 * it has moved: how far w will be moved by the change of the stages, relative to the stages' own size and absolutely,
 * next to the products in them. A step ends where the w of it are right to s->tolerance, as its last two changes tell;
 * 0: where nothing moves but by round-off, as long runs need it. */
#ifndef SMG_FIXED_POINT_H
#define SMG_FIXED_POINT_H

#include "smg_lanes.h"
#include "smg_rules.h"

/* The iteration must contract: from its first change on, times the slack for what grows before it falls, each sweep
 * must leave no more than this part of the one before. Then its solution is the one connected to the state at h = 0. */
#define SMG_CONTRACTION (smg_real)0.75
#define SMG_SLACK 32
/* twice, from the polynomial and from rest, with the last ones below: fewer than 1000 evaluations of all sites */
#define SMG_MOST_SWEEPS 400
/* The formula of the field may carry so much round-off, relative to the state: below it changes that have found no new
 * least for some sweeps are taken for that. */
#define SMG_FIELD_NOISE (4194304 * SMG_EPS)
#define SMG_PATIENCE 8

/* Beside this, slopes of a site at rest are nothing: next to it, 0/0 is 0. */
#define SMG_LEAST (smg_real) DBL_MIN

/* What a sweep has moved, the largest over its sites and stages, lane by lane: the fields of smg_change; `absolute`
 * alone where smg_of_the_whole says so. */
typedef struct smg_moved {
  smg_lanes relative, absolute, rounding_scale;
} smg_moved;

/* Is an accuracy asked for? Changes then count next to the whole state. To round-off they count next to the size of
 * what changes: small sites keep all their digits. */
SMG_INLINE int smg_of_the_whole(const smg_state *s) { return s->tolerance > 0; }

static void smg_begin_stages(smg_state *s, void *with, int extrapolated);
static smg_moved smg_sweep_stages(smg_state *s, void *with);

/* What the sweeps of a step have shown: the last change and the two before it, the least one and how long ago it was,
 * the most that a contraction allows, and how large a change is round-off. */
typedef struct smg_watch {
  smg_change now, last;
  smg_real before;
  smg_real least, most, size;
  int since;
} smg_watch;

/* Takes in what a sweep has moved. The products in the increments count only where they could be larger than the
 * state. */
SMG_INLINE void smg_look(const smg_state *s, const smg_moved *moved, smg_watch *watch) {
  const int whole = smg_of_the_whole(s);
  watch->before = watch->last.absolute;
  watch->last = watch->now;
  watch->now.absolute = smg_lane_largest(moved->absolute);
  watch->now.relative = whole ? watch->now.absolute : smg_lane_largest(moved->relative);
  watch->size = s->scale;
  if (!whole && !smg_still(watch->now.absolute, s->scale))
    watch->size = smg_max(s->scale, smg_lane_largest(moved->rounding_scale));
}

/* Is what is left after these two changes, now^2/(last - now) of a geometric sequence, at most that? One that was
 * larger than all that it changed is no part of such a sequence, and tells no more than one as large. */
SMG_INLINE int smg_leaves_at_most(smg_real now, smg_real last, smg_real whole, smg_real most) {
  return now * now <= most * (smg_min(last, whole) - now);
}

/* The same of the accuracy asked for, by the last two ratios of changes. Of h X the derivative at a point of a sphere
 * has its eigenvalues in pairs of both signs, so that large and small changes alternate: a small one tells nothing by
 * itself. */
SMG_INLINE int smg_leaves_tolerance(const smg_watch *watch, smg_real whole, smg_real tolerance) {
  const smg_real now = watch->now.absolute, last = watch->last.absolute;
  if (smg_max(now, last) <= tolerance) return 1;
  return tolerance > 0 && watch->most >= 0 && smg_leaves_at_most(now, last, whole, tolerance) &&
         now * last <= tolerance * (smg_min(watch->before, whole) - last);
}

/* The accuracy asked for, round-off of the increment or none; stagnation, as smg_settled has it but for every
 * contraction that is allowed; or the round-off of the field. */
SMG_INLINE int smg_stages_settled(const smg_state *s, const smg_watch *watch) {
  const smg_change *now = &watch->now, *last = &watch->last;
  const smg_real tolerance = smg_allowed(s), one = smg_of_the_whole(s) ? s->scale : 1; /* of `relative` */
  /* beside products so large anything looks like round-off */
  if (!(now->absolute <= smg_max(SMG_BLIND * s->scale, tolerance))) return 0;
  if (now->relative <= SMG_EPS * one || smg_leaves_tolerance(watch, s->scale, tolerance)) return 1;
  if (watch->most >= 0 && smg_leaves_at_most(now->relative, last->relative, one, SMG_EPS * one)) return 1;
  if (smg_still(now->absolute, watch->size) && now->relative >= SMG_CONTRACTION * last->relative) return 1;
  return now->absolute <= SMG_FIELD_NOISE * watch->size && watch->since >= SMG_PATIENCE;
}

/* Takes in a change that has not settled; is the iteration a contraction as far as can be seen? */
SMG_INLINE int smg_sweeps_contract(smg_watch *watch) {
  const smg_real now = watch->now.absolute;
  const int first = watch->most < 0, falls = first || now <= SMG_CONTRACTION * watch->least;
  watch->since = falls ? 0 : watch->since + 1;
  if (falls) watch->least = now;
  watch->most = first ? SMG_SLACK * now : SMG_CONTRACTION * watch->most;
  return now <= smg_max(watch->most, SMG_FIELD_NOISE * watch->size);
}

/* So many sweeps more; are they numbers still? */
static int smg_more_sweeps(smg_state *s, void *with, int more) {
  smg_real change = 0;
  for (; more > 0; --more) {
    const smg_moved moved = smg_sweep_stages(s, with);
    change = smg_lane_largest(moved.absolute);
  }
  return change <= SMG_MAX;
}

/* Sweeps until what is left is round-off, one more, and an eighth as many again: what was left is of one sign along
 * many an orbit, a drift. */
static smg_status smg_sweep_to_rest(smg_state *s, void *with) {
  smg_watch watch = {{SMG_MAX, SMG_MAX, 0}, {SMG_MAX, SMG_MAX, 0}, SMG_MAX, 0, -1, 0, 0};
  for (int n = 0; n < SMG_MOST_SWEEPS; ++n) {
    const smg_moved moved = smg_sweep_stages(s, with);
    smg_look(s, &moved, &watch);
    ++s->report.iterations;
    s->report.residual = watch.now.absolute;
    /* beside infinite products every change is small */
    if (!(watch.now.absolute <= SMG_MAX)) return SMG_NOT_FINITE;
    if (!smg_of_the_whole(s) && !(smg_lane_largest(moved.rounding_scale) <= SMG_MAX)) return SMG_NOT_FINITE;
    if (smg_stages_settled(s, &watch))
      return smg_more_sweeps(s, with, s->tolerance > 0 ? 0 : 1 + n / 8) ? SMG_OK : SMG_NOT_FINITE;
    if (!smg_sweeps_contract(&watch)) break;
  }
  return SMG_NO_CONVERGENCE;
}

/* The stages of a step: from the polynomial of the steps before; when that fails, or there are none, from rest. */
static smg_status smg_solve_stages(smg_state *s, void *with) {
  s->report.iterations = 0;
  smg_begin_stages(s, with, s->history > 0);
  const smg_status status = smg_sweep_to_rest(s, with);
  if (status == SMG_OK || s->history == 0) return status;
  smg_begin_stages(s, with, 0);
  return smg_sweep_to_rest(s, with);
}

#endif
