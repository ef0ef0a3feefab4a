/* smidgen runtime: a state from a model and a start. */
#ifndef SMG_STATE_H
#define SMG_STATE_H

#include <string.h>

#include "smg_parameters.h"

/* What the steps of a method are found to where nothing else is asked for; 0: to round-off. */
#ifndef SMG_TOLERANCE
#define SMG_TOLERANCE 0
#endif

/* A tolerance for the steps from now on, as part of s->scale: iterations end there, or step control aims at it; 0: the
 * method's own. What is left over is of one sign along many an orbit: energy, lengths and momenta drift by some of it a
 * step. */
static inline smg_status smg_set_tolerance(smg_state *s, double tolerance) {
  if (!(tolerance >= 0 && tolerance < 1)) return SMG_BAD_PARAMETER;
  s->tolerance = tolerance > 0 ? (smg_real)tolerance : (smg_real)SMG_TOLERANCE;
  return SMG_OK;
}

/* h with the sign of the bracket that the spec means. */
static inline smg_real smg_signed_h(double h) { return SMG_ORIENTATION * (smg_real)h; }

/* The time of `steps` steps and a part more: t0 + steps h, from the integer. */
static inline smg_real smg_time_at(const smg_state *s, smg_real part) {
  return (smg_real)s->t0 + ((smg_real)s->count + part) * (smg_real)s->h;
}

/* What depends on time, at that of a part more than the steps taken. */
static inline void smg_set_time_at(SMG_UNUSED smg_coefficients *c, SMG_UNUSED const smg_state *s,
                                   SMG_UNUSED smg_real part) {
#if SMG_TIMED
  smg_set_time(c, smg_time_at(s, part));
#endif
}

/* Are two states at the same time, with the same h? */
static inline int smg_same_times(const smg_state *a, const smg_state *b) {
  return a->count == b->count && smg_abs((smg_real)(a->t0 - b->t0)) + smg_abs((smg_real)(a->h - b->h)) <= 0;
}

/* The arrays of the state, one after the other in mem; returns how many numbers they take. */
static size_t smg_layout(smg_state *s, smg_real *mem);

/* An array of the state begins at mem + used, where there is memory; returns where the next one does. */
static inline size_t smg_place_array(smg_real **array, smg_real *mem, size_t used, size_t size) {
  *array = mem ? mem + used : NULL;
  return used + size;
}

#if SMG_BY_ROWS
/* What a lattice by rows answers; defined by smg_row_state.h, or the smg_*_state.h of an explicit method: does it go by
 * rows (s->rows)? Its tables; what its steps have lost to rounding, forgotten, saved and restored. */
static inline void smg_choose_rows(smg_state *s);
#if SMG_IN_PARTS
static void smg_clear_rows(const smg_state *s);
#endif
#if SMG_LAYERS_APART
static void smg_move_saved(const smg_state *s, enum smg_carried_where where);
/* Of which state layers are held; without them nothing can be saved. */
static const smg_state *smg_layers_held = NULL;
#endif
static inline void smg_make_tables(smg_state *s);
static inline void smg_forget_rows(const smg_state *s);
static void smg_save_rows(const smg_state *s, smg_real *lost, smg_real *past);
static void smg_restore_rows(smg_state *s, const smg_real *lost, const smg_real *past);
#endif

/* Bytes, whatever the way of its steps. */
static inline size_t smg_memory(const smg_model *model) {
  smg_state s;
  s.c.model = model;
  smg_choose_own(&s.c);
#if SMG_BY_ROWS
  s.rows = 1;
  const size_t by_rows = smg_layout(&s, NULL);
  s.rows = 0;
  if (smg_is_divided() || by_rows > smg_layout(&s, NULL)) return sizeof(smg_real) * by_rows;
#endif
  return sizeof(smg_real) * smg_layout(&s, NULL);
}

/* A time and a step. A denormal h has too few digits; noise has no step backward. */
static inline smg_status smg_check_times(double t0, double h) {
  if (!(t0 - t0 == 0 && h - h == 0)) return SMG_NOT_FINITE;
#if SMG_THERMAL
  if (h < 0) return SMG_BAD_PARAMETER;
#endif
  return h != 0 && h < DBL_MIN && h > -DBL_MIN ? SMG_BAD_PARAMETER : SMG_OK;
}

/* One site: on its sphere, to the part `off` of the radius; in R^3 of a size that can be squared; of a Nambu leaf that
 * the method projects onto, C != 0. */
static inline smg_status smg_check_site(const smg_coefficients *c, int64_t k, const smg_real *w, smg_real off) {
  const smg_real leaf = smg_leaf_value_of(c, k, w);
  if (!(smg_present(c, k) > 0)) return SMG_OK;
  if (smg_kind(c, k) == SMG_SPHERE) {
    const smg_real size = SMG_MATH(sqrt)(smg_dot(w, w));
    return size > 0 && size <= SMG_MAX && SMG_MATH(fabs)(size - leaf) <= off * leaf ? SMG_OK : SMG_OFF_MANIFOLD;
  }
  const smg_real size = smg_largest(w);
  /* w.w is no number */
  if (size > 0 && !(size >= (smg_real)1e-150 && size <= (smg_real)1e150)) return SMG_BAD_PARAMETER;
  return smg_kind(c, k) == SMG_NAMBU && SMG_ONTO_LEAF && !(leaf != 0) ? SMG_OFF_MANIFOLD : SMG_OK;
}

#define SMG_OFF_SPHERE (smg_real)1e-12 /* part of the radius by which a start may be off its sphere */

/* The part of the radius by which a site is off its sphere. */
static inline smg_real smg_off_sphere(const smg_coefficients *c, int64_t k, const smg_real *w) {
  if (smg_kind(c, k) != SMG_SPHERE) return 0;
  return SMG_MATH(fabs)(SMG_MATH(sqrt)(smg_dot(w, w)) - smg_radius(c, k)) / smg_radius(c, k);
}

/* All sites. Where `before` is not NULL they may be off their spheres by as much more as they are there. *site: the
 * first that is refused, or -1. */
static smg_status smg_check_state(const smg_coefficients *c, const smg_real *w, const smg_real *before, smg_real off,
                                  int64_t *site) {
  const int64_t first = smg_own_from(c), end = smg_own_to(c);
  for (*site = first; *site < end; ++*site)
    if (!(smg_largest(w + 3 * *site) <= SMG_MAX)) return SMG_NOT_FINITE;
  for (*site = first; *site < end; ++*site) {
    const smg_status status =
        smg_check_site(c, *site, w + 3 * *site, before ? off + smg_off_sphere(c, *site, before + 3 * *site) : off);
    if (status != SMG_OK) return status;
  }
  *site = -1;
  return SMG_OK;
}

/* Whatever is given of a site that is not there, it stands at (0, 0, r) in all states. Is it absent? */
static inline int smg_put_away(const smg_state *s, int64_t k) {
  if (smg_present(&s->c, k) > 0) return 0;
  s->w[3 * k] = s->w[3 * k + 1] = 0;
  s->w[3 * k + 2] = smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) : 1;
  return 1;
}

/* Sites that are not there: by slots 0, so that others feel nothing of them, else as smg_put_away has them. */
static inline void smg_put_absent(smg_state *s, int by_slots) {
  for (int64_t k = smg_own_from(&s->c); k < smg_own_to(&s->c); ++k)
    if (smg_put_away(s, k) && by_slots) s->w[3 * k + 2] = 0;
}

/* s->w = w, which is checked, each site on its sphere to round-off; s->scale is the largest component. */
static void smg_put_state(smg_state *s, const smg_real *w) {
  s->scale = 0;
  for (int64_t k = smg_own_from(&s->c); k < smg_own_to(&s->c); ++k) {
    if (smg_put_away(s, k)) continue;
    const smg_real leaf = smg_leaf_value_of(&s->c, k, w + 3 * k), size = SMG_MATH(sqrt)(smg_dot(w + 3 * k, w + 3 * k));
    /* given with some digits less */
    const int off = smg_kind(&s->c, k) == SMG_SPHERE && SMG_MATH(fabs)(size - leaf) > 8 * SMG_EPS * leaf;
    s->scale = smg_max(s->scale, smg_largest(w + 3 * k));
    if (off) smg_multiple(s->w + 3 * k, leaf / size, w + 3 * k, 3);
    else smg_copy(s->w + 3 * k, w + 3 * k, 3);
  }
  smg_largest_of_all(&s->scale);
  smg_share_ends(&s->c, s->w);
}

#ifndef SMG_OWN_BLANK_HISTORY
/* The history of no steps; methods that remember more than arrays have their own. */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }
#endif

/* The state before any memory is known: all that is not an array. */
static void smg_blank(smg_state *s, const smg_model *model, double t0, double h) {
  memset(s, 0, sizeof *s);
  s->c.model = model;
  s->report.status = SMG_BAD_PARAMETER;
  s->report.site = s->report.partner = -1;
  s->t0 = t0;
  s->h = h;
  s->tolerance = (smg_real)SMG_TOLERANCE;
  smg_blank_history(s);
}

/* What depends on h, of steps of this size. */
static inline void smg_set_size(smg_state *s, smg_real h) {
  smg_set_step(&s->c, h);
#if SMG_EXTENDED
  smg_wide_prepare(&s->wide, &s->c);
#endif
}

#if SMG_SITE_NUMBERS
/* What formulas have of single sites, found once. */
static void smg_fill_site_numbers(smg_state *s) {
  const int64_t sites = smg_sites(&s->c);
  for (int64_t k = 0; k < SMG_SITE_NUMBERS * sites; ++k)
    s->site_numbers[k] = smg_site_number(&s->c, k / sites, k % sites);
  s->c.of_sites = s->site_numbers;
}
#endif

#if SMG_THERMAL && SMG_ROWS_IN_TIME && !SMG_IN_PARTS
/* A step with noise may change over to other arrays: w before its noise comes along. */
static void smg_clear_arrays(smg_state *s, smg_real *mem, int64_t kept) {
  const size_t numbers = (size_t)(3 * smg_sites(&s->c));
  const smg_real *unturned = s->unturned;
  const size_t used = smg_layout(s, mem);
  if (unturned) memmove(s->unturned, unturned, numbers * sizeof *mem);
  for (smg_real *p = mem + kept; p < mem + used; ++p)
    if (p < s->unturned || p >= s->unturned + numbers) *p = 0;
}
#else
static void smg_clear_arrays(smg_state *s, smg_real *mem, int64_t kept) {
  const size_t used = smg_layout(s, mem);
#if SMG_IN_PARTS
  if (smg_is_divided()) smg_clear_rows(s);
  else
#endif
    for (size_t k = (size_t)kept; k < used; ++k) mem[k] = 0;
}
#endif

/* All that h and the parameters decide, and the arrays, empty but for tables and the first `kept` numbers; w comes
 * first. */
static void smg_begin_arrays(smg_state *s, smg_real *mem, int64_t kept) {
#if SMG_SITE_NUMBERS
  s->c.of_sites = NULL; /* those of other parameters */
#endif
  smg_set_size(s, smg_signed_h(s->h));
#if SMG_BY_ROWS
  smg_choose_rows(s);
  s->row_kept = 0;
#endif
  smg_clear_arrays(s, mem, kept);
#if SMG_BY_ROWS
  smg_make_tables(s);
#endif
#if SMG_SITE_NUMBERS
  smg_fill_site_numbers(s);
#endif
  s->version = s->c.model->version;
}

/* Steps of divided memory go by rows, or not at all. */
#if SMG_IN_PARTS
static inline int smg_may_begin(smg_state *s) {
  smg_set_size(s, smg_signed_h(s->h));
  smg_choose_rows(s);
  return s->rows || !smg_is_divided();
}
#else
#define smg_may_begin(s) 1
#endif

/* Of a state whose start was refused, in place of the version of its parameters: a step is refused as the start was,
 * until there is another w. */
#define SMG_REFUSED UINT64_MAX

static smg_status smg_begin_state(smg_state *s, const smg_model *model, void *mem, const smg_real *w, double t0,
                                  double h) {
  smg_blank(s, model, t0, h);
  s->report.status = model->status == SMG_OK ? smg_check_times(t0, h) : model->status;
  if (s->report.status != SMG_OK) return s->report.status;
  smg_choose_own(&s->c);
  s->report.status = smg_status_of_ranks(
      model->version && mem && w && smg_may_begin(s) && smg_may_cut(&s->c) ? SMG_OK : SMG_BAD_PARAMETER,
      &s->report.site);
  if (s->report.status != SMG_OK) return s->report.status;
  smg_begin_arrays(s, (smg_real *)mem, 0);
  s->report.status =
      smg_status_of_ranks(smg_check_state(&s->c, w, NULL, SMG_OFF_SPHERE, &s->report.site), &s->report.site);
  if (s->report.status == SMG_OK) smg_put_state(s, w);
  else s->version = SMG_REFUSED;
  return s->report.status;
}

static inline int64_t smg_sites_of(const smg_model *model) {
  smg_coefficients c;
  c.model = model;
  return smg_sites(&c);
}

#endif
