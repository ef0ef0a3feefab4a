/* smidgen runtime: one step of all sites; it works in scratch arrays and changes the state at its end. */
#ifndef SMG_STEP_H
#define SMG_STEP_H

#if SMG_EXTENDED
#include "smg_extended.h"
#endif
#include "smg_history.h"
#include "smg_predictor.h"
#include "smg_report.h"
#include "smg_state.h"
#if SMG_BY_ROWS
#include "smg_row_step.h"
#endif
#if SMG_HAS_COUPLED
#include "smg_branch.h"
#if SMG_BY_ROWS && SMG_ONTO_LEAF
#include "smg_row_beyond.h"
#elif SMG_SWEPT
#include "smg_sweep.h"
#endif
#if SMG_FEW_IN_LANES
#include "smg_few_step.h"
#endif
#endif
#if SMG_ALONE_IN_LANES
#include "smg_alone_lanes.h"
#endif
#if SMG_HAS_ALONE
#include "smg_alone.h"
#endif

#if SMG_HAS_COUPLED
/* The coupled sites: from the extrapolated start; when that fails from rest; when that fails, or has taken all products
 * with J that it may, by following the branch. */
static smg_status smg_solve_coupled(smg_state *s, smg_real h) {
  smg_status status = SMG_OK;
#if SMG_MATRIX_FREE
  SMG_PRODUCTS_LEFT(s) = SMG_KRYLOV_A_STEP;
#endif
#if SMG_FEW_IN_LANES
  if (smg_few_iterate(s, h) == SMG_OK) return SMG_OK;
#endif
#if SMG_SWEPT
  status = smg_sweeps(s, h);
  if (status == SMG_OK) return SMG_OK;
#endif
  for (int k = 0; k < (s->degree < 0 ? 1 : 2); ++k) {
    smg_predict(s, k == 0 ? s->degree : -1);
    status = smg_newton(s, h);
    if (status == SMG_OK) return SMG_OK;
    if (status == SMG_WRONG_BRANCH) break;
  }
#if SMG_MATRIX_FREE
  if (status == SMG_SINGULAR && SMG_PRODUCTS_LEFT(s) <= 0) status = SMG_NO_CONVERGENCE;
#endif
  const smg_status followed = smg_follow_branch(s, h);
  if (!smg_curve_tells(followed) && s->report.site < 0) s->report.site = smg_worst_site(s);
  return smg_curve_tells(followed) || status == SMG_WRONG_BRANCH ? followed : status;
}
#endif

/* The step equation of all sites; the increments end up in u. */
static smg_status smg_solve_step(smg_state *s, smg_real h) {
  smg_status status = SMG_OK;
#if SMG_LEAVES
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    if (smg_kind(&s->c, k) != SMG_SPHERE) s->leaf_value[k] = smg_leaf_value_of(&s->c, k, s->w + 3 * k);
#endif
#if SMG_HAS_COUPLED
  status = smg_solve_coupled(s, h);
#endif
#if SMG_HAS_ALONE
  status = smg_solve_all_alone(s, h, status);
#endif
  return status;
}

/* w = w + u with the rounding error carried along. */
static inline void smg_add_increment(smg_state *s) {
  const int64_t n = 3 * smg_sites(&s->c);
#if SMG_EXTENDED && !SMG_PLAIN_SUMS
  for (int64_t k = 0; k < n; ++k) smg_wide_commit(&s->w[k], &s->compensation[k], s->u[k], s->low[k]);
#else
  smg_add_step(n, s->w, s->compensation, s->u);
#endif
}

/* The state after the step. */
static void smg_commit(smg_state *s) {
  if (smg_time_to_choose(s, SMG_HISTORY)) smg_choose_degree(s);
#if SMG_EXTENDED
  smg_widen(s);
#endif
  smg_add_increment(s);
#if SMG_LEAVES
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) /* open leaves: orbits grow */
    if (smg_kind(&s->c, k) == SMG_NAMBU) s->scale = smg_max(s->scale, smg_largest(s->w + 3 * k));
#endif
  smg_remember(s, SMG_HISTORY, &s->u);
}

#if SMG_UNIT == 1
SMG_LINKED smg_status smg_advance(smg_state *s, smg_real h);
#else
/* One step of the size h, the time of its midpoint in s->c: the state after it, but not counted. */
SMG_LINKED smg_status smg_advance(smg_state *s, smg_real h) {
  const int newton_steps = s->newton_steps;
  smg_begin_report(s);
  s->report.status = smg_solve_step(s, h);
  if (s->report.status == SMG_OK) {
    s->report.site = -1; /* a first try may have failed there */
    smg_commit(s);
  } else s->newton_steps = newton_steps; /* a refused step leaves no trace */
  return s->report.status;
}
#endif

#if !SMG_COMPOSED
static smg_status smg_step(smg_state *s) {
#if SMG_BY_ROWS
  smg_suit_arrays(s);
  if (s->rows) return smg_row_steps(s, 1);
#endif
  smg_set_time_at(&s->c, s, (smg_real)0.5);
  const smg_status status = smg_advance(s, smg_signed_h(s->h));
  if (status == SMG_OK) ++s->count;
  return status;
}

#include "smg_steps.h"
#endif

#endif
