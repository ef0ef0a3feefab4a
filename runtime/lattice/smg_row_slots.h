/* smidgen runtime: vectors carried between arrays by sites and arrays by slots (smg_rows.h). */
#ifndef SMG_ROW_SLOTS_H
#define SMG_ROW_SLOTS_H

#include "smg_row_blocks.h"
#include "smg_row_ranks.h"

/* The first number from p on that begins a line of the cache. */
static inline smg_real *smg_line_from(smg_real *p) {
  const uintptr_t line = SMG_WIDEST * sizeof(double), off = (uintptr_t)p % line;
  return off > 0 ? p + (line - off) / sizeof(smg_real) : p;
}

/* A visit of all sites: their number and their slot. */
typedef void smg_slot_visit(void *context, int64_t site, int64_t slot);
SMG_INLINE void smg_each_slot(const smg_coefficients *c, void *context, smg_slot_visit *visit) {
#if SMG_IN_PARTS
  smg_each_own_slot(c, context, visit);
#else
  const int64_t length = smg_row_length(c);
  smg_blocks blocks = {{0}, {0}, {0}};
  if (smg_in_blocks(c, &blocks)) {
    smg_each_in_blocks(c, &blocks, context, visit);
    return;
  }
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (smg_lattice_row at = smg_row_of(c, colour, 0); at.rank < SMG_RANKS; smg_next_row(c, length, &at)) {
      const int64_t cell = ((at.s3 * smg_cells(c, 2) + at.s2) * smg_cells(c, 1) + at.s1) * smg_cells(c, 0) + at.first,
                    site = smg_numbered_site(c, cell, at.sub), sites = at.sites, start = at.start;
      for (int64_t j = 0; j < sites; ++j) visit(context, site + SMG_ROW_STEP * SMG_HOME_PLACES * j, start + j);
    }
#endif
}

#if SMG_SITE_VALUES
/* The numbers of sites, by slots. */
SMG_INLINE void smg_put_values(void *context, int64_t site, int64_t slot) {
  const smg_state *s = (const smg_state *)context;
  for (int64_t n = 0; n < SMG_SITE_VALUES; ++n)
    s->row_values[n * smg_pitch(&s->c) + slot] = smg_site_value(&s->c, n, site);
}
static void smg_fill_values(smg_state *s) {
#if SMG_RADII /* of empty slots 1 */
  for (int64_t slot = 0; slot < smg_slots(&s->c); ++slot) s->row_values[SMG_RADIUS_AT * smg_pitch(&s->c) + slot] = 1;
#endif
#if SMG_LAYERS_APART
  smg_each_slot_of_block(&s->c, s, smg_put_values);
#else
  smg_each_slot(&s->c, s, smg_put_values);
#endif
}
#endif

/* Vectors between an array by sites and one by slots: from one to the other. */
typedef struct smg_carried {
  const smg_real *from;
  smg_real *to;
  int64_t pitch, first, end; /* of the slots; lower ones have none, and others are left as they are */
} smg_carried;

SMG_INLINE void smg_site_to_slot(void *context, int64_t site, int64_t slot) {
  const smg_carried *a = (const smg_carried *)context;
  for (int k = 0; k < 3 && slot >= a->first && slot < a->end; ++k)
    a->to[k * a->pitch + slot - a->first] = a->from[3 * site + k];
}
SMG_INLINE void smg_slot_to_site(void *context, int64_t site, int64_t slot) {
  const smg_carried *a = (const smg_carried *)context;
  for (int k = 0; k < 3 && slot < a->end; ++k)
    a->to[3 * site + k] = slot >= a->first ? a->from[k * a->pitch + slot - a->first] : 0;
}

static void smg_to_slots(const smg_state *s, const smg_real *sites, smg_real *slots) {
  smg_carried all = {sites, slots, smg_pitch(&s->c), 0, INT64_MAX};
  smg_each_slot(&s->c, &all, smg_site_to_slot);
}
static void smg_to_sites(const smg_state *s, const smg_real *slots, smg_real *sites) {
  smg_carried all = {slots, sites, smg_pitch(&s->c), 0, INT64_MAX};
  smg_each_slot(&s->c, &all, smg_slot_to_site);
}

#endif
