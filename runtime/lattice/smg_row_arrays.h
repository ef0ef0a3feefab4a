/* smidgen runtime: the arrays by slots of a state whose steps go by rows, and w between them and the sites. */
#ifndef SMG_ROW_ARRAYS_H
#define SMG_ROW_ARRAYS_H

#include "smg_row_slots.h"
#include "smg_row_spin.h"
#include "smg_row_team.h"
#include "smg_state.h"

/* 1/radius^2: of a radius that the compiler knows, no number to multiply by where it is 1. */
SMG_INLINE smg_real smg_inverse_square(const smg_coefficients *c) { return 1 / (smg_radius(c, 0) * smg_radius(c, 0)); }

/* The same of sites whose radii differ: by slots, from the number SMG_RADIUS_AT on; and of those of one vector. */
#if SMG_RADII
typedef const smg_real *smg_inverses;
SMG_INLINE smg_inverses smg_inverses_of(const smg_state *s) { return s->row_values + SMG_RADIUS_AT * smg_pitch(&s->c); }
SMG_INLINE smg_inverse smg_inverse_at(smg_inverses all, int64_t slot) { return smg_lane_take(all + slot); }
#else
typedef smg_real smg_inverses;
SMG_INLINE smg_inverses smg_inverses_of(const smg_state *s) { return smg_inverse_square(&s->c); }
SMG_INLINE smg_inverse smg_inverse_at(smg_inverses all, SMG_UNUSED int64_t slot) { return all; }
#endif

/* An array by slots, from *next on. */
static inline smg_real *smg_place_slots(smg_real **next, size_t size) {
  smg_real *first = *next + SMG_BEFORE;
  *next += size;
  return first;
}

/* Those that all such states have, from mem on; where the next one begins. The first one holds w by sites between
 * calls. */
static inline smg_real *smg_place_row_arrays(smg_state *s, smg_real *mem, size_t size) {
  smg_real *next = smg_line_from(mem) + size;
  s->w = mem;
  s->row_w = smg_place_slots(&next, size);
  s->row_compensation = smg_place_slots(&next, size);
  return next;
}

/* Numbers that tables take: of neighbours, of a lattice in blocks; of what differs from site to site; of many kinds of
 * rows, with the norms beside each place. */
static inline size_t smg_place_tables(smg_state *s, smg_real *mem) {
  smg_blocks blocks = {{0}, {0}, {0}};
  const int there = smg_in_blocks(&s->c, &blocks);
  size_t used = there ? smg_beside_size(&s->c) : 0;
  s->row_beside = there && mem ? (smg_slot_beside *)(void *)mem : NULL;
#if SMG_SITE_VALUES
  s->row_values = mem ? smg_line_from(mem + used) + SMG_BEFORE : NULL;
  used += SMG_WIDEST + (size_t)(SMG_SITE_VALUES * smg_pitch(&s->c));
#endif
#if SMG_MANY_KINDS
  s->row_kinds = mem ? smg_line_from(mem + used) : NULL;
  used += SMG_WIDEST + (size_t)smg_kinds_size() + SMG_BESIDE_NORMS * SMG_PLACES * (SMG_BESIDES + 1);
#endif
  return used;
}

/* Nothing is lost to rounding: in empty slots nothing ever is. */
static inline void smg_forget_rows(const smg_state *s) {
#if SMG_IN_PARTS
  smg_clear_slots(&s->c, s->row_compensation, smg_pitch(&s->c), 0, SMG_COLOURS);
#else
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  for (int k = 0; k < 3; ++k) smg_zero(s->row_compensation + k * pitch, slots);
#endif
}

/* What is in them. */
static inline void smg_fill_tables(smg_state *s) {
  smg_blocks blocks = {{0}, {0}, {0}};
  if (smg_in_blocks(&s->c, &blocks)) smg_fill_beside(&s->c, &blocks, s->row_beside);
#if SMG_SITE_VALUES
  smg_fill_values(s);
#endif
}

/* The blocks of a state, or NULL. */
static inline const smg_blocks *smg_blocks_of(const smg_state *s, smg_blocks *b) {
  if (s->row_beside) smg_find_blocks(&s->c, b);
  return s->row_beside ? b : NULL;
}

/* w into slots, where it is not there yet, and back; empty ones hold a spin that nothing turns, or the vector 0 where a
 * torque would turn that, or radii differ. */
static void smg_enter_rows(smg_state *s) {
  const int64_t pitch = smg_pitch(&s->c);
  if (!s->row_kept) {
    smg_put_absent(s, 1);
    smg_hold_layers(&s->c);
    SMG_COLOURS_AT_ONCE(colour, n, 0) SMG_STRIPS(&s->c, k) {
      const smg_share part = smg_strip_of_rank(&s->c, colour, n, k);
      for (int64_t slot = part.from; slot < part.to; ++slot)
        s->row_w[2 * pitch + slot] = SMG_PUSHES || SMG_RADII ? 0 : smg_radius(&s->c, 0);
    }
    smg_to_slots(s, s->w, s->row_w);
    smg_carry_w(s, SMG_TO_BLOCKS);
  }
  smg_release_other(s);
}

/* All kinds at once, where several threads read them. */
static inline void smg_know_besides(const smg_coefficients *c, smg_besides *all) {
  const int64_t length = smg_row_length(c);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (smg_lattice_row at = smg_row_of(c, colour, 0); at.rank < SMG_RANKS; smg_next_row(c, length, &at))
      smg_besides_of(c, &at, all);
}

/* What stands beside the sites. */
static void smg_know_rows(const smg_state *s, smg_besides *known) {
  smg_blocks found;
  const smg_blocks *blocks = smg_blocks_of(s, &found);
  smg_forget_besides(&s->c, SMG_KINDS_OF(s), known);
  known->beside = s->row_beside;
#if SMG_SITE_VALUES
  known->values = s->row_values;
#endif
  if (blocks) smg_order_lanes(blocks, known->order);
}

/* Threads, and w into slots. */
static void smg_begin_team(smg_state *s, smg_besides *known) {
  s->row_team = smg_row_team(&s->c);
  if (s->row_team > 1 && !s->row_beside) smg_know_besides(&s->c, known);
  smg_enter_rows(s);
}

/* A call of some steps begins, of all ranks. */
static void smg_begin_call(smg_state *s, smg_besides *known) {
  smg_know_rows(s, known);
  smg_begin_ranks(s, known);
  smg_move_saved(s, SMG_DROPPED);
  smg_begin_team(s, known);
}
static void smg_leave_rows(smg_state *s) {
  smg_release_other(s);
  smg_carry_w(s, SMG_TO_LAYERS);
  smg_to_sites(s, s->row_w, s->w);
  smg_carry_w(s, SMG_DROPPED);
  smg_put_absent(s, 0);
  smg_share_ends(&s->c, s->w);
#if !SMG_THERMAL /* which turns w between steps */
  s->row_kept = 1;
#endif
}

#endif
