/* smidgen runtime: the functions of a model that smg_plain.h has not, for editors (smg_stub_model.h). */
#ifndef SMG_STUB_FUNCTIONS_H
#define SMG_STUB_FUNCTIONS_H

#include "smg_lane_vec.h"
#include "smg_model.h"
#include "smg_stub_template.h"

#include "smg_in_lanes.h"
#include "smg_stub_template.h"
#include "smg_in_numbers.h"

void smg_sizes(smg_model *model, const smg_params *p);
smg_status smg_check_sizes(const smg_model *model);
int smg_same_sizes(const smg_model *model, const smg_model *other);
void smg_hessian_blocks(const smg_state *s);
void smg_hessian_vector(const smg_state *s);
void smg_gather(const smg_coefficients *c, smg_lattice_site at, const smg_real *all, const smg_real *own, smg_real *g);
void smg_site_hessian_vector(const smg_coefficients *c, smg_lattice_site at, const smg_real *all, const smg_real *own,
                             const smg_real *v, smg_real *y);
void smg_each(const smg_coefficients *c, void *context, void (*visit)(void *context, smg_lattice_site at));
void smg_each_coloured(const smg_coefficients *c, void *context, void (*visit)(void *context, smg_lattice_site at));
smg_real smg_hessian_row_norm(const smg_coefficients *c, int64_t k);
smg_real smg_diffusion(const smg_coefficients *c, int64_t k);
smg_real smg_slope_bound(const smg_coefficients *c, smg_real size);
smg_lanes smg_lane_bond_slope(const smg_coefficients *c, int64_t term, smg_lanes product);
void smg_lane_fill(smg_lane_coefficients *to, int l, const smg_coefficients *c);
void smg_lane_spread(smg_lane_coefficients *to, const smg_coefficients *c);

/* What a method gives. */
#ifdef SMG_LANE_BATCH_H
#define SMG_GROUPS 1
enum { SMG_TIMES = 1, SMG_TABLES = 1 };

typedef struct smg_group {
  smg_lanes w[3], compensation[3];
  smg_lane_mask live, began;
  smg_state *state[SMG_LANES];
  const smg_lane_coefficients *c;
  int64_t taken;
} smg_group;

smg_status smg_step(smg_state *s);
#endif
#if defined(SMG_DOP853_TABLE_H) && !defined(SMG_DOP853_TRIAL_H)
typedef smg_state smg_trial;
smg_real *smg_vector(const smg_trial *f, int i);
int64_t smg_width(const smg_trial *f);
void smg_trial_slope(smg_trial *f, smg_real part, smg_real size, const smg_real *z, smg_real *k);
#endif
#if defined(SMG_TABLEAU_H) && !defined(SMG_EXTRAPOLATION_H)
typedef smg_state smg_tableau_field;
const smg_coefficients *smg_tableau_at(smg_tableau_field *f, int j, int m);
#endif

#endif
