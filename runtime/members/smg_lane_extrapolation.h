/* smidgen method: the step of smg_extrapolation.h for SMG_LANES states of a single unit sphere at once, one a lane,
 * each with the bits that it has alone.
 *
 * The same operations in the same order. Where the field depends on time, its coefficients at all times of a step are
 * computed before it: once for all states that have the same parameters and the same time. A state that is no number
 * any more is put back to before that step and left to smg_step(), which says so; its lane goes on for nothing.
 *
 * The model adds: smg_lane_coefficients, the numbers that its field reads, in lanes; smg_lane_fill(to, l, c) puts those
 * of one state into lane l, smg_lane_spread(to, c) into all; smg_lane_motion, q h (1/kappa) grad C(w) x dH/dw. */
#ifndef SMG_LANE_EXTRAPOLATION_H
#define SMG_LANE_EXTRAPOLATION_H

#include "smg_extrapolation.h"
#include "smg_lane_vec.h"

#if SMG_LANES > 1

/* Groups of lanes that step in turn: while one waits for the end of its rows, the processor works on the next, and what
 * depends on time is computed for all of them. Groups whose parameters differ have coefficients of their own,
 * SMG_TABLES of them at most, at SMG_TIMES times. */
#define SMG_TABLEAU_GROUPS 8
#if SMG_TIMED
enum { SMG_TIMES = 1 + SMG_TABLEAU_ROWS * SMG_TABLEAU_ROWS, SMG_TABLES = 1 };
#else
enum { SMG_TIMES = 1, SMG_TABLES = SMG_TABLEAU_GROUPS };
#endif

/* SMG_LANES states under way. */
typedef struct smg_tableau_group {
  smg_lanes w[3], compensation[3];
  smg_lane_mask live; /* no lane is live that repeats another, or whose step failed */
  smg_state *state[SMG_LANES];
  const smg_lane_coefficients *c;
} smg_tableau_group;

/* Groups that step in turn. alike: all have the same parameters and times, and those of `clock`. */
typedef struct smg_tableau_batch {
  smg_tableau_group group[SMG_TABLEAU_GROUPS];
  smg_lane_coefficients c[SMG_TABLES][SMG_TIMES];
  smg_state clock;
  int groups, alike;
} smg_tableau_batch;

/* Where the coefficients for t + m h/n stand, n = 2j: row j has 2j - 1 of them, behind the (j - 1)^2 of those before it
 * and those for t. */
SMG_INLINE int smg_time_of(int j, int m) { return SMG_TIMES > 1 ? (j - 1) * (j - 1) + m : 0; }

/* ---- the step, as in smg_extrapolation.h
 * ------------------------------------------------------------------------------------- */
SMG_INLINE smg_lane_vec smg_lanes_tableau_row(const smg_lane_coefficients *c, smg_lane_vec w, smg_lane_vec first,
                                              int j) {
  const smg_lanes zero = smg_lane_of(-(smg_real)0), part = smg_lane_of((smg_real)1 / (smg_real)j), one = smg_lane_of(1);
  smg_lane_vec older = smg_lane_vec_of(zero, zero, zero), newer = smg_lane_vec_scale(smg_lane_of((smg_real)0.5), first);
  for (int m = 1; m < 2 * j; ++m) {
    const smg_lane_vec point = smg_lane_vec_add(w, smg_lane_vec_scale(part, newer));
    const smg_lane_vec next = smg_lane_vec_add(older, smg_lane_motion(c + smg_time_of(j, m), point, one));
    older = newer;
    newer = next;
  }
  return newer;
}

SMG_INLINE smg_lane_vec smg_lanes_increment(const smg_lane_coefficients *c, smg_lane_vec w) {
  const smg_lane_vec first = smg_lane_motion(c, w, smg_lane_of(1));
  const smg_lanes unit = smg_lane_of(smg_tableau_unit);
  smg_lane_vec sum = smg_lane_vec_scale(smg_lane_of(smg_tableau_weights[0]), smg_lanes_tableau_row(c, w, first, 1));
  SMG_UNROLL
  for (int j = 2; j <= SMG_TABLEAU_ROWS; ++j)
    sum = smg_lane_vec_add(
        sum, smg_lane_vec_scale(smg_lane_of(smg_tableau_weights[j - 1]), smg_lanes_tableau_row(c, w, first, j)));
  return smg_lane_vec_of(sum.x / unit, sum.y / unit, sum.z / unit);
}

SMG_INLINE smg_lane_mask smg_lanes_finite(smg_lane_vec a) {
  return (smg_lane_mask)(smg_lane_abs(a.x) <= SMG_MAX) & (smg_lane_mask)(smg_lane_abs(a.y) <= SMG_MAX) &
         (smg_lane_mask)(smg_lane_abs(a.z) <= SMG_MAX);
}

/* ---- lanes and states
 * ------------------------------------------------------------------------------------------------------- */
static void smg_lane_take_up(smg_tableau_group *g, int l, smg_state *s) {
  g->state[l] = s;
  for (int b = 0; b < 3; ++b) {
    smg_lane_set(g->w + b, l, s->w[b]);
    smg_lane_set(g->compensation + b, l, s->compensation[b]);
  }
}

/* Lane l as a state, after `taken` steps. */
static void smg_lane_put_back(const smg_tableau_group *g, int l, int64_t taken) {
  smg_state *s = g->state[l];
  for (int b = 0; b < 3; ++b) {
    s->w[b] = smg_lane_get(g->w + b, l);
    s->compensation[b] = smg_lane_get(g->compensation + b, l);
  }
  s->count += taken;
}

/* The step of the lanes `lost` by smg_step(), where it fails. */
SMG_COLD static void smg_lanes_lost(smg_tableau_group *g, smg_lane_mask lost, int64_t taken) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(lost, l)) continue;
    smg_lane_put_back(g, l, taken);
    g->state[l]->report.status = smg_step(g->state[l]);
    g->live[l] = 0;
  }
}

/* One step, after `taken` others. */
SMG_INLINE void smg_group_step(smg_tableau_group *g, int64_t taken) {
  const smg_lane_vec w = smg_lane_vec_load(g->w), u = smg_lanes_increment(g->c, w);
  const smg_lane_mask lost = g->live & ~smg_lanes_finite(smg_lane_vec_add(w, u));
  if (smg_lane_any(lost)) smg_lanes_lost(g, lost, taken);
  const smg_lane_vec y = smg_lane_vec_add(u, smg_lane_vec_load(g->compensation)), sum = smg_lane_vec_add(w, y);
  smg_lane_vec_store(g->compensation, smg_lane_vec_sub(y, smg_lane_vec_sub(sum, w)));
  smg_lane_vec_store(g->w, sum);
}

/* ---- coefficients
 * ----------------------------------------------------------------------------------------------------------- */
/* Those of s at the part `part` of the step that comes after `taken` others. */
static const smg_coefficients *smg_at_time(smg_state *s, int64_t taken, smg_real part) {
  s->count += taken;
  smg_set_time_at(&s->c, s, part);
  s->count -= taken;
  return &s->c;
}

/* The same in lanes, of group k. */
static void smg_fill_time(smg_tableau_batch *b, int k, smg_lane_coefficients *to, int64_t taken, smg_real part) {
  if (b->alike) smg_lane_spread(to, smg_at_time(&b->clock, taken, part));
  else
    for (int l = 0; l < SMG_LANES; ++l) smg_lane_fill(to, l, smg_at_time(b->group[k].state[l], taken, part));
}

/* All tables, for one step. */
static void smg_fill_tables(smg_tableau_batch *b, int64_t taken) {
  const int tables = b->alike ? 1 : b->groups;
  for (int k = 0; k < tables; ++k) {
    smg_fill_time(b, k, b->c[k], taken, 0);
#if SMG_TIMED
    for (int j = 1; j <= SMG_TABLEAU_ROWS; ++j)
      for (int m = 1; m < 2 * j; ++m) smg_fill_time(b, k, b->c[k] + smg_time_of(j, m), taken, smg_tableau_part(j, m));
#endif
  }
}

/* ---- many states
 * ------------------------------------------------------------------------------------------------------------ */
/* The states at s, one a lane, n <= SMG_LANES of them; other lanes repeat the first. */
static void smg_tableau_group_begin(smg_tableau_group *g, smg_state *const *s, int n, const smg_lane_coefficients *c) {
  g->live = smg_lane_below(n);
  g->c = c;
  for (int l = 0; l < SMG_LANES; ++l) smg_lane_take_up(g, l, s[l < n ? l : 0]);
}

/* All lanes that have not failed are states again. */
static void smg_tableau_group_end(smg_tableau_group *g, int64_t taken) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(g->live, l)) continue;
    smg_lane_put_back(g, l, taken);
    g->state[l]->report.site = g->state[l]->report.partner = -1;
  }
}

/* count steps of n states, of as many as a batch holds at most. */
static void smg_tableau_batch_steps(smg_state *const *s, int n, int64_t count, int alike) {
  smg_tableau_batch b;
  b.clock = *s[0];
  b.alike = alike;
  b.groups = 0;
  for (int k = 0; k < n; k += SMG_LANES, ++b.groups)
    smg_tableau_group_begin(b.group + b.groups, s + k, n - k < SMG_LANES ? n - k : SMG_LANES,
                            b.c[alike ? 0 : b.groups]);
  for (int64_t taken = 0; taken < count; ++taken) {
    if (SMG_TIMES > 1 || taken == 0) smg_fill_tables(&b, taken);
    for (int k = 0; k < b.groups; ++k) smg_group_step(b.group + k, taken);
  }
  for (int k = 0; k < b.groups; ++k) smg_tableau_group_end(b.group + k, count);
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

/* count steps of those states that have not failed; alike: all have the same parameters. */
static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_state *some[SMG_TABLEAU_GROUPS * SMG_LANES];
  const int same = alike && smg_all_at_once(s, members), most = (same ? SMG_TABLEAU_GROUPS : SMG_TABLES) * SMG_LANES;
  int n = 0;
  for (int64_t k = 0; k < members; ++k) {
    if (s[k].report.status == SMG_OK) some[n++] = s + k;
    if (n == most || (n > 0 && k + 1 == members)) {
      smg_tableau_batch_steps(some, n, count, same);
      n = 0;
    }
  }
}

#else

/* One lane: states step by themselves, and the kernel stays unused. */
static inline void smg_lanes_of_one(smg_lane_coefficients *to, const smg_coefficients *c, smg_lane_vec m, smg_lanes q) {
  smg_lane_fill(to, 0, c);
  smg_lane_spread(to, c);
  (void)smg_lane_motion(to, m, q);
}

#endif
#endif
