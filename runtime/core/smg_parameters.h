/* smidgen runtime: a model from its parameters, and other parameters for a model that states have.
 *
 * The model gives smg_sizes(model, p), smg_check_sizes(model), smg_same_sizes(model, other), smg_prepare(model). States
 * share a model and never write to it. */
#ifndef SMG_PARAMETERS_H
#define SMG_PARAMETERS_H

#include <string.h>

#include "smg_leaf.h"
#include "smg_respond.h"

/* The coefficients of a call that has no state, at the time t. */
static const smg_coefficients *smg_begin(smg_coefficients *c, const smg_model *model, smg_real t) {
  c->model = model;
#if SMG_SITE_NUMBERS
  c->of_sites = NULL;
#endif
  smg_choose_own(c);
  smg_set_step(c, 0);
  smg_set_time(c, t);
  return c;
}

/* Is it a number from 0 to SMG_MAX? */
static inline int smg_is_size(smg_real x) { return x >= 0 && x <= SMG_MAX; }

/* Can steps use the strength and the damping of a site (negative damping would heat it), and its diffusion? */
static inline int smg_site_serves(const smg_coefficients *c, int64_t k) {
#if SMG_RESPONDS
  smg_real r[SMG_RESPONSE_SIZE];
  smg_response(c, k, r);
  if (!smg_is_size(smg_kappa(c, k) > 0 ? SMG_ORIENTATION * r[1] : -SMG_ORIENTATION * r[1])) return 0;
#endif
#if SMG_THERMAL
  if (!smg_is_size(smg_diffusion(c, k))) return 0;
#endif
  return smg_kappa(c, k) != 0 && smg_is_size(smg_abs(smg_kappa(c, k)));
}

/* Is the radius of a sphere one of its kind, and that of `before`, where that is not NULL? */
static inline int smg_radius_serves(const smg_coefficients *c, const smg_coefficients *before, int64_t k) {
  return smg_radius(c, k) != 0 && smg_is_size(smg_radius(c, k)) &&
         (!before || smg_radius(c, k) == smg_radius(before, k));
}

/* Strengths, dampings and radii that no step could use, sites of which none is there, and radii other than `before`. */
static smg_status smg_check_sites(const smg_coefficients *c, const smg_coefficients *before) {
  int there = 0;
  for (int64_t k = 0; k < smg_sites(c); ++k) {
    there |= smg_present(c, k) > 0;
    if (!smg_site_serves(c, k) || (smg_kind(c, k) == SMG_SPHERE && !smg_radius_serves(c, before, k)))
      return SMG_BAD_PARAMETER;
  }
  return there ? SMG_OK : SMG_BAD_PARAMETER;
}

/* The parameters, with what they alone decide; in place of those of a model that states have, where `before` is not
 * NULL: sizes and radii stay, for states of others are other states. */
static smg_status smg_make_model(smg_model *model, const smg_params *p, const smg_model *before) {
  smg_coefficients c, old;
  if (!p) {
    memset(model, 0, sizeof *model);
    return model->status = SMG_BAD_PARAMETER;
  }
  smg_sizes(model, p);
  model->version = before ? before->version + 1 : 1;
  model->status = smg_check_sizes(model);
  if (before && (before->status != SMG_OK || !smg_same_sizes(model, before))) model->status = SMG_BAD_PARAMETER;
  if (model->status == SMG_OK && !smg_prepare(model)) model->status = SMG_NOT_FINITE;
  if (model->status == SMG_OK)
    model->status = smg_check_sites(smg_begin(&c, model, 0), before ? smg_begin(&old, before, 0) : NULL);
  return model->status;
}

/* Other parameters for all states of the model. Refused, the model is as it was. */
static inline smg_status smg_set_parameters(smg_model *model, const smg_params *p) {
  smg_model next;
  const smg_status status = smg_make_model(&next, p, model);
  if (status == SMG_OK) *model = next;
  return status;
}

#endif
