/* smidgen runtime: many states of a single unit sphere that all take the same number of steps, SMG_LANES at a time.
 *
 * A group has one state a lane, and a batch has several groups that step in turn: while one waits for its arithmetic
 * to end, the processor works on the next. A lane whose step is not for lanes is put back into its state, which
 * takes the step by smg_step(). Lanes of a group that is not full repeat its first state.
 *
 * The method gives, before: SMG_GROUPS, the groups of a batch; SMG_TABLES, those that may have coefficients of their
 * own; SMG_TIMES, at how many times of a step; smg_group, with the members
 *     smg_lanes w[3], compensation[3];
 *     smg_lane_mask live, began;          (which lanes step, and s->count at the beginning)
 *     smg_state *state[SMG_LANES];
 *     const smg_lane_coefficients *c;
 *     int64_t taken;                      (steps since the beginning)
 * and the functions that are declared here. The model gives smg_lane_coefficients, the numbers that its kernels read,
 * in lanes; smg_lane_fill(to, l, c) puts those of one state into lane l, smg_lane_spread(to, c) into all. */
#ifndef SMG_LANE_BATCH_H
#define SMG_LANE_BATCH_H

#include "smg_model.h"

#include "smg_lanes.h"
#include "smg_state.h"

#if SMG_TIMED
#define SMG_FIELD_MOVES 1
#else
#define SMG_FIELD_MOVES 0
#endif

typedef struct smg_batch {
  smg_group group[SMG_GROUPS];
  smg_lane_coefficients c[SMG_TABLES][SMG_TIMES];
  int groups, alike; /* alike: all states have the same parameters and times, and one table is enough */
} smg_batch;

/* The history of all lanes is empty. */
static inline void smg_group_clear(smg_group *g);
/* What else lane l keeps of its state s, or only what the newest step changed, and back. */
static inline void smg_lane_take_up(smg_group *g, int l, const smg_state *s, int newest);
static inline void smg_lane_put_back(const smg_group *g, int l, smg_state *s);
/* What the last step of lane l says in the report of its state. */
static inline void smg_lane_report(const smg_group *g, int l, smg_state *s);
/* The coefficients of group k, for the step to come, by smg_fill_time(). */
static void smg_fill_table(const smg_batch *b, int k, smg_lane_coefficients *table);
/* One step of all groups. */
static void smg_groups_step(smg_group *g, int groups);

/* The coefficients of lane l at the part `part` of the step to come. */
static inline const smg_coefficients *smg_lane_at(const smg_group *g, int l, smg_real part) {
  smg_state *s = g->state[l];
  const int64_t count = s->count;
  s->count = g->began[l] + g->taken;
  smg_set_time_at(&s->c, s, part);
  s->count = count;
  return &s->c;
}

/* The same of group k, in lanes. */
static inline void smg_fill_time(const smg_batch *b, int k, smg_lane_coefficients *to, smg_real part) {
  if (b->alike) smg_lane_spread(to, smg_lane_at(b->group + k, 0, part));
  else
    for (int l = 0; l < SMG_LANES; ++l) smg_lane_fill(to, l, smg_lane_at(b->group + k, l, part));
}

/* Lane l is where its state is; newest: it was there before its last step. */
static inline void smg_lane_begin(smg_group *g, int l, int newest) {
  smg_state *s = g->state[l];
  smg_lane_insert(g->w, l, s->w, 3);
  smg_lane_insert(g->compensation, l, s->compensation, 3);
  smg_lane_take_up(g, l, s, newest);
}

/* Its state is where lane l is. */
static inline void smg_lane_end(const smg_group *g, int l) {
  smg_state *s = g->state[l];
  smg_lane_extract(g->w, l, s->w, 3);
  smg_lane_extract(g->compensation, l, s->compensation, 3);
  smg_lane_put_back(g, l, s);
  s->count = g->began[l] + g->taken;
}

/* The steps of the lanes `alone` by smg_step(): the lanes stay where they are. */
SMG_COLD static void smg_lanes_step_alone(smg_group *g, smg_lane_mask alone) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(alone, l)) continue;
    smg_lane_end(g, l);
    g->state[l]->report.status = smg_step(g->state[l]);
    if (g->state[l]->report.status != SMG_OK) g->live[l] = 0;
  }
}

static void smg_group_begin(smg_group *g, smg_state *const *s, int n, const smg_lane_coefficients *c) {
  g->live = smg_lane_below(n);
  g->c = c;
  g->taken = 0;
  smg_group_clear(g);
  for (int l = 0; l < SMG_LANES; ++l) {
    g->state[l] = s[l < n ? l : 0];
    g->began[l] = g->state[l]->count;
    smg_lane_begin(g, l, 0);
  }
}

static void smg_group_end(const smg_group *g) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(g->live, l)) continue;
    smg_lane_end(g, l);
    smg_lane_report(g, l, g->state[l]);
  }
}

/* count steps of n states, of as many as a batch holds at most. */
static void smg_batch_steps(smg_state *const *s, int n, int64_t count, int alike) {
  smg_batch b;
  b.alike = alike;
  b.groups = 0;
  for (int k = 0; k < n; k += SMG_LANES, ++b.groups)
    smg_group_begin(b.group + b.groups, s + k, n - k < SMG_LANES ? n - k : SMG_LANES, b.c[alike ? 0 : b.groups]);
  for (int64_t taken = 0; taken < count; ++taken) {
    for (int k = 0; k < (alike ? 1 : b.groups) && (SMG_FIELD_MOVES || taken == 0); ++k) smg_fill_table(&b, k, b.c[k]);
    smg_groups_step(b.group, b.groups);
  }
  for (int k = 0; k < b.groups; ++k) smg_group_end(b.group + k);
}

/* Are all those at the same time that have not failed, with the same h? */
static int smg_all_at_once(const smg_state *s, int64_t members) {
  const smg_state *first = NULL;
  for (int64_t k = 0; k < members; ++k) {
    if (s[k].report.status != SMG_OK) continue;
    if (!first) first = s + k;
    if (!smg_same_times(first, s + k)) return 0;
  }
  return 1;
}

/* count steps of those states that have not failed, a batch of them after the other. */
static void smg_batches_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_state *some[SMG_GROUPS * SMG_LANES];
  const int same = alike && smg_all_at_once(s, members), most = (same ? SMG_GROUPS : SMG_TABLES) * SMG_LANES;
  int n = 0;
  for (int64_t k = 0; k < members && count > 0; ++k) {
    if (s[k].report.status == SMG_OK) some[n++] = s + k;
    if (n < most && !(n > 0 && k + 1 == members)) continue;
    smg_batch_steps(some, n, count, same);
    n = 0;
  }
}

#endif
