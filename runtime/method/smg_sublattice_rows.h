/* smidgen method: the steps of sublattice rotations (smg_sublattice_rotations.h) by rows of a lattice, sites in the lanes of vectors, with
 * the bits of those from site to site. A colour goes in pieces (smg_row_piece.h): the fields of its sites, then their turns. */
#ifndef SMG_SUBLATTICE_ROWS_H
#define SMG_SUBLATTICE_ROWS_H

#include "smg_row_piece.h"
#include "smg_row_spin.h"

/* What the turns of a colour work with: w and what it has lost, by slots; h/(2 kappa), 1/radius^2. */
typedef struct smg_row_turning {
  smg_real *w, *lost;
  int64_t pitch;
  smg_real half, inverse;
} smg_row_turning;

/* The slots of one vector about half their field, `in` of them sites of the piece; last: in this stage. */
SMG_INLINE void smg_turn_slots(const smg_row_turning turn, int last, int64_t slot, int64_t in, smg_lanes *g) {
  const smg_lanes none = {0};
  smg_lanes w[3], lost[3], x[3], xx[3];
  for (int k = 0; k < 3; ++k) g[k] *= turn.half;
  if (in < SMG_LANES)
    for (int k = 0; k < 3; ++k) g[k] = smg_lane_select(smg_lane_below(in), g[k], none);
  smg_take_slots(turn.w, turn.pitch, slot, w);
  smg_take_slots(turn.lost, turn.pitch, slot, lost);
  const smg_lanes scale = 2 / (1 + smg_lane_dot(g, g)), back = (smg_real)0.5 * SMG_RESTORED * (1 - turn.inverse * smg_lane_dot(w, w));
  smg_lane_cross(x, w, g);
  smg_lane_cross(xx, x, g);
  for (int k = 0; k < 3; ++k) {
    smg_lanes moved = scale * (x[k] + xx[k]);
    if (last) moved += back * (w[k] + moved);
    smg_lane_add_compensated(w + k, lost + k, moved);
  }
  smg_put_slots(turn.w, turn.pitch, slot, w);
  smg_put_slots(turn.lost, turn.pitch, slot, lost);
}

/* The share of this thread in a colour. */
SMG_INLINE void smg_turn_share(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour, int last) {
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  smg_begin_piece(&s->c, known, gradient, &piece);
  smg_begin_share(&s->c, colour, &piece);
  while (smg_next_piece(&s->c, s->row_w, &piece)) {
    const int64_t size = piece.size, start = piece.start;
    for (int64_t k = 0; k < size; k += SMG_LANES) {
      smg_lanes g[3];
      smg_take_slots(gradient, SMG_PIECE_ROOM, k, g);
      smg_turn_slots(turn, last, start + k, size - k, g);
    }
  }
}
static void smg_turn_usual(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour) { smg_turn_share(s, known, turn, colour, 0); }
static void smg_turn_last(const smg_state *s, smg_besides *known, const smg_row_turning turn, int64_t colour) { smg_turn_share(s, known, turn, colour, 1); }

/* A colour by all threads, for the part h of the step. */
static void smg_turn_row_colour(const smg_state *s, smg_besides *known, int64_t colour, smg_real h, int last) {
  const smg_row_turning turn = {s->row_w, s->row_compensation, smg_pitch(&s->c), (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, h), smg_row_inverse(s)};
  SMG_TEAM(s->row_team) {
    if (last) smg_turn_last(s, known, turn, colour);
    else smg_turn_usual(s, known, turn, colour);
  }
}

/* smg_stage. */
static void smg_row_stage(const smg_state *s, smg_besides *known, smg_real h, int end) {
  const int64_t last = SMG_COLOURS - 1;
  (void)end;
  for (int64_t colour = 0; colour < last; ++colour) smg_turn_row_colour(s, known, colour, 0.5 * h, 0);
  smg_turn_row_colour(s, known, last, h, 1);
  for (int64_t colour = last - 1; colour >= 0; --colour) smg_turn_row_colour(s, known, colour, 0.5 * h, 1);
}

#include "smg_turn_steps.h"

#endif
