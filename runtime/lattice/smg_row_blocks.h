/* smidgen runtime: small lattices in SMG_WIDEST blocks that are alike, one in each lane ("virtual nodes": P. Boyle, A.
 * Yamaguchi, G. Cossu and A. Portelli, "Grid: a next generation data parallel C++ QCD library", 2015).
 *
 * Lanes of a vector are the same cell of all blocks. The neighbours of a cell are in another vector, and of those in
 * lane 0 one is in some lane t. All others are then turned alike: the neighbour of lane l is in lane l (+) t, for the
 * lanes are a product of rings, of as many blocks as each direction has. Inside the blocks t = 0: vectors are loaded as
 * they stand, from where lines of the cache begin. So a table is all there is to know, SMG_BESIDES numbers for a
 * vector, and the slots of a colour are one run.
 *
 * The next block of a direction begins `shear` cells farther along direction 0, so that it begins with the same
 * colour. */
#ifndef SMG_ROW_BLOCKS_H
#define SMG_ROW_BLOCKS_H

#include "smg_rows.h"

#ifndef SMG_BLOCKS_TO
#if SMG_ROW_TURNS
#define SMG_BLOCKS_TO (SMG_SOME_TURNED / 2 - 1) /* slots */
#else
#define SMG_BLOCKS_TO (SMG_LARGE_PLANE - 1) /* beyond, wavefronts are worth more */
#endif
#endif

/* Cells of a block, blocks along each direction, and shears. */
typedef struct smg_blocks {
  int64_t cells[4], parts[4], shear[4];
} smg_blocks;

/* A cut of direction d into so many parts: does it keep colours, and close around the ring? */
static inline int smg_cut_direction(const smg_coefficients *c, int d, int64_t parts, smg_blocks *b) {
  const int64_t n = smg_cells(c, d), around = smg_cells(c, 0);
  b->parts[d] = parts;
  b->cells[d] = n / parts;
  if (n % parts > 0) return 0;
  for (int64_t k = 0; k < (d > 0 ? parts : 1); ++k) {
    b->shear[d] = k * around / parts;
    if (k * around % parts == 0 && (b->shear[d] * smg_weight_of(0) + b->cells[d] * smg_weight_of(d)) % SMG_COLOURS == 0)
      return 1;
  }
  return 0;
}

/* Such blocks, if there are any: cut rather along the fast directions, so that their layers are small, and three of
 * them stay in the nearest cache. */
static int smg_find_blocks(const smg_coefficients *c, smg_blocks *b) {
  for (int64_t k = 1; k <= SMG_WIDEST; k *= 2)
    for (int64_t j = 1; j <= SMG_WIDEST / k; j *= 2)
      for (int64_t i = SMG_WIDEST / k / j; i > 0; i /= 2)
        if (smg_cut_direction(c, 3, k, b) && smg_cut_direction(c, 2, j, b) && smg_cut_direction(c, 1, i, b) &&
            smg_cut_direction(c, 0, SMG_WIDEST / k / j / i, b))
          return 1;
  return 0;
}

/* Does the lattice stand in blocks? Where it is small, has no empty slots, and is not shared by ranks. */
static int smg_in_blocks(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED smg_blocks *b) {
#if defined(SMG_MPI)
  return 0;
#else
  return SMG_BLOCKS && smg_slots(c) == smg_sites(c) && smg_slots(c) <= SMG_BLOCKS_TO && !smg_colours_meet(c) &&
         smg_find_blocks(c, b);
#endif
}

/* The slot of a place in a cell. */
static int64_t smg_slot_in_blocks(const smg_coefficients *c, const smg_blocks *b, int64_t sub, const int64_t *cell) {
  const int64_t colour = smg_colour_of(sub, cell[0], cell[1], cell[2], cell[3]);
  int64_t x = cell[0], lane = 0, vector = smg_rank(sub);
  for (int d = 3; d > 0; --d) {
    const int64_t part = cell[d] / b->cells[d];
    x -= part * b->shear[d];
    lane = lane * b->parts[d] + part;
    vector = vector * b->cells[d] + cell[d] % b->cells[d];
  }
  x = smg_left(x, smg_cells(c, 0));
  lane = lane * b->parts[0] + x / b->cells[0];
  vector = vector * (b->cells[0] / SMG_ROW_STEP) + x % b->cells[0] / SMG_ROW_STEP;
  return colour * smg_colour_slots(c) + vector * SMG_WIDEST + lane;
}

/* A vector in its turn: colour, place, and the cell of its lane 0; the slot of that lane. */
typedef struct smg_block_vector {
  int64_t colour, rank, sub, cell[4], slot;
} smg_block_vector;

/* The first cell along direction 0 that has the colour. */
static inline void smg_begin_block_row(smg_block_vector *v) {
  v->sub = smg_place(v->colour, v->rank);
  v->cell[0] =
      smg_left(SMG_TURN_0 * (v->colour - smg_colour_of(v->sub, 0, v->cell[1], v->cell[2], v->cell[3])), SMG_ROW_STEP);
}

static inline smg_block_vector smg_first_vector(void) {
  smg_block_vector v = {0, 0, 0, {0, 0, 0, 0}, 0};
  smg_begin_block_row(&v);
  return v;
}

/* The next one: along direction 0, then 1, 2, 3, places, colours; 0 where they end. */
static inline int smg_next_vector(const smg_blocks *b, smg_block_vector *v) {
  v->slot += SMG_WIDEST;
  v->cell[0] += SMG_ROW_STEP;
  if (v->cell[0] < b->cells[0]) return 1;
  int d = 1;
  for (; d < 4 && ++v->cell[d] == b->cells[d]; ++d) v->cell[d] = 0;
  if (d == 4 && ++v->rank == SMG_RANKS) {
    v->rank = 0;
    ++v->colour;
  }
  if (v->colour == SMG_COLOURS) return 0;
  smg_begin_block_row(v);
  return 1;
}

/* Every site, and its slot. */
SMG_INLINE void smg_each_in_blocks(const smg_coefficients *c, const smg_blocks *b, void *context,
                                   void (*visit)(void *, int64_t, int64_t)) {
  const int64_t n[4] = {smg_cells(c, 0), smg_cells(c, 1), smg_cells(c, 2), smg_cells(c, 3)};
  int64_t along[SMG_WIDEST], cells[SMG_WIDEST];
  for (int64_t lane = 0; lane < SMG_WIDEST; ++lane) {
    int64_t left = lane / b->parts[0], above = n[0];
    along[lane] = lane % b->parts[0] * b->cells[0];
    cells[lane] = 0;
    for (int d = 1; d < 4; ++d) {
      const int64_t part = left % b->parts[d];
      left /= b->parts[d];
      along[lane] += part * b->shear[d];
      cells[lane] += part * b->cells[d] * above;
      above *= n[d];
    }
    along[lane] %= n[0];
  }
  smg_block_vector v = smg_first_vector();
  do {
    const int64_t row = ((v.cell[3] * n[2] + v.cell[2]) * n[1] + v.cell[1]) * n[0];
    for (int64_t lane = 0; lane < SMG_WIDEST; ++lane) {
      const int64_t x = v.cell[0] + along[lane];
      visit(context, smg_numbered_site(c, row + cells[lane] + (x < n[0] ? x : x - n[0]), v.sub), v.slot + lane);
    }
  } while (smg_next_vector(b, &v));
}

/* The table: of each vector, where what is beside its lane 0 stands. */
static inline size_t smg_beside_size(const smg_coefficients *c) {
  return ((size_t)(smg_slots(c) / SMG_WIDEST * SMG_BESIDES) * sizeof(smg_slot_beside) + sizeof(smg_real) - 1) /
         sizeof(smg_real);
}

static inline void smg_fill_beside(const smg_coefficients *c, const smg_blocks *b, smg_slot_beside *table) {
  smg_offset beside[SMG_BESIDES];
  smg_block_vector v = smg_first_vector();
  do {
    const int64_t found = smg_offsets(v.sub, beside);
    smg_slot_beside *of = table + v.slot / SMG_WIDEST * SMG_BESIDES;
    int turned = 0;
    for (int64_t k = 0; k < SMG_BESIDES; ++k) {
      int64_t cell[4];
      for (int d = 0; d < 4 && k < found; ++d) cell[d] = smg_left(v.cell[d] + beside[k].cell[d], smg_cells(c, d));
      of[k] = k < found ? (smg_slot_beside)(smg_slot_in_blocks(c, b, beside[k].sub, cell) - v.slot) : 0;
      turned |= of[k] % SMG_WIDEST != 0;
    }
    for (int64_t k = 0; turned && k < SMG_BESIDES; ++k) of[k] += SMG_SOME_TURNED;
  } while (smg_next_vector(b, &v));
}

/* order[t][l] = l (+) t. */
static inline void smg_order_lanes(const smg_blocks *b, smg_lane_order *order) {
  for (int64_t t = 0; t < SMG_WIDEST; ++t)
    for (int64_t l = 0; l < SMG_WIDEST; ++l) {
      int64_t sum = 0, unit = 1;
      for (int d = 0; d < 4; unit *= b->parts[d++]) sum += (l / unit + t / unit) % b->parts[d] * unit;
      order[t].of[l] = sum;
    }
}

#endif
