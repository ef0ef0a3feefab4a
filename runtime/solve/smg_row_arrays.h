/* smidgen runtime: the arrays by slots of a state whose steps go by rows, w between them and the sites, and how strong fields are. */
#ifndef SMG_ROW_ARRAYS_H
#define SMG_ROW_ARRAYS_H

#include "smg_row_slots.h"

/* x^2 (B r + F0)^2, a bound on |g|^2, g = (h/2kappa) dH/dw: x = |h/2kappa|, B a bound on the norms of the Hessian in a row, F0 of the field of no spins. */
static inline smg_real smg_row_field(const smg_coefficients *c, smg_real h) {
  const smg_real g = smg_abs((smg_real)0.5 * smg_h_over_kappa(c, 0, h)) * (smg_hessian_row_norm(c, 0) * smg_radius(c, 0) + smg_rest_field_norm(c, 0));
  return g * g;
}

/* An array by slots, from *next on. */
static inline smg_real *smg_place_slots(smg_real **next, size_t size) {
  smg_real *first = *next + SMG_BEFORE;
  *next += size;
  return first;
}

/* Empty slots at the ends of rows hold a spin that nothing turns; those at the end of a colour have increments 0. */
static void smg_fill_empty_slots(const smg_state *s) {
  const smg_coefficients *c = &s->c;
  const int64_t length = smg_row_length(c), pitch = smg_pitch(c);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    for (smg_lattice_row at = smg_first_row(c, colour); at.rank < SMG_RANKS; smg_next_row(c, length, &at))
      for (int64_t k = at.sites; k < length; ++k) s->row_w[2 * pitch + at.start + k] = smg_radius(c, 0);
    for (int64_t k = smg_rows(c) * length; k < smg_colour_slots(c); ++k)
      for (int b = 0; b < 3; ++b) s->row_u[b * pitch + colour * smg_colour_slots(c) + k] = 0;
  }
}

/* w into slots, and back. */
static void smg_enter_rows(smg_state *s) {
  smg_to_slots(s, s->w, s->row_w);
  smg_fill_empty_slots(s);
}
static void smg_leave_rows(smg_state *s) { smg_to_sites(s, s->row_w, s->w); }

#endif
