/* smidgen runtime: the sites of one colour of a lattice in pieces, with the gradient at their places by smg_row_gradient of the model.
 * Pieces are cut alike for all SMG_LANES, so short that what a sweep works on stays in the nearest cache. */
#ifndef SMG_ROW_PIECE_H
#define SMG_ROW_PIECE_H

#include "smg_rows.h"

/* The next sites of a colour: the slots start .. start + size - 1, with the gradient at their places; at, from: where the one after begins. */
typedef struct smg_piece {
  smg_lattice_row at;
  int64_t from, start, size, room;
  smg_besides known;
  smg_real *g; /* 3 SMG_PIECE_ROOM numbers */
#if SMG_BY_ROWS
  SMG_LINES smg_real made[3 * SMG_PIECE_ROOM];
#endif
} smg_piece;

/* Slots of a piece: as many whole rows as fit, so that the next piece begins where a vector does if that can be; of a longer row SMG_PIECE. */
static inline int64_t smg_piece_room(const smg_coefficients *c) {
  const int64_t length = smg_row_length(c);
  int64_t rows = SMG_PIECE / length;
  for (int64_t n = rows; n > 0; --n)
    if (n * length % SMG_WIDEST == 0) return n * length;
  return rows > 0 ? rows * length : SMG_PIECE;
}

static inline void smg_begin_piece(const smg_coefficients *c, smg_real *g, smg_piece *piece) {
  piece->g = g;
  piece->room = smg_piece_room(c);
  smg_forget_besides(&piece->known);
}

static inline void smg_begin_colour(const smg_coefficients *c, int64_t colour, smg_piece *piece) {
  piece->at = smg_first_row(c, colour);
  piece->from = 0;
}

/* The gradient of the sites from <= j < to of the row; of empty slots at its end it is 0. */
static inline void smg_piece_gradient(const smg_coefficients *c, const smg_real *m, smg_piece *piece, int64_t to) {
  smg_real *g = piece->g + piece->size;
  smg_row_gradient(c, &piece->at, smg_besides_of(c, &piece->at, &piece->known), m, piece->from, to < piece->at.sites ? to : piece->at.sites, g);
  for (int64_t j = piece->at.sites > piece->from ? piece->at.sites : piece->from; j < to; ++j)
    for (int k = 0; k < 3; ++k) g[k * SMG_PIECE_ROOM + j - piece->from] = 0;
  piece->size += to - piece->from;
}

/* The next piece; 0 where the colour ends. */
static inline int smg_next_piece(const smg_coefficients *c, const smg_real *m, smg_piece *piece) {
  const int64_t length = smg_row_length(c);
  piece->size = 0;
  piece->start = piece->at.start + piece->from;
  while (piece->at.rank < SMG_RANKS && piece->size < piece->room) {
    const int64_t room = piece->room - piece->size, to = length - piece->from > room ? piece->from + room : length;
    smg_piece_gradient(c, m, piece, to);
    piece->from = to;
    if (to < length) break;
    piece->from = 0;
    smg_next_row(c, length, &piece->at);
  }
  return piece->size > 0;
}

#endif
