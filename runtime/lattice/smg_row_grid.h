/* smidgen runtime: parts of ranks that are blocks of cells: -DSMG_MPI_GRID=2,1,4 has so many ranks along directions 0,
 * 1 and 2, the first direction first. Without it parts are layers of the slowest direction (smg_row_ranks.h).
 *
 * Of direction 0 a block has some slots of its rows, in whole vectors. So in a colour its slots are strips, each of
 * which begins and ends where vectors do: all slots of as many directions as the block has whole, from direction 0 on,
 * and some of the next. */
#ifndef SMG_ROW_GRID_H
#define SMG_ROW_GRID_H

#include "smg_row_ranks.h"

#if SMG_GRID

#define SMG_IMAGES 81 /* of a block around rings, three in each direction */

/* Cells from <= s < to of each direction, of direction 0 slots of a row. */
typedef struct smg_box {
  int64_t from[4], to[4];
} smg_box;

/* That of this rank; of a rank that does all, the lattice. */
static smg_box smg_my_box;

/* Ranks along a direction; slots of a row, or cells; slots of a layer of direction d. */
SMG_INLINE int64_t smg_grid(int d) {
  const int64_t grid[4] = {SMG_MPI_GRID};
  return grid[d] > 1 ? grid[d] : 1;
}
SMG_INLINE int64_t smg_extent(const smg_coefficients *c, int d) { return d > 0 ? smg_cells(c, d) : smg_row_length(c); }
static inline int64_t smg_below(const smg_coefficients *c, int d) {
  int64_t slots = 1;
  while (d-- > 0) slots *= smg_extent(c, d);
  return slots;
}

/* What a direction is cut into: cells, or vectors. */
SMG_INLINE int64_t smg_cut_unit(int d) { return d > 0 || smg_grid(0) == 1 ? 1 : SMG_WIDEST; }

static smg_box smg_box_of(const smg_coefficients *c, int64_t rank) {
  smg_box b;
  for (int d = 0; d < 4; ++d) {
    const int64_t n = smg_mpi_parts > 1 ? smg_grid(d) : 1, at = rank % n, units = smg_extent(c, d) / smg_cut_unit(d);
    b.from[d] = units * at / n * smg_cut_unit(d);
    b.to[d] = at + 1 < n ? units * (at + 1) / n * smg_cut_unit(d) : smg_extent(c, d);
    rank /= n;
  }
  return b;
}

/* Cells of a direction that every part can be counted on to have; at the end of a row the last one may have empty
 * slots. */
static int64_t smg_least_cells(const smg_coefficients *c, int d) {
  const int64_t n = smg_grid(d), unit = smg_cut_unit(d), units = smg_extent(c, d) / unit, least = units / n * unit,
                inner = (least - 1) * SMG_ROW_STEP, last = smg_cells(c, 0) - units * (n - 1) / n * unit * SMG_ROW_STEP;
  return d > 0 ? least : inner < last ? inner : last;
}

/* Does a part hold as many cells of each direction that is cut as couplings reach? */
static int smg_parts_reach(const smg_coefficients *c) {
  smg_offset beside[SMG_BESIDES];
  int far = 1;
  for (int64_t sub = 0; sub < SMG_PLACES; ++sub)
    for (int64_t k = smg_offsets(sub, beside) - 1; k >= 0; --k)
      for (int d = 0; d < 4; ++d) {
        const int64_t cells = smg_least_cells(c, d), o = beside[k].cell[d];
        far &= smg_grid(d) == 1 || (o <= cells && -o <= cells);
      }
  return far;
}

/* Do layers of a direction, or parts of rows, begin where vectors do? */
static int smg_cut_at_vectors(const smg_coefficients *c, int d) {
  return smg_below(c, d > 0 ? d : 1) % SMG_WIDEST == 0;
}

/* Can the lattice be cut so, among that many ranks? Parts begin where vectors do. */
static int smg_grid_fits(const smg_coefficients *c, int64_t ranks) {
  int first = 0;
  int64_t all = 1;
  for (int d = 3; d >= 0; --d) {
    if (smg_extent(c, d) < smg_grid(d) * smg_cut_unit(d)) return 0;
    if (smg_grid(d) > 1) first = d;
    all *= smg_grid(d);
  }
  return all == ranks && smg_cut_at_vectors(c, first) && !SMG_TANGENT && !smg_colours_meet(c) && smg_parts_reach(c) &&
         smg_may_divide(c);
}

#define smg_part_of_rank(c, all) (all) /* of one that does all */

static void smg_choose_ranks(const smg_coefficients *c);
static int smg_fits;
static void smg_choose_parts(const smg_coefficients *c) {
  smg_fits = smg_mpi_size == 1 || smg_grid_fits(c, smg_mpi_size);
  smg_mpi_parts = smg_fits ? smg_mpi_size : 1;
  smg_my_box = smg_box_of(c, smg_mpi_me);
}
static int smg_may_cut(const smg_coefficients *c) {
  smg_choose_ranks(c);
  return smg_fits;
}

/* Slots of strips of a box: rows, runs of rows that begin alike, planes, or more. */
static int smg_whole_directions(const smg_coefficients *c, const smg_box *b) {
  int d = 0;
  while (d < 4 && b->from[d] == 0 && b->to[d] == smg_extent(c, d)) ++d;
  return d;
}
static int64_t smg_strips(const smg_coefficients *c, const smg_box *b) {
  const int whole = smg_whole_directions(c, b);
  int64_t n = whole == 1 ? smg_plane_step(c, smg_row_length(c)) : 1;
  for (int d = whole + 1; d < 4; ++d) n *= b->to[d] - b->from[d];
  return whole == 4 ? 1 : n * SMG_RANKS;
}

/* Of the rows from <= s1 < to those that begin like the q-th: the first, and how many. */
typedef struct smg_alike {
  int64_t first, rows;
} smg_alike;
static inline smg_alike smg_rows_alike(int64_t from, int64_t to, int64_t q, int64_t step) {
  smg_alike found = {from + smg_left(q - from, step), 0};
  if (found.first < to) found.rows = (to - found.first + step - 1) / step;
  return found;
}

/* The k-th strip of a box in a colour. */
static smg_share smg_strip(const smg_coefficients *c, int64_t colour, const smg_box *b, int64_t k) {
  const int whole = smg_whole_directions(c, b);
  const int64_t first = colour * smg_colour_slots(c), step = smg_plane_step(c, smg_row_length(c));
  smg_share strip = {first, first + smg_colour_slots(c)};
  int64_t s[4] = {0}, slots;
  if (whole == 4) return strip;
  const smg_alike rows = smg_rows_alike(b->from[1], b->to[1], k % step, step);
  if (whole == 1) k /= step;
  for (int d = whole + 1; d < 4; k /= b->to[d] - b->from[d], ++d) s[d] = b->from[d] + k % (b->to[d] - b->from[d]);
  if (whole > 0) s[whole] = b->from[whole];
  if (whole == 1) s[1] = rows.rows > 0 ? rows.first : 0;
  slots = whole == 1 ? rows.rows * smg_row_length(c) : (b->to[whole] - b->from[whole]) * smg_below(c, whole);
  strip.from = first + smg_row_slot(c, k, s[1], s[2], s[3]) + (whole == 0 ? b->from[0] : 0);
  strip.to = strip.from + slots;
  return strip;
}

/* Those of this rank; which there are of smg_row_team.h. */
#define SMG_STRIPS(c, k) for (int64_t k = 0, k##_end = smg_strips(c, &smg_my_box); k < k##_end; ++k)
#define smg_strip_of_rank(c, colour, n, k) smg_strip(c, colour, &smg_my_box, k)

/* How many slots a box has in a colour. */
static int64_t smg_box_slots(const smg_box *b) {
  int64_t slots = SMG_RANKS;
  for (int d = 0; d < 4; ++d) slots *= b->to[d] > b->from[d] ? b->to[d] - b->from[d] : 0;
  return slots;
}

static inline int smg_is_empty(const smg_box *b) { return smg_box_slots(b) == 0; }
static smg_box smg_both(const smg_box *a, const smg_box *b) {
  smg_box found;
  for (int d = 0; d < 4; ++d) {
    found.from[d] = a->from[d] > b->from[d] ? a->from[d] : b->from[d];
    found.to[d] = a->to[d] < b->to[d] ? a->to[d] : b->to[d];
  }
  return found;
}

/* The shell of a box: of each direction what is before and after the cells within, of those left by slower ones. */
static int smg_shell(const smg_box *b, smg_box inner, smg_box *shell) {
  smg_box left = *b;
  int n = 0;
  if (smg_is_empty(&inner)) inner.from[3] = inner.to[3] = left.to[3];
  for (int d = 3; d >= 0; --d) {
    smg_box before = left, after = left;
    before.to[d] = inner.from[d];
    after.from[d] = inner.to[d];
    if (!smg_is_empty(&before)) shell[n++] = before;
    if (!smg_is_empty(&after)) shell[n++] = after;
    left.from[d] = inner.from[d];
    left.to[d] = inner.to[d];
  }
  return n;
}

/* The rank that has a slot. */
static int smg_mpi_owner(const smg_coefficients *c, int64_t slot) {
  const int64_t colour = slot / smg_colour_slots(c), row = (slot - colour * smg_colour_slots(c)) / smg_row_length(c);
  const smg_lattice_row at = smg_row_of(c, colour, row);
  const int64_t s[4] = {slot - at.start, at.s1, at.s2, at.s3};
  int64_t rank = 0;
  for (int d = 3; d >= 0; --d) {
    const int64_t n = smg_grid(d), units = smg_extent(c, d) / smg_cut_unit(d), unit = s[d] / smg_cut_unit(d);
    rank = rank * n + (n * (unit + 1) + units - 1) / units - 1;
  }
  return (int)rank;
}

/* Types of MPI: so many of one at equal distances, in numbers; several of them; the rows of a plane; some boxes of a
 * colour, x, y and z. */
static void smg_repeat_type(int64_t count, int64_t apart, MPI_Datatype *type) {
  MPI_Datatype one = *type;
  MPI_Type_create_hvector((int)count, 1, (MPI_Aint)(apart * (int64_t)sizeof(smg_real)), one, type);
  MPI_Type_free(&one);
}
static void smg_join_types(int n, const MPI_Aint *at, MPI_Datatype *some, MPI_Datatype *type) {
  int each[SMG_IMAGES];
  for (int k = 0; k < n; ++k) each[k] = 1;
  MPI_Type_create_struct(n, each, at, some, type);
  for (int k = 0; k < n; ++k) MPI_Type_free(some + k);
}
static void smg_plane_type(const smg_coefficients *c, const smg_box *b, MPI_Datatype *type) {
  const int64_t length = smg_row_length(c), step = smg_plane_step(c, length);
  MPI_Datatype some[SMG_IMAGES];
  MPI_Aint at[SMG_IMAGES];
  int n = 0;
  for (int64_t q = 0; q < step; ++q) {
    const smg_alike rows = smg_rows_alike(b->from[1], b->to[1], q, step);
    if (rows.rows == 0) continue;
    at[n] = (MPI_Aint)((smg_place_in_plane(c, rows.first) * length + b->from[0]) * (int64_t)sizeof(smg_real));
    MPI_Type_contiguous((int)(b->to[0] - b->from[0]), SMG_MPI_REAL, some + n);
    smg_repeat_type(rows.rows, length, some + n++);
  }
  smg_join_types(n, at, some, type);
}
static void smg_boxes_type(const smg_coefficients *c, const smg_box *b, int n, int64_t pitch, MPI_Datatype *type) {
  MPI_Datatype some[SMG_IMAGES];
  MPI_Aint at[SMG_IMAGES];
  for (int k = 0; k < n; ++k) {
    at[k] = (MPI_Aint)((b[k].from[3] * smg_below(c, 3) + b[k].from[2] * smg_below(c, 2)) * (int64_t)sizeof(smg_real));
    smg_plane_type(c, b + k, some + k);
    smg_repeat_type(b[k].to[2] - b[k].from[2], smg_below(c, 2), some + k);
    smg_repeat_type(b[k].to[3] - b[k].from[3], smg_below(c, 3), some + k);
    smg_repeat_type(SMG_RANKS, smg_below(c, 4), some + k);
    smg_repeat_type(3, pitch, some + k);
  }
  smg_join_types(n, at, some, type);
  MPI_Type_commit(type);
}

/* All ranks get all parts of an array of some colours, x, y and z a pitch apart. */
static void smg_mpi_gather(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colours) {
  for (int rank = 0; rank < smg_mpi_parts; ++rank) {
    const smg_box b = smg_box_of(c, rank);
    MPI_Datatype type;
    smg_boxes_type(c, &b, 1, pitch, &type);
    for (int64_t q = 0; q < colours; ++q) MPI_Bcast(array + q * smg_colour_slots(c), 1, type, rank, SMG_MPI_COMM);
    MPI_Type_free(&type);
  }
}

#endif
#endif
