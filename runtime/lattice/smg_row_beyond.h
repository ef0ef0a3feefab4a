/* smidgen runtime: sweeps by rows in lanes where the bound of smg_row_state.h does not show beforehand that they are a
 * contraction. Such a state is kept by sites; a step takes w and the predicted midpoints into slots, sweeps there, and
 * brings the increments back.
 *
 * At the solution that they find, one spin's own equation rho m - h/2 m x R = w, R = F + m x Q, has in its tangent
 * plane the derivative a I + b [m x]/r with a = rho - h/2 m.Q, b = h/2 m.F/r. So a change of its field moves m by at
 * most 1/s of it, s^2 = a^2 + b^2, and there all spins at once are a contraction by the numerator of smg_row_factor()
 * over the least s, or by less with weights (smg_row_weights.h). Where that is at most SMG_ROW_SHOWN, a > 0, and
 * sweeps came there straight, the solution is on the branch of W = w at h = 0; else the branch is followed
 * (smg_row_follow.h), and where that fails, Newton decides. */
#ifndef SMG_ROW_BEYOND_H
#define SMG_ROW_BEYOND_H

#include "smg_history.h"
#include "smg_row_follow.h"
#include "smg_row_weights.h"

/* 1/s of the slots of one vector, whose gradient is g; 0 in empty ones. */
SMG_INLINE smg_lanes smg_own_slope(const smg_turning turn, int64_t slot, const smg_lanes *m, const smg_lanes *g) {
  smg_lanes w[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  const smg_inverse inverse = smg_inverse_at(turn.inverses, slot);
  smg_lanes rho = inverse * smg_lane_dot(w, m);
#if SMG_TOLD
  const smg_told told = smg_told_at(turn, slot);
  smg_lanes F[3], Q[3];
  smg_lane_told_parts(told.r, g, F, Q);
  rho -= turn.half * smg_lane_dot(m, Q);
  const smg_lanes along = turn.half * smg_lane_dot(m, F);
#else
  const smg_lanes along = turn.half * smg_lane_dot(m, g);
#endif
  const smg_lanes slope = 1 / smg_lane_sqrt(rho * rho + inverse * (along * along));
  return smg_lane_select((smg_lane_mask)(smg_lane_dot(w, w) > 0),
                         smg_lane_select((smg_lane_mask)(rho > 0), slope, smg_lane_of(SMG_MAX)), smg_lane_of(0));
}

/* Increments, the largest square of their residual, and |h/2kappa| r gain/s of all slots. */
typedef struct smg_showing {
  smg_turning turn;
  smg_real pull, *slopes;
  smg_lanes most, slope;
} smg_showing;

SMG_INLINE void smg_show_vector(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  smg_showing *show = (smg_showing *)context;
  smg_lanes m[3];
  smg_take_slots(show->turn.m, show->turn.pitch, slot, m);
  const smg_lanes slope = show->pull * smg_own_slope(show->turn, slot, m, g);
  smg_lane_put(show->slopes + slot, slope);
  show->slope = smg_lane_max(show->slope, smg_lane_first(in, slope));
  smg_end_slots(show->turn, slot, in, m, g, &show->most);
}

/* The increments of all sites; do they solve the step? */
static int smg_show_rows(smg_state *s, smg_beyond *a) {
  smg_real most = 0, slope = 0;
  const smg_real pull = smg_abs(a->turn.half) * smg_at_all_sites(&s->c, smg_radius) * smg_row_gain(&s->c);
  SMG_TEAM(s->row_team) {
    smg_showing show = {a->turn, pull, smg_row_slopes(s), smg_lane_of(0), smg_lane_of(0)};
    show.turn.inverses = smg_inverses_of(s);
    for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
      smg_increments_into(s, colour, &show.turn);
      smg_each_vector(&s->c, &a->known, s->row_m, colour, smg_share_of(&s->c, colour, 1), &show, smg_show_vector);
    }
    SMG_ONE_BY_ONE {
      smg_take(&most, smg_lane_largest(show.most));
      smg_take(&slope, smg_lane_largest(show.slope));
    }
  }
  a->slope = slope;
  a->left -= SMG_COLOURS; /* an evaluation of all sites is worth a sweep */
  return smg_row_solved(s, SMG_MATH(sqrt)(most),
                        smg_max(smg_left_by_sweeps(s), 2 / (1 - smg_min(a->ratio, 1 - SMG_EPS))));
}

/* Are they on the branch? By the bound at the solution. */
static int smg_shown_by_rows(const smg_state *s, smg_beyond *a) {
  if (a->grew) return 0;
  return a->slope * smg_at_all_sites(&s->c, SMG_HESSIAN_EVER) <= SMG_ROW_SHOWN ||
         smg_weights_show(s, &a->known, smg_row_slopes(s), smg_row_slopes(s) + smg_pitch(&s->c));
}

/* They belong to sites again. */
SMG_INLINE void smg_increment_of_slot(void *context, int64_t site, int64_t slot) {
  const smg_state *s = (const smg_state *)context;
  const int64_t first = SMG_KEPT_FROM(&s->c);
  for (int64_t k = 0; k < 3; ++k)
    s->u[3 * site + k] = slot < first ? s->row_u[k * SMG_FIRST_PITCH(&s->c) + slot]
                                      : s->row_late[k * SMG_LATE_PITCH(&s->c) + slot - first];
}

/* Sweeps, while they settle soon, with the increments that they leave; do these solve the step? */
static int smg_solve_beyond(smg_state *s, smg_beyond *a) {
  while (smg_settle_beyond(s, a, smg_allowed(s) / 2)) /* W moves by twice as much as midpoints */
    if (smg_show_rows(s, a)) return 1;
  return 0;
}

/* The same where the branch leads that begins with w: is that what has been found, or another solution? */
static int smg_solve_at_end(smg_state *s, smg_real h, smg_beyond *a, int solved) {
  smg_row_path path;
  smg_real *found = smg_paths_of(s) + SMG_BEFORE;
  path.found = found;
  path.solved = solved;
  smg_rows_copy(s, found, s->row_m);
  a->left = SMG_PATH_SWEEPS * SMG_COLOURS;
  a->relax = solved ? 1 : SMG_RELAXED;
  if (!smg_follow_rows(s, h, a, &path)) return 0;
  const int found_there = smg_missed(s, &path, found) <= SMG_STRAIGHT;
  if (solved && found_there) return 1;
  if (found_there) smg_rows_copy(s, s->row_m, found); /* slow sweeps continue where they stopped */
  smg_turn_beyond(s, h, a);
  return smg_solve_beyond(s, a) && smg_missed(s, &path, s->row_m) <= SMG_STRAIGHT;
}

/* Sweeps, while they settle soon; SMG_NO_CONVERGENCE leaves the step to Newton. */
static smg_status smg_sweeps(smg_state *s, smg_real h) {
  smg_beyond a;
  smg_begin_beyond(s, h, &a);
  const int solved = smg_solve_beyond(s, &a);
  const int there = (solved && smg_shown_by_rows(s, &a)) || smg_solve_at_end(s, h, &a, solved);
  s->report.iterations = (int)(a.passes / SMG_COLOURS);
  if (!there) return SMG_NO_CONVERGENCE;
  smg_each_slot(&s->c, s, smg_increment_of_slot);
  return SMG_OK;
}

#endif
