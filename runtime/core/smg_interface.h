/* smidgen runtime: the functions that every model has, under their public names: SMG_PUBLIC(word) is <model>_<word>.
 *
 * The header of the model declares them and says what they do. */
#ifndef SMG_INTERFACE_H
#define SMG_INTERFACE_H

#include "smg_saved.h"
#include "smg_sum.h"

/* What the value of a sum over terms begins with: its coefficients c and the sum. */
#define SMG_BEGIN_SUM(model, t)                        \
  smg_coefficients k;                                  \
  const smg_coefficients *c = smg_begin(&k, model, t); \
  smg_sum sum = SMG_NO_SUM

#if SMG_UNIT != 2
smg_status SMG_PUBLIC(model_init)(smg_model *model, const smg_params *p) { return smg_make_model(model, p, NULL); }
smg_status SMG_PUBLIC(set_parameters)(smg_model *model, const smg_params *p) { return smg_set_parameters(model, p); }
int64_t SMG_PUBLIC(sites)(const smg_model *model) { return smg_sites_of(model); }
size_t SMG_PUBLIC(memsize)(const smg_model *model) { return smg_memory(model); }

smg_status SMG_PUBLIC(init)(smg_state *s, const smg_model *model, void *mem, const smg_real *w, double t0, double h) {
  return smg_begin_state(s, model, mem, w, t0, h);
}

smg_status SMG_PUBLIC(set_tolerance)(smg_state *s, double tolerance) { return smg_set_tolerance(s, tolerance); }
smg_status SMG_PUBLIC(steps)(smg_state *s, int64_t count) {
  return smg_is_ready(s) ? smg_steps(s, count) : s->report.status;
}
smg_status SMG_PUBLIC(step)(smg_state *s) { return SMG_PUBLIC(steps)(s, 1); }
#if SMG_THERMAL
void SMG_PUBLIC(set_seed)(smg_state *s, uint64_t seed, uint32_t member) { smg_set_seed(s, seed, member); }
#endif
smg_status SMG_PUBLIC(set_state)(smg_state *s, const smg_real *w) { return smg_set_state(s, w); }
double SMG_PUBLIC(time)(const smg_state *s) { return s->t0 + (double)s->count * s->h; }

size_t SMG_PUBLIC(savesize)(const smg_model *model) {
  smg_coefficients c;
  return smg_saved_size(smg_begin(&c, model, 0));
}
void SMG_PUBLIC(save)(const smg_state *s, smg_real *out) {
  if (!s->w || s->version == SMG_REFUSED) out[SMG_SAVED_SIZE] = 0; /* which restore refuses */
  else {
    smg_choose_own(&s->c);
    smg_move_saved(s, SMG_TO_LAYERS);
    smg_save_state(s, out);
  }
}
smg_status SMG_PUBLIC(restore)(smg_state *s, const smg_real *in) {
  smg_choose_own(&s->c);
  return smg_restore_state(s, in);
}

/* b = (1/kappa) dH/dw. */
void SMG_PUBLIC(field)(const smg_model *model, smg_real t, const smg_real *w, smg_real *b) {
  smg_coefficients c;
  smg_begin(&c, model, t);
  smg_zero(b, 3 * smg_sites(&c));
#if SMG_TORQUES
  (void)smg_gradient; /* methods may ask for that of coupled sites alone */
  smg_energy_gradient(&c, w, b);
#else
  smg_gradient(&c, w, b);
#endif
  for (int64_t k = 0; k < smg_sites(&c); ++k) smg_divide(b + 3 * k, smg_kappa(&c, k), 3);
}

/* sum of kappa w over each family: SMG_FAMILIES of them, the f-th ending before the site smg_family_end(c, f). */
void SMG_PUBLIC(momentum)(const smg_model *model, const smg_real *w, smg_real *out) {
  smg_coefficients c;
  int64_t first = 0;
  smg_begin(&c, model, 0);
  for (int f = 0; f < SMG_FAMILIES; ++f) {
    for (int b = 0; b < 3; ++b) {
      const int64_t end = smg_family_end(&c, f);
      smg_sum sum = SMG_NO_SUM;
      smg_sum_go_on(&sum);
      for (int64_t from = smg_part_begin(first, 1); from < smg_part_end(end, 1); from += SMG_HELD) {
        smg_real *held = smg_sum_room(&sum, smg_held_end(from, smg_part_end(end, 1)) - from);
        for (int64_t k = from; k < smg_held_end(from, smg_part_end(end, 1)); ++k)
          held[k - from] = smg_present(&c, k) * smg_kappa(&c, k) * w[3 * k + b];
      }
      out[3 * f + b] = smg_sum_of_ranks(&sum);
    }
    first = smg_family_end(&c, f);
  }
}

/* |w|^2, or C(w) of a Nambu site. */
void SMG_PUBLIC(casimirs)(const smg_model *model, const smg_real *w, smg_real *out) {
  smg_coefficients c;
  smg_begin(&c, model, 0);
  for (int64_t k = 0; k < smg_sites(&c); ++k) out[k] = smg_present(&c, k) * smg_casimir(&c, k, w + 3 * k);
}
#endif

#endif
