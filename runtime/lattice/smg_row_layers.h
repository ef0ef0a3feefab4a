/* smidgen runtime: memory divided among ranks whose parts are blocks (smg_row_grid.h): steps go by blocks, w by sites,
 * outputs and sums by layers of the slowest direction, as without a grid. Between the two, each rank sends others what
 * they have next: when w goes into slots and comes back, when a state is saved and when it is restored. */
#ifndef SMG_ROW_LAYERS_H
#define SMG_ROW_LAYERS_H

#include "smg_row_parts.h"

#if SMG_LAYERS_APART
static void smg_move_saved(const smg_state *s, enum smg_carried_where where); /* smg_row_state.h */

/* A box as something to send, so many times: not at all where it is empty. */
static int smg_box_type(const smg_coefficients *c, const smg_box *b, int64_t pitch, MPI_Datatype *type) {
  const int there = !smg_is_empty(b);
  *type = SMG_MPI_REAL;
  if (there) smg_boxes_type(c, b, 1, pitch, type);
  return there;
}

/* An array of some colours, from blocks to layers or back: from each rank what it has of those of another one. */
static void smg_carry(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colours, int to_layers) {
  const smg_box block = smg_box_of(c, smg_mpi_me), layers = smg_layers_of(c, smg_mpi_me);
  for (int k = 1, n = smg_mpi_parts; k < n; ++k) {
    const int to = (smg_mpi_me + k) % n, from = (smg_mpi_me + n - k) % n;
    const smg_box goal = to_layers ? smg_layers_of(c, to) : smg_box_of(c, to),
                  source = to_layers ? smg_box_of(c, from) : smg_layers_of(c, from),
                  goes = smg_both(to_layers ? &block : &layers, &goal),
                  comes = smg_both(to_layers ? &layers : &block, &source);
    MPI_Datatype out, in;
    const int sent = smg_box_type(c, &goes, pitch, &out), got = smg_box_type(c, &comes, pitch, &in);
    for (int64_t q = 0; q < colours; ++q) {
      smg_real *first = array + q * smg_colour_slots(c);
      MPI_Sendrecv(first, sent, out, sent ? to : MPI_PROC_NULL, 3, first, got, in, got ? from : MPI_PROC_NULL, 3,
                   SMG_MPI_COMM, MPI_STATUS_IGNORE);
    }
    if (sent) MPI_Type_free(&out);
    if (got) MPI_Type_free(&in);
  }
}

/* The pages of layers that are not of this rank's block, given back. */
static void smg_drop_layers(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colours) {
  const smg_box layers = smg_layers_of(c, smg_mpi_me), block = smg_box_of(c, smg_mpi_me),
                common = smg_both(&layers, &block);
  smg_box apart[8];
  for (int n = smg_shell(&layers, common, apart); n > 0; --n)
    for (int64_t colour = 0; colour < colours; ++colour)
      for (int64_t k = smg_strips(c, apart + n - 1) - 1; k >= 0; --k) {
        const smg_share strip = smg_strip(c, colour, apart + n - 1, k);
        for (int x = 0; x < 3; ++x)
          smg_advise(array + x * pitch + strip.from, strip.to - strip.from, 4096, MADV_DONTNEED);
      }
}

/* All that a saved state has: to layers, dropped there, or from layers to blocks. */
static void smg_carry_array(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colours,
                            enum smg_carried_where where) {
  if (where != SMG_DROPPED) smg_carry(c, array, pitch, colours, where == SMG_TO_LAYERS);
  if (where != SMG_TO_LAYERS) smg_drop_layers(c, array, pitch, colours);
}
static void smg_carry_saved(const smg_state *s, int history, int64_t late, enum smg_carried_where where) {
  if (smg_mpi_parts == 1 || (where == SMG_DROPPED && smg_layers_held != s)) return;
  smg_carry_array(&s->c, s->row_compensation, smg_pitch(&s->c), SMG_COLOURS, where);
  for (int j = 0; j < history; ++j)
    smg_carry_array(&s->c, s->past[j], late, SMG_COLOURS - SMG_FIRST_KEPT(&s->c), where);
  smg_layers_held = where == SMG_TO_LAYERS ? s : NULL;
}

/* w, by slots. */
static void smg_carry_w(const smg_state *s, enum smg_carried_where where) {
  if (smg_mpi_parts > 1) smg_carry_array(&s->c, s->row_w, smg_pitch(&s->c), SMG_COLOURS, where);
  smg_my_box = smg_box_of(&s->c, smg_mpi_me);
}
static void smg_hold_layers(const smg_coefficients *c) { smg_my_box = smg_layers_of(c, smg_mpi_me); }

/* A visit of all sites of this rank's block. */
SMG_INLINE void smg_each_slot_of_block(const smg_coefficients *c, void *context,
                                       void (*visit)(void *context, int64_t site, int64_t slot)) {
  const smg_box b = smg_my_box;
  const int64_t cells = smg_cells(c, 0), end = b.to[0] * SMG_ROW_STEP < cells ? b.to[0] * SMG_ROW_STEP : cells;
  for (int64_t s3 = b.from[3]; s3 < b.to[3]; ++s3)
    for (int64_t s2 = b.from[2]; s2 < b.to[2]; ++s2)
      for (int64_t s1 = b.from[1]; s1 < b.to[1]; ++s1)
        smg_each_of_row(c, (s3 * smg_cells(c, 2) + s2) * smg_cells(c, 1) + s1, b.from[0] * SMG_ROW_STEP, end, context,
                        visit);
}

#endif
#endif
