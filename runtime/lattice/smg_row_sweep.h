/* smidgen runtime: sweeps over the colours of a lattice in lanes: every spin solves its own step in the field of its
 * neighbours.
 *
 * A piece of a colour goes through two loops, so that each is short enough for a processor to overlap its turns and
 * what they share stays in the nearest cache: along its runs of rows the fields of the sites, by smg_slot_gradient of
 * the model, with the directions of their midpoints, since the one waits for memory and the other for products; then
 * the midpoints. Pieces are cut alike for all SMG_LANES. */
#ifndef SMG_ROW_SWEEP_H
#define SMG_ROW_SWEEP_H

#include "smg_rest.h"
#include "smg_row_end.h"

#define SMG_LOOK (smg_real)1e-12 /* part of the state by which midpoints move when that begins */
/* times as far: changes shrink by about that in a pass, so that from step to step it hardly begins a pass earlier */
#define SMG_NEAR_LOOK 10
#ifndef SMG_ROW_PASSES
#define SMG_ROW_PASSES (500 * SMG_COLOURS) /* of colours: 0.9^k is round-off after 350 sweeps */
#endif

/* How far midpoints moved: the largest square, and the largest part of what a small component is made of; where the
 * pass may be the last one, the largest square of the residual too. */
typedef struct smg_row_motion {
  smg_lanes square, part, residual;
} smg_row_motion;

/* |w_k| + |g_k| + |w_i g_j| + |w_j g_i|, what component k of a midpoint is made of. */
SMG_INLINE void smg_made_of(const smg_lanes *w, const smg_lanes *g, smg_lanes *made) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    made[k] = smg_lane_abs(w[k]) + smg_lane_abs(g[k]) + smg_lane_abs(w[i] * g[j]) + smg_lane_abs(w[j] * g[i]);
  }
}

/* Is a component of a spin small? What the others are made of is not. */
SMG_INLINE int smg_some_small(smg_real small, const smg_lanes *w) {
  return smg_lane_any((smg_lane_mask)(smg_lane_abs(w[0]) < small) | (smg_lane_mask)(smg_lane_abs(w[1]) < small) |
                      (smg_lane_mask)(smg_lane_abs(w[2]) < small));
}

/* The spin w and the field g = (h/2 kappa) b of precession, from w and the gradient b; with a response w - r^2 P and G
 * (smg_own_response.h). */
SMG_INLINE void smg_precess(const smg_turning turn, SMG_UNUSED int64_t slot, SMG_UNUSED smg_lanes *w, smg_lanes *g) {
#if SMG_TOLD
  const smg_told told = smg_told_at(turn, slot);
  smg_lanes F[3], Q[3];
  smg_lane_told_parts(told.r, g, F, Q);
#if SMG_PUSHES
  const smg_lane_mask there = (smg_lane_mask)(smg_lane_dot(w, w) > 0); /* in an empty slot w stays 0 */
  for (int k = 0; k < 3; ++k) Q[k] = smg_lane_select(there, Q[k], smg_lane_of(0));
#endif
  smg_lane_multiple(g, smg_lane_of(turn.half), F, 3);
  const smg_lanes none = {0};
  smg_lane_axpy(w, -turn.half / smg_inverse_at(turn.inverses, slot) - none, Q, 3);
#else
  smg_lane_scale(g, smg_lane_of(turn.half), 3);
#endif
}

/* |w|^2/r^2 of such a spin. */
SMG_INLINE smg_lanes smg_precessing(SMG_UNUSED smg_inverse inverse, SMG_UNUSED const smg_lanes *w) {
#if SMG_TOLD
  return inverse * smg_lane_dot(w, w);
#else
  return smg_lane_of(1);
#endif
}

/* The largest part by which small components of the slots of one vector moved, by d, in the gradient b. */
SMG_INLINE void smg_watch_slots(const smg_turning turn, int64_t slot, const smg_lanes *b, const smg_lanes *d,
                                smg_lanes *part) {
  smg_lanes w[3], g[3], made[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  if (!smg_some_small(turn.small, w)) return;
  smg_lane_copy(g, b, 3);
  smg_precess(turn, slot, w, g);
  smg_made_of(w, g, made);
  for (int k = 0; k < 3; ++k) *part = smg_lane_larger(*part, smg_part_moved(smg_lane_of(turn.small), d[k], made[k]));
}

/* How rho is found: from w.m of the sweep before; where there was none, from k and d; or by its root. */
enum smg_row_way { SMG_FROM_BEFORE, SMG_FROM_FIELD, SMG_BY_ROOT };

SMG_INLINE smg_lanes smg_rho_of(const smg_turning turn, int64_t slot, enum smg_row_way way, const smg_lanes *w,
                                const smg_lanes *g) {
  smg_lanes m[3], rho;
  const smg_inverse inverse = smg_inverse_at(turn.inverses, slot);
  const smg_lanes one = smg_precessing(inverse, w);
  if (way == SMG_BY_ROOT || (SMG_TOLD && way == SMG_FROM_FIELD)) return smg_lane_rho(one, w, g, inverse);
  if (way == SMG_FROM_FIELD) rho = smg_lane_first_rho(w, g, inverse);
  else {
    smg_take_slots(turn.m, turn.pitch, slot, m);
    rho = inverse * smg_lane_dot(w, m);
  }
  return smg_lane_corrected_rho(one, w, g, rho, inverse, turn.weak, turn.flat);
}

/* v, along the midpoints of the slots of one vector, in place of their gradient g; the midpoints themselves where those
 * are no projections. */
SMG_INLINE void smg_aim_slots(const smg_turning turn, int64_t slot, enum smg_row_way way, smg_lanes *g) {
  smg_lanes w[3], v[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  smg_precess(turn, slot, w, g);
  if (SMG_ONTO_LEAF) smg_lane_along_spin(w, g, smg_rho_of(turn, slot, way, w, g), v);
  else smg_lane_midpoint(w, g, v);
  smg_lane_copy(g, v, 3);
}

/* Midpoints v of those slots are moved back towards m, where they were before. */
SMG_INLINE void smg_relax_slots(const smg_turning turn, int64_t slot, const smg_lanes *m, smg_lanes *v) {
  smg_lane_scale(v, smg_lane_of(turn.relax), 3);
  smg_lane_axpy(v, smg_lane_of(1 - turn.relax), m, 3);
  smg_lane_stretch_to(smg_inverse_at(turn.inverses, slot), 0, v);
}

/* m = r v/|v| of those slots, `in` of them sites of the piece, from v and their gradient b. watched: is it to be known
 * how far they move? small: small components too? last: are increments found? */
SMG_INLINE void smg_turn_slots(const smg_turning turn, int64_t slot, int64_t in, smg_lanes *v, const smg_lanes *b,
                               int watched, int small, int last, smg_row_motion *moved) {
  smg_lanes m[3], d[3];
  smg_take_slots(turn.m, turn.pitch, slot, m);
  if (SMG_ONTO_LEAF) smg_lane_stretch_to(smg_inverse_at(turn.inverses, slot), turn.weak, v);
  if (SMG_HAS_COUPLED && turn.relax < 1) smg_relax_slots(turn, slot, m, v);
  if (in < SMG_LANES) smg_lane_choose(v, smg_lane_below(in), v, m, 3);
  smg_put_slots(turn.m, turn.pitch, slot, v);
  if (!watched) return;
  smg_lane_waxpy(d, smg_lane_of(-1), m, v, 3);
  moved->square = smg_lane_larger(moved->square, smg_turned_as_large(turn, slot, smg_lane_dot(d, d)));
  if (small) smg_watch_slots(turn, slot, b, d, &moved->part);
  if (last) smg_end_slots(turn, slot, in, v, b, &moved->residual);
}

/* Along the midpoints of a run, kept from k on. */
SMG_INLINE void smg_aim_run(const smg_coefficients *c, const smg_turning turn, const smg_run *run, int blocks,
                            enum smg_row_way way, int small, int last, smg_piece *piece, int64_t k) {
  for (int64_t j = run->from, p = j; j < run->to; j += SMG_LANES, p = blocks ? j : smg_next_place(p, run->length)) {
    smg_lanes v[3];
    smg_run_gradient(c, run, blocks, turn.m, turn.pitch, j, p, v);
    if (small || last) smg_put_slots(piece->field, SMG_PIECE_ROOM, k + j - run->from, v);
    smg_aim_slots(turn, run->start + j, way, v);
    smg_put_slots(piece->g, SMG_PIECE_ROOM, k + j - run->from, v);
  }
}

/* The midpoints of one vector, whose directions are in a piece from its k-th slot on. */
SMG_INLINE void smg_turn_aimed(const smg_turning turn, const smg_piece *piece, int64_t k, int64_t slot, int64_t in,
                               int watched, int small, int last, smg_row_motion *moved) {
  const smg_lanes none = {0};
  smg_lanes v[3], field[3] = {none, none, none};
  smg_take_slots(piece->g, SMG_PIECE_ROOM, k, v);
  if (small || last) {
    smg_take_slots(piece->field, SMG_PIECE_ROOM, k, field);
    smg_first_lanes(in, field); /* the others are of no piece yet */
  }
  smg_turn_slots(turn, slot, in, v, field, watched, small, last, moved);
}

/* From there to the midpoints of a piece. */
SMG_INLINE void smg_turn_vectors(const smg_turning turn, const smg_piece *piece, int watched, int small, int last,
                                 smg_row_motion *moved) {
  for (int64_t k = 0; k < piece->size; k += SMG_LANES)
    smg_turn_aimed(turn, piece, k, piece->start + k, piece->size - k, watched, small, last, moved);
}

/* Sites that a row has at least where its last one is turned twice: in shorter ones this takes longer than it saves. */
#define SMG_ROW_ENDS 12
/* Once more the last sites of those rows of a run that meet the first ones across a seam, in the field of what these
 * are by now; not in the last passes, which move those by round-off. */
SMG_INLINE void smg_turn_ends(const smg_coefficients *c, const smg_turning turn, smg_run run, smg_piece *piece,
                              enum smg_row_way way, int watched, int small, smg_row_motion *moved) {
  const int64_t to = run.start + run.to, last = run.sites - 1;
  for (; run.start + last < to; run.start += run.length) {
    run.from = last;
    run.to = last + 1;
    smg_aim_run(c, turn, &run, 0, way, small, 0, piece, 0);
    smg_turn_aimed(turn, piece, 0, run.start + last, 1, watched, small, 0, moved);
  }
}

/* The spins of a piece. */
SMG_INLINE void smg_turn_piece(const smg_coefficients *c, const smg_turning turn, smg_piece *piece,
                               enum smg_row_way way, int watched, int small, int last, smg_row_motion *moved) {
  const smg_lattice_row at = piece->at;
  const int64_t from = piece->from;
  smg_row_motion most = *moved;
  smg_run run;
  for (int64_t k = 0; smg_next_run(c, piece, &run); k = piece->done) {
    if (SMG_BLOCKS && run.beside) smg_aim_run(c, turn, &run, 1, way, small, last, piece, k);
    else smg_aim_run(c, turn, &run, 0, way, small, last, piece, k);
  }
  if (watched) smg_turn_vectors(turn, piece, 1, small, last, &most);
  else smg_turn_vectors(turn, piece, 0, 0, 0, &most);
  if (smg_meet_along(c, 0) && !small) {
    piece->at = at;
    piece->from = from;
    piece->done = 0;
    while (smg_next_run(c, piece, &run))
      if (run.sites >= SMG_ROW_ENDS && run.sites * SMG_ROW_STEP > smg_cells(c, 0))
        smg_turn_ends(c, turn, run, piece, way, watched, small, &most);
  }
  *moved = most;
}

/* How a colour is passed: watched: is it to be known how far midpoints move? small: small components too? last: may it
 * be the last pass, and increments are found too? */
typedef struct smg_row_pass {
  int64_t colour;
  enum smg_row_way way;
  int watched, small, last;
} smg_row_pass;

SMG_INLINE smg_row_motion smg_at_rest(void) {
  const smg_lanes none = {0};
  const smg_row_motion motion = {none, none, none};
  return motion;
}
SMG_INLINE void smg_join_motion(smg_row_motion *motion, const smg_row_motion *more) {
  motion->square = smg_lane_max(motion->square, more->square);
  motion->part = smg_lane_max(motion->part, more->part);
  motion->residual = smg_lane_max(motion->residual, more->residual);
}

/* Some slots of a colour. */
SMG_INLINE void smg_turn_part(const smg_state *s, smg_besides *known, smg_turning turn, const smg_row_pass pass,
                              smg_share part, enum smg_row_way way, int small, smg_row_motion *motion) {
  smg_row_motion most = smg_at_rest();
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  turn.inverses = smg_inverses_of(s);
  if (pass.last) smg_increments_into(s, pass.colour, &turn);
  smg_begin_piece(&s->c, known, gradient, &piece);
  smg_begin_part(&s->c, pass.colour, part, &piece);
  while (smg_open_piece(&piece)) smg_turn_piece(&s->c, turn, &piece, way, pass.watched, small, pass.last, &most);
  smg_join_motion(motion, &most);
}

#if SMG_UNIT == 2
SMG_LINKED void smg_turn_some_slots(const smg_state *s, smg_besides *known, const smg_turning *turn,
                                    const smg_row_pass pass, smg_share part, smg_row_motion *motion);
#else
/* Most passes by a copy of their own, in which the compiler knows the way; the first ones, and those that look at small
 * components, by another. The largest function of a step by rows, so only one unit has it. */
SMG_LINKED void smg_turn_some_slots(const smg_state *s, smg_besides *known, const smg_turning *turn,
                                    const smg_row_pass pass, smg_share part, smg_row_motion *motion) {
  if (pass.way == SMG_FROM_BEFORE && !pass.small)
    smg_turn_part(s, known, *turn, pass, part, SMG_FROM_BEFORE, 0, motion);
  else smg_turn_part(s, known, *turn, pass, part, pass.way, pass.small, motion);
}
#endif

/* Some slots of this rank by all threads. */
SMG_INLINE void smg_turn_by_team(const smg_state *s, smg_besides *known, const smg_turning *turn,
                                 const smg_row_pass pass, smg_share slots, smg_row_motion *moved) {
  if (slots.from >= slots.to) return;
  SMG_TEAM(smg_team_for(slots, s->row_team)) {
    smg_row_motion motion = smg_at_rest();
    smg_turn_some_slots(s, known, turn, pass, smg_share_of_thread(slots), &motion);
    SMG_ONE_BY_ONE smg_join_motion(moved, &motion);
  }
}

#if SMG_GRID
/* The strips of a box. */
static void smg_turn_box(const smg_state *s, smg_besides *known, const smg_turning *turn, const smg_row_pass pass,
                         const smg_box *b, smg_row_motion *moved) {
  const smg_share slots = {0, smg_box_slots(b)};
  if (slots.to == 0) return;
  SMG_TEAM(smg_team_for(slots, s->row_team)) {
    smg_row_motion motion = smg_at_rest();
    for (int64_t k = 0, n = smg_strips(&s->c, b); k < n; ++k) {
      const smg_share part = smg_thread_strip(&s->c, pass.colour, b, k);
      if (part.from < part.to) smg_turn_some_slots(s, known, turn, pass, part, &motion);
    }
    SMG_ONE_BY_ONE smg_join_motion(moved, &motion);
  }
}

/* A colour: first the shell that other ranks read; while that is on its way, what is within. */
static smg_row_motion smg_turn_colour(const smg_state *s, smg_besides *known, const smg_turning *turn,
                                      const smg_row_pass pass) {
  const smg_share inner = {0, smg_box_slots(&smg_halo.inner)};
  smg_row_motion moved = smg_at_rest();
  for (int k = 0; k < smg_halo.shells; ++k) smg_turn_box(s, known, turn, pass, smg_halo.shell + k, &moved);
  smg_send_colour(pass.colour);
  for (int64_t k = 0, n = smg_mpi_looks(inner); k < n; ++k) {
    const smg_box part = smg_inner_part(&s->c, k, n);
    smg_turn_box(s, known, turn, pass, &part, &moved);
    smg_look_at_colour(pass.colour);
  }
  smg_await_colour(pass.colour);
  return moved;
}
#else
/* A colour: first the ends that other ranks read; while those are on their way, what is between. */
static smg_row_motion smg_turn_colour(const smg_state *s, smg_besides *known, const smg_turning *turn,
                                      const smg_row_pass pass) {
  const smg_share all = smg_share_of_rank(&s->c, pass.colour, 1), inner = smg_between_ends(pass.colour, all),
                  first = {all.from, inner.from}, last = {inner.to, all.to};
  smg_row_motion moved = smg_at_rest();
  smg_turn_by_team(s, known, turn, pass, first, &moved);
  smg_turn_by_team(s, known, turn, pass, last, &moved);
  smg_send_colour(pass.colour);
  for (int64_t k = 0, n = smg_mpi_looks(inner); k < n; ++k) {
    smg_turn_by_team(s, known, turn, pass, smg_part_of(inner, k, n), &moved);
    smg_look_at_colour(pass.colour);
  }
  smg_await_colour(pass.colour);
  return moved;
}
#endif

/* The sweeps of one step: colours done, and the changes of the last SMG_COLOURS - 1 of them; the pass from which small
 * components are nearly looked at; the colour whose increments are known already (-1: none), and the largest square of
 * their residual. */
typedef struct smg_row_sweeping {
  int64_t passes, near, ended;
  smg_real residual, recent[SMG_COLOURS], parts[SMG_COLOURS];
  smg_rest whole, part;
} smg_row_sweeping;

static inline void smg_begin_sweeping(smg_row_sweeping *sweep) {
  sweep->passes = 0;
  sweep->near = SMG_ROW_PASSES;
  sweep->ended = -1;
  sweep->residual = 0;
  for (int k = 0; k < SMG_COLOURS; ++k) sweep->recent[k] = sweep->parts[k] = SMG_MAX;
  sweep->whole = sweep->part = smg_unknown_rest;
}

/* The largest of all colours but the next. */
static inline smg_real smg_recent(const smg_real *changes, int64_t next) {
  smg_real most = 0;
  for (int k = 0; k < SMG_COLOURS; ++k)
    if (k != next || SMG_COLOURS == 1) most = smg_max(most, changes[k]);
  return most;
}

/* The last passes of a step, so many, show at least whether it has ended: the changes of all colours, and those
 * before. */
#ifndef SMG_ROW_WATCHED
#define SMG_ROW_WATCHED (SMG_COLOURS + 2)
#endif

/* The next pass: rho by its root where fields are strong, without midpoints of a sweep before where there was none;
 * small components are looked at once the others have nearly settled. Of sites that do not feel their own colour the
 * gradient stays what it is in the last pass, and gives their increments at once: that is expected to be the pass that
 * was the last one of the step before. Passes that move midpoints too far for an end are not watched
 * (smg_watch_from). */
SMG_INLINE smg_row_pass smg_next_pass(const smg_state *s, const smg_row_sweeping *sweep) {
  /* an extrapolation may be far off, and midpoints then not near spins */
  const int64_t unknown = s->row_weak ? SMG_COLOURS : 1;
  const enum smg_row_way way = s->row_strong && sweep->passes < SMG_COLOURS ? SMG_BY_ROOT
                               : sweep->passes < unknown                    ? SMG_FROM_FIELD
                                                                            : SMG_FROM_BEFORE;
  const int late = way == SMG_FROM_BEFORE && sweep->whole.now <= SMG_LOOK * s->scale;
  const int watched = sweep->passes >= s->row_from, last = watched && s->row_alone &&
                                                           sweep->passes + 1 >= SMG_OF_STAGE(s, row_passes) &&
                                                           sweep->passes >= SMG_COLOURS;
  const smg_row_pass pass = {sweep->passes % SMG_COLOURS, way, watched, late, last};
  return pass;
}

/* What it has shown. */
SMG_INLINE void smg_take_pass(const smg_state *s, const smg_row_pass pass, const smg_row_motion *moved,
                              smg_row_sweeping *sweep) {
  const int64_t next = (pass.colour + 1) % SMG_COLOURS;
  ++sweep->passes;
  sweep->ended = pass.last ? pass.colour : -1;
  if (!pass.watched) return;
  smg_real whole = smg_lane_largest(moved->square), part = pass.small ? smg_lane_largest(moved->part) : SMG_MAX;
  smg_largest_of_ranks(&whole, &part);
  sweep->residual = smg_lane_largest(moved->residual); /* of this rank */
  sweep->recent[pass.colour] = SMG_MATH(sqrt)(whole);
  sweep->parts[pass.colour] = part;
  if (sweep->passes < SMG_COLOURS) return; /* the first colours moved from nowhere */
  const int still = smg_still(smg_recent(sweep->recent, next), s->scale);
  smg_rest_take(&sweep->whole, smg_recent(sweep->recent, next), still);
  const smg_real part_moved = smg_recent(sweep->parts, next); /* sweeps beyond the bound may be slow: by its own size */
  smg_rest_take(&sweep->part, part_moved, s->rows ? still : part_moved <= SMG_SWEEP_ULPS * SMG_EPS);
  if (sweep->passes < sweep->near && sweep->whole.now <= SMG_NEAR_LOOK * SMG_LOOK * s->scale)
    sweep->near = sweep->passes;
}

/* Have they come to rest? */
static inline int smg_rows_at_rest(const smg_row_sweeping *sweep, smg_real scale) {
  return smg_rest_settled(&sweep->whole, SMG_EPS * scale) && smg_rest_settled(&sweep->part, SMG_EPS);
}
/* Have they, or is W, which moves by twice as much as midpoints, within the tolerance? */
static inline int smg_rows_settled(const smg_state *s, const smg_row_sweeping *sweep) {
  if (sweep->passes < SMG_COLOURS) return 0;
  if (s->tolerance > 0 && smg_tolerated(s, smg_left_by_sweeps(s) * sweep->whole.rate * sweep->whole.now)) return 1;
  return smg_rows_at_rest(sweep, s->scale);
}

#endif
