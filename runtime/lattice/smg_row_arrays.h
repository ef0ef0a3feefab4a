/* smidgen runtime: the arrays by slots of a state whose steps go by rows, and w between them and the sites. */
#ifndef SMG_ROW_ARRAYS_H
#define SMG_ROW_ARRAYS_H

#include "smg_row_slots.h"

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

/* Numbers that tables take: of neighbours, of a lattice in blocks; of what differs from site to site. */
static inline size_t smg_place_tables(smg_state *s, smg_real *mem) {
  smg_blocks blocks;
  const int there = smg_in_blocks(&s->c, &blocks);
  const size_t used = there ? smg_beside_size(&s->c) : 0;
  s->row_beside = there && mem ? (smg_slot_beside *)(void *)mem : NULL;
#if SMG_SITE_VALUES
  s->row_values = mem ? smg_line_from(mem + used) + SMG_BEFORE : NULL;
  return used + SMG_WIDEST + (size_t)(SMG_SITE_VALUES * smg_pitch(&s->c));
#else
  return used;
#endif
}

/* Nothing is lost to rounding: in empty slots nothing ever is. */
static inline void smg_forget_rows(const smg_state *s) {
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  for (int k = 0; k < 3; ++k)
    for (int64_t slot = 0; slot < slots; ++slot) s->row_compensation[k * pitch + slot] = 0;
}

/* What is in them. */
static inline void smg_make_tables(smg_state *s) {
  smg_blocks blocks;
  if (s->rows && smg_in_blocks(&s->c, &blocks)) smg_fill_beside(&s->c, &blocks, s->row_beside);
#if SMG_SITE_VALUES
  if (s->rows) smg_fill_values(s);
#endif
}

/* The blocks of a state, or NULL. */
static inline const smg_blocks *smg_blocks_of(const smg_state *s, smg_blocks *b) {
  if (s->row_beside) smg_find_blocks(&s->c, b);
  return s->row_beside ? b : NULL;
}

/* What stands beside the sites, for a call of some steps. */
static inline void smg_begin_besides(const smg_state *s, smg_besides *known) {
  smg_blocks found;
  const smg_blocks *blocks = smg_blocks_of(s, &found);
  smg_forget_besides(&s->c, known);
  known->beside = s->row_beside;
#if SMG_SITE_VALUES
  known->values = s->row_values;
#endif
  if (blocks) smg_order_lanes(blocks, known->order);
}

/* Empty slots at the ends of rows hold a spin that nothing turns. */
static void smg_fill_empty_slots(const smg_state *s) {
  const smg_coefficients *c = &s->c;
  const int64_t length = smg_row_length(c), pitch = smg_pitch(c);
  if (s->row_beside) return; /* none */
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (smg_lattice_row at = smg_first_row(c, colour); at.rank < SMG_RANKS; smg_next_row(c, length, &at))
      for (int64_t k = at.sites; k < length; ++k) s->row_w[2 * pitch + at.start + k] = smg_radius(c, 0);
}

/* w into slots, and back. */
static void smg_enter_rows(smg_state *s) {
  smg_to_slots(s, s->w, s->row_w);
  smg_fill_empty_slots(s);
}
static void smg_leave_rows(smg_state *s) { smg_to_sites(s, s->row_w, s->w); }

#endif
