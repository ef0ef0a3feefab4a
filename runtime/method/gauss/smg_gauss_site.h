/* smidgen method: one site of Gauss collocation (smg_gauss.h), in numbers or in lanes. */
#ifndef SMG_GAUSS_SITE_H
#define SMG_GAUSS_SITE_H

#define SMG_ONTO_LEAF 0

#include "smg_model.h"
#include "smg_gauss_table.h"
#include "smg_fixed_point.h"
#include "smg_report.h"

#if !(SMG_STAGES >= 1 && SMG_STAGES <= 8) || SMG_HISTORY != 1 || SMG_EXTENDED
#error "smg_gauss.h: SMG_STAGES 1 to 8, SMG_HISTORY 1, and no SMG_EXTENDED"
#endif

#define SMG_NO_DEGREE 0

/* The history: the L_j of the step before, s->history = 1 once there are any. */
#define SMG_STAGE_NUMBERS (4 * SMG_STAGES) /* of a site */
static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)(SMG_STAGE_NUMBERS * smg_sites(c)); }

#include "smg_state.h"

/* ---- stages or sites in lanes ---------------------------------------------------------------- */

/* What a site has one of, and what a stage has one of; products of the two are vectors of lanes. How many sites go at
 * once, and how many vectors the stages of each fill. */
#if SMG_ROW_STAGES
typedef smg_lanes smg_of_site;
typedef smg_real smg_of_stage;
#define SMG_AT_ONCE SMG_LANES
#define SMG_STAGE_VECTORS SMG_STAGES
SMG_INLINE smg_of_stage smg_stage_entry(const smg_real *row, int q) { return row[q]; }
#else
typedef smg_real smg_of_site;
typedef smg_lanes smg_of_stage;
#define SMG_AT_ONCE 1
#define SMG_STAGE_VECTORS SMG_STAGE_BLOCKS
SMG_INLINE smg_of_stage smg_stage_entry(const smg_real *row, int q) { return smg_lane_load(row + SMG_LANES * q); }
#endif

/* out_i = sum_j rows[j][i] x_j for all stages i. */
SMG_INLINE void smg_combine(const smg_real (*rows)[SMG_PADDED], const smg_of_site *x, smg_lanes *out) {
  SMG_UNROLL
  for (int q = 0; q < SMG_STAGE_VECTORS; ++q) out[q] = x[0] * smg_stage_entry(rows[0], q);
  SMG_UNROLL
  for (int j = 1; j < SMG_STAGES; ++j) SMG_UNROLL
  for (int q = 0; q < SMG_STAGE_VECTORS; ++q) out[q] += x[j] * smg_stage_entry(rows[j], q);
}

/* ---- one site, z = (z[0] + i z[1], z[2] + i z[3]) ------------------------------------------- */

/* Beside |z|^2 it is nothing; r over it is finite. */
SMG_INLINE smg_real smg_least(smg_real r) { return SMG_LEAST + r * SMG_LEAST; }

/* x = (r/|z|^2) z and p = r w(z)/|z|^2, stage by stage; both are 0 if z = 0. least = smg_least(r). */
SMG_INLINE void smg_point(smg_real r, smg_real least, const smg_lanes *z, smg_lanes *x, smg_lanes *p) {
  const smg_lanes scale = r / ((z[0] * z[0] + z[1] * z[1]) + (z[2] * z[2] + z[3] * z[3]) + least);
  smg_lane_multiple(x, scale, z, 4);
  p[0] = 2 * (x[0] * z[2] + x[1] * z[3]);
  p[1] = 2 * (x[0] * z[3] - x[1] * z[2]);
  p[2] = (x[0] * z[0] + x[1] * z[1]) - (x[2] * z[2] + x[3] * z[3]);
}

/* l = i (a.sigma - a.p/r) x = h b_i F(Z_i), a = (h b_i/2 kappa) dH/dw = half g, which may take the place of g;
 * inverse = 1/r. */
SMG_INLINE void smg_slope(smg_of_stage half, smg_real inverse, const smg_lanes *g, const smg_lanes *p,
                          const smg_lanes *x, smg_lanes *a, smg_lanes *l) {
  for (int b = 0; b < 3; ++b) a[b] = half * g[b];
  const smg_lanes along = inverse * (p[0] * a[0] + p[1] * a[1] + p[2] * a[2]), up = a[2] - along, down = a[2] + along;
  l[0] = a[1] * x[2] - a[0] * x[3] - up * x[1];
  l[1] = a[0] * x[2] + a[1] * x[3] + up * x[0];
  l[2] = down * x[3] - a[0] * x[1] - a[1] * x[0];
  l[3] = a[0] * x[0] - a[1] * x[1] - down * x[2];
}

/* u = 2 B(z + dz/2, dz), 2 B(z, z) = 2 w(z): w_1 + i w_2 = 2 conj(z_0) z_1, w_3 = |z_0|^2 - |z_1|^2, made bilinear and
 * symmetric. */
SMG_INLINE void smg_collect(const smg_of_site *z, const smg_of_site *d, smg_of_site *u) {
  smg_of_site y[4];
  for (int b = 0; b < 4; ++b) y[b] = z[b] + (smg_real)0.5 * d[b];
  u[0] = 2 * ((y[0] * d[2] + y[2] * d[0]) + (y[1] * d[3] + y[3] * d[1]));
  u[1] = 2 * ((y[0] * d[3] + y[3] * d[0]) - (y[1] * d[2] + y[2] * d[1]));
  u[2] = 2 * ((y[0] * d[0] + y[1] * d[1]) - (y[2] * d[2] + y[3] * d[3]));
}

#endif
