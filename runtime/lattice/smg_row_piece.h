/* smidgen runtime: the sites of one colour of a lattice in pieces, with the gradient at their places by
 * smg_slot_gradient of the model. Pieces, and the runs of rows in them, are cut alike for all SMG_LANES, so short that
 * what a sweep works on stays in the nearest cache. */
#ifndef SMG_ROW_PIECE_H
#define SMG_ROW_PIECE_H

#include "smg_row_team.h"

/* The next sites of a colour, or of a share of it: the slots start .. start + size - 1; done: of those, how many have
 * been gone through as runs; at, from: where the next run begins; end: the slot where they all end; length: slots of a
 * row; g: what there is to keep of each, first of all its gradient. */
typedef struct smg_piece {
  smg_lattice_row at;
  int64_t from, start, size, done, room, end, length;
  smg_besides *known;
  smg_real *g; /* 3 SMG_PIECE_ROOM numbers */
#if SMG_BY_ROWS && !SMG_ROW_TURNS
  SMG_LINES smg_real field[3 * SMG_PIECE_ROOM];
#endif
} smg_piece;

static inline void smg_begin_piece(const smg_coefficients *c, smg_besides *known, smg_real *g, smg_piece *piece) {
  piece->g = g;
  piece->known = known;
  piece->room = known->room;
  piece->length = smg_row_length(c);
}

/* All of a colour. */
static inline void smg_begin_colour(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  piece->at = smg_first_row(c, colour);
  piece->from = 0;
  piece->end = piece->at.start + smg_rows(c) * smg_row_length(c);
}

/* Some slots of it, from one on where a vector begins. */
static inline void smg_begin_part(const smg_coefficients *c, int64_t colour, smg_share part, smg_piece *piece) {
  const int64_t first = colour * smg_colour_slots(c), length = smg_row_length(c), end = first + smg_rows(c) * length;
  const int64_t row = piece->known->beside || part.from == first ? 0 : (part.from - first) / length;
  piece->at = row > 0 ? smg_row_of(c, colour, row) : piece->known->first[colour];
  piece->from = part.from - first - row * length;
  piece->end = part.to < end ? part.to : end;
  piece->size = piece->done = 0;
}

/* The share of this thread in it. */
static inline void smg_begin_share(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  smg_begin_part(c, colour, smg_share_of_colour(c, colour), piece);
}

/* The next piece; 0 where they end. */
SMG_INLINE int smg_open_piece(smg_piece *piece) {
  piece->start = piece->at.start + piece->from;
  piece->size = piece->end - piece->start < piece->room ? piece->end - piece->start : piece->room;
  piece->done = 0;
  return piece->size > 0;
}

/* Of a lattice in blocks: all sites of a place in it. */
static inline void smg_next_run_of_blocks(const smg_coefficients *c, smg_piece *piece, smg_run *run) {
  const int64_t alike = smg_colour_slots(c) / SMG_RANKS, rank = piece->from / alike,
                end = piece->from + piece->size - piece->done;
  run->start = piece->at.start;
  run->sub = smg_place(piece->at.colour, rank);
  run->b = NULL;
  run->from = piece->from;
  run->to = end < (rank + 1) * alike ? end : (rank + 1) * alike;
  run->length = run->sites = run->to;
  run->beside = piece->known->beside;
  run->order = piece->known->order;
  piece->done += run->to - run->from;
  piece->from = run->to;
}

/* Its next run of rows, or what there is of it in the piece; 0 where it ends. */
static inline int smg_next_run(const smg_coefficients *c, smg_piece *piece, smg_run *run) {
  const int64_t room = piece->size - piece->done, length = piece->length;
  if (room <= 0) return 0;
  run->place = piece->known->place;
#if SMG_SITE_VALUES
  run->values = piece->known->values;
#endif
  if (SMG_BLOCKS && piece->known->beside) {
    smg_next_run_of_blocks(c, piece, run);
    return 1;
  }
  run->beside = NULL;
  run->order = NULL;
  const int64_t rows = smg_run_of_rows(c, &piece->at, length), end = rows * length;
  run->start = piece->at.start;
  run->sub = piece->at.sub;
  run->sites = piece->at.sites;
  run->b = smg_besides_of(c, &piece->at, piece->known);
  run->length = length;
  run->from = piece->from;
  run->to = end - piece->from > room ? piece->from + room : end;
  piece->done += run->to - run->from;
  const int64_t gone = run->to == end ? rows : run->to / length;
  piece->from = run->to - gone * length;
  if (gone > 0) smg_after_rows(c, length, gone, &piece->at);
  return 1;
}

/* The next run of blocks, of whatever piece; 0 where all of them end. */
static inline int smg_next_blocks(const smg_coefficients *c, smg_piece *piece, smg_run *run) {
  if (piece->done == piece->size && !smg_open_piece(piece)) return 0;
  return smg_next_run(c, piece, run);
}

/* The gradient of one vector of a run, of blocks or not; of empty slots at the ends of rows it is 0. */
SMG_INLINE void smg_run_gradient(const smg_coefficients *c, const smg_run *run, int blocks, const smg_real *m,
                                 int64_t pitch, int64_t j, int64_t p, smg_lanes *g) {
  for (int k = 0; k < 3; ++k) g[k] = smg_lane_of(0);
  smg_slot_gradient(c, run, blocks, m, pitch, j, p, g);
  if (!blocks) smg_only_sites(run, p, g);
}

/* The gradients of a run of rows, one after the other from g on. */
SMG_INLINE void smg_run_gradients(const smg_coefficients *c, const smg_run *run, const smg_real *m, int64_t pitch,
                                  smg_real *g) {
  for (int64_t j = run->from, p = j; j < run->to; j += SMG_LANES, p = smg_next_place(p, run->length)) {
    smg_lanes sum[3];
    smg_run_gradient(c, run, 0, m, pitch, j, p, sum);
    smg_put_slots(g, SMG_PIECE_ROOM, j - run->from, sum);
  }
}

/* The next piece of rows, with the gradient at its places; 0 where they end. */
static inline int smg_next_piece(const smg_coefficients *c, const smg_real *m, smg_piece *piece) {
  const int64_t pitch = smg_pitch(c);
  smg_run run;
  if (!smg_open_piece(piece)) return 0;
  for (smg_real *g = piece->g; smg_next_run(c, piece, &run); g += run.to - run.from)
    smg_run_gradients(c, &run, m, pitch, g);
  return 1;
}

#endif
