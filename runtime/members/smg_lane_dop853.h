/* smidgen method: the steps of smg_dop853.h for SMG_LANES states of a single unit sphere at once, one a lane, each with
 * the bits that it has alone.
 *
 * The arithmetic is that of smg_dop853_template.h, of a field that does not depend on time. Each lane has its own place
 * within its step, its own size, and is accepted or refused by itself; a state that has taken all its steps hands its
 * lane to the next one. Steps that fail are left to smg_step(), from the state before them: so what a failure says
 * stands in one place, there.
 *
 * The model adds: smg_lane_coefficients, the numbers that its field reads, in lanes; smg_lane_fill(to, l, c) puts those
 * of one state into lane l; smg_lane_motion, q h (1/kappa) grad C(w) x dH/dw. */
#ifndef SMG_LANE_DOP853_H
#define SMG_LANE_DOP853_H

#include "smg_dop853.h"
#include "smg_lane_vec.h"

#if SMG_LANES > 1

/* SMG_LANES states under way: the vectors of smg_vector(), and the increment. */
typedef struct smg_lane_trial {
  smg_lanes stages[3 * SMG_STAGE_VECTORS], u[3];
  smg_lane_coefficients c;
} smg_lane_trial;

SMG_INLINE smg_lanes *smg_lane_vector(smg_lane_trial *f, int i) { return f->stages + 3 * i; }
SMG_INLINE int64_t smg_lane_width(SMG_UNUSED const smg_lane_trial *f) { return 3; }
SMG_INLINE void smg_lane_trial_slope(smg_lane_trial *f, SMG_UNUSED smg_lanes part, smg_lanes size, const smg_lanes *w,
                                     smg_lanes *k) {
  smg_lane_vec_store(k, smg_lane_motion(&f->c, smg_lane_vec_load(w), size));
}

#define smg_trial smg_lane_trial
#define smg_vector smg_lane_vector
#define smg_width smg_lane_width
#define smg_trial_slope smg_lane_trial_slope
#define smg_sixteenth smg_lane_sixteenth
#define smg_pace smg_lane_pace
#define smg_weighted smg_lane_weighted
#define smg_dop853_point smg_lane_dop853_point
#define smg_dop853_stage smg_lane_dop853_stage
#define smg_later_stages smg_lane_later_stages
#define smg_combine_slopes smg_lane_combine_slopes
#define smg_site_error smg_lane_site_error
#define smg_add_where smg_lane_add_where
#define smg_take_increment smg_lane_take_increment
#define smg_towards_leaf smg_lane_towards_leaf
#define smg_next_try smg_lane_next_try
#define smg_step_factor smg_lane_step_factor
#define smg_judge smg_lane_judge
#define smg_gives_up smg_lane_gives_up
#include "smg_in_lanes.h"
#include "smg_dop853_template.h"
#include "smg_in_numbers.h"
#undef smg_pace
#undef smg_vector

/* registers full of states that step in turn: while one waits for its control, the processor works on the other; 3: the
 * same */
#define SMG_LANE_GROUPS 2

typedef struct smg_lane_group {
  smg_lane_trial trial;
  smg_lane_pace pace;
  smg_lanes w[3], compensation[3], natural_before; /* as they were before the step */
  smg_lane_mask live;                              /* no lane is live that repeats another, or has nothing left to do */
  smg_lane_mask lost, off_leaf;                    /* k_1 is no number; not yet back on the leaf */
  smg_lane_mask count, left;                       /* steps taken, and those still to take */
  smg_state *state[SMG_LANES];
} smg_lane_group;

/* The states that wait for a lane, and how many steps each is to take. */
typedef struct smg_queue {
  smg_state *next, *end;
  int64_t count;
} smg_queue;

/* ---- one internal step ---- */
/* k_1 */
SMG_INLINE void smg_lanes_first_stage(smg_lane_group *f) {
  smg_lane_trial_slope(&f->trial, f->pace.done, f->pace.size, smg_lane_vector(&f->trial, SMG_Y), f->trial.stages);
  f->lost = ~smg_lane_vec_finite(smg_lane_vec_load(f->trial.stages));
}

/* u and the square of its error. */
SMG_INLINE void smg_lanes_estimate(smg_lane_group *f) {
  smg_lanes e5[3], e3[3];
  smg_lane_combine_slopes(f->trial.stages, 3, f->pace.per_allowed, f->trial.u, e5, e3);
  f->pace.square = smg_lane_site_error(smg_lane_vector(&f->trial, SMG_Y), f->trial.u, e5, e3);
}

SMG_INLINE void smg_lanes_end_try(smg_lane_group *f) {
  f->off_leaf = smg_lane_judge(&f->pace);
  smg_lane_take_increment(&f->trial, f->off_leaf);
}

/* A round of smg_back_on_leaf() on the unit sphere, where grad C(y) = y, in the lanes that are off it; are there such
 * lanes? */
SMG_INLINE int smg_lanes_back_on_leaf(smg_lane_group *f) {
  smg_lanes *y = smg_lane_vector(&f->trial, SMG_Y);
  const smg_lanes n[3] = {y[0], y[1], y[2]};
  f->off_leaf =
      smg_lane_towards_leaf(f->off_leaf, smg_lane_of(1), n, y, smg_lane_vector(&f->trial, SMG_Y_COMPENSATION));
  return smg_lane_any(f->off_leaf);
}

/* ---- lanes and states
 * ------------------------------------------------------------------------------------------------------- */
/* Lane l is at the beginning of a step of the state s. */
static void smg_lane_take_up(smg_lane_group *f, int l, smg_state *s) {
  smg_pace pace;
  smg_copy(smg_vector(s, SMG_Y), s->w, 3);
  smg_begin_pace(s, &pace);
  smg_lane_insert(smg_lane_vector(&f->trial, SMG_Y), l, s->w, 3);
  smg_lane_insert(smg_lane_vector(&f->trial, SMG_Y_COMPENSATION), l, s->compensation, 3);
  smg_lane_insert(f->w, l, s->w, 3);
  smg_lane_insert(f->compensation, l, s->compensation, 3);
  smg_lane_set(&f->natural_before, l, *smg_natural(s));
  smg_lane_set(&f->pace.natural, l, pace.natural);
  smg_lane_set(&f->pace.per_allowed, l, pace.per_allowed);
  smg_lane_set(&f->pace.done, l, 0);
  smg_lane_set(&f->pace.largest, l, 0);
  f->pace.tries[l] = f->pace.accepted[l] = f->pace.refused[l] = 0;
  f->count[l] = s->count;
  smg_lane_fill(&f->trial.c, l, &s->c);
  f->state[l] = s;
}

/* The state of lane l, as it was before the step under way. */
static void smg_lane_put_back(const smg_lane_group *f, int l) {
  smg_state *s = f->state[l];
  smg_lane_extract(f->w, l, s->w, 3);
  smg_lane_extract(f->compensation, l, s->compensation, 3);
  *smg_natural(s) = smg_lane_get(&f->natural_before, l);
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

/* The lanes `finished` are at the end of their steps: the next one begins, or the next state. */
SMG_COLD static void smg_lanes_end_steps(smg_lane_group *f, smg_lane_mask finished, smg_queue *q) {
  const smg_lanes none = smg_lane_of(0), *y = smg_lane_vector(&f->trial, SMG_Y),
                  *carry = smg_lane_vector(&f->trial, SMG_Y_COMPENSATION);
  smg_lane_pace *pace = &f->pace;
  smg_lane_choose(f->w, finished, y, f->w, 3);
  smg_lane_choose(f->compensation, finished, carry, f->compensation, 3);
  f->natural_before = smg_lane_select(finished, pace->natural, f->natural_before);
  pace->natural = smg_lane_select(finished, smg_lane_max(smg_lane_of(SMG_LEAST_PART), pace->natural), pace->natural);
  f->count -= finished;
  f->left += finished;
  const smg_lane_mask over = finished & (smg_lane_mask)(f->left == 0);
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(over, l)) continue;
    smg_report_pace(f->state[l], (int)pace->accepted[l], smg_lane_get(&pace->largest, l));
    f->state[l]->report.site = -1;
    smg_lane_put_back(f, l);
    smg_lane_next(f, l, q);
  }
  pace->done = smg_lane_select(finished, none, pace->done);
  pace->largest = smg_lane_select(finished, none, pace->largest);
  pace->tries &= ~finished;
  pace->accepted &= ~finished;
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

/* Steps that are at their end, and those that are left to smg_step(). */
SMG_INLINE void smg_group_finish(smg_lane_group *f, smg_queue *q) {
  const smg_lane_mask end = ~(f->pace.refused | f->lost | (smg_lane_mask)(f->pace.done < 1)), finished = f->live & end,
                      alone = f->live & ~end & (f->lost | smg_lane_gives_up(&f->pace));
  if (!smg_lane_any(finished | alone)) return;
  smg_lanes_end_steps(f, finished, q);
  if (smg_lane_any(alone)) smg_lanes_alone(f, alone, q);
}

/* One internal step of every lane, in parts short enough that a processor works on several groups at once. */
static void smg_groups_try(smg_lane_group *f, int groups, smg_queue *q) {
  for (int k = 0; k < groups; ++k) {
    smg_lane_next_try(&f[k].pace);
    smg_lanes_first_stage(f + k);
    smg_lane_later_stages(&f[k].trial, f[k].pace.done, f[k].pace.size, smg_lane_vector(&f[k].trial, SMG_Y));
  }
  for (int k = 0; k < groups; ++k) smg_lanes_estimate(f + k);
  for (int k = 0; k < groups; ++k) smg_lanes_end_try(f + k);
#if SMG_PROJECT
  for (int round = 0, left = 1; left && round < SMG_LEAF_ROUNDS; ++round) {
    left = 0;
    for (int k = 0; k < groups; ++k) left |= smg_lanes_back_on_leaf(f + k);
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
static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, SMG_UNUSED int alike) {
  smg_lane_group f[SMG_LANE_GROUPS];
  smg_queue q = {s, s + members, count};
  int groups = 0, busy = count > 0;
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

#endif
#endif
