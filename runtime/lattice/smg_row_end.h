/* smidgen runtime: the increments of a lattice by rows, from settled midpoints, and what the equation of the step
 * leaves. */
#ifndef SMG_ROW_END_H
#define SMG_ROW_END_H

#include "smg_row_piece.h"
#include "smg_row_spin.h"
#include "smg_lane_respond.h"

#define SMG_ROW_SMALL (smg_real)1e-3 /* part of the radius below which a component is watched on its own */

/* What a sweep works with, at hand in registers: spins, midpoints and, once it is known of which colour, increments by
 * slots; h/(2 kappa), 1/radius^2, the size below which a component is small, |g|^2 = 1/(36 half^2) from which an
 * increment is made to keep the length of its spin. */
typedef struct smg_turning {
  const smg_real *w, *compensation;
  smg_real *m, *u;
  int64_t pitch, u_pitch;
  smg_real half, inverse, small, weakest;
  int weak, stretched; /* are fields so weak that midpoints are near spins? are there such increments? */
#if SMG_RESPONDS
  smg_told told;
#endif
} smg_turning;

/* 1/radius^2: of a radius that the compiler knows, no number to multiply by where it is 1. */
SMG_INLINE smg_real smg_inverse_square(const smg_coefficients *c) { return 1 / (smg_radius(c, 0) * smg_radius(c, 0)); }

static inline smg_turning smg_turning_of(const smg_state *s, smg_real h) {
  const smg_real half = (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, h);
  smg_turning turn = {
    s->row_w,
    s->row_compensation,
    s->row_m,
    NULL,
    smg_pitch(&s->c),
    0,
    half,
    smg_inverse_square(&s->c),
    SMG_ROW_SMALL * smg_radius(&s->c, 0),
    s->row_stretched ? 1 / (36 * half * half) : SMG_MAX,
    s->row_weak,
    s->row_stretched,
#if SMG_RESPONDS
    smg_told_of(&s->c, 0)
#endif
  };
  return turn;
}

SMG_INLINE const smg_told *smg_told_to(const smg_turning *turn) {
#if SMG_RESPONDS
  return &turn->told;
#else
  return (void)turn, (const smg_told *)0;
#endif
}

/* Where the increments of a colour are. */
SMG_INLINE void smg_increments_into(const smg_state *s, int64_t colour, smg_turning *turn) {
  const int64_t first = smg_colour_slots(&s->c);
  turn->u = colour > 0 ? s->row_late - first : s->row_u;
  turn->u_pitch = colour > 0 ? SMG_LATE_PITCH(&s->c) : SMG_FIRST_PITCH(&s->c);
}

/* u = h X(m) of the slots of one vector, `in` of them sites, whose gradient is g; the largest square of the residual w
 * + u/2 - rho m. */
SMG_INLINE void smg_end_slots(const smg_turning turn, int64_t slot, int64_t in, const smg_lanes *m, const smg_lanes *g,
                              smg_lanes *most) {
  const smg_lanes none = {0};
  smg_lanes w[3], u[3], e[3], room[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  const smg_lanes *R = smg_lane_respond(smg_told_to(&turn), m, g, room);
  smg_lane_cross(u, m, R); /* the rate last: pairs of spins turn each other by exactly opposite amounts */
  for (int k = 0; k < 3; ++k) u[k] *= 2 * turn.half;
  if (turn.stretched) {
    smg_lanes lost[3];
    smg_take_slots(turn.compensation, turn.pitch, slot, lost);
    smg_lane_stretch(w, lost, R, turn.inverse, turn.weakest, u);
  }
  const smg_lanes rho = turn.inverse * smg_lane_dot(w, m);
  for (int k = 0; k < 3; ++k) e[k] = w[k] + (smg_real)0.5 * u[k] - rho * m[k];
  smg_lanes square = smg_lane_dot(e, e);
  if (in < SMG_LANES) { /* what is no site of the piece: 0, in empty slots to stay */
    square = smg_lane_select(smg_lane_below(in), square, none);
    for (int k = 0; k < 3; ++k) u[k] = smg_lane_select(smg_lane_below(in), u[k], none);
  }
  *most = smg_lane_max(*most, square);
  smg_put_slots(turn.u, turn.u_pitch, slot, u);
}

/* The same of a piece. */
SMG_INLINE void smg_end_piece(const smg_turning turn, const smg_piece *piece, smg_lanes *most) {
  const int64_t size = piece->size, start = piece->start;
  smg_lanes all = *most;
  for (int64_t k = 0; k < size; k += SMG_LANES) {
    smg_lanes g[3], m[3];
    smg_take_slots(piece->g, SMG_PIECE_ROOM, k, g);
    smg_take_slots(turn.m, turn.pitch, start + k, m);
    smg_end_slots(turn, start + k, size - k, m, g, &all);
  }
  *most = all;
}

/* Those of blocks, vector by vector: there is next to nothing to look up between them. */
SMG_INLINE void smg_end_blocks(const smg_coefficients *c, const smg_turning turn, smg_piece *piece, smg_lanes *most) {
  smg_run run;
  smg_lanes all = *most;
  while (smg_next_blocks(c, piece, &run))
    for (int64_t j = run.from; j < run.to; j += SMG_LANES) {
      smg_lanes g[3], m[3];
      smg_run_gradient(c, &run, 1, turn.m, turn.pitch, j, j, g);
      smg_take_slots(turn.m, turn.pitch, run.start + j, m);
      smg_end_slots(turn, run.start + j, SMG_LANES, m, g, &all);
    }
  *most = all;
}

/* The increments of some slots of a colour, and the largest square of their residual. */
static void smg_end_part(const smg_state *s, smg_besides *known, smg_turning turn, int64_t colour, smg_share part,
                         smg_lanes *most) {
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  turn.inverse = smg_inverse_square(&s->c);
  smg_increments_into(s, colour, &turn);
  smg_begin_piece(&s->c, known, gradient, &piece);
  smg_begin_part(&s->c, colour, part, &piece);
  if (SMG_BLOCKS && known->beside) smg_end_blocks(&s->c, turn, &piece, most);
  else
    while (smg_next_piece(&s->c, s->row_m, &piece)) smg_end_piece(turn, &piece, most);
}

/* Those of a thread's share of all colours but one that has them. */
static smg_lanes smg_end_share(const smg_state *s, smg_besides *known, const smg_turning *turn, int64_t ended) {
  smg_lanes most = {0};
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    if (colour != ended) smg_end_part(s, known, *turn, colour, smg_share_of_colour(&s->c, colour), &most);
  return most;
}

#endif
