/* smidgen method: the geodesic midpoint, of order 2. A comparator, NOT symplectic: the great circle from w to W has the
 * direction of X(m) at its middle m, and the length h |X(m)| (McLachlan, Modin, Verdier, A minimal-variable symplectic
 * integrator on spheres, remark 2.2; the spherical midpoint makes the chord that long). With a = (h/2) X(m) and the
 * length r of w,
 *
 *     w = cos(phi) m - (sin(phi)/phi) a,   W = cos(phi) m + (sin(phi)/phi) a,   phi = |a|/r:
 *
 *     m = r mbar/|mbar|,   mbar = w + (sin(phi)/phi) a,   W - w = 2 (sin(phi)/phi) a.
 *
 * W - w is a multiple of X(m) as that of the spherical midpoint, and keeps quadratic integrals of single sites; but
 * each site has a factor of its own, and momentum is not kept. */
#ifndef SMG_GEODESIC_MIDPOINT_H
#define SMG_GEODESIC_MIDPOINT_H

#define SMG_ONTO_LEAF 1
#define SMG_TURNED_SLOPE 1

#include "smg_model.h"
#include "smg_rotation.h"

/* (sin(phi)/phi) a, half of W - w. */
SMG_INLINE void smg_half_chord(smg_real r, const smg_real *a, smg_real *u) {
  smg_multiple(u, r > 0 ? smg_sinc(smg_norm(a) / r) : 1, a, 3);
}

/* m. */
SMG_INLINE void smg_stage_point(const smg_real *w, const smg_real *a, smg_real *m) {
  const smg_real r = smg_norm(w);
  smg_half_chord(r, a, m);
  smg_axpy(m, 1, w, 3);
  const smg_real size = smg_norm(m), scale = size > 0 ? r / size : 0;
  smg_scale(m, scale, 3);
}

/* a = (h/2) X(m) = m x g. */
SMG_INLINE void smg_stage_slope(const smg_real *m, const smg_real *g, smg_real *a) { smg_cross(a, m, g); }

SMG_INLINE void smg_stage_increment(const smg_real *w, const smg_real *a, smg_real *u) {
  smg_half_chord(smg_norm(w), a, u);
  smg_scale(u, 2, 3);
}

SMG_INLINE smg_real smg_stage_weight(SMG_UNUSED smg_real r) { return 1; }

SMG_INLINE int smg_stage_serves(SMG_UNUSED const smg_real *a) { return 1; }

#include "smg_one_stage.h"

#endif
