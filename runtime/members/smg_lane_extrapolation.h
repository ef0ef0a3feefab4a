/* smidgen method: the step of smg_extrapolation.h for many states of a single unit sphere at once (smg_lane_batch.h),
 * one a lane, each with the bits that it has alone.
 *
 * Where the field depends on time, its coefficients at all times of a step are computed before it: once for all states
 * that have the same parameters and the same time. Where a step fails smg_step() says so, from before it; its lane goes
 * on for nothing.
 *
 * The model adds smg_lane_motion, q h (1/kappa) grad C(w) x dH/dw. */
#ifndef SMG_LANE_EXTRAPOLATION_H
#define SMG_LANE_EXTRAPOLATION_H

#include "smg_extrapolation.h"
#include "smg_lane_vec.h"

#if SMG_LANES > 1

#define SMG_GROUPS 8
/* Of fields that depend on time one group has as much as the nearest cache holds. */
#if SMG_TIMED
enum { SMG_TIMES = 1 + SMG_TABLEAU_ROWS * SMG_TABLEAU_ROWS, SMG_TABLES = 1 };
#else
enum { SMG_TIMES = 1, SMG_TABLES = SMG_GROUPS };
#endif

typedef struct smg_group {
  smg_lanes w[3], compensation[3];
  smg_lane_mask live, began;
  smg_state *state[SMG_LANES];
  const smg_lane_coefficients *c;
  int64_t taken;
} smg_group;

#include "smg_lane_batch.h"

/* ---- coefficients
 * ----------------------------------------------------------------------------------------------------------- */
/* Where those for t + m h/(2j) stand: row j has 2j - 1 of them, behind the (j - 1)^2 of those before it and those for
 * t. */
SMG_INLINE int smg_time_of(int j, int m) { return SMG_TIMES > 1 ? (j - 1) * (j - 1) + m : 0; }

static void smg_fill_table(const smg_batch *b, int k, smg_lane_coefficients *table) {
  smg_fill_time(b, k, table, 0);
#if SMG_TIMED
  for (int j = 1; j <= SMG_TABLEAU_ROWS; ++j)
    for (int m = 1; m < 2 * j; ++m) smg_fill_time(b, k, table + smg_time_of(j, m), smg_tableau_part(j, m));
#endif
}

/* ---- the step
 * --------------------------------------------------------------------------------------------------------------- */
typedef const smg_lane_coefficients smg_lane_tableau_field;

SMG_INLINE const smg_lane_coefficients *smg_lane_tableau_at(const smg_lane_coefficients *c, int j, int m) {
  return c + smg_time_of(j, m);
}

#define smg_tableau_field smg_lane_tableau_field
#define smg_tableau_at smg_lane_tableau_at
#define smg_tableau_row smg_lane_tableau_row
#define smg_tableau_increment smg_lane_tableau_increment
#include "smg_in_lanes.h"
#include "smg_tableau_template.h"
#include "smg_in_numbers.h"

static void smg_groups_step(smg_group *g, int groups) {
  for (int k = 0; k < groups; ++k, ++g) {
    const smg_lane_vec u = smg_lane_tableau_increment(g->c, smg_lane_vec_load(g->w)),
                       end = smg_lane_vec_add(smg_lane_vec_load(g->w), u);
    const smg_lane_mask lost = g->live & ~smg_lane_vec_finite(end);
    if (smg_lane_any(lost)) smg_lanes_step_alone(g, lost);
    smg_lane_add_compensated(g->w, g->compensation, u.x);
    smg_lane_add_compensated(g->w + 1, g->compensation + 1, u.y);
    smg_lane_add_compensated(g->w + 2, g->compensation + 2, u.z);
    ++g->taken;
  }
}

static inline void smg_group_clear(SMG_UNUSED smg_group *g) {}
static inline void smg_lane_take_up(SMG_UNUSED smg_group *g, SMG_UNUSED int l, SMG_UNUSED const smg_state *s,
                                    SMG_UNUSED int newest) {}
static inline void smg_lane_put_back(SMG_UNUSED const smg_group *g, SMG_UNUSED int l, SMG_UNUSED smg_state *s) {}
static inline void smg_lane_report(SMG_UNUSED const smg_group *g, SMG_UNUSED int l, smg_state *s) {
  s->report.site = s->report.partner = -1;
}

static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_batches_steps(s, members, count, alike);
}

#endif
#endif
