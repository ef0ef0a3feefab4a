/* smidgen method: the steps of sublattice rotations (smg_sublattice_rotations.h) by rows of a lattice, sites in the
 * lanes of vectors, with the bits of those from site to site. A colour goes in pieces (smg_row_piece.h): the fields of
 * its sites, then their turns. */
#ifndef SMG_SUBLATTICE_ROWS_H
#define SMG_SUBLATTICE_ROWS_H

#include "smg_explicit_step.h"
#include "smg_row_piece.h"
#include "smg_row_spin.h"
#include "smg_sublattice_state.h"

/* What the turns of a colour work with: w and what it has lost, by slots; 1/radius^2; h/(2 kappa) of the turn that is
 * the last one of a stage, and of another one: 0 where there is none. */
typedef struct smg_row_turning {
  smg_real *w, *lost;
  int64_t pitch;
  smg_real inverse, last, other;
} smg_row_turning;

/* w of one vector about half its gradient g; last: in this stage. */
SMG_INLINE void smg_turn_lanes(smg_real half, smg_real inverse, int last, const smg_lanes *gradient, smg_lanes *w,
                               smg_lanes *lost) {
  smg_lanes g[3], x[3], xx[3];
  for (int k = 0; k < 3; ++k) g[k] = half * gradient[k];
  const smg_lanes scale = 2 / (1 + smg_lane_dot(g, g)),
                  back = (smg_real)0.5 * SMG_RESTORED * (1 - inverse * smg_lane_dot(w, w));
  smg_lane_cross(x, w, g);
  smg_lane_cross(xx, x, g);
  for (int k = 0; k < 3; ++k) {
    smg_lanes moved = scale * (x[k] + xx[k]);
    if (last) moved += back * (w[k] + moved);
    smg_lane_add_compensated(w + k, lost + k, moved);
  }
}

/* The turns of a colour: that which is no stage's last one; that which is; or both, the other one that of the next
 * stage: between them no other site has turned, so that the gradient is the same. */
enum smg_row_turns { SMG_TURN_OTHER, SMG_TURN_LAST, SMG_TURN_BOTH };

/* The slots of one vector, `in` of them sites of the piece. */
SMG_INLINE void smg_rotate_slots(const smg_row_turning turn, enum smg_row_turns which, int64_t slot, int64_t in,
                                 smg_lanes *g) {
  const smg_lanes none = {0};
  smg_lanes w[3], lost[3];
  if (in < SMG_LANES)
    for (int k = 0; k < 3; ++k) g[k] = smg_lane_select(smg_lane_below(in), g[k], none);
  smg_take_slots(turn.w, turn.pitch, slot, w);
  smg_take_slots(turn.lost, turn.pitch, slot, lost);
  if (which != SMG_TURN_OTHER) smg_turn_lanes(turn.last, turn.inverse, 1, g, w, lost);
  if (which != SMG_TURN_LAST) smg_turn_lanes(SMG_STAGES > 1 ? turn.other : turn.last, turn.inverse, 0, g, w, lost);
  smg_put_slots(turn.w, turn.pitch, slot, w);
  smg_put_slots(turn.lost, turn.pitch, slot, lost);
}

/* Those of blocks, vector by vector. */
SMG_INLINE void smg_turn_blocks(const smg_coefficients *c, const smg_row_turning turn, enum smg_row_turns which,
                                smg_piece *piece) {
  smg_run run;
  while (smg_next_blocks(c, piece, &run))
    for (int64_t j = run.from; j < run.to; j += SMG_LANES) {
      smg_lanes g[3];
      smg_run_gradient(c, &run, 1, turn.w, turn.pitch, j, j, g);
      smg_rotate_slots(turn, which, run.start + j, SMG_LANES, g);
    }
}

/* The share of this thread in a colour. */
SMG_INLINE void smg_turn_share(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour,
                               enum smg_row_turns which) {
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  smg_begin_piece(&s->c, known, gradient, &piece);
  smg_begin_share(&s->c, colour, &piece);
  if (SMG_BLOCKS && known->beside) {
    smg_turn_blocks(&s->c, turn, which, &piece);
    return;
  }
  while (smg_next_piece(&s->c, s->row_w, &piece)) {
    const int64_t size = piece.size, start = piece.start;
    for (int64_t k = 0; k < size; k += SMG_LANES) {
      smg_lanes g[3];
      smg_take_slots(gradient, SMG_PIECE_ROOM, k, g);
      smg_rotate_slots(turn, which, start + k, size - k, g);
    }
  }
}
static void smg_turn_other(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour) {
  smg_turn_share(s, known, turn, colour, SMG_TURN_OTHER);
}
static void smg_turn_last(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour) {
  smg_turn_share(s, known, turn, colour, SMG_TURN_LAST);
}
static void smg_turn_both(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour) {
  smg_turn_share(s, known, turn, colour, SMG_TURN_BOTH);
}

/* A colour by all threads, for the part h of the stage, and for `other` of it or of the next one. */
static void smg_turn_row_colour(const smg_state *s, smg_besides *known, int64_t colour, smg_real h, smg_real other,
                                enum smg_row_turns which) {
  const smg_row_turning turn = {s->row_w,
                                s->row_compensation,
                                smg_pitch(&s->c),
                                smg_row_inverse(s),
                                (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, h),
                                (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, other)};
  SMG_TEAM(s->row_team) {
    if (which == SMG_TURN_BOTH) smg_turn_both(s, known, turn, colour);
    else if (which == SMG_TURN_LAST) smg_turn_last(s, known, turn, colour);
    else smg_turn_other(s, known, turn, colour);
  }
}

/* smg_stage; where one follows, the first turn of that too, and so not of the one that comes after. */
static void smg_row_stage(const smg_state *s, smg_besides *known, const smg_turn_stage part) {
  const int64_t last = SMG_COLOURS - 1;
  const smg_real half = (smg_real)0.5 * part.h;
  for (int64_t colour = part.after; colour < last; ++colour)
    smg_turn_row_colour(s, known, colour, half, half, SMG_TURN_OTHER);
  smg_turn_row_colour(s, known, last, part.h, 0, SMG_TURN_LAST);
  for (int64_t colour = last - 1; colour >= 0; --colour) {
    const int both = colour == 0 && part.before;
    smg_turn_row_colour(s, known, colour, half, both ? (smg_real)0.5 * part.next : 0,
                        both ? SMG_TURN_BOTH : SMG_TURN_LAST);
  }
}

#include "smg_turn_steps.h"

#endif
