/* smidgen method: the step of a composition of a single sphere (smg_composition.h) for many states at once
 * (smg_lane_batch.h), one a lane, each with the bits that it has alone.
 *
 * The stages of a step go through smg_lane_newton.h one after the other. A lane with a stage that
 * lanes cannot solve continues to the end of the step, its results unused, and is then put back to where the step
 * began: smg_step() takes it. So are steps taken while the history is not full. */
#ifndef SMG_LANE_COMPOSITION_H
#define SMG_LANE_COMPOSITION_H

#include "smg_lane_newton.h"

#include "smg_composition.h"

#if SMG_LANES > 1

#define smg_add_level_misses smg_lane_add_level_misses
#include "smg_in_lanes.h"
#include "smg_level_misses_template.h"
#include "smg_in_numbers.h"
#undef smg_add_level_misses

#define SMG_GROUPS 3
#if SMG_TIMED
enum { SMG_TIMES = SMG_COMPOSED };
#else
enum { SMG_TIMES = SMG_COMPOSED / 2 + 1 };
#endif
/* rows of the history: a step begins with room for all of its stages before the newest one; and tables */
enum { SMG_LANE_ROWS = SMG_HISTORY + SMG_COMPOSED * (1 + 16 / SMG_COMPOSED), SMG_TABLES = SMG_GROUPS };

typedef struct smg_group {
  smg_lanes w[3], compensation[3], rows[4 * SMG_LANE_ROWS], before[6], residual, misses[SMG_LEVELS];
  smg_lane_iterate next;
  const smg_lane_coefficients *c;
  smg_lane_mask live, began, iterations, alone, level; /* alone: those that have left this step to smg_step() */
  smg_state *state[SMG_LANES];
  int64_t taken;
  int row, first,
      one_level; /* the newest of the history, now and before the step; is the level the same in all lanes? */
} smg_group;

#include "smg_lane_batch.h"

/* ---- lanes and states ------------------------------------------------------------------------ */

static void smg_lane_level(smg_group *g, int l, int level) {
  g->level[l] = level;
  g->one_level = !smg_lane_any((smg_lane_mask)(g->level != g->level[0]));
}

static inline void smg_group_clear(smg_group *g) {
  g->row = SMG_LANE_ROWS - SMG_HISTORY;
  g->level = smg_lane_all(0);
}

static inline void smg_lane_take_up(smg_group *g, int l, const smg_state *s, SMG_UNUSED int newest) {
  smg_lane_insert(g->rows + 4 * g->row, l, s->rows + 4 * s->row, 4 * SMG_HISTORY);
  smg_lane_level(g, l, s->degree);
}

static inline void smg_lane_put_back(const smg_group *g, int l, smg_state *s) {
  s->row = SMG_ROWS - SMG_HISTORY;
  smg_lane_extract(g->rows + 4 * g->row, l, s->rows + 4 * s->row, 4 * SMG_HISTORY);
}

/* The coefficients of a stage of group k, its midpoint a part `middle` of the step to come. */
static void smg_fill_stage(const smg_batch *b, int k, smg_lane_coefficients *to, int stage, smg_real middle) {
  for (int l = 0; l < SMG_LANES; ++l) {
    smg_state *s = b->group[k].state[l];
    smg_have_stages(s);
    s->c = smg_prepared(s)[smg_size_of_stage(stage)];
  }
  smg_fill_time(b, k, to, middle);
}

static void smg_fill_table(const smg_batch *b, int k, smg_lane_coefficients *table) {
  smg_real done = 0;
  for (int stage = 0; stage < SMG_TIMES; ++stage) {
    smg_fill_stage(b, k, table + stage, stage, done + 0.5 * smg_gamma[stage]);
    done += smg_gamma[stage];
  }
}

static inline void smg_lane_report(const smg_group *g, int l, smg_state *s) {
  s->report.iterations = (int)g->iterations[l];
  s->report.residual = smg_lane_get(&g->residual, l);
}

/* ---- one stage of a group --------------------------------------------------------------------- */

SMG_INLINE const smg_lane_coefficients *smg_lanes_of_stage(const smg_group *g, int stage) {
  return g->c + (SMG_FIELD_MOVES ? stage : smg_size_of_stage(stage));
}

/* The weight of row j, of the level of each lane. */
SMG_INLINE smg_lanes smg_lane_weight(const smg_group *g, int stage, int j) {
  smg_lanes a = smg_lane_of((smg_real)smg_stage_weights[stage][g->level[0]][j]);
  if (g->one_level) return a;
  for (int l = 0; l < SMG_LEVELS; ++l)
    a = smg_lane_select((smg_lane_mask)(g->level == l), smg_lane_of((smg_real)smg_stage_weights[stage][l][j]), a);
  return a;
}

/* smg_sphere_predict() */
SMG_INLINE void smg_lanes_predict(smg_group *g, int stage) {
  const smg_lanes *row = g->rows + 4 * g->row;
  smg_lanes sum[4] = {{0}, {0}, {0}, {0}};
  for (int j = SMG_HISTORY - 1; j >= 0; --j) {
    const smg_lanes a = smg_lane_weight(g, stage, j);
    for (int i = 0; i < 4; ++i) sum[i] += a * row[4 * j + i];
  }
  g->next.u = smg_lane_vec_of(sum[0], sum[1], sum[2]);
  g->next.q = sum[3] * (smg_real)smg_inverse_gamma[stage];
}

/* The lanes of which it is time to choose a level in the step to come. */
SMG_INLINE smg_lane_mask smg_lanes_due(const smg_group *g) {
  return (smg_lane_mask)(((g->began + g->taken) & 15) == 2);
}

/* smg_stage_misses(), of the stage whose row is the newest. */
SMG_COLD static void smg_lanes_misses(smg_group *g, int stage) {
  for (int i = 0; i < 3; ++i) {
    smg_lanes row[SMG_HISTORY + 1];
    for (int j = 0; j <= SMG_HISTORY; ++j) row[j] = g->rows[4 * (g->row + j) + i];
    smg_lane_add_level_misses(stage, row, g->misses);
  }
}

SMG_INLINE void smg_lanes_end_stage(smg_group *g, int stage) {
  const smg_lane_coefficients *c = smg_lanes_of_stage(g, stage);
  smg_lane_found f = smg_lane_sphere_evaluate(c, smg_lane_vec_load(g->w), smg_lane_vec_load(g->compensation), g->next);
  const smg_lane_mask left = g->live & ~g->alone & ~smg_lane_sphere_done(f, g->next);
  smg_lane_mask iterations = smg_lane_all(0) + 1;
  if (smg_lane_any(left)) g->alone |= smg_lanes_again(c, g->w, g->compensation, left, &g->next, &f, &iterations);
  g->iterations += iterations;
  g->residual = smg_lane_max(g->residual, f.residual);
  g->row = smg_lane_sphere_keep(g->rows, g->row, SMG_LANE_ROWS, f.v, smg_gamma[stage] * f.q);
  smg_lane_sphere_move(g->w, g->compensation, &f);
  if (smg_lane_any(smg_lanes_due(g))) smg_lanes_misses(g, stage);
}

/* ---- one step --------------------------------------------------------------------------------- */

/* The rows of a step fit below the newest one: those of the steps before stay as they are until the next begins. */
SMG_INLINE void smg_lanes_hold(smg_group *g) {
  if (g->row < SMG_COMPOSED) {
    smg_lane_copy(g->rows + 4 * (SMG_LANE_ROWS - SMG_HISTORY), g->rows + 4 * g->row, 4 * SMG_HISTORY);
    g->row = SMG_LANE_ROWS - SMG_HISTORY;
  }
  g->first = g->row;
  smg_lane_copy(g->before, g->w, 3);
  smg_lane_copy(g->before + 3, g->compensation, 3);
  smg_lane_zero(g->misses, SMG_LEVELS);
  g->residual = smg_lane_of(0);
  g->iterations = g->alone = smg_lane_all(0);
}

/* The step of those that have left it, from its beginning. */
SMG_COLD static void smg_lanes_redo(smg_group *g) {
  const int row = g->row;
  const smg_lane_mask alone = g->alone;
  smg_lane_choose(g->w, alone, g->before, g->w, 3);
  smg_lane_choose(g->compensation, alone, g->before + 3, g->compensation, 3);
  g->row = g->first;
  smg_lanes_step_alone(g, alone);
  g->row = row;
  ++g->taken;
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(alone & g->live, l)) continue;
    smg_lane_begin(g, l, 0);
    smg_lane_set(&g->residual, l, g->state[l]->report.residual);
    g->iterations[l] = g->state[l]->report.iterations;
  }
}

/* smg_choose_level() in the lanes `due`, whose misses are those of all stages. */
SMG_COLD static void smg_lanes_choose(smg_group *g, smg_lane_mask due) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(due, l)) continue;
    smg_state *s = g->state[l];
    smg_lane_extract(g->misses, l, s->misses, SMG_LEVELS);
    s->misses[SMG_LEVELS] = SMG_COMPOSED - 1;
    smg_choose_level(s);
    smg_lane_level(g, l, s->degree);
  }
}

SMG_INLINE void smg_lanes_end(smg_group *g) {
  const smg_lane_mask due = smg_lanes_due(g) & g->live & ~g->alone;
  if (smg_lane_any(due)) smg_lanes_choose(g, due);
  if (smg_lane_any(g->alone)) smg_lanes_redo(g);
  else ++g->taken;
}

static void smg_groups_step(smg_group *g, int groups) {
  for (int k = 0; k < groups; ++k) smg_lanes_hold(g + k);
  for (int stage = 0; stage < SMG_COMPOSED; ++stage) {
    for (int k = 0; k < groups; ++k) smg_lanes_predict(g + k, stage);
    for (int k = 0; k < groups; ++k)
      g[k].next =
          smg_lane_sphere_newton(smg_lanes_of_stage(g + k, stage), smg_lane_vec_load(g[k].w), g[k].next.u, g[k].next.q);
    for (int k = 0; k < groups; ++k) smg_lanes_end_stage(g + k, stage);
  }
  for (int k = 0; k < groups; ++k) smg_lanes_end(g + k);
}

/* Steps of all states by themselves until every history is full, at most `count`; returns how many that were. */
static int64_t smg_lane_first_steps(smg_state *s, int64_t members, int64_t count) {
  for (int64_t taken = 0; taken < count; ++taken) {
    int fresh = 0;
    for (int64_t k = 0; k < members; ++k) fresh |= s[k].report.status == SMG_OK && s[k].history < SMG_HISTORY;
    if (!fresh) return taken;
    for (int64_t k = 0; k < members; ++k)
      if (s[k].report.status == SMG_OK) s[k].report.status = smg_step(s + k);
  }
  return count;
}

static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_batches_steps(s, members, count - smg_lane_first_steps(s, members, count), alike);
}

#endif
#endif
