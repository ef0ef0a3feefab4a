/* smidgen runtime: which steps of a lattice go by rows in lanes (smg_row_step.h), and the arrays of such a state.
 *
 * One spin in the field g = (h/2kappa) F of its neighbours has the midpoint m with rho m - m x g = w (smg_spin.h), and
 * a change of g moves m by at most 1/sqrt(rho^2 + (m.g)^2) <= 1/sqrt(1 - |g|^2) of it. With B a bound on the norms of
 * the Hessian in a row, F0 of the field of no spins and x = |h/2kappa|, |g| <= x (B r + F0), so all spins at once are a
 * contraction of the product of spheres by
 *
 *     x B r / sqrt(1 - x^2 (B r + F0)^2).
 *
 * and of spins with a response sqrt(f^2 + r^2 q^2) times that (smg_row_field.h). Of the classical midpoint, where rho =
 * 1, a change of g moves m by at most |m| <= r times it.
 *
 * Where that is below 1, for this h and so for all smaller ones, there is one solution; it moves continuously from W =
 * w at h = 0, and sweeps find it. Neither a branch is to be checked nor a matrix needed: such a state keeps its rows
 * alone. */
#ifndef SMG_ROW_STATE_H
#define SMG_ROW_STATE_H

#include "smg_row_arrays.h"
#include "smg_row_field.h"
#include "smg_row_ranks.h"
#include "smg_state.h"

/* of that factor */
#ifndef SMG_ROW_BOUND
#define SMG_ROW_BOUND (smg_real)0.9
#endif
/* of the factor of the sweeps that have found a solution, at that solution (smg_row_beyond.h) */
#define SMG_ROW_SHOWN (smg_real)0.95
/* parts of h whose midpoints extrapolate those of the next one (smg_row_follow.h), and arrays that this takes: what
 * they foresee, and midpoints that have been found, are two more */
#define SMG_PATH_POINTS 3
#define SMG_PATH_ARRAYS 5
/* |g|^2 from which the first sweep finds rho by its root: below, rho >= 0.95 and one correction leaves 1 % of its
 * error. */
#define SMG_ROW_STRONG (smg_real)0.1
/* |g|^2 up to which |v|^2/r^2 is within 0.0215 of 1, with what a rho off by 1e-4 adds: smg_lane_inverse_root_near_1, to
 * the digits of double. */
#define SMG_ROW_WEAK (SMG_EPS < (smg_real)1e-16 ? 0 : (smg_real)0.0104)
/* increments kept: with them a spin has at most 160 bytes beside tables, 216 where all colours keep them; of
 * compositions those of all stages that their predictor looks back on, with spare arrays for a step that fails */
#if SMG_COMPOSED
#define SMG_ROW_HISTORY SMG_HISTORY
#define SMG_ROW_SPARE (SMG_COMPOSED < SMG_HISTORY ? SMG_COMPOSED : SMG_HISTORY)
/* w before the step, what the predictor has missed, and the increments of all stages for the tangent map */
#define SMG_ROW_HELD(size) ((2 + SMG_COMPOSED * SMG_TANGENT) * (size) + SMG_WIDEST)
#else
#define SMG_ROW_HISTORY (SMG_COLOURS <= 2 ? 5 : 4)
#define SMG_ROW_SPARE 0
#define SMG_ROW_HELD(size) 0
#endif
/* The pitches of the arrays of slots before the first one that increments are kept of, and from it on. */
#define SMG_FIRST_PITCH(c) (SMG_KEPT_FROM(c) + SMG_BEFORE + SMG_AFTER)
#define SMG_LATE_PITCH(c) (smg_slots(c) - SMG_KEPT_FROM(c) + SMG_BEFORE + SMG_AFTER)

/* What is known of the passes of each stage; the array that a stage adds the increments before it to: in the second
 * one of a step to that of its start, which is kept. */
#if SMG_COMPOSED
#define SMG_OF_STAGE(s, member) (s)->member[(s)->stage]
#define SMG_ROW_FROM(s, array) ((s)->stage == 1 ? (s)->array##_before : (s)->array)
#else
#define SMG_OF_STAGE(s, member) (s)->member
#define SMG_ROW_FROM(s, array) (s)->array
#endif

/* The size of the largest stage. */
static inline smg_real smg_largest_stage(const smg_state *s) {
  smg_real most = smg_signed_h(s->h);
#if SMG_COMPOSED
  smg_real part = 0;
  for (int i = 0; i < SMG_COMPOSED; ++i) smg_take(&part, smg_abs(smg_gamma[i]));
  most *= part;
#endif
  return most;
}

/* That factor, or SMG_MAX. */
static inline smg_real smg_row_factor(const smg_coefficients *c, smg_real h) {
  const smg_real field = smg_row_field(c, h), x = smg_abs((smg_real)0.5 * smg_h_over_kappa(c, 0, h));
  return field < 1 ? x * smg_at_all_sites(c, SMG_HESSIAN_EVER) * smg_at_all_sites(c, smg_radius) * smg_row_gain(c) /
                         SMG_MATH(sqrt)(1 - field)
                   : SMG_MAX;
}

/* What an error of midpoints leaves, at most, beside the change of the next sweep: 2 (q + q^2 + ..), as W is
 * 2 mbar - w. */
static inline smg_real smg_left_by_sweeps(const smg_state *s) {
  const smg_real factor = smg_min(s->row_bound, SMG_ROW_SHOWN);
  return 2 * factor / (1 - factor);
}

/* What the bounds say: of all steps, or of the next one (SMG_ROWS_IN_TIME). */
static inline void smg_weigh_rows(smg_state *s) {
  const smg_real h = smg_largest_stage(s), field = smg_row_field(&s->c, h);
  s->row_bound = smg_row_factor(&s->c, h);
  s->row_strong = field > SMG_ROW_STRONG;
  s->row_flat = 2 * (1 - field) < SMG_ROW_FLAT;
  s->row_weak = !SMG_TOLD && field <= SMG_ROW_WEAK; /* a response leaves spins of another length to turn */
  s->row_stretched = 36 * field > 1;                /* |h b| > 1/3 may be, as in smg_end_site */
}

/* Do the steps of this state go by rows? Where that depends on time, did the last one? */
static inline void smg_choose_rows(smg_state *s) {
#if SMG_ROWS_IN_TIME
  smg_set_time_at(&s->c, s, s->count > 0 ? (smg_real)-0.5 : (smg_real)0.5);
#endif
  smg_weigh_rows(s);
  s->rows = s->row_bound <= SMG_ROW_BOUND;
  s->row_from = s->row_reach = s->row_due = 0;
#if SMG_COMPOSED
  for (s->stage = SMG_COMPOSED; s->stage > 0;) {
    --s->stage;
    SMG_OF_STAGE(s, row_passes) = SMG_OF_STAGE(s, row_fewest) = SMG_OF_STAGE(s, row_near) = 0;
  }
#else
  s->row_passes = s->row_fewest = s->row_near = 0;
#endif
}

#if SMG_ROWS_IN_TIME
/* Does the next step go by rows? */
static int smg_next_by_rows(smg_state *s) {
  smg_set_time_at(&s->c, s, (smg_real)0.5);
  smg_weigh_rows(s);
  return s->row_bound <= SMG_ROW_BOUND;
}

/* The arrays that it has: where the last one had others, w alone is kept, and what the steps before have left is
 * forgotten. */
static void smg_suit_arrays(smg_state *s) {
  if (smg_next_by_rows(s) == s->rows) return;
  ++s->count; /* as that of the last step */
  smg_begin_arrays(s, s->w, 3 * smg_sites(&s->c));
  --s->count;
  s->history = 0;
  smg_blank_history(s);
}
#else
#define smg_next_by_rows(s) 1
#define smg_suit_arrays(s)
#endif

/* Their arrays. */
static inline size_t smg_row_layout(smg_state *s, smg_real *mem) {
  const size_t size = (size_t)smg_array_size(&s->c), first = (size_t)(3 * SMG_FIRST_PITCH(&s->c)),
               late = (size_t)(3 * SMG_LATE_PITCH(&s->c));
  if (mem) {
    smg_real *under = smg_line_from(mem), *next = smg_place_row_arrays(s, mem, size);
    s->row_m = smg_place_slots(&under, size); /* found anew in each call */
    s->row_u = smg_place_slots(&next, first);
#if SMG_TANGENT
    s->row_u_before = smg_place_slots(&next, first);
#endif
    s->row_late = smg_place_slots(&next, late);
    for (int j = 0; j < SMG_ROW_HISTORY; ++j) s->past[j] = smg_place_slots(&next, late);
#if SMG_COMPOSED
    for (int j = 0; j < SMG_ROW_SPARE; ++j) s->spare[j] = smg_place_slots(&next, late);
    s->row_w_before = smg_place_slots(&next, size);
    s->row_compensation_before = smg_place_slots(&next, size);
#if SMG_TANGENT
    for (int i = 0; i < SMG_COMPOSED; ++i) s->row_increments[i] = smg_place_slots(&next, size);
#endif
    s->misses = next;
#endif
  }
  const size_t used = SMG_WIDEST + 3 * size + (1 + SMG_TANGENT) * first + (SMG_ROW_HISTORY + SMG_ROW_SPARE + 1) * late +
                      SMG_ROW_HELD(size);
  return used + smg_place_tables(s, mem ? mem + used : NULL);
}

#if SMG_LAYERS_APART
static void smg_move_saved(const smg_state *s, enum smg_carried_where where) {
  smg_carry_saved(s, SMG_ROW_HISTORY, SMG_LATE_PITCH(&s->c), where);
}
#endif
#if SMG_IN_PARTS
/* This rank's part of all arrays but that of w and midpoints. */
static void smg_clear_rows(const smg_state *s) {
  smg_forget_rows(s);
  smg_clear_slots(&s->c, s->row_w, smg_pitch(&s->c), 0, SMG_COLOURS);
  const int64_t kept = SMG_FIRST_KEPT(&s->c), late = SMG_LATE_PITCH(&s->c);
  smg_clear_slots(&s->c, s->row_u, SMG_FIRST_PITCH(&s->c), 0, kept);
  smg_clear_slots(&s->c, s->row_late, late, kept, SMG_COLOURS);
  for (int j = 0; j < SMG_ROW_HISTORY; ++j) smg_clear_slots(&s->c, s->past[j], late, kept, SMG_COLOURS);
}
#endif

#if SMG_ONTO_LEAF && SMG_HAS_COUPLED
/* Those of a state that is kept by sites, for the sweeps of smg_row_beyond.h, and their number. */
static inline size_t smg_place_beyond(smg_state *s, smg_real *mem) {
  const size_t size = (size_t)smg_array_size(&s->c), first = (size_t)(3 * SMG_FIRST_PITCH(&s->c)),
               late = (size_t)(3 * SMG_LATE_PITCH(&s->c)),
               used = SMG_WIDEST + (4 + SMG_PATH_ARRAYS) * size + first + late;
  if (mem) {
    smg_real *next = smg_line_from(mem) + (1 + SMG_PATH_ARRAYS) * size;
    s->row_w = smg_place_slots(&next, size);
    s->row_compensation = smg_place_slots(&next, size);
    s->row_m = smg_place_slots(&next, size);
    s->row_u = smg_place_slots(&next, first);
    s->row_late = smg_place_slots(&next, late);
  }
  return used + smg_place_tables(s, mem ? mem + used : NULL);
}

static inline smg_real *smg_row_slopes(const smg_state *s) { return smg_line_from(s->row_beyond) + SMG_BEFORE; }
static inline smg_real *smg_paths_of(const smg_state *s) {
  return smg_line_from(s->row_beyond) + smg_array_size(&s->c); /* behind slopes and weights, a number a slot */
}

static inline size_t smg_beyond_size(const smg_coefficients *c) {
  smg_state s;
  s.c.model = c->model;
  return smg_place_beyond(&s, NULL);
}
#endif

static inline void smg_make_tables(smg_state *s) {
#if SMG_ONTO_LEAF && SMG_HAS_COUPLED
  if (!s->rows) (void)smg_place_beyond(s, s->row_beyond);
  smg_fill_tables(s);
#else
  if (s->rows) smg_fill_tables(s);
#endif
}

#if SMG_TANGENT
/* The increments of the step just taken, of all slots. */
static void smg_newest_increments(const smg_state *s, smg_real *u) {
  const int64_t first = SMG_KEPT_FROM(&s->c), pitch = smg_pitch(&s->c);
  for (int k = 0; k < 3; ++k) {
    smg_copy(u + k * pitch, s->row_u + k * SMG_FIRST_PITCH(&s->c), first);
    smg_copy(u + k * pitch + first, s->past[0] + k * SMG_LATE_PITCH(&s->c), smg_slots(&s->c) - first);
  }
}
#endif

/* What a saved state has; of the increments those of the first colour are 0, but for the newest ones where the tangent
 * map takes them. */
static void smg_save_rows(const smg_state *s, smg_real *lost, smg_real *past) {
  const int64_t n3 = 3 * smg_sites(&s->c), from = 3 * smg_own_from(&s->c), to = 3 * smg_own_to(&s->c);
  smg_gather_saved(s, SMG_ROW_HISTORY, SMG_LATE_PITCH(&s->c));
  smg_to_sites(s, s->row_compensation, lost);
  for (int j = 0; j < SMG_HISTORY; ++j) smg_zero(past + j * n3 + from, to - from);
  for (int j = 0; j < SMG_ROW_HISTORY; ++j) {
    smg_carried late = {s->past[j], past + j * n3, SMG_LATE_PITCH(&s->c), SMG_KEPT_FROM(&s->c), INT64_MAX};
    smg_each_slot(&s->c, &late, smg_slot_to_site);
  }
#if SMG_TANGENT
  smg_carried early = {s->row_u, past, SMG_FIRST_PITCH(&s->c), 0, SMG_KEPT_FROM(&s->c)};
  smg_each_slot(&s->c, &early, smg_slot_to_site);
#endif
}

static void smg_restore_rows(smg_state *s, const smg_real *lost, const smg_real *past) {
  if (s->history > SMG_ROW_HISTORY) s->history = SMG_ROW_HISTORY;
  if (s->degree >= s->history) s->degree = s->history - 1;
  smg_to_slots(s, lost, s->row_compensation);
  for (int j = 0; j < SMG_ROW_HISTORY; ++j) {
    smg_carried late = {past + 3 * smg_sites(&s->c) * j, s->past[j], SMG_LATE_PITCH(&s->c), SMG_KEPT_FROM(&s->c),
                        INT64_MAX};
    smg_each_slot(&s->c, &late, smg_site_to_slot);
  }
  smg_move_saved(s, SMG_TO_BLOCKS);
#if SMG_TANGENT
  smg_carried early = {past, s->row_u, SMG_FIRST_PITCH(&s->c), 0, SMG_KEPT_FROM(&s->c)};
  smg_each_slot(&s->c, &early, smg_site_to_slot);
#endif
}

#endif
