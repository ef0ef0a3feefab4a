/* smidgen runtime: the sites of one colour of a lattice in pieces, and the runs of rows in them. Both are cut alike for
 * all SMG_LANES, so short that what a sweep works on stays in the nearest cache. */
#ifndef SMG_ROW_RUNS_H
#define SMG_ROW_RUNS_H

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

/* Some slots of a colour, from one on where a vector begins. */
static inline void smg_begin_part(const smg_coefficients *c, int64_t colour, smg_share part, smg_piece *piece) {
  const int64_t first = colour * smg_colour_slots(c), length = smg_row_length(c), end = first + smg_rows(c) * length;
  const int64_t row = piece->known->beside || part.from == first ? 0 : (part.from - first) / length;
  piece->at = row > 0 ? smg_row_of(c, colour, row) : piece->known->first[colour];
  piece->from = part.from - first - row * length;
  piece->end = part.to < end ? part.to : end;
  piece->size = piece->done = 0;
}

/* All of it. */
static inline void smg_begin_colour(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  smg_begin_part(c, colour, smg_colours_from(c, colour, 1), piece);
}

/* The next piece; 0 where they end. */
SMG_INLINE int smg_open_piece(smg_piece *piece) {
  piece->start = piece->at.start + piece->from;
  piece->size = piece->start > piece->known->first[piece->at.colour].start ? piece->room : piece->known->begin;
  if (piece->size > piece->end - piece->start) piece->size = piece->end - piece->start;
  piece->done = 0;
  return piece->size > 0;
}

/* Of a lattice in blocks: what there is in `room` slots of the sites of a place, and what they have alike. */
static inline void smg_run_of_blocks(const smg_coefficients *c, smg_piece *piece, int64_t room, smg_run *run) {
  const int64_t alike = smg_colour_slots(c) / SMG_RANKS, rank = run->from / alike, end = (rank + 1) * alike;
  run->to = end - run->from > room ? run->from + room : end;
  run->sub = smg_place(piece->at.colour, rank);
  run->b = NULL;
  run->length = run->sites = run->to;
  piece->from = run->to;
}

/* Of rows, as many as are alike; and the row where the next run begins. */
static inline void smg_run_in_rows(const smg_coefficients *c, smg_piece *piece, int64_t room, smg_run *run) {
  const int64_t length = piece->length, rows = smg_run_of_rows(c, &piece->at, length), end = rows * length;
  run->to = end - run->from > room ? run->from + room : end;
  run->sub = piece->at.sub;
  run->sites = piece->at.sites;
  run->b = smg_besides_of(c, &piece->at, piece->known);
  run->length = length;
  const int64_t gone = run->to == end ? rows : run->to / length;
  piece->from = run->to - gone * length;
  if (gone > 0) smg_after_rows(c, length, gone, &piece->at);
}

/* The next run, or what there is of it in the piece; 0 where that ends. */
SMG_INLINE int smg_next_run(const smg_coefficients *c, smg_piece *piece, smg_run *run) {
  const int64_t room = piece->size - piece->done;
  if (room <= 0) return 0;
  run->start = piece->at.start;
  run->from = piece->from;
  run->place = piece->known->place;
#if SMG_SITE_VALUES
  run->values = piece->known->values;
#endif
#if SMG_TANGENT
  run->points = piece->known->points;
#endif
  run->beside = piece->known->beside;
  run->order = piece->known->order;
  if (SMG_BLOCKS && run->beside) smg_run_of_blocks(c, piece, room, run);
  else smg_run_in_rows(c, piece, room, run);
  piece->done += run->to - run->from;
  return 1;
}

/* A visit of one vector: the slot of its first lane, how many lanes are sites that it is for, and their gradient. */
typedef void smg_vector_visit(void *context, int64_t slot, int64_t in, smg_lanes *g);

#endif
