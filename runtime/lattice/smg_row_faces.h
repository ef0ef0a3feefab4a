/* smidgen runtime: what blocks of cells feel of those of other ranks (smg_row_grid.h), and the messages that bring it.
 *
 * The cells that one block reads of another are boxes, which both ranks find alike: of the cells that stand beside the
 * one's, around rings too, those that the other one has. One message goes each way once the shell of a block is turned,
 * of which others read, and is on its way while the cells within are; requests are made once a call. */
#ifndef SMG_ROW_FACES_H
#define SMG_ROW_FACES_H

#include "smg_row_grid.h"

#if SMG_GRID

/* Blocks around one, in four directions. */
#define SMG_MPI_PARTNERS 80

/* Boxes that are turned before messages begin; the cells within. */
typedef struct smg_mpi_halo {
  int partners, messages[SMG_COLOURS], shells;
  smg_box shell[8], inner;
  MPI_Request message[SMG_COLOURS][2 * SMG_MPI_PARTNERS];
} smg_mpi_halo;

static smg_mpi_halo smg_halo;

/* The least box with both. */
static void smg_hull(smg_box *a, const smg_box *b) {
  const int empty = smg_is_empty(a);
  for (int d = 0; d < 4; ++d) {
    if (empty || b->from[d] < a->from[d]) a->from[d] = b->from[d];
    if (empty || b->to[d] > a->to[d]) a->to[d] = b->to[d];
  }
}

/* The cells beside those of a box, at a distance and so many times around the rings: of directions that no rank cuts
 * all. */
static smg_box smg_box_beside(const smg_coefficients *c, const smg_box *b, const smg_offset *o, const int64_t *around) {
  smg_box found;
  for (int d = 0; d < 4; ++d) {
    const int64_t step = d > 0 ? 1 : SMG_ROW_STEP, moved = o->cell[d] + around[d] * smg_cells(c, d),
                  end = b->to[d] * step < smg_cells(c, d) ? b->to[d] * step : smg_cells(c, d);
    found.from[d] = smg_grid(d) > 1 ? smg_down(b->from[d] * step + moved, step) : 0;
    found.to[d] = smg_grid(d) > 1 ? smg_down(end + moved - 1, step) + 1 : smg_extent(c, d);
  }
  return found;
}

/* What a box reads of another one, so many times around. */
static smg_box smg_read_around(const smg_coefficients *c, const smg_box *reader, const smg_box *owner,
                               const int64_t *around) {
  smg_offset beside[SMG_BESIDES];
  smg_box all = {{0}, {0}};
  for (int64_t sub = 0; sub < SMG_PLACES; ++sub)
    for (int64_t k = smg_offsets(sub, beside) - 1; k >= 0; --k) {
      const smg_box there = smg_box_beside(c, reader, beside + k, around), found = smg_both(&there, owner);
      int closed = 1;
      for (int d = 0; d < 4; ++d) closed &= around[d] == 0 || (beside[k].ring >> d & 1);
      if (closed && !smg_is_empty(&found)) smg_hull(&all, &found);
    }
  return all;
}

/* One box more; those that meet are one. */
static int smg_add_box(smg_box *all, int n, smg_box one) {
  for (int k = 0; k < n; ++k) {
    const smg_box common = smg_both(all + k, &one);
    if (smg_is_empty(&common)) continue;
    smg_hull(&one, all + k);
    all[k] = all[--n];
    k = -1;
  }
  all[n] = one;
  return n + 1;
}

/* All that a box reads of another one. */
static int smg_reads(const smg_coefficients *c, const smg_box *reader, const smg_box *owner, smg_box *all) {
  int n = 0;
  for (int image = 0; image < SMG_IMAGES; ++image) {
    int64_t around[4];
    int cut = 1;
    for (int d = 0, k = image; d < 4; ++d, k /= 3) {
      around[d] = k % 3 - 1;
      cut &= around[d] == 0 || (smg_grid(d) > 1 && (SMG_RINGS >> d & 1));
    }
    if (!cut) continue;
    const smg_box one = smg_read_around(c, reader, owner, around);
    if (!smg_is_empty(&one)) n = smg_add_box(all, n, one);
  }
  return n;
}

/* What others read of an end of the cells within is none of these: the thinnest slab that holds it. */
static void smg_take_off(smg_box *inner, const smg_box *told) {
  const smg_box common = smg_both(inner, told);
  int64_t least = INT64_MAX, *end = NULL, to = 0;
  if (smg_is_empty(&common)) return;
  for (int d = 0; d < 4; ++d) {
    const int64_t unit = smg_cut_unit(d), after = (told->to[d] + unit - 1) / unit * unit,
                  before = told->from[d] / unit * unit, weight = smg_box_slots(inner) / (inner->to[d] - inner->from[d]);
    if (smg_grid(d) == 1) continue;
    if (told->from[d] <= inner->from[d] && (after - inner->from[d]) * weight < least) {
      least = (after - inner->from[d]) * weight;
      end = inner->from + d;
      to = after;
    }
    if (told->to[d] >= inner->to[d] && (inner->to[d] - before) * weight < least) {
      least = (inner->to[d] - before) * weight;
      end = inner->to + d;
      to = before;
    }
  }
  if (end) *end = to;
  else inner->to[0] = inner->from[0];
}

/* The messages to and from another rank: boxes that are read of it, or told it. */
static void smg_mpi_prepare(const smg_state *s, int rank, const smg_box *b, int n, int told) {
  MPI_Datatype type;
  if (n == 0) return;
  smg_boxes_type(&s->c, b, n, smg_pitch(&s->c), &type);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    smg_real *first = s->row_m + colour * smg_colour_slots(&s->c);
    MPI_Request *message = smg_halo.message[colour] + smg_halo.messages[colour]++;
    if (told) MPI_Send_init(first, 1, type, rank, (int)colour, SMG_MPI_COMM, message);
    else MPI_Recv_init(first, 1, type, rank, (int)colour, SMG_MPI_COMM, message);
  }
  MPI_Type_free(&type);
}

/* May a block be beside this rank's? Parts are at least as long as couplings reach. */
static int smg_is_near(int64_t rank) {
  int near = rank != smg_mpi_me;
  for (int64_t d = 0, me = smg_mpi_me; d < 4; rank /= smg_grid((int)d), me /= smg_grid((int)d), ++d) {
    const int64_t n = smg_grid((int)d), apart = smg_left(rank - me, n);
    near &= apart <= 1 || apart == n - 1;
  }
  return near;
}

/* Those of this rank. */
static void smg_mpi_meet(const smg_state *s, int rank) {
  const smg_box other = smg_box_of(&s->c, rank);
  smg_box read[SMG_IMAGES], told[SMG_IMAGES];
  const int reads = smg_reads(&s->c, &smg_my_box, &other, read), tells = smg_reads(&s->c, &other, &smg_my_box, told);
  for (int k = 0; k < tells; ++k) smg_take_off(&smg_halo.inner, told + k);
  smg_halo.partners += reads + tells > 0;
  smg_mpi_prepare(s, rank, read, reads, 0);
  smg_mpi_prepare(s, rank, told, tells, 1);
}

/* A call begins. */
static void smg_begin_ranks(const smg_state *s, SMG_UNUSED smg_besides *known) {
  smg_choose_ranks(&s->c);
  smg_halo.partners = 0;
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) smg_halo.messages[colour] = 0;
  smg_halo.inner = smg_my_box;
  for (int rank = 0; rank < smg_mpi_parts; ++rank)
    if (smg_is_near(rank)) smg_mpi_meet(s, rank);
  smg_halo.shells = smg_shell(&smg_my_box, smg_halo.inner, smg_halo.shell);
}

/* This rank has all of the lattice. */
static void smg_stay_whole(const smg_coefficients *c) {
  smg_my_box = smg_halo.inner = smg_box_of(c, 0);
  smg_halo.shells = smg_halo.partners = 0;
}

/* The k-th of n parts of the cells within, along the slowest direction that they are several of; where a part would not
 * begin where vectors do, the last one is all. */
static smg_box smg_inner_part(const smg_coefficients *c, int64_t k, int64_t n) {
  smg_box part = smg_halo.inner;
  int d = 3;
  while (d > 0 && part.to[d] - part.from[d] == 1 && smg_cut_at_vectors(c, d - 1)) --d;
  const int64_t from = part.from[d], cells = part.to[d] - from, unit = d > 0 ? 1 : SMG_WIDEST;
  part.from[d] = from + cells / unit * k / n * unit;
  if (k + 1 < n) part.to[d] = from + cells / unit * (k + 1) / n * unit;
  return part;
}

#endif
#endif
