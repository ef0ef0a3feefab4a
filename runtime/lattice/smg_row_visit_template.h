/* smidgen runtime: visits of the vectors of a colour with what smg_slot_gradient of the model makes of an array; a
 * template, of which smg_row_tangent.h has another copy with another function of the model in its place. */
#include "smg_row_runs.h"

/* The gradient of one vector of a run, of blocks or not; of empty slots at the ends of rows it is 0. */
SMG_INLINE void smg_run_gradient(const smg_coefficients *c, const smg_run *run, int blocks, const smg_real *m,
                                 int64_t pitch, int64_t j, int64_t p, smg_lanes *g) {
  smg_lane_zero(g, 3);
  if (smg_standing_of(run, blocks, j) == SMG_STRAIGHT_ON) {
    smg_run straight = *run;
    SMG_ANEW(straight.beside);
    smg_slot_gradient(c, &straight, SMG_STRAIGHT_ON, m, pitch, j, p, g);
  } else smg_slot_gradient(c, run, blocks, m, pitch, j, p, g);
  if (!blocks) smg_only_sites(run, p, g);
}

/* The next piece of rows, with the gradient at its places; 0 where they end. */
static inline int smg_next_piece(const smg_coefficients *c, const smg_real *m, smg_piece *piece) {
  const int64_t pitch = smg_pitch(c);
  smg_run run;
  if (!smg_open_piece(piece)) return 0;
  for (smg_real *g = piece->g; smg_next_run(c, piece, &run); g += run.to - run.from)
    for (int64_t j = run.from, p = j; j < run.to; j += SMG_LANES, p = smg_next_place(p, run.length)) {
      smg_lanes sum[3];
      smg_run_gradient(c, &run, 0, m, pitch, j, p, sum);
      smg_put_slots(g, SMG_PIECE_ROOM, j - run.from, sum);
    }
  return 1;
}

/* Visits of all vectors of some slots of a colour, with the gradient of the spins or midpoints `all`. Of rows a piece
 * has its gradients first; of blocks there is next to nothing to look up from vector to vector. */
SMG_INLINE void smg_each_vector(const smg_coefficients *c, smg_besides *known, const smg_real *all, int64_t colour,
                                smg_share part, void *context, smg_vector_visit *visit) {
  const int64_t pitch = smg_pitch(c);
  smg_piece piece;
  smg_run run;
  smg_lanes g[3];
  SMG_LINES smg_real gradient[3 * SMG_PIECE_ROOM];
  smg_begin_piece(c, known, gradient, &piece);
  smg_begin_part(c, colour, part, &piece);
  while (SMG_BLOCKS && known->beside && smg_open_piece(&piece))
    while (smg_next_run(c, &piece, &run))
      for (int64_t j = run.from; j < run.to; j += SMG_LANES) {
        smg_run_gradient(c, &run, 1, all, pitch, j, j, g);
        visit(context, run.start + j, SMG_LANES, g);
      }
  while (!known->beside && smg_next_piece(c, all, &piece))
    for (int64_t k = 0; k < piece.size; k += SMG_LANES) {
      smg_take_slots(gradient, SMG_PIECE_ROOM, k, g);
      visit(context, piece.start + k, piece.size - k, g);
    }
}
