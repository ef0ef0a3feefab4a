/* smidgen runtime: the functions that every model has, under their public names: SMG_PUBLIC(word) is <model>_<word>.
 *
 * The header of the model declares them and says what they do. */
#ifndef SMG_INTERFACE_H
#define SMG_INTERFACE_H

#include "smg_saved.h"

smg_status SMG_PUBLIC(check)(const smg_params *p) { return smg_check_params(p); }
int64_t SMG_PUBLIC(sites)(const smg_params *p) { return smg_sites_of(p); }
size_t SMG_PUBLIC(memsize)(const smg_params *p) { return smg_memory(p); }

smg_status SMG_PUBLIC(init)(smg_state *s, const smg_params *p, void *mem, const smg_real *w, double t0, double h) {
  return smg_begin_state(s, p, mem, w, t0, h);
}

smg_status SMG_PUBLIC(set_tolerance)(smg_state *s, double tolerance) { return smg_set_tolerance(s, tolerance); }
#if SMG_THERMAL
smg_status SMG_PUBLIC(step)(smg_state *s) { return smg_steps(s, 1); }
void SMG_PUBLIC(set_seed)(smg_state *s, uint64_t seed, uint32_t member) { smg_set_seed(s, seed, member); }
#else
smg_status SMG_PUBLIC(step)(smg_state *s) { return smg_step(s); }
#endif
smg_status SMG_PUBLIC(steps)(smg_state *s, int64_t count) { return smg_steps(s, count); }
smg_status SMG_PUBLIC(set_state)(smg_state *s, const smg_real *w) { return smg_set_state(s, w); }
double SMG_PUBLIC(time)(const smg_state *s) { return s->t0 + (double)s->count * s->h; }

size_t SMG_PUBLIC(savesize)(const smg_params *p) { return smg_saved_size(p); }
void SMG_PUBLIC(save)(const smg_state *s, smg_real *out) { smg_save_state(s, out); }
smg_status SMG_PUBLIC(restore)(smg_state *s, const smg_real *in) { return smg_restore_state(s, in); }

void SMG_PUBLIC(field)(const smg_params *p, smg_real t, const smg_real *w, smg_real *b) { smg_field_of(p, t, w, b); }
void SMG_PUBLIC(momentum)(const smg_params *p, const smg_real *w, smg_real *out) { smg_momentum_of(p, w, out); }
void SMG_PUBLIC(casimirs)(const smg_params *p, const smg_real *w, smg_real *out) { smg_casimirs_of(p, w, out); }

#endif
