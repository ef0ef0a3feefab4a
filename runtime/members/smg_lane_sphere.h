/* smidgen method: the step of smg_single_sphere.h for many states at once (smg_lane_batch.h), one a lane, each with the
 * bits that it has alone.
 *
 * Lanes take the prediction, Newton iterations where one leaves too much, and the evaluation that confirms them, by
 * smg_lane_newton.h. Rare cases, and the first step of a state, fall back to smg_step(). */
#ifndef SMG_LANE_SPHERE_H
#define SMG_LANE_SPHERE_H

#include "smg_lane_newton.h"

#if SMG_LANES > 1

/* While the results of one are awaited, the other steps. With three, histories and all else leave too little of a
 * first-level cache of 32 KB. */
#define SMG_GROUPS 2
enum { SMG_TIMES = 1, SMG_TABLES = SMG_GROUPS };
/* rows of history before they are moved back: more leave the nearest cache, fewer are moved more often */
#define SMG_LANE_ROWS 24

typedef struct smg_group {
  smg_lanes w[3], compensation[3], weights[SMG_HISTORY], rows[4 * SMG_LANE_ROWS], residual;
  smg_lane_iterate next;
  const smg_lane_coefficients *c;
  smg_lane_mask live, began, iterations;
  smg_state *state[SMG_LANES];
  int64_t taken;
  int row; /* the newest of the history */
} smg_group;

#include "smg_lane_batch.h"

/* ---- lanes and states ------------------------------------------------------------------------ */

/* The weights of the predictor of lane l. */
static void smg_lane_degree(smg_group *g, int l, int degree) {
  for (int j = 0; j < SMG_HISTORY; ++j) smg_lane_set(g->weights + j, l, smg_sphere_weights[degree][4 * j]);
}

static inline void smg_group_clear(smg_group *g) { g->row = SMG_LANE_ROWS - SMG_HISTORY; }

static inline void smg_lane_take_up(smg_group *g, int l, const smg_state *s, int newest) {
  smg_lane_insert(g->rows + 4 * g->row, l, s->rows + 4 * s->row, newest ? 4 : 4 * SMG_HISTORY);
  smg_lane_degree(g, l, s->degree);
}

static inline void smg_lane_put_back(const smg_group *g, int l, smg_state *s) {
  s->row = SMG_ROWS - SMG_HISTORY;
  smg_lane_extract(g->rows + 4 * g->row, l, s->rows + 4 * s->row, 4 * SMG_HISTORY);
}

static inline void smg_lane_report(const smg_group *g, int l, smg_state *s) {
  s->report.iterations = (int)g->iterations[l];
  s->report.residual = smg_lane_get(&g->residual, l);
  smg_set_time_at(&s->c, s, (smg_real)-0.5); /* of the step just taken */
}

static void smg_fill_table(const smg_batch *b, int k, smg_lane_coefficients *table) {
  smg_fill_time(b, k, table, (smg_real)0.5);
}

/* ---- one step of a group ---------------------------------------------------------------------- */

/* smg_sphere_predict() */
SMG_INLINE void smg_lanes_predict(smg_group *g) {
  const smg_lanes *row = g->rows + 4 * g->row, *a = g->weights;
  smg_lanes sum[4];
  for (int i = 0; i < 4; ++i) sum[i] = a[SMG_HISTORY - 2] * row[4 * (SMG_HISTORY - 2) + i];
  SMG_UNROLL
  for (int j = SMG_HISTORY - 3; j >= 0; --j)
    for (int i = 0; i < 4; ++i) sum[i] += a[j] * row[4 * j + i];
  g->next.u = smg_lane_vec_of(sum[0], sum[1], sum[2]);
  g->next.q = sum[3];
}

/* smg_sphere_degree() in the lanes `due`. */
SMG_COLD static void smg_lanes_degree(smg_group *g, smg_lane_mask due) {
  smg_lanes miss[SMG_HISTORY] = {{0}};
  smg_lane_sphere_misses(g->rows + 4 * g->row, SMG_HISTORY, miss);
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(due, l)) continue;
    smg_state *s = g->state[l];
    smg_real own[SMG_HISTORY];
    smg_lane_extract(miss, l, own, SMG_HISTORY);
    s->history = smg_rows_known(s, g->began[l] + g->taken);
    s->degree = smg_best_degree(s->history - 1, own);
    smg_lane_degree(g, l, s->degree);
  }
}

SMG_INLINE void smg_lanes_commit(smg_group *g, const smg_lane_found *f) {
  g->row = smg_lane_sphere_keep(g->rows, g->row, SMG_LANE_ROWS, f->v, f->q);
  smg_lane_sphere_move(g->w, g->compensation, f);
  g->residual = f->residual;
  ++g->taken;
}

/* The lanes `left`, which one Newton iteration has not settled; f: what it found. */
SMG_COLD static void smg_lanes_resume(smg_group *g, smg_lane_mask left, const smg_lane_iterate *n, smg_lane_found f) {
  const smg_lane_mask alone = smg_lanes_again(g->c, g->w, g->compensation, left, n, &f, &g->iterations);
  if (smg_lane_any(alone)) smg_lanes_step_alone(g, alone);
  smg_lanes_commit(g, &f);
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(alone & g->live, l)) continue;
    smg_lane_begin(g, l, 1);
    smg_lane_set(&g->residual, l, g->state[l]->report.residual);
    g->iterations[l] = g->state[l]->report.iterations;
  }
  const smg_lane_mask due = left & ~alone & (smg_lane_mask)(((g->began + g->taken) & 15) == 0);
  if (smg_lane_any(due)) smg_lanes_degree(g, due);
}

SMG_INLINE void smg_lanes_finish(smg_group *g) {
  const smg_lane_found f =
      smg_lane_sphere_evaluate(g->c, smg_lane_vec_load(g->w), smg_lane_vec_load(g->compensation), g->next);
  const smg_lane_mask left = g->live & ~smg_lane_sphere_done(f, g->next);
  g->iterations = smg_lane_all(0) + 1;
  if (smg_lane_any(left)) smg_lanes_resume(g, left, &g->next, f);
  else smg_lanes_commit(g, &f);
}

/* In three parts, each short enough that a processor works on several groups at once. */
static void smg_groups_step(smg_group *g, int groups) {
  for (int k = 0; k < groups; ++k) smg_lanes_predict(g + k);
  for (int k = 0; k < groups; ++k)
    g[k].next = smg_lane_sphere_newton(g[k].c, smg_lane_vec_load(g[k].w), g[k].next.u, g[k].next.q);
  for (int k = 0; k < groups; ++k) smg_lanes_finish(g + k);
}

/* One step of each state that has none behind it, with all others, where there is such a one; returns how many steps
 * that were. */
static int64_t smg_lane_first_steps(smg_state *s, int64_t members) {
  int fresh = 0;
  for (int64_t k = 0; k < members; ++k) fresh |= s[k].report.status == SMG_OK && s[k].count == s[k].begun;
  if (!fresh) return 0;
  for (int64_t k = 0; k < members; ++k)
    if (s[k].report.status == SMG_OK) s[k].report.status = smg_step(s + k);
  return 1;
}

static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_batches_steps(s, members, count - smg_lane_first_steps(s, members), alike);
}

#endif
#endif
