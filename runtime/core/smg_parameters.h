/* smidgen runtime: a model from its parameters, and other parameters for a model that states have.
 *
 * The model gives smg_sizes(model, p), smg_check_sizes(model), smg_same_sizes(model, other), smg_prepare(model). States
 * share a model and never write to it. */
#ifndef SMG_PARAMETERS_H
#define SMG_PARAMETERS_H

#include "smg_leaf.h"

/* The coefficients of a call that has no state, at the time t. */
static const smg_coefficients *smg_begin(smg_coefficients *c, const smg_model *model, smg_real t) {
  c->model = model;
#if SMG_SITE_NUMBERS
  c->of_sites = NULL;
#endif
  smg_set_step(c, 0);
  smg_set_time(c, t);
  return c;
}

/* Strengths and radii that no step could use, sites of which none is there, and radii other than `before`, where that
 * is not NULL. */
static smg_status smg_check_sites(const smg_coefficients *c, const smg_coefficients *before) {
  int there = 0;
  for (int64_t k = 0; k < smg_sites(c); ++k) {
    there |= smg_present(c, k) > 0;
    const smg_real kappa = smg_kappa(c, k);
    if (!(kappa != 0) || !(SMG_MATH(fabs)(kappa) <= SMG_MAX)) return SMG_BAD_PARAMETER;
#if SMG_THERMAL
    const smg_real diffusion = smg_diffusion(c, k);
    if (!(diffusion >= 0 && diffusion <= SMG_MAX)) return SMG_BAD_PARAMETER;
#endif
    if (smg_kind(c, k) != SMG_SPHERE) continue;
    const smg_real radius = smg_radius(c, k);
    if (!(radius > 0 && radius <= SMG_MAX)) return SMG_BAD_PARAMETER;
    if (before && !(radius == smg_radius(before, k))) return SMG_BAD_PARAMETER;
  }
  return there ? SMG_OK : SMG_BAD_PARAMETER;
}

/* The parameters, with what they alone decide; in place of those of a model that states have, where `before` is not
 * NULL: sizes and radii stay, for states of others are other states. */
static smg_status smg_make_model(smg_model *model, const smg_params *p, const smg_model *before) {
  smg_coefficients c, old;
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
