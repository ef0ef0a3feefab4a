/* smidgen runtime: steps of a lattice by rows in lanes, where the sweeps are a contraction whatever the state (smg_row_state.h). */
#ifndef SMG_ROW_STEP_H
#define SMG_ROW_STEP_H

#include "smg_row_sweep.h"

#ifndef SMG_ROW_PASSES
#define SMG_ROW_PASSES 2000 /* of colours: 0.9^k is round-off after 350 sweeps */
#endif

/* Sites of the first colour need a beginning, w, where they feel their own midpoints (SMG_OWN_FIELD), or each other across the seam of a
 * ring that is no multiple of the colours. */
static void smg_begin_first_colour(smg_state *s) {
  const smg_coefficients *c = &s->c;
  const int felt = SMG_OWN_FIELD || smg_meet_at_seam(c);
  for (int k = 0; felt && k < 3; ++k)
    for (int64_t j = 0; j < smg_colour_slots(c); ++j) s->row_m[k * smg_pitch(c) + j] = s->row_w[k * smg_pitch(c) + j];
}

/* m = P(w + u/2) of some slots, u extrapolated. */
static void smg_predict_slots(const smg_state *s, smg_share part) {
  const int64_t pitch = smg_pitch(&s->c), first = smg_colour_slots(&s->c), late = SMG_LATE_PITCH(&s->c);
  const int degree = s->degree;
  const smg_real r = smg_radius(&s->c, 0), inverse = 1 / (r * r), *w = s->row_w, *past[SMG_ROW_HISTORY];
  smg_real weights[SMG_ROW_HISTORY], *midpoints = s->row_m;
  for (int j = 0; j <= degree; ++j) {
    weights[j] = smg_weight(degree, j);
    past[j] = s->past[j] - first;
  }
  for (int64_t slot = part.from; slot < part.to; slot += SMG_LANES) {
    smg_lanes m[3];
    for (int k = 0; k < 3; ++k) {
      smg_lanes u = {0};
      for (int j = 0; j <= degree; ++j) u += weights[j] * smg_lane_take(past[j] + k * late + slot);
      m[k] = smg_lane_take(w + k * pitch + slot) + (smg_real)0.5 * u;
    }
    smg_lane_stretch_to(inverse, 0, m);
    smg_put_slots(midpoints, pitch, slot, m);
  }
}

/* Those of all colours but the first. */
static void smg_predict_rows(const smg_state *s) {
  const int64_t first = smg_colour_slots(&s->c);
  SMG_TEAM(s->row_team) {
    SMG_COLOURS_AT_ONCE(k, n, 1) smg_predict_slots(s, smg_share_of(k * first, n * first));
  }
  smg_exchange_late();
}

/* Sweeps to stagnation, or to the tolerance. */
static void smg_settle_rows(smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_sweeping *sweep) {
  do smg_next_colour(s, known, turn, sweep);
  while (sweep->passes < SMG_COLOURS || (sweep->passes < SMG_ROW_PASSES && !smg_rows_settled(s, sweep)));
  s->report.iterations = (int)((sweep->passes + SMG_COLOURS - 1) / SMG_COLOURS);
}

/* Is a residual of w + u/2 - rho m round-off? Or is what W leaves, smaller by the factor of a sweep, within the tolerance? */
static int smg_row_solved(smg_state *s, smg_real residual) {
  s->report.residual = residual;
  if (residual <= SMG_SWEEP_ULPS * SMG_EPS * s->scale) return 1;
  s->report.residual = s->row_bound * residual;
  return s->report.residual <= s->tolerance * s->scale;
}

/* u = h X(m) of the slots of one vector; the largest square of the residual w + u/2 - rho m. */
SMG_INLINE void smg_end_slots(const smg_turning turn, int stretched, smg_real weakest, int64_t slot, int64_t in, const smg_lanes *g, smg_lanes *most) {
  const smg_lanes none = {0};
  smg_lanes w[3], m[3], u[3], e[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  smg_take_slots(turn.m, turn.pitch, slot, m);
  smg_lane_cross(u, m, g); /* the rate last: pairs of spins turn each other by exactly opposite amounts */
  for (int k = 0; k < 3; ++k) u[k] *= 2 * turn.half;
  if (stretched) {
    smg_lanes lost[3];
    smg_take_slots(turn.compensation, turn.pitch, slot, lost);
    smg_lane_stretch(w, lost, turn.inverse, (smg_lane_mask)(smg_lane_dot(g, g) >= weakest), u);
  }
  const smg_lanes rho = turn.inverse * smg_lane_dot(w, m);
  for (int k = 0; k < 3; ++k) e[k] = w[k] + (smg_real)0.5 * u[k] - rho * m[k];
  smg_lanes square = smg_lane_dot(e, e);
  if (in < SMG_LANES) { /* what is no site of the piece: 0, in empty slots to stay */
    square = smg_lane_select(smg_lane_below(in), square, none);
    for (int k = 0; k < 3; ++k) u[k] = smg_lane_select(smg_lane_below(in), u[k], none);
  }
  *most = smg_lane_max(*most, square);
  smg_put_slots(turn.u, turn.pitch, slot, u);
}

/* The same of a piece. */
SMG_INLINE void smg_end_piece(const smg_turning turn, int stretched, smg_real weakest, const smg_piece *piece, smg_lanes *most) {
  const int64_t size = piece->size, start = piece->start;
  smg_lanes all = *most;
  for (int64_t k = 0; k < size; k += SMG_LANES) {
    smg_lanes g[3];
    smg_take_slots(piece->g, SMG_PIECE_ROOM, k, g);
    smg_end_slots(turn, stretched, weakest, start + k, size - k, g, &all);
  }
  *most = all;
}

/* The increments of a thread's share of all colours, and the largest square of their residual. Those by strong fields, |h b| >= 1/3,
 * keep the lengths of spins. */
static smg_real smg_end_share(const smg_state *s, smg_besides *known, const smg_turning *turn) {
  const smg_real weakest = 1 / (36 * turn->half * turn->half);
  smg_lanes most = {0};
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  smg_begin_piece(&s->c, known, gradient, &piece);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    smg_begin_share(&s->c, colour, &piece);
    while (smg_next_piece(&s->c, s->row_m, &piece)) {
      if (s->row_stretched) smg_end_piece(*turn, 1, weakest, &piece, &most);
      else smg_end_piece(*turn, 0, 0, &piece, &most);
    }
  }
  smg_real square = 0;
  for (int l = 0; l < SMG_LANES; ++l) smg_take(&square, ((const smg_real *)&most)[l]);
  return square;
}

/* The increments of all sites, and whether they solve the step. */
static int smg_end_rows(smg_state *s, smg_besides *known, const smg_turning *turn) {
  smg_real most = 0;
  SMG_TEAM(s->row_team) {
    const smg_real square = smg_end_share(s, known, turn);
    SMG_ONE_BY_ONE smg_take(&most, square);
  }
  smg_largest_of_ranks(&most, &most);
  return smg_row_solved(s, SMG_MATH(sqrt)(most));
}

/* w + compensation + u of one component in some slots (Kahan); the increments of all colours but the first are remembered. */
static void smg_commit_slots(const smg_state *s, smg_share part, int64_t component, smg_real *past) {
  const int64_t first = smg_colour_slots(&s->c), skip = component * smg_pitch(&s->c);
  smg_real *rows_w = s->row_w + skip, *rows_u = s->row_u + skip;
#if !SMG_PLAIN_SUMS
  smg_real *lost = s->row_compensation + skip;
#endif
  for (int64_t k = part.from; k < part.to; k += SMG_LANES) {
    const smg_lanes w = smg_lane_take(rows_w + k), u = smg_lane_take(rows_u + k);
#if SMG_PLAIN_SUMS
    smg_lane_put(rows_w + k, w + u);
#else
    const smg_lanes y = u + smg_lane_take(lost + k), sum = w + y;
    smg_lane_put(lost + k, y - (sum - w));
    smg_lane_put(rows_w + k, sum);
#endif
    if (k + SMG_LANES > first) smg_lane_put(past + k - first, u);
  }
}

/* The error, squared, that every degree would have made in one component of the step just solved. */
static void smg_row_misses(const smg_state *s, int64_t k, smg_real newest, smg_real *miss) {
  smg_real row[SMG_HISTORY + 1];
  row[0] = newest;
  for (int j = 0; j < s->history; ++j) row[j + 1] = s->past[j][k];
  for (int d = 0; d < s->history; ++d) {
    for (int j = 0; j < s->history - d; ++j) row[j] -= row[j + 1];
    miss[d] += row[0] * row[0];
  }
}

#define SMG_SAMPLE 20 /* slots, of which each has three numbers */

/* Which degree would have served best? A sample of the slots decides, now and then. */
static void smg_choose_row_degree(smg_state *s) {
  const int64_t first = smg_colour_slots(&s->c), size = smg_slots(&s->c) - first, stride = 1 + size / SMG_SAMPLE;
  smg_real miss[SMG_HISTORY] = {0};
  for (int64_t k = 0; k < size; k += stride) {
    smg_share_sample(s, k, SMG_LATE_PITCH(&s->c));
    for (int b = 0; b < 3; ++b) smg_row_misses(s, b * SMG_LATE_PITCH(&s->c) + k, s->row_u[b * smg_pitch(&s->c) + first + k], miss);
  }
  s->degree = s->history > 0 ? 0 : SMG_NO_DEGREE;
  for (int d = 1; d < s->history; ++d)
    if (miss[d] < miss[s->degree]) s->degree = d;
}

/* The state after the step. */
static void smg_commit_rows(smg_state *s) {
  smg_real *oldest = s->past[SMG_ROW_HISTORY - 1];
  if (s->history < SMG_ROW_HISTORY || s->count % 16 == 0) smg_choose_row_degree(s);
  for (int j = SMG_ROW_HISTORY - 1; j > 0; --j) s->past[j] = s->past[j - 1];
  s->past[0] = oldest;
  SMG_TEAM(s->row_team) {
    SMG_COLOURS_AT_ONCE(colour, n, 0) {
      const smg_share part = smg_share_of(colour * smg_colour_slots(&s->c), n * smg_colour_slots(&s->c));
      for (int k = 0; k < 3; ++k) smg_commit_slots(s, part, k, oldest + k * SMG_LATE_PITCH(&s->c));
    }
  }
  if (s->history < SMG_ROW_HISTORY) ++s->history;
  if (s->degree < 0) s->degree = 0;
}

/* One step, in slots: what sweeps leave is put into the equation, and more of them follow where its residual is more than round-off. */
static smg_status smg_row_step(smg_state *s, smg_besides *known) {
  const smg_turning turn = smg_turning_of(s, smg_signed_h(s->h));
  smg_row_sweeping sweep;
  smg_begin_sweeping(&sweep);
  smg_begin_first_colour(s);
  smg_predict_rows(s);
  do smg_settle_rows(s, known, &turn, &sweep);
  while (!smg_end_rows(s, known, &turn) && sweep.passes < SMG_ROW_PASSES);
  s->report.site = s->report.partner = -1;
  s->report.reached = 0;
  s->report.status = sweep.passes < SMG_ROW_PASSES ? SMG_OK : SMG_NO_CONVERGENCE;
  if (s->report.status != SMG_OK) return s->report.status;
  smg_commit_rows(s);
  ++s->count;
  return SMG_OK;
}

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_row_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_besides known;
  smg_forget_besides(&known);
  smg_begin_ranks(s, &known);
  s->row_team = smg_row_team(&s->c);
  if (s->row_team > 1) smg_know_besides(&s->c, &known);
  smg_enter_rows(s);
  while (count-- > 0 && status == SMG_OK) {
#if SMG_TIMED
    smg_set_time(&s->c, smg_time_at(s, (smg_real)0.5));
#endif
    status = smg_row_step(s, &known);
  }
  smg_end_ranks(s);
  smg_leave_rows(s);
  return status;
}

#endif
