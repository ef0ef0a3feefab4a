/* smidgen runtime: few sites that all feel each other, as arrays for vectors of lanes: x, y and z apart, a site in each
 * lane.
 *
 * A site is a slot (smg_slots.h); those beyond the last site, up to a whole vector, belong to none.
 * The model gives smg_few_field(c, all, pitch, i, g), g = dH/dw of the sites i .. i + SMG_LANES - 1 with all vectors in
 * `all`, the other sites one after the other, so that every number of lanes has the same bits; and smg_few_norms, the
 * same with a bound on the norms of the Hessian in their rows. Of tracers smg_alone_field(c, all, own, g), with
 * the vectors `own` in the field of those of the state, and smg_alone_change, y += d2H/dw2 d. */
#ifndef SMG_FEW_H
#define SMG_FEW_H

#include "smg_model.h"
#include "smg_slots.h"

/* Arrays of a step: x, y and z of w, of what it has lost to rounding, of u and of m; h/(2 kappa), the radius, and the
 * radius over |mbar|. */
enum {
  SMG_FEW_W = 0,
  SMG_FEW_LOST = 3,
  SMG_FEW_U = 6,
  SMG_FEW_M = 9,
  SMG_FEW_HALF = 12,
  SMG_FEW_RADIUS,
  SMG_FEW_ONTO,
  SMG_FEW_ARRAYS
};

#define SMG_FEW_SIZE(sites) (SMG_FEW_ARRAYS * smg_whole_vectors(sites))

/* One component of n sites in lanes, from the three numbers of each; `beyond` in the other lanes. */
SMG_INLINE smg_lanes smg_few_gather(const smg_real *v, int64_t n, int beyond) {
  smg_lanes x = smg_lane_of((smg_real)beyond);
  for (int64_t l = 0; l < n; ++l) smg_lane_set(&x, (int)l, v[3 * l]);
  return x;
}

/* That of one site in all lanes. */
SMG_INLINE void smg_few_spread(const smg_real *all, int64_t pitch, int64_t j, smg_lanes *v) {
  for (int k = 0; k < 3; ++k) v[k] = smg_lane_of(all[k * pitch + j]);
}

/* The entries i, i + 1, .. of an array with one for each site; beyond the last site its own again. */
SMG_INLINE smg_lanes smg_few_entries(const double *a, int64_t i, int64_t sites) {
  smg_lanes x = {0};
  for (int64_t l = 0; l < SMG_LANES; ++l) smg_lane_set(&x, (int)l, (smg_real)a[i + l < sites ? i + l : sites - 1]);
  return x;
}

/* The site after the last of those in lanes from i on. */
SMG_INLINE int64_t smg_few_end(int64_t i, int64_t sites) { return i + SMG_LANES < sites ? i + SMG_LANES : sites; }

/* sum += more, of n vectors of lanes; in the lane of the site itself that is seen, 0. */
SMG_INLINE void smg_few_add(int n, int64_t lane, const smg_lanes *more, smg_lanes *sum) {
  const smg_lane_mask own = smg_lane_only(lane);
  for (int k = 0; k < n; ++k) sum[k] += smg_lane_select(own, smg_lane_of(0), more[k]);
}

#endif
