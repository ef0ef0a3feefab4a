/* smidgen method: the right-hand side by rows of a lattice (smg_rows.h), sites in the lanes of vectors, for methods
 * that ask for nothing else: smg_dop853.h, smg_dormand_prince.h and smg_extrapolation.h, where SMG_ROW_FIELDS says so.
 *
 * Their vectors hold slots, all x, all y and all z; what they do to numbers one by one they do to slots as well, empty
 * ones included, which nothing moves. Spins go into slots when a call begins, and back when it ends. */
#ifndef SMG_FIELD_ROWS_H
#define SMG_FIELD_ROWS_H

#include "smg_lane_respond.h"
#include "smg_row_piece.h"
#include "smg_row_slots.h"
#include "smg_state.h"

/* Numbers of an array of n of them a slot; of a vector. */
static inline int64_t smg_slot_numbers(const smg_coefficients *c, int64_t n) { return SMG_WIDEST + n * smg_pitch(c); }
SMG_INLINE int64_t smg_numbers(const smg_state *s) { return smg_array_size(&s->c); }

/* The i-th vector of an array; w, and what it has lost to rounding, during a call. */
static inline smg_real *smg_vector_of(const smg_state *s, smg_real *array, int64_t i) {
  return smg_line_from(array) + i * smg_numbers(s);
}
static inline smg_real *smg_spins(const smg_state *s) { return smg_vector_of(s, s->row_spins, 0); }
static inline smg_real *smg_spins_lost(const smg_state *s) { return smg_vector_of(s, s->row_spins, 1); }

/* What the right-hand side works with: w and k from slot 0 on; p/kappa; the response. */
typedef struct smg_field_work {
  const smg_real *w;
  smg_real *k, rate;
  int64_t pitch;
  smg_told told;
#if SMG_LAW_BY_SITE
  const smg_real *values; /* of sites, by slots */
#endif
} smg_field_work;

/* k of the slots of one vector, `in` of them sites, whose gradient is g. */
SMG_INLINE void smg_field_slots(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  const smg_field_work *a = (const smg_field_work *)context;
  smg_lanes w[3], k[3], room[3];
  smg_take_slots(a->w, a->pitch, slot, w);
#if SMG_LAW_BY_SITE
  const smg_told told = smg_told_of_slots(a->told, a->values + slot, a->pitch);
  smg_lane_cross(k, w, smg_lane_respond(&told, w, g, room));
#else
  smg_lane_cross(k, w, smg_lane_respond(&a->told, w, g, room));
#endif
  smg_lane_scale(k, smg_lane_of(a->rate), 3);
  smg_first_lanes(in, k);
  smg_put_slots(a->k, a->pitch, slot, k);
}

/* k = p f of every site, p the part `size` of h. */
static void smg_slopes_at(smg_state *s, smg_real size, const smg_real *w, smg_real *k) {
  const smg_coefficients *c = &s->c;
  smg_field_work a = {
    w + SMG_BEFORE,
    k + SMG_BEFORE,
    smg_h_over_kappa(c, 0, c->h * size),
    smg_pitch(c),
    smg_told_of(c, 0),
#if SMG_LAW_BY_SITE
    s->row_values,
#endif
  };
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    smg_each_vector(c, (smg_besides *)s->row_known, a.w, colour, smg_colours_from(c, colour, 1), &a, smg_field_slots);
}

/* The largest number of a vector, or one that is none. */
static smg_real smg_largest_number(const smg_state *s, const smg_real *v) {
  smg_lanes most = {0};
  for (int64_t q = 0; q < smg_numbers(s); q += SMG_LANES) most = smg_lane_max(most, smg_lane_abs(smg_lane_take(v + q)));
  return smg_lane_largest(most);
}

/* The site at a slot, or -1. */
typedef struct smg_slot_search {
  int64_t slot, site;
} smg_slot_search;

SMG_INLINE void smg_look_at_slot(void *context, int64_t site, int64_t slot) {
  smg_slot_search *a = (smg_slot_search *)context;
  if (slot == a->slot) a->site = site;
}
static int64_t smg_site_at(const smg_state *s, int64_t slot) {
  smg_slot_search a = {slot, -1};
  smg_each_slot(&s->c, &a, smg_look_at_slot);
  return a.site;
}

/* A site with numbers of a vector that are none, or -1. */
static int64_t smg_lost_in(const smg_state *s, const smg_real *v) {
  int64_t q = 0;
  if (smg_largest_number(s, v) <= SMG_MAX) return -1;
  while (smg_abs(v[q]) <= SMG_MAX) ++q;
  return smg_site_at(s, q % smg_pitch(&s->c) - SMG_BEFORE);
}

/* A call of some steps begins, and ends. */
static void smg_enter_fields(smg_state *s, smg_besides *known) {
  const int64_t pitch = smg_pitch(&s->c);
  smg_real *w = smg_spins(s) + SMG_BEFORE;
  smg_forget_besides(&s->c, SMG_KINDS_OF(s), known);
  s->row_known = known;
#if SMG_SITE_VALUES
  known->values = s->row_values = smg_vector_of(s, s->row_spins, 2) + SMG_BEFORE;
  smg_fill_values(s);
#endif
  for (int64_t slot = 0; slot < smg_slots(&s->c); ++slot) w[2 * pitch + slot] = SMG_PUSHES ? 0 : smg_radius(&s->c, 0);
  smg_put_absent(s, 1);
  smg_to_slots(s, s->w, w);
  smg_to_slots(s, s->compensation, smg_spins_lost(s) + SMG_BEFORE);
}
static void smg_leave_fields(smg_state *s) {
  smg_to_sites(s, smg_spins(s) + SMG_BEFORE, s->w);
  smg_put_absent(s, 0);
  smg_to_sites(s, smg_spins_lost(s) + SMG_BEFORE, s->compensation);
  s->row_known = NULL;
}

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_one_step(smg_state *s);
static smg_status smg_field_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_besides known;
  smg_enter_fields(s, &known);
  for (; count > 0 && status == SMG_OK; --count) status = smg_one_step(s);
  smg_leave_fields(s);
  return status;
}

#endif
