/* smidgen runtime: the midpoints where sweeps begin. */
#ifndef SMG_SWEPT_H
#define SMG_SWEPT_H

#include "smg_newton.h"

/* mbar = w + u/2 of all sites. */
static inline void smg_set_midpoints(smg_state *s) { smg_waxpy(s->mbar, 0.5, s->u, s->w, 3 * smg_sites(&s->c)); }

#if SMG_ROTATION
/* m = P(w + u/2) of site k. */
static inline smg_real smg_halfway(const smg_state *s, int64_t k, const smg_real *u, smg_real *m) {
  smg_real mbar[3];
  smg_waxpy(mbar, 0.5, u, s->w + 3 * k, 3);
  return smg_project(&s->c, k, smg_leaf_value(s, k), mbar, m);
}

/* m = P(w + u/2) with u extrapolated: where the sweeps begin. */
static void smg_sweep_start(smg_state *s) {
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    smg_real u[3];
    for (int b = 0; b < 3; ++b) u[b] = smg_extrapolate(s, 3 * k + b, s->degree);
    (void)smg_halfway(s, k, u, s->m + 3 * k);
  }
}
#else
static void smg_sweep_start(smg_state *s) { smg_predict(s, s->degree); }
#endif

#endif
