/* smidgen runtime: sweeps by rows in lanes where the bound of smg_row_state.h does not show beforehand that they are a
 * contraction. Such a state is kept by sites; a step takes w and the predicted midpoints into slots, sweeps there, and
 * brings the increments back.
 *
 * At the solution that they find, one spin's own equation rho m - h/2 m x R = w, R = F + m x Q, has in its tangent
 * plane the derivative a I + b [m x]/r with a = rho - h/2 m.Q, b = h/2 m.F/r. So a change of its field moves m by at
 * most 1/s of it, s^2 = a^2 + b^2, and there all spins at once are a contraction by the numerator of smg_row_factor()
 * over the least s, or by less with weights (smg_row_weights.h). Where that is at most SMG_ROW_SHOWN, a > 0, or the
 * derivative of all equations together is coercive (smg_row_mean.h), and sweeps came there straight, the solution is on
 * the branch of W = w at h = 0; else the matrix of Newton decides. */
#ifndef SMG_ROW_BEYOND_H
#define SMG_ROW_BEYOND_H

#include "smg_history.h"
#include "smg_row_mean.h"
#include "smg_row_step.h"
#include "smg_row_weights.h"
#include "smg_swept.h"

#define SMG_BEYOND_SWEEPS 200 /* sweeps before Newton takes over: they take as long as some 20 of its iterations */
#define SMG_BEYOND_ROUNDS 4   /* ends that solve nothing */

/* The sweeps of a step: what stands beside the sites; did a change grow? |h/2kappa| r gain/s, the largest. */
typedef struct smg_beyond {
  smg_besides known;
  smg_turning turn;
  smg_row_sweeping sweep;
  int grew;
  smg_real slope;
} smg_beyond;

/* w, what it has lost to rounding, and predicted midpoints into slots; one rank does all. */
static void smg_begin_beyond(smg_state *s, smg_real h, smg_beyond *a) {
  smg_sweep_start(s);
  smg_know_rows(s, &a->known);
  smg_by_each_rank();
  smg_begin_team(s, &a->known);
  smg_put_absent(s, 0);
  smg_to_slots(s, s->compensation, s->row_compensation);
  smg_to_slots(s, s->m, s->row_m);
  s->row_alone = 0; /* increments are found at the end alone */
  a->turn = smg_turning_of(s, h);
  a->grew = 0;
  a->slope = 0;
  smg_begin_sweeping(&a->sweep);
}

/* Sweeps to rest; 0 where they do not come there. */
static int smg_settle_beyond(smg_state *s, smg_beyond *a) {
  smg_row_sweeping *sweep = &a->sweep;
  do {
    const smg_row_pass pass = smg_next_pass(s, sweep);
    const smg_real before = sweep->whole.now;
    const smg_row_motion moved = smg_turn_colour(s, &a->known, &a->turn, pass);
    smg_take_pass(s, pass, &moved, sweep);
    if (sweep->passes > 2 * SMG_COLOURS && sweep->whole.now > before && sweep->whole.now > SMG_NEARLY * s->scale)
      a->grew = 1;
    if (!(sweep->whole.now <= SMG_MAX) || sweep->passes > SMG_BEYOND_SWEEPS * SMG_COLOURS) return 0;
  } while (sweep->passes < SMG_COLOURS || !smg_rows_settled(s, sweep));
  return 1;
}

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
  return smg_row_solved(s, SMG_MATH(sqrt)(most));
}

/* Are they on the branch? By the bound that is known beforehand, or by that at the solution. */
static int smg_shown_by_rows(const smg_state *s, smg_beyond *a) {
  if (s->row_bound <= SMG_ROW_BOUND) return 1;
  if (a->grew) return 0;
  smg_real *slopes = smg_row_slopes(s);
  const smg_real B = smg_at_all_sites(&s->c, SMG_HESSIAN_EVER);
  return a->slope * B <= SMG_ROW_SHOWN || smg_weights_show(s, &a->known, slopes, slopes + smg_pitch(&s->c)) ||
         smg_mean_shows(s, &a->known, a->turn, B, slopes + smg_pitch(&s->c));
}

/* They belong to sites again. */
SMG_INLINE void smg_increment_of_slot(void *context, int64_t site, int64_t slot) {
  const smg_state *s = (const smg_state *)context;
  const int64_t first = smg_colour_slots(&s->c);
  for (int64_t k = 0; k < 3; ++k)
    s->u[3 * site + k] = slot < first ? s->row_u[k * SMG_FIRST_PITCH(&s->c) + slot]
                                      : s->row_late[k * SMG_LATE_PITCH(&s->c) + slot - first];
}
static void smg_increments_to_sites(smg_state *s) { smg_each_slot(&s->c, s, smg_increment_of_slot); }

/* What the sweeps left is no proof: the matrix at their midpoints gives one, or Newton goes on from there. */
static smg_status smg_go_on_by_newton(smg_state *s, smg_real h, SMG_UNUSED int solved) {
  smg_sweep_midpoints(s, h);
#if SMG_MATRIX_FREE
  smg_assemble(s, h);
  if (solved && (smg_row_bound(s) < 1 || smg_on_branch(s, h, smg_row_bound(s), 0))) {
    smg_increments_to_sites(s); /* the matrix took another evaluation */
    return SMG_OK;
  }
#endif
  return smg_newton(s, h); /* which finds it solved, and checks the branch */
}

/* Sweeps, while they settle soon; SMG_NO_CONVERGENCE leaves the step to Newton, and the next SMG_NEWTON_STEPS steps
 * with it. */
static smg_status smg_sweeps(smg_state *s, smg_real h) {
  smg_beyond a;
  int solved = 0, settled = 1;
  if (s->newton_steps > 0) {
    --s->newton_steps;
    return SMG_NO_CONVERGENCE;
  }
  smg_begin_beyond(s, h, &a);
  for (int round = 0; settled && !solved && round < SMG_BEYOND_ROUNDS; ++round) {
    settled = smg_settle_beyond(s, &a);
    if (settled) solved = smg_show_rows(s, &a);
  }
  s->report.iterations = (int)(a.sweep.passes / SMG_COLOURS);
  if (!settled) {
    s->newton_steps = SMG_NEWTON_STEPS;
    return SMG_NO_CONVERGENCE;
  }
  smg_increments_to_sites(s);
  return solved && smg_shown_by_rows(s, &a) ? SMG_OK : smg_go_on_by_newton(s, h, solved);
}

#endif
