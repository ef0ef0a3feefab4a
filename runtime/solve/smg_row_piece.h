/* smidgen runtime: the sites of one colour of a lattice in pieces, with the gradient at their places by smg_row_gradient of the model.
 * Pieces are cut alike for all SMG_LANES, so short that what a sweep works on stays in the nearest cache. */
#ifndef SMG_ROW_PIECE_H
#define SMG_ROW_PIECE_H

#include "smg_row_team.h"

/* The next sites of a colour, or of a share of it: the slots start .. start + size - 1, with the gradient at their places; at, from: where
 * the one after begins; end: the slot where they all end. */
typedef struct smg_piece {
  smg_lattice_row at;
  int64_t from, start, size, room, end;
  smg_besides *known;
  smg_real *g; /* 3 SMG_PIECE_ROOM numbers */
#if SMG_BY_ROWS
  SMG_LINES smg_real made[3 * SMG_PIECE_ROOM];
#endif
} smg_piece;

/* Slots of a piece, so that the next one begins where a vector does: as many whole rows as fit, or SMG_PIECE. */
static inline int64_t smg_piece_room(const smg_coefficients *c) {
  const int64_t length = smg_row_length(c);
  for (int64_t n = SMG_PIECE / length; n > 0; --n)
    if (n * length % SMG_WIDEST == 0) return n * length;
  return SMG_PIECE;
}

static inline void smg_begin_piece(const smg_coefficients *c, smg_besides *known, smg_real *g, smg_piece *piece) {
  piece->g = g;
  piece->known = known;
  piece->room = smg_piece_room(c);
}

/* All of a colour. */
static inline void smg_begin_colour(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  piece->at = smg_first_row(c, colour);
  piece->from = 0;
  piece->end = piece->at.start + smg_rows(c) * smg_row_length(c);
}

/* The share of this thread in it. */
static inline void smg_begin_share(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  const int64_t first = colour * smg_colour_slots(c), length = smg_row_length(c), rows = smg_rows(c) * length;
  const smg_share share = smg_share_of(first, rows);
  const int64_t row = (share.from - first) / length;
  piece->at = smg_row_of(c, colour, row);
  piece->from = share.from - first - row * length;
  piece->end = share.to < first + rows ? share.to : first + rows;
}

/* The gradient of the sites from <= j < to of the row; of empty slots at its end it is 0. */
static inline void smg_piece_gradient(const smg_coefficients *c, const smg_real *m, smg_piece *piece, int64_t to) {
  smg_real *g = piece->g + piece->size;
  smg_row_gradient(c, &piece->at, smg_besides_of(c, &piece->at, piece->known), m, piece->from, to < piece->at.sites ? to : piece->at.sites, g);
  for (int64_t j = piece->at.sites > piece->from ? piece->at.sites : piece->from; j < to; ++j)
    for (int k = 0; k < 3; ++k) g[k * SMG_PIECE_ROOM + j - piece->from] = 0;
  piece->size += to - piece->from;
}

/* The next piece; 0 where they end. */
static inline int smg_next_piece(const smg_coefficients *c, const smg_real *m, smg_piece *piece) {
  const int64_t length = smg_row_length(c);
  piece->size = 0;
  piece->start = piece->at.start + piece->from;
  const int64_t whole = piece->end - piece->start < piece->room ? piece->end - piece->start : piece->room;
  while (piece->size < whole) {
    const int64_t room = whole - piece->size, to = length - piece->from > room ? piece->from + room : length;
    smg_piece_gradient(c, m, piece, to);
    piece->from = to;
    if (to < length) break;
    piece->from = 0;
    smg_next_row(c, length, &piece->at);
  }
  return piece->size > 0;
}

#endif
