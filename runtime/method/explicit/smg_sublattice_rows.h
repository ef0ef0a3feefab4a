/* smidgen method: the steps of sublattice rotations (smg_sublattice_rotations.h) by rows of a lattice, sites in the
 * lanes of vectors, with the bits of those from site to site. A colour goes in pieces (smg_row_piece.h): the fields of
 * its sites, then their turns. */
#ifndef SMG_SUBLATTICE_ROWS_H
#define SMG_SUBLATTICE_ROWS_H

#include "smg_explicit_step.h"
#include "smg_row_piece.h"
#include "smg_sublattice_state.h"

/* The turns of a colour: that which is no stage's last one; that which is; or both, the other one that of the next
 * stage: between them no other site has turned, so that the gradient is the same. */
enum smg_row_turns { SMG_TURN_OTHER, SMG_TURN_LAST, SMG_TURN_BOTH };

/* What they work with: 1/|w|^2, and h/(2 kappa) of the last one of a stage, and of another one. */
typedef struct smg_row_turning {
  smg_turned all;
  smg_real inverse, last, other;
  enum smg_row_turns which;
} smg_row_turning;

/* w of one vector about half its gradient. */
SMG_INLINE void smg_turn_spins(smg_real half, smg_real inverse, int back, const smg_lanes *gradient,
                               smg_lane_spins *a) {
  const smg_lanes g[3] = {half * gradient[0], half * gradient[1], half * gradient[2]};
  smg_lane_turn_one(g, inverse, back, a->w, a->lost);
}

/* The slots of one vector, `in` of them sites of the piece. */
SMG_INLINE void smg_rotate_slots(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  const smg_row_turning *turn = (const smg_row_turning *)context;
  smg_lane_spins a;
  smg_first_lanes(in, g);
  smg_take_spins(turn->all, slot, &a);
  if (turn->which != SMG_TURN_OTHER) smg_turn_spins(turn->last, turn->inverse, 1, g, &a);
  /* of a single stage the two have the same h, and so the same g */
  if (turn->which != SMG_TURN_LAST) smg_turn_spins(SMG_STAGES > 1 ? turn->other : turn->last, turn->inverse, 0, g, &a);
  smg_put_spins(turn->all, slot, &a);
}

/* The share of this thread in a colour, by turns that the compiler knows. */
SMG_INLINE void smg_turn_share(const smg_state *s, smg_besides *known, smg_row_turning turn, int64_t colour,
                               enum smg_row_turns which) {
  turn.which = which;
  smg_each_vector(&s->c, known, s->row_w, colour, smg_share_of(&s->c, colour, 1), &turn, smg_rotate_slots);
}

/* A colour by all threads, for the part h of the stage, and for `other` of it or of the next one. */
static void smg_turn_row_colour(const smg_state *s, smg_besides *known, int64_t colour, smg_real h, smg_real other,
                                enum smg_row_turns which) {
  const smg_row_turning turn = {smg_turned_of(s), smg_inverse_square(&s->c),
                                (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, h),
                                (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, other), which};
  SMG_TEAM(s->row_team) {
    if (which == SMG_TURN_BOTH) smg_turn_share(s, known, turn, colour, SMG_TURN_BOTH);
    else if (which == SMG_TURN_LAST) smg_turn_share(s, known, turn, colour, SMG_TURN_LAST);
    else smg_turn_share(s, known, turn, colour, SMG_TURN_OTHER);
  }
}

/* smg_stage; where one follows, the first turn of that too, and so not of the one that comes after. */
static void smg_row_stage(const smg_state *s, smg_besides *known, const smg_turn_stage part) {
  const int64_t n = SMG_COLOURS, end = 2 * n - 2;
  for (int64_t k = part.after; k <= end; ++k) {
    const int both = k == end && part.before;
    smg_turn_row_colour(s, known, smg_there_and_back(k, n), smg_turn_h(k, n, part.h),
                        (smg_real)0.5 * (both ? part.next : part.h),
                        both        ? SMG_TURN_BOTH
                        : k < n - 1 ? SMG_TURN_OTHER
                                    : SMG_TURN_LAST);
  }
}

#include "smg_turn_steps.h"

#endif
