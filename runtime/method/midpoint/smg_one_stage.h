/* smidgen method: a step with one stage in its middle, found by fixed-point iteration over all sites together
 * (smg_slopes.h). Its header defines, for a site at w, |w| = r, with the slope a of its stage,
 *
 *     smg_stage_point(w, a, v)      the point v where the field is taken, at the time t + h/2
 *     smg_stage_slope(v, g, a)      a from the field g = (h/2) b(v), b = (1/kappa) dH/dw
 *     smg_stage_increment(w, a, u)  u = W - w
 *     smg_stage_weight(r)           w moves by about twice as much as this times a change of a
 *     smg_stage_serves(a)           is the method defined for a slope so large?
 *
 * The slope is the field itself, and r its weight, where no SMG_TURNED_SLOPE says otherwise. */
#ifndef SMG_ONE_STAGE_H
#define SMG_ONE_STAGE_H

#define SMG_SLOPES 3

#include "smg_respond.h"
#include "smg_slopes.h"

#if !SMG_TURNED_SLOPE
SMG_INLINE void smg_stage_slope(SMG_UNUSED const smg_real *v, const smg_real *g, smg_real *a) { smg_copy(a, g, 3); }

SMG_INLINE smg_real smg_stage_weight(smg_real r) { return r; }
#endif

/* The new slope of site k from its dH/dw in s->u. */
static inline void smg_new_slope(smg_state *s, int64_t k, smg_moved *moved) {
  smg_real *g = s->u + 3 * k, next[3];
  const smg_real half = 0.5 * smg_h_over_kappa(&s->c, k, smg_signed_h(s->h)), size = smg_norm(s->w + 3 * k);
  smg_scale(g, half, 3);
  smg_stage_slope(s->points + 3 * k, g, next);
  smg_renew_slopes(s, k, next, smg_stage_weight(size), smg_sum_of_sizes(g, 3), moved);
}

static smg_moved smg_sweep_stages(smg_state *s, SMG_UNUSED void *with) {
  const int64_t sites = smg_sites(&s->c);
  smg_moved moved = {0, 0, 0};
  for (int64_t q = 0; q < 3 * sites; q += 3) smg_stage_point(s->w + q, s->slopes + q, s->points + q);
  smg_zero(s->u, 3 * sites);
  smg_gradient(&s->c, s->points, s->u);
  smg_respond_all(&s->c, s->points, s->u);
  for (int64_t k = 0; k < sites; ++k) smg_new_slope(s, k, &moved);
  return moved;
}

#endif
