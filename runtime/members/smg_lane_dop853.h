/* smidgen method: the steps of smg_dop853.h for SMG_LANES states of a single unit sphere at once, one a lane, each with
 * the bits that it has alone.
 *
 * The same operations in the same order, of a field that does not depend on time. Each lane has its own place within
 * its step, its own size, and is accepted or refused by itself; a state that has taken all its steps hands its lane to
 * the next one. Steps that fail are left to smg_step(), from the state before them: so what a failure says stands in
 * one place, there.
 *
 * The model adds: smg_lane_coefficients, the numbers that its field reads, in lanes; smg_lane_fill(to, l, c) puts those
 * of one state into lane l; smg_lane_motion, q h (1/kappa) grad C(w) x dH/dw. */
#ifndef SMG_LANE_DOP853_H
#define SMG_LANE_DOP853_H

#include "smg_dop853.h"
#include "smg_lane_vec.h"

#if SMG_LANES > 1

/* registers full of states that step in turn: while one waits for its control, the processor works on the other; 3: the
 * same */
#define SMG_LANE_GROUPS 2

/* SMG_LANES steps under way, each as smg_pace has it. */
typedef struct smg_lane_group {
  smg_lanes y[3], carry[3], k[3 * SMG_STAGES_USED];
  smg_lanes done, size, natural, largest;
  smg_lanes end, u[3], square, factor;             /* of the internal step that is tried */
  smg_lanes w[3], compensation[3], natural_before; /* as they were before the step */
  smg_lanes per_allowed;
  smg_lane_coefficients c;
  smg_lane_mask live, refused;                /* no lane is live that repeats another, or has nothing left to do */
  smg_lane_mask lost, off_leaf;               /* what lanes do not do has come up; not yet back on the leaf */
  smg_lane_mask tries, accepted, count, left; /* count: steps taken; left: those still to take */
  smg_state *state[SMG_LANES];
} smg_lane_group;

/* The states that wait for a lane, and how many steps each is to take. */
typedef struct smg_queue {
  smg_state *next, *end;
  int64_t count;
} smg_queue;

/* ---- one internal step, as in smg_dop853.h
 * ---------------------------------------------------------------------------------- */
SMG_INLINE smg_lane_vec smg_lanes_plus(smg_lane_vec sum, smg_real a, smg_lane_vec k) {
  return a != 0 ? smg_lane_vec_add(sum, smg_lane_vec_scale(smg_lane_of(a), k)) : sum;
}

/* sum_j a_j k_j */
SMG_INLINE smg_lane_vec smg_lanes_weighted(const smg_real *a, int count, const smg_lanes *k) {
  const smg_lanes zero = smg_lane_of(-(smg_real)0);
  smg_lane_vec sum = smg_lane_vec_of(zero, zero, zero);
  SMG_UNROLL
  for (int j = 0; j < count; ++j) sum = smg_lanes_plus(sum, a[j], smg_lane_vec_load(k + 3 * j));
  return sum;
}

/* k_1 */
SMG_INLINE void smg_lanes_first_stage(smg_lane_group *f) {
  const smg_lane_vec k = smg_lane_motion(&f->c, smg_lane_vec_load(f->y), f->size);
  smg_lane_vec_store(f->k, k);
  f->lost = ~smg_lane_vec_finite(k);
}

/* k_(i+1), i = 1 .. 11 */
SMG_INLINE void smg_lanes_stage(smg_lane_group *f, int i) {
  smg_lane_vec z = smg_lane_vec_load(f->y);
  if (i > 1) z = smg_lane_vec_add(z, smg_lanes_weighted(smg_dop853_a[i], i - 1, f->k));
  z = smg_lane_vec_add(z,
                       smg_lane_vec_scale(smg_lane_of(smg_dop853_a[i][i - 1]), smg_lane_vec_load(f->k + 3 * (i - 1))));
  smg_lane_vec_store(f->k + 3 * i, smg_lane_motion(&f->c, z, f->size));
}

/* k_2 .. k_12 */
SMG_INLINE void smg_lanes_later_stages(smg_lane_group *f) {
  smg_lanes_stage(f, 1);
  smg_lanes_stage(f, 2);
  smg_lanes_stage(f, 3);
  smg_lanes_stage(f, 4);
  smg_lanes_stage(f, 5);
  smg_lanes_stage(f, 6);
  smg_lanes_stage(f, 7);
  smg_lanes_stage(f, 8);
  smg_lanes_stage(f, 9);
  smg_lanes_stage(f, 10);
  smg_lanes_stage(f, 11);
}

/* u, e5 and e3, the three of smg_estimate(), at once, so that each k is loaded once. */
SMG_INLINE void smg_lanes_combine(const smg_lane_group *f, smg_lane_vec *u, smg_lane_vec *e5, smg_lane_vec *e3) {
  const smg_lanes zero = smg_lane_of(-(smg_real)0);
  smg_lane_vec sum = smg_lane_vec_of(zero, zero, zero), fifth = sum, third = sum;
  SMG_UNROLL
  for (int j = 0; j < SMG_STAGES_USED; ++j) {
    const smg_lane_vec k = smg_lane_vec_load(f->k + 3 * j);
    sum = smg_lanes_plus(sum, smg_dop853_b[j], k);
    fifth = smg_lanes_plus(fifth, smg_dop853_e5[j], k);
    third = smg_lanes_plus(third, smg_dop853_e3[j], k);
  }
  *u = sum;
  *e5 = smg_lane_vec_scale(f->per_allowed, fifth);
  *e3 = smg_lane_vec_scale(f->per_allowed, third);
}

/* u and the square of its error, as smg_site_error() has it. */
SMG_INLINE void smg_lanes_estimate(smg_lane_group *f) {
  const smg_lanes none = smg_lane_of(0);
  smg_lane_vec u, e5, e3;
  smg_lanes_combine(f, &u, &e5, &e3);
  const smg_lanes first = smg_lane_vec_dot(e5, e5), both = first + smg_lane_vec_dot(e3, e3) * (smg_real)0.01;
  smg_lanes square = smg_lane_select((smg_lane_mask)(first > none), first * (first / both), first);
  square = smg_lane_select((smg_lane_mask)(both <= SMG_MAX), square, smg_lane_of(SMG_MAX));
  f->square = smg_lane_select(smg_lane_vec_finite(smg_lane_vec_add(smg_lane_vec_load(f->y), u)), square,
                              smg_lane_of((smg_real)NAN));
  smg_lane_vec_store(f->u, u);
}

/* y + carry := y + carry + u in the lanes `which`. */
SMG_INLINE void smg_lanes_add(smg_lane_group *f, smg_lane_mask which, smg_lane_vec u) {
  const smg_lane_vec y = smg_lane_vec_load(f->y), carry = smg_lane_vec_load(f->carry),
                     more = smg_lane_vec_add(u, carry), sum = smg_lane_vec_add(y, more);
  smg_lane_vec_store(f->carry, smg_lane_vec_select(which, smg_lane_vec_sub(more, smg_lane_vec_sub(sum, y)), carry));
  smg_lane_vec_store(f->y, smg_lane_vec_select(which, sum, y));
}

/* The increment is taken in the lanes `good`. */
SMG_INLINE void smg_lanes_take(smg_lane_group *f, smg_lane_mask good) {
  const smg_lane_vec u = smg_lane_vec_load(f->u);
#if SMG_PLAIN_SUMS
  const smg_lane_vec y = smg_lane_vec_load(f->y);
  smg_lane_vec_store(f->y, smg_lane_vec_select(good, smg_lane_vec_add(y, u), y));
#else
  smg_lanes_add(f, good, u);
#endif
  f->off_leaf = good;
}

/* A round of smg_back_on_leaf() on the unit sphere, where grad C(y) = y, in the lanes that are off it; returns those
 * that still are. */
SMG_INLINE smg_lane_mask smg_lanes_back_on_leaf(smg_lane_group *f) {
  const smg_lane_vec n = smg_lane_vec_load(f->y);
  const smg_lanes square = smg_lane_vec_dot(n, n),
                  off = 1 - (square + 2 * smg_lane_vec_dot(n, smg_lane_vec_load(f->carry)));
  f->off_leaf &= (smg_lane_mask)(square > 0) & ~(smg_lane_mask)(smg_lane_abs(off) <= SMG_EPS * square);
  smg_lanes_add(f, f->off_leaf, smg_lane_vec_scale(off / (2 * square), n));
  return f->off_leaf;
}

/* ---- control of the size
 * ---------------------------------------------------------------------------------------------------- */
SMG_INLINE void smg_lanes_factor(smg_lane_group *f) {
  const smg_lanes most = smg_lane_of(SMG_GROWTH), factor = SMG_SAFETY * smg_lane_of_bits(SMG_SIXTEENTH, f->square, 4);
  f->factor = smg_lane_select((smg_lane_mask)(f->square > 0),
                              smg_lane_min(most, smg_lane_max(smg_lane_of(SMG_SHRINK), factor)), most);
}

SMG_INLINE void smg_lanes_next_end(smg_lane_group *f) {
  const smg_lanes left = 1 - f->done, near = f->done + smg_lane_min(f->natural, left / 2), far = f->done + f->natural;
  const smg_lane_mask whole = smg_lane_all(SMG_FIXED_STEP) | (smg_lane_mask)(left <= f->natural * (smg_real)1.01);
  f->end = smg_lane_select(whole, smg_lane_of(1), smg_lane_select((smg_lane_mask)(left > 2 * f->natural), far, near));
  f->size = f->end - f->done;
}

/* smg_accept() and smg_refuse_step() */
SMG_INLINE void smg_lanes_judge(smg_lane_group *f) {
  const smg_lane_mask finite = (smg_lane_mask)(f->square - f->square == smg_lane_of(0)),
                      good = SMG_FIXED_STEP ? finite : (smg_lane_mask)(f->square <= 1);
  const smg_lanes grown = smg_lane_select(f->refused, smg_lane_min(smg_lane_of(1), f->factor), f->factor),
                  next = f->size * grown;
  const smg_lanes kept =
      smg_lane_select((smg_lane_mask)(grown < SMG_GROWTH) | (smg_lane_mask)(next > f->natural), next, f->natural);
  f->natural = smg_lane_select(good, kept, f->size * smg_lane_select(finite, f->factor, smg_lane_of(SMG_SHRINK)));
  f->largest = smg_lane_select(good, smg_lane_max(f->largest, f->square), f->largest);
  f->done = smg_lane_select(good, f->end, f->done);
  f->refused = ~good;
  /* hopeless */
  f->lost |= f->refused & (smg_lane_all(SMG_FIXED_STEP) | ~(smg_lane_mask)(f->natural >= SMG_LEAST_PART));
  f->accepted -= good; /* where a test holds its lane is -1 */
  f->tries += 1;
  smg_lanes_take(f, good);
}

/* ---- lanes and states
 * ------------------------------------------------------------------------------------------------------- */
/* The size of the very first internal step of a state. */
static smg_real smg_first_natural(smg_state *s) {
  for (int b = 0; b < 3; ++b) smg_vector(s, SMG_Y)[b] = s->w[b];
  return smg_first_size(s);
}

/* Lane l is at the beginning of a step of the state s. */
static void smg_lane_take_up(smg_lane_group *f, int l, smg_state *s) {
  const smg_real natural = smg_kept(s)[SMG_NATURAL], allowed = s->tolerance * s->scale;
  for (int b = 0; b < 3; ++b) {
    smg_lane_set(f->y + b, l, s->w[b]);
    smg_lane_set(f->w + b, l, s->w[b]);
    smg_lane_set(f->carry + b, l, s->compensation[b]);
    smg_lane_set(f->compensation + b, l, s->compensation[b]);
  }
  smg_lane_set(&f->natural, l, smg_max(SMG_LEAST_PART, natural > 0 ? natural : smg_first_natural(s)));
  smg_lane_set(&f->natural_before, l, natural);
  smg_lane_set(&f->per_allowed, l, allowed > 0 ? 1 / allowed : 0);
  smg_lane_set(&f->done, l, 0);
  smg_lane_set(&f->largest, l, 0);
  f->tries[l] = f->accepted[l] = f->refused[l] = 0;
  f->count[l] = s->count;
  smg_lane_fill(&f->c, l, &s->c);
  f->state[l] = s;
}

/* The state of lane l, as it was before the step under way. */
static void smg_lane_put_back(const smg_lane_group *f, int l) {
  smg_state *s = f->state[l];
  for (int b = 0; b < 3; ++b) {
    s->w[b] = smg_lane_get(f->w + b, l);
    s->compensation[b] = smg_lane_get(f->compensation + b, l);
  }
  smg_kept(s)[SMG_NATURAL] = smg_lane_get(&f->natural_before, l);
  smg_kept(s)[SMG_LAST_SIZE] = smg_kept(s)[SMG_EXTRA_READY] = 0;
  s->count = f->count[l];
}

/* Lane l takes up the next state that has not failed, if there is one. */
static void smg_lane_next(smg_lane_group *f, int l, smg_queue *q) {
  while (q->next < q->end && q->next->report.status != SMG_OK) ++q->next;
  f->live[l] = q->next < q->end ? -1 : 0;
  if (q->next == q->end) return;
  f->left[l] = q->count;
  smg_lane_take_up(f, l, q->next++);
}

/* Lane l has taken all its steps: what the last of them says. */
static void smg_lane_report(const smg_lane_group *f, int l) {
  const smg_state *s = f->state[l];
  smg_report *r = &f->state[l]->report;
  r->iterations = (int)f->accepted[l];
  r->residual = SMG_MATH(sqrt)(smg_lane_get(&f->largest, l)) * (s->tolerance * s->scale);
  r->site = r->partner = -1;
  r->reached = 0;
}

/* The lanes `finished` are at the end of their steps: the next one begins, or the next state. */
SMG_COLD static void smg_lanes_end_steps(smg_lane_group *f, smg_lane_mask finished, smg_queue *q) {
  const smg_lanes none = smg_lane_of(0);
  smg_lane_vec_store(f->w, smg_lane_vec_select(finished, smg_lane_vec_load(f->y), smg_lane_vec_load(f->w)));
  smg_lane_vec_store(f->compensation,
                     smg_lane_vec_select(finished, smg_lane_vec_load(f->carry), smg_lane_vec_load(f->compensation)));
  f->natural_before = smg_lane_select(finished, f->natural, f->natural_before);
  f->natural = smg_lane_select(finished, smg_lane_max(smg_lane_of(SMG_LEAST_PART), f->natural), f->natural);
  f->count -= finished;
  f->left += finished;
  const smg_lane_mask over = finished & (smg_lane_mask)(f->left == 0);
  if (smg_lane_any(over))
    for (int l = 0; l < SMG_LANES; ++l) {
      if (!smg_lane_holds(over, l)) continue;
      smg_lane_report(f, l);
      smg_lane_put_back(f, l);
      smg_lane_next(f, l, q);
    }
  f->done = smg_lane_select(finished, none, f->done);
  f->largest = smg_lane_select(finished, none, f->largest);
  f->tries &= ~finished;
  f->accepted &= ~finished;
}

/* The step of the lanes `alone` by smg_step(), from its beginning. */
SMG_COLD static void smg_lanes_alone(smg_lane_group *f, smg_lane_mask alone, smg_queue *q) {
  for (int l = 0; l < SMG_LANES; ++l) {
    smg_state *s = f->state[l];
    if (!smg_lane_holds(alone, l)) continue;
    smg_lane_put_back(f, l);
    s->report.status = smg_step(s);
    if (s->report.status != SMG_OK || --f->left[l] == 0) smg_lane_next(f, l, q);
    else smg_lane_take_up(f, l, s);
  }
}

/* smg_too_far() */
SMG_INLINE smg_lane_mask smg_lanes_too_far(const smg_lane_group *f) {
  smg_lanes left = {0};
  for (int l = 0; l < SMG_LANES; ++l) smg_lane_set(&left, l, (smg_real)(SMG_MOST_TRIES - f->tries[l]));
  return (smg_lane_mask)(1 - f->done > f->natural * left);
}

/* Steps that are at their end, and those that are left to smg_step(). */
SMG_INLINE void smg_group_finish(smg_lane_group *f, smg_queue *q) {
  const smg_lane_mask end = ~(f->refused | f->lost | (smg_lane_mask)(f->done < 1)), finished = f->live & end;
  const smg_lane_mask due = (smg_lane_mask)((f->tries & (SMG_LOOK_AHEAD - 1)) == 0);
  const smg_lane_mask far = smg_lane_any(f->live & ~end & due) ? due & smg_lanes_too_far(f) : due & ~due;
  const smg_lane_mask alone = f->live & ~end & (f->lost | far | (smg_lane_mask)(f->tries >= SMG_MOST_TRIES));
  if (!smg_lane_any(finished | alone)) return;
  smg_lanes_end_steps(f, finished, q);
  if (smg_lane_any(alone)) smg_lanes_alone(f, alone, q);
}

/* One internal step of every lane, in parts short enough that a processor works on several groups at once. */
static void smg_groups_try(smg_lane_group *f, int groups, smg_queue *q) {
  for (int k = 0; k < groups; ++k) {
    smg_lanes_next_end(f + k);
    smg_lanes_first_stage(f + k);
    smg_lanes_later_stages(f + k);
  }
  for (int k = 0; k < groups; ++k) smg_lanes_estimate(f + k);
  for (int k = 0; k < groups; ++k) smg_lanes_factor(f + k);
  for (int k = 0; k < groups; ++k) smg_lanes_judge(f + k);
#if SMG_PROJECT
  for (int round = 0, left = 1; left && round < SMG_LEAF_ROUNDS; ++round) {
    left = 0;
    for (int k = 0; k < groups; ++k) left |= smg_lane_any(smg_lanes_back_on_leaf(f + k));
  }
#endif
  for (int k = 0; k < groups; ++k) smg_group_finish(f + k, q);
}

/* ---- many states
 * ------------------------------------------------------------------------------------------------------------ */
/* Is a state left for the first lane? Other lanes that none is left for repeat it. */
static int smg_dop853_lanes_begin(smg_lane_group *f, smg_queue *q) {
  for (int l = 0; l < SMG_LANES; ++l) {
    smg_lane_next(f, l, q);
    if (!smg_lane_holds(f->live, 0)) return 0;
    if (!smg_lane_holds(f->live, l)) smg_lane_take_up(f, l, f->state[0]);
  }
  return 1;
}

/* count steps of those states that have not failed. */
static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_lane_group f[SMG_LANE_GROUPS];
  smg_queue q = {s, s + members, count};
  int groups = 0, busy = count > 0;
  (void)alike;
  for (int k = 0; k < SMG_LANE_GROUPS && busy; ++k) {
    busy = smg_dop853_lanes_begin(f + k, &q);
    groups += busy;
  }
  for (busy = groups > 0; busy;) {
    smg_groups_try(f, groups, &q);
    busy = 0;
    for (int k = 0; k < groups; ++k) busy |= smg_lane_any(f[k].live);
  }
}

#else

/* One lane: states step by themselves, and the kernel stays unused. */
static inline void smg_lanes_of_one(smg_lane_coefficients *to, const smg_coefficients *c, smg_lane_vec m, smg_lanes q) {
  smg_lane_fill(to, 0, c);
  (void)smg_lane_motion(to, m, q);
}

#endif
#endif
