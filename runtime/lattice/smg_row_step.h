/* smidgen runtime: steps of a lattice by rows in lanes, where the sweeps are a contraction whatever the state
 * (smg_row_state.h). */
#ifndef SMG_ROW_STEP_H
#define SMG_ROW_STEP_H

#include "smg_history.h"
#include "smg_report.h"
#include "smg_row_wave.h"

#define SMG_ROW_ROUNDS 100 /* ends that solve nothing, before the step is given up; one or two are usual */

/* Sweeps to stagnation, or to the tolerance. */
static void smg_settle_rows(smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_sweeping *sweep) {
  do {
    const smg_row_pass pass = smg_next_pass(s, sweep);
    const smg_row_motion moved = smg_turn_colour(s, known, turn, pass);
    smg_take_pass(s, pass, &moved, sweep);
  } while (sweep->passes < SMG_COLOURS || (sweep->passes < SMG_ROW_PASSES && !smg_rows_settled(s, sweep)));
}

/* Is a residual of w + u/2 - rho m round-off? Or is the error of W, at most `left` times as large, within the
 * tolerance? */
static int smg_row_solved(smg_state *s, smg_real residual, smg_real left) {
  s->report.residual = residual;
  if (smg_swept_to_round_off(residual, s->scale)) return 1;
  s->report.residual = left * residual;
  return smg_tolerated(s, s->report.residual);
}

/* The increments of all sites but of a colour that has them, and whether they solve the step. */
static int smg_end_rows(smg_state *s, smg_besides *known, const smg_turning *turn, const smg_row_sweeping *sweep) {
  smg_real most = sweep->ended < 0 ? 0 : sweep->residual;
  SMG_TEAM(s->row_team) {
    smg_lanes squares = {0};
    for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
      if (colour != sweep->ended) {
        SMG_STRIPS(&s->c, k)
        smg_end_part(s, known, *turn, colour, smg_strip_of_thread(&s->c, colour, 1, k), &squares);
      }
    SMG_ONE_BY_ONE smg_take(&most, smg_lane_largest(squares));
  }
  smg_largest_of_ranks(&most, &most);
  return smg_row_solved(s, SMG_MATH(sqrt)(most), smg_left_by_sweeps(s));
}

/* The slot in blocks of the site that by rows has this one; b is NULL where there are none. */
static int64_t smg_slot_by_rows(const smg_coefficients *c, const smg_blocks *b, int64_t slot) {
  const int64_t colour = slot / smg_colour_slots(c), row = (slot - colour * smg_colour_slots(c)) / smg_row_length(c);
  if (!b) return slot;
  const smg_lattice_row at = smg_row_of(c, colour, row);
  const int64_t cell[4] = {at.first + SMG_ROW_STEP * (slot - at.start), at.s1, at.s2, at.s3};
  return smg_slot_in_blocks(c, b, at.sub, cell);
}

/* What every degree would have missed in one slot, the k-th whose increments are kept, of the step just solved: of each
 * component its increments, the newest and those before. */
static void smg_row_misses(const smg_state *s, int64_t k, smg_real *miss) {
  const int n = s->history + 1;
  smg_real all[3 * (SMG_HISTORY + 1)];
  for (int b = 0; b < 3; ++b) {
    const int64_t at = b * SMG_LATE_PITCH(&s->c) + k;
    all[b * n] = s->row_late[at];
    for (int j = 0; j < s->history; ++j) all[b * n + 1 + j] = s->past[j][at];
  }
  smg_share_sample(&s->c, k, all, 3 * n);
#if SMG_COMPOSED
  for (int b = 0; b < 3; ++b) smg_add_level_misses(s->stage, all + b * n, miss);
#else
  for (int b = 0; b < 3; ++b) smg_add_misses(s->history, all + b * n, miss);
#endif
}

#define SMG_SAMPLE 20 /* slots, of which each has three numbers */

/* Which degree would have served best? A sample decides, now and then: of the same sites wherever they stand. */
static void smg_choose_row_degree(smg_state *s) {
  const int64_t first = SMG_KEPT_FROM(&s->c), size = smg_slots(&s->c) - first, stride = 1 + size / SMG_SAMPLE;
#if SMG_COMPOSED
  smg_real *miss = s->misses;
  if (s->history < SMG_HISTORY) {
    s->degree = smg_highest_level(s->history + 1);
    return;
  }
#else
  smg_real miss[SMG_HISTORY] = {0};
#endif
  smg_blocks found;
  const smg_blocks *blocks = smg_blocks_of(s, &found);
  for (int64_t k = 0; k < size; k += stride)
    smg_row_misses(s, smg_slot_by_rows(&s->c, blocks, first + k) - first, miss);
#if SMG_COMPOSED
  smg_choose_level(s);
#else
  s->degree = s->history > 0 ? smg_best_degree(s->history, miss) : SMG_NO_DEGREE;
#endif
}

/* The step is taken; more: does another one begin, and add its increments to w? */
static void smg_commit_rows(smg_state *s, int more) {
  if (smg_time_to_choose(s, SMG_ROW_HISTORY)) smg_choose_row_degree(s);
  smg_remember(s, SMG_ROW_HISTORY, &s->row_late);
  s->row_due = more;
  if (!more) smg_go_on_rows(s, 0);
}

/* What the end of a step has left to do, and the midpoints to begin the next one with. */
static void smg_begin_rows(smg_state *s) {
  if (s->row_due) {
    smg_go_on_rows(s, 1);
    smg_exchange_late();
  }
  SMG_STRIPS(&s->c, k) smg_begin_first_colour(s, smg_strip_of_rank(&s->c, 0, 1, k));
  s->row_due = 0;
}

/* The passes of the next step that are watched: from those before midpoints have nearly settled on, so that rates are
 * known before round-off; where they had when this step was first looked at, from some earlier ones. */
static int64_t smg_watch_from(const smg_state *s, const smg_row_sweeping *sweep) {
  const int64_t last = sweep->passes - SMG_ROW_WATCHED, near = sweep->near - SMG_COLOURS,
                seen = s->row_from + SMG_COLOURS - 1;
  int64_t from = near < last ? near : last;
  if (s->row_from > 0 && sweep->near <= seen && s->row_from - 2 < from) from = s->row_from - 2;
  return from < 0 ? 0 : from < SMG_NEWTON_STEPS ? from : SMG_NEWTON_STEPS;
}

static smg_status smg_report_sweeps(smg_state *s, const smg_row_sweeping *sweep) {
  smg_begin_report(s);
  s->report.iterations = (int)((sweep->passes + SMG_COLOURS - 1) / SMG_COLOURS);
  return smg_end_report(s, sweep->passes < SMG_ROW_PASSES ? SMG_OK : SMG_NO_CONVERGENCE, -1);
}

/* One step of the size h, in slots, from predicted midpoints: what sweeps leave is put into the equation, and more of
 * them follow where its residual is more than round-off. *from: smg_watch_from. */
static smg_status smg_solve_rows(smg_state *s, smg_besides *known, smg_real h, int more, int64_t *from) {
  const smg_turning turn = smg_turning_of(s, h);
  smg_row_sweeping sweep;
  smg_row_wave wave;
  int solved = 0;
  smg_begin_sweeping(&sweep);
  if (!smg_wave_pays(s, &wave)) smg_begin_rows(s);
  else
    solved = smg_sweep_in_wave(s, known, &turn, &wave, &sweep) &&
             smg_row_solved(s, SMG_MATH(sqrt)(sweep.residual), smg_left_by_sweeps(s));
  for (int round = 0; !solved && sweep.passes < SMG_ROW_PASSES; ++round) {
    smg_settle_rows(s, known, &turn, &sweep);
    solved = smg_end_rows(s, known, &turn, &sweep);
    if (!solved && round == SMG_ROW_ROUNDS) sweep.passes = SMG_ROW_PASSES;
  }
  smg_expect_passes(s, known, &sweep);
  if (smg_report_sweeps(s, &sweep) != SMG_OK) return s->report.status;
  *from = smg_watch_from(s, &sweep);
  smg_commit_rows(s, more);
  return SMG_OK;
}

/* A step of a call; more: does another one follow? from: the pass from which those of the next one are watched. */
struct smg_row_call {
  smg_besides *known;
  int more;
  int64_t from;
};

#if SMG_COMPOSED
static smg_status smg_compose(smg_state *s, struct smg_row_call *rows); /* smg_composition.h */
static smg_status smg_row_step(smg_state *s, struct smg_row_call *rows) { return smg_compose(s, rows); }
#else
static smg_status smg_row_step(smg_state *s, struct smg_row_call *rows) {
  smg_set_time_at(&s->c, s, (smg_real)0.5);
  const smg_status status = smg_solve_rows(s, rows->known, smg_signed_h(s->h), rows->more, &rows->from);
  if (status == SMG_OK) ++s->count;
  return status;
}
#endif

/* The increments of the first colour are kept during a step, and come back when it fails: the tangent map is then that
 * of the step before, and so is what a saved state has. */
static inline void smg_hold_first(SMG_UNUSED const smg_state *s, SMG_UNUSED int back) {
#if SMG_TANGENT
  smg_real *from = back ? s->row_u_before : s->row_u, *to = back ? s->row_u : s->row_u_before;
  smg_copy(to - SMG_BEFORE, from - SMG_BEFORE, 3 * SMG_FIRST_PITCH(&s->c));
#endif
}

/* count steps, or fewer: the first that fails is the last, or the one before the first that does not go by rows. */
static smg_status smg_row_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_besides known;
  smg_begin_call(s, &known);
  s->row_alone = !SMG_OWN_FIELD && !smg_colours_meet(&s->c);
#if SMG_COMPOSED
  s->stage = 0;
#endif
  smg_predict_rows(s);
  smg_exchange_late();
  for (; count > 0 && status == SMG_OK && smg_next_by_rows(s); --count) {
    struct smg_row_call rows = {&known, count > 1, s->row_from};
    smg_hold_first(s, 0);
    status = smg_row_step(s, &rows);
    if (status == SMG_OK) s->row_from = rows.from;
    else smg_hold_first(s, 1);
  }
  if (s->row_due) smg_go_on_rows(s, 0); /* the next one goes from site to site */
  s->row_due = 0;
  smg_end_ranks(s);
  smg_leave_rows(s);
  return status;
}

#endif
