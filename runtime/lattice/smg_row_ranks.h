/* smidgen runtime: lattices by rows on several ranks of MPI, with -DSMG_MPI: which slots are the part of a rank, and
 * what all ranks come to know. Without it nothing is left of this file.
 *
 * The state is replicated, the step distributed: every rank has all arrays, and works on its part of the slots of each
 * colour; within it threads have their shares. What ranks find together is a largest number, so the bits are those of
 * one rank. Between calls every rank has the whole of w; the other arrays are gathered when a state is saved. Where
 * memory is divided too (smg_row_parts.h) nothing is gathered. All ranks make the same calls. */
#ifndef SMG_ROW_RANKS_H
#define SMG_ROW_RANKS_H

#include "smg_rows.h"
#if SMG_DISTRIBUTED
#include "smg_sum.h"
#endif

/* Increments are kept of all colours but the first, whose midpoints follow from the others; where sites of a
 * colour feel each other, or it has all there are, of that one too: the first colour and slot. */
#define SMG_FIRST_KEPT(c) (SMG_COLOURS == 1 || smg_colours_meet(c) ? 0 : 1)
#define SMG_KEPT_FROM(c) (SMG_FIRST_KEPT(c) * smg_colour_slots(c))

#if defined(SMG_MPI) && SMG_BY_ROWS && !SMG_ROW_TURNS
#include <mpi.h>

#ifdef SMG_QUAD
#error "MPI has no numbers of quadruple precision"
#endif
#ifdef SMG_LONG_DOUBLE
#define SMG_MPI_REAL MPI_LONG_DOUBLE
#else
#define SMG_MPI_REAL MPI_DOUBLE
#endif
#ifndef SMG_MPI_COMM
#define SMG_MPI_COMM MPI_COMM_WORLD
#endif
/* slots of a colour that are worth a rank: some 30 microseconds of work, where an exchange and a largest number take 5
 * to 20 */
#ifndef SMG_MPI_SHARE
#define SMG_MPI_SHARE 4096
#endif

/* Ranks of this call: this one, all, and those that have parts, the first ones. MPI is called by one thread of a
 * process at a time, and each call begins by setting them. */
static int smg_mpi_me = 0, smg_mpi_size = 1, smg_mpi_parts = 1;

#define SMG_SHARED_BY_RANKS (smg_mpi_parts > 1)
/* Colours are shared one by one: n of them from the k-th on, up to the last. */
#define SMG_COLOURS_AT_ONCE(k, n, first) for (int64_t k = (first), n = 1; k < SMG_COLOURS; k += n)

#if SMG_IN_PARTS
static inline int smg_may_divide(const smg_coefficients *c);
static void smg_choose_sites(const smg_coefficients *c);
#else
#define smg_may_divide(c) 1
#define smg_choose_sites(c) (void)0
#endif

#ifdef SMG_MPI_GRID
#include "smg_row_grid.h"
#else
static int64_t smg_mpi_unit = SMG_WIDEST; /* slots of a colour that parts are whole numbers of */

/* The farthest that a site feels, in slots of its colour, and a vector more: some layers of the slowest direction. */
static inline int64_t smg_mpi_reach(const smg_coefficients *c) {
  const int64_t reach[3] = {SMG_REACH_1, SMG_REACH_2, SMG_REACH_3};
  int64_t layer = smg_row_length(c), slots = SMG_BEFORE;
  for (int d = 0; d < 3; ++d) {
    if (smg_cells(c, d + 1) > 1) slots = (reach[d] + 1) * layer;
    layer *= smg_cells(c, d + 1);
  }
  return slots + SMG_WIDEST;
}

static inline int smg_slowest(const smg_coefficients *c) {
  int d = 3;
  while (d > 0 && smg_cells(c, d) == 1) --d;
  return d;
}

/* Slots of each colour in a layer of the slowest direction, of one direction alone 1; 0 where slots do not follow
 * layers. */
static inline int64_t smg_mpi_layer(const smg_coefficients *c) {
  const int slowest = smg_slowest(c);
  int64_t slots = slowest > 0 ? smg_row_length(c) : 1;
  for (int d = 1; d < slowest; ++d) slots *= smg_cells(c, d);
  return SMG_RANKS > 1 || (slowest == 1 && smg_plane_step(c, slots) > 1) ? 0 : slots;
}

/* So many layers that vectors begin with them, or vectors. */
static inline int64_t smg_mpi_unit_of(int64_t layer) {
  int64_t slots = layer > 0 ? layer : SMG_WIDEST;
  while (slots % SMG_WIDEST > 0) slots += layer;
  return slots;
}

/* Ranks that have parts: each no shorter than that, and worth its messages; one where sites of a colour feel each
 * other, where memory could not be divided, and where the tangent map takes the increments of all sites. */
static inline int64_t smg_mpi_fit(const smg_coefficients *c, int64_t ranks) {
  const int64_t slots = smg_colour_slots(c), worth = slots / SMG_MPI_SHARE, unit = smg_mpi_unit,
                far = slots / unit / ((smg_mpi_reach(c) + unit - 1) / unit), most = worth < far ? worth : far;
  return most <= 1 || SMG_TANGENT || smg_colours_meet(c) || !smg_may_divide(c) ? 1 : most < ranks ? most : ranks;
}

static void smg_choose_parts(const smg_coefficients *c) {
  smg_mpi_unit = smg_mpi_unit_of(smg_mpi_layer(c));
  smg_mpi_parts = (int)smg_mpi_fit(c, smg_mpi_size);
}

/* Where the slots of a rank begin in a colour; of ranks without a part, at its end. */
SMG_INLINE int64_t smg_mpi_from(const smg_coefficients *c, int64_t rank) {
  const int64_t slots = smg_colour_slots(c);
  return rank < smg_mpi_parts ? slots / smg_mpi_unit * rank / smg_mpi_parts * smg_mpi_unit : slots;
}

/* This rank's part of a colour, or of all where it has them all. */
SMG_INLINE smg_share smg_part_of_rank(const smg_coefficients *c, smg_share all) {
  const smg_share part = {all.from + smg_mpi_from(c, smg_mpi_me), all.from + smg_mpi_from(c, smg_mpi_me + 1)};
  return smg_mpi_parts > 1 ? part : all;
}

/* The rank that has a slot: the last q with U q/n <= slot/unit for U units and n parts; slots that are no unit belong
 * to the last one. */
SMG_INLINE int smg_mpi_owner(const smg_coefficients *c, int64_t slot) {
  const int64_t units = smg_colour_slots(c) / smg_mpi_unit, unit = slot % smg_colour_slots(c) / smg_mpi_unit,
                at = unit < units ? unit : units - 1;
  return (int)((smg_mpi_parts * (at + 1) + units - 1) / units - 1);
}

/* All ranks get all parts of an array of some colours, x, y and z a pitch apart. */
static void smg_mpi_gather(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colours) {
  for (int rank = 0; rank < smg_mpi_parts; ++rank) {
    const int64_t from = smg_mpi_from(c, rank), slots = smg_mpi_from(c, rank + 1) - from;
    for (int64_t q = 0; q < 3 * colours; ++q)
      MPI_Bcast(array + q / colours * pitch + q % colours * smg_colour_slots(c) + from, (int)slots, SMG_MPI_REAL, rank,
                SMG_MPI_COMM);
  }
}
#endif

/* Who shares the steps of this lattice? A state that was never begun has none, and its calls are of this rank alone. */
static void smg_choose_ranks(const smg_coefficients *c) {
  int ready = 0, ended = 0;
  MPI_Initialized(&ready);
  MPI_Finalized(&ended);
  smg_mpi_me = 0;
  smg_mpi_size = smg_mpi_parts = 1;
  if (!c->model) return;
  if (ready && !ended) {
    MPI_Comm_rank(SMG_MPI_COMM, &smg_mpi_me);
    MPI_Comm_size(SMG_MPI_COMM, &smg_mpi_size);
  }
  smg_choose_parts(c);
  smg_choose_sites(c);
}

/* The larger of two numbers of all ranks; what is not a number counts as infinite, so that all come to the same. */
static void smg_largest_of_ranks(smg_real *a, smg_real *b) {
  if (smg_mpi_parts == 1) return;
  smg_real most[2] = {*a == *a ? *a : (smg_real)INFINITY, *b == *b ? *b : (smg_real)INFINITY};
  MPI_Allreduce(MPI_IN_PLACE, most, 2, SMG_MPI_REAL, MPI_MAX, SMG_MPI_COMM);
  *a = most[0];
  *b = most[1];
}

/* w of all ranks. */
static void smg_gather_rows(const smg_state *s) {
  if (smg_mpi_parts > 1 && !SMG_IN_PARTS) smg_mpi_gather(&s->c, s->row_w, smg_pitch(&s->c), SMG_COLOURS);
}

/* What else a saved state has: of `history` increments, late numbers apart, there are all colours but the first. */
static void smg_gather_saved(const smg_state *s, int history, int64_t late) {
  if (SMG_IN_PARTS) return;
  smg_choose_ranks(&s->c);
  if (smg_mpi_parts == 1) return;
  smg_mpi_gather(&s->c, s->row_compensation, smg_pitch(&s->c), SMG_COLOURS);
  for (int j = 0; j < history; ++j) smg_mpi_gather(&s->c, s->past[j], late, SMG_COLOURS - SMG_FIRST_KEPT(&s->c));
}

/* Numbers of the k-th late slot, from the rank that has it. */
static void smg_share_sample(const smg_coefficients *c, int64_t k, smg_real *all, int count) {
  if (smg_mpi_parts > 1) MPI_Bcast(all, count, SMG_MPI_REAL, smg_mpi_owner(c, k), SMG_MPI_COMM);
}

#if SMG_DISTRIBUTED
#include "smg_row_parts.h"
#ifdef SMG_MPI_GRID
#include "smg_row_layers.h"
#endif
#endif
#include "smg_row_halo.h"

#else
#define smg_part_of_rank(c, all) (all)
#define SMG_SHARED_BY_RANKS 0
#define SMG_COLOURS_AT_ONCE(k, n, first) for (int64_t k = (first), n = SMG_COLOURS - k; k < SMG_COLOURS; k += n)
#define smg_begin_ranks(s, known) (void)0
#define smg_by_each_rank(c) (void)0
#define smg_end_ranks(s) (void)0
#define smg_largest_of_ranks(a, b) (void)0
#define smg_between_ends(colour, all) (all)
#define smg_send_colour(colour) (void)0
#define smg_mpi_looks(inner) 1
#define smg_look_at_colour(colour) (void)0
#define smg_await_colour(colour) (void)0
#define smg_exchange_late() (void)0
#define smg_share_sample(c, k, all, count) (void)0
#define smg_gather_saved(s, history, late) (void)0
#endif

#endif
