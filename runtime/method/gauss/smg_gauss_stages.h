/* smidgen method: Gauss collocation (smg_gauss.h), its stages in the lanes of vectors. */
#ifndef SMG_GAUSS_STAGES_H
#define SMG_GAUSS_STAGES_H

#include "smg_gauss_site.h"
#include "smg_lane_respond.h"

/* ---- arrays ------------------------------------------------------------------------------- */

/* Where the numbers of a site begin: z and what its steps are scaled by, |z|, r = |z|^2 and a size negligible
 * beside it, 1/r, and by how much w is moved by a change of L, and by products, in units of the largest; then what
 * has one number for every stage: h b_i/(2 kappa), the change of L_i in the last sweep, the four components of L_i,
 * and of the L_i before. */
enum {
  SMG_OWN_Z = 0,
  SMG_OWN_SIZE = 4,
  SMG_OWN_NORM = 5,
  SMG_OWN_LEAST = 6,
  SMG_OWN_INVERSE = 7,
  SMG_OWN_MOVES = 8,
  SMG_OWN_ROUNDS = 9,
  SMG_STAGE_HALF = 16,
  SMG_STAGE_CHANGE = SMG_STAGE_HALF + SMG_PADDED,
  SMG_STAGE_SLOPE = SMG_STAGE_CHANGE + SMG_PADDED,
  SMG_STAGE_PAST = SMG_STAGE_SLOPE + 4 * SMG_PADDED,
  SMG_OWN_NUMBERS = SMG_STAGE_PAST + 4 * SMG_PADDED
};

/* Vectors that a sweep has of every site: four components of x = (r/|Z_i|^2) Z_i for all blocks of stages, and three of
 * p(Z_i) and of dH/dw there for one. */
enum { SMG_SWEPT_X = 4 * SMG_STAGE_BLOCKS, SMG_SWEPT_VECTORS = SMG_SWEPT_X + 6 };

/* Numbers of the array s->stages. */
#define SMG_STAGES_SIZE(sites) ((SMG_OWN_NUMBERS + SMG_SWEPT_VECTORS * SMG_LANES) * (sites) + SMG_LANES)

/* What sweeps work with: x, points and gradients, and the numbers of the first site. */
typedef struct smg_gauss_work {
  smg_lanes *x, *points, *gradients;
  smg_real *own;
} smg_gauss_work;

/* Its vectors, from these on. */
SMG_INLINE void smg_sweep_with(smg_gauss_work *a, smg_lanes *vectors, int64_t sites) {
  a->x = vectors;
  a->points = vectors + SMG_SWEPT_X * sites;
  a->gradients = a->points + 3 * sites;
}

/* From where vectors may begin. */
static inline smg_gauss_work smg_work_of(const smg_state *s) {
  const int64_t sites = smg_sites(&s->c);
  const size_t size = sizeof(smg_lanes), over = (size_t)((uintptr_t)s->stages % size);
  smg_gauss_work a;
  a.own = s->stages + (over ? (size - over) / sizeof(smg_real) : 0);
  smg_sweep_with(&a, (smg_lanes *)a.own, sites);
  a.own += SMG_SWEPT_VECTORS * SMG_LANES * sites;
  return a;
}

SMG_INLINE smg_real *smg_own(const smg_gauss_work *a, int64_t k) { return a->own + SMG_OWN_NUMBERS * k; }

SMG_INLINE smg_lanes *smg_vector_at(const smg_gauss_work *a, int part, int b, int q, int64_t k) {
  return (smg_lanes *)(smg_own(a, k) + part + SMG_PADDED * b + SMG_LANES * q);
}
SMG_INLINE smg_real smg_number_at(const smg_gauss_work *a, int part, int b, int j, int64_t k) {
  return smg_own(a, k)[part + SMG_PADDED * b + j];
}
/* Component b of x, of the q-th block of stages. */
SMG_INLINE smg_lanes *smg_swept_x(const smg_gauss_work *a, int b, int q, int64_t k) {
  return a->x + SMG_SWEPT_X * k + SMG_STAGE_BLOCKS * b + q;
}
static inline smg_real *smg_past_number(const smg_state *s, int b, int j, int64_t k) {
  const smg_gauss_work a = smg_work_of(s);
  return smg_own(&a, k) + SMG_STAGE_PAST + SMG_PADDED * b + j;
}

static inline int64_t smg_places(const smg_coefficients *c) { return smg_sites(c); }
typedef void smg_slot_visit(void *context, int64_t site, int64_t slot);
SMG_INLINE void smg_each_slot(const smg_coefficients *c, void *context, smg_slot_visit *visit) {
  for (int64_t k = 0; k < smg_sites(c); ++k) visit(context, k, k);
}

/* ---- z and w -------------------------------------------------------------------------------- */

/* A z with w(z) = w, norm = |w|: the larger of z_0, z_1 is real and positive, sqrt((|w| + |w_3|)/2); nothing
 * cancels. */
static inline void smg_lift(const smg_real *w, smg_real norm, smg_real *z) {
  const smg_real large = SMG_MATH(sqrt)(0.5 * (norm + smg_abs(w[2])));
  const smg_real re = large > 0 ? 0.5 * w[0] / large : 0, im = large > 0 ? 0.5 * w[1] / large : 0;
  const int south = w[2] < 0;
  z[0] = south ? re : large;
  z[1] = south ? -im : 0;
  z[2] = south ? large : re;
  z[3] = south ? 0 : im;
}

/* |w|, of spheres r (smg_gauss.h). */
static inline smg_real smg_length(const smg_state *s, int64_t k) {
  return smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) : smg_norm(s->w + 3 * k);
}

/* What a step of site k begins with, from its w alone. */
static inline void smg_lift_site(const smg_state *s, const smg_gauss_work *a, int64_t k) {
  smg_real *own = smg_own(a, k);
  const smg_real *w = s->w + 3 * k, norm = smg_length(s, k), size = SMG_MATH(sqrt)(norm), up = smg_site_up(s, k);
  const smg_real half = 0.5 * smg_h_over_kappa(&s->c, k, smg_signed_h(s->h));
  smg_lift(w, norm, own + SMG_OWN_Z);
  own[SMG_OWN_SIZE] = size;
  own[SMG_OWN_NORM] = size * size;
  own[SMG_OWN_LEAST] = smg_least(size * size);
  own[SMG_OWN_INVERSE] = norm > 0 ? 1 / norm : 0;
  own[SMG_OWN_MOVES] = 2 * size * up;
  own[SMG_OWN_ROUNDS] = 2 * size * size * up;
  for (int q = 0; q < SMG_STAGE_BLOCKS; ++q)
    *smg_vector_at(a, SMG_STAGE_HALF, 0, q, k) = half * smg_stage_entry(smg_gauss_weight, q);
}

static void smg_lift_sites(const smg_state *s) {
  const smg_gauss_work a = smg_work_of(s);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_lift_site(s, &a, k);
}

SMG_INLINE void smg_take_z(const smg_gauss_work *a, int64_t k, smg_real *z) {
  smg_copy(z, smg_own(a, k) + SMG_OWN_Z, 4);
}

/* x/|w|; of a site at rest at w = 0, 0. */
SMG_INLINE smg_real smg_over_length(const smg_state *s, SMG_UNUSED const smg_gauss_work *a, int64_t k, smg_real x) {
  const smg_real length = smg_length(s, k);
  return length > 0 ? x / length : 0;
}

static inline void smg_add_to_sites(smg_state *s, const smg_gauss_work *a, int64_t k, const smg_real *u, smg_real *z) {
  smg_add_step(3, s->w + 3 * k, s->compensation + 3 * k, u);
  smg_lift_site(s, a, k);
  smg_take_z(a, k, z);
}

/* ---- the iteration ------------------------------------------------------------------------ */

/* Z_i = z + sum_j (a_ij/b_j) L_j of one site, in place of x. */
SMG_INLINE void smg_join_stages(const smg_gauss_work *a, int64_t k) {
  for (int b = 0; b < 4; ++b) {
    smg_lanes sum[SMG_STAGE_BLOCKS];
    smg_combine(smg_gauss_share, &smg_own(a, k)[SMG_STAGE_SLOPE + SMG_PADDED * b], sum);
    SMG_UNROLL
    for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) *smg_swept_x(a, b, q, k) = smg_own(a, k)[b] + sum[q];
  }
}

/* The points of a site, and x where the Z_i were, of the q-th block of stages; no gradient there yet. */
SMG_INLINE void smg_place_points(const smg_gauss_work *a, int q, int64_t k) {
  const smg_real *own = smg_own(a, k);
  smg_lanes z[4], x[4];
  for (int b = 0; b < 4; ++b) z[b] = *smg_swept_x(a, b, q, k);
  smg_point(own[SMG_OWN_NORM], own[SMG_OWN_LEAST], z, x, a->points + 3 * k);
  for (int b = 0; b < 4; ++b) *smg_swept_x(a, b, q, k) = x[b];
  smg_lane_zero(a->gradients + 3 * k, 3);
}

/* dH/dw at the points of the q-th block of stages, one a lane. */
SMG_INLINE void smg_stage_gradient(SMG_UNUSED const smg_state *s, smg_coefficients *c, SMG_UNUSED int q,
                                   const smg_gauss_work *a) {
#if SMG_TIMED
  smg_set_time(c, smg_time_at(s, smg_gauss_node[SMG_LANES * q]));
#endif
#if SMG_HAS_LANES
  smg_lane_gradient(c, a->points, a->gradients);
#else
  smg_gradient(c, a->points, a->gradients);
#endif
}

/* R = F + p x Q in place of the gradient of all sites, one stage a lane (smg_respond.h). */
SMG_INLINE void smg_respond_stages(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED const smg_lanes *points,
                                   SMG_UNUSED smg_lanes *gradients) {
#if SMG_RESPONDS
  for (int64_t k = 0; k < smg_sites(c); ++k) {
    const smg_told told = smg_told_of(c, k);
    smg_lanes room[3];
    (void)smg_lane_respond(&told, points + 3 * k, gradients + 3 * k, room);
    smg_lane_copy(gradients + 3 * k, room, 3);
  }
#endif
}

/* L_i of a site and the stages of one block, from p and dH/dw there; a of smg_slope in place of the latter. Its change
 * is measured in w, as 2 |z| |change of L|. */
SMG_INLINE void smg_new_slopes(const smg_gauss_work *a, int q, int64_t k, smg_moved *moved) {
  const smg_real *own = smg_own(a, k);
  smg_lanes x[4], next[4], change = {0}, *turn = a->gradients + 3 * k;
  for (int b = 0; b < 4; ++b) x[b] = *smg_swept_x(a, b, q, k);
  smg_slope(*smg_vector_at(a, SMG_STAGE_HALF, 0, q, k), own[SMG_OWN_INVERSE], turn, a->points + 3 * k, x, turn, next);
  for (int b = 0; b < 4; ++b) {
    smg_lanes *slope = smg_vector_at(a, SMG_STAGE_SLOPE, b, q, k);
    const smg_lanes moves = smg_lane_abs(next[b] - *slope);
    if (b == 0) change = moves;
    else change += moves;
    *slope = next[b];
  }
  *smg_vector_at(a, SMG_STAGE_CHANGE, 0, q, k) = change;
  moved->absolute = smg_lane_more(moved->absolute, own[SMG_OWN_MOVES] * change);
}

/* That change next to the products in it, and these. */
SMG_INLINE void smg_compare_slopes(const smg_gauss_work *a, int q, int64_t k, smg_moved *moved) {
  const smg_real *own = smg_own(a, k);
  const smg_lanes *turn = a->gradients + 3 * k, change = *smg_vector_at(a, SMG_STAGE_CHANGE, 0, q, k),
                  strength = smg_lane_abs(turn[0]) + smg_lane_abs(turn[1]) + smg_lane_abs(turn[2]);
  moved->relative = smg_lane_larger(moved->relative, change / (own[SMG_OWN_SIZE] * strength + SMG_LEAST));
  moved->rounding_scale = smg_lane_larger(moved->rounding_scale, own[SMG_OWN_ROUNDS] * strength);
}

/* One sweep of so many sites: every stage from the L of all as they were. */
SMG_INLINE smg_moved smg_sweep_sites(const smg_state *s, smg_coefficients *c, const smg_gauss_work *a, int64_t sites) {
  const smg_lanes zero = {0};
  smg_moved moved = {zero, zero, zero};
  SMG_UNROLL_SITES
  for (int64_t k = 0; k < sites; ++k) smg_join_stages(a, k);
  for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) {
    SMG_UNROLL_SITES
    for (int64_t k = 0; k < sites; ++k) smg_place_points(a, q, k);
    smg_stage_gradient(s, c, q, a);
    smg_respond_stages(c, a->points, a->gradients);
    SMG_UNROLL_SITES
    for (int64_t k = 0; k < sites; ++k) smg_new_slopes(a, q, k, &moved);
    for (int64_t k = 0; k < sites && !smg_of_the_whole(s); ++k) smg_compare_slopes(a, q, k, &moved);
  }
  return moved;
}

#if SMG_FEW_STAGED && SMG_LANES > 1
/* The same of few, whose number the compiler knows: what a sweep works with is in registers. */
SMG_INLINE smg_moved smg_sweep_few(const smg_state *s, const smg_gauss_work *all, int64_t sites) {
  smg_lanes vectors[SMG_SWEPT_VECTORS * SMG_FEW_STAGED];
  smg_model model = *s->c.model;
  smg_coefficients c = s->c;
  smg_gauss_work a = *all;
#if SMG_ASSUMES_SITES
  smg_assume_sites(&model, sites);
#endif
  c.model = &model;
  smg_sweep_with(&a, vectors, sites);
  return smg_sweep_sites(s, &c, &a, sites);
}
#endif

static smg_moved smg_sweep_stages(smg_state *s, void *with) {
  const smg_gauss_work work = *(const smg_gauss_work *)with, *a = &work; /* in registers: vectors may alias anything */
  const int64_t sites = smg_sites(&s->c);
#if SMG_FEW_STAGED && SMG_LANES > 1
  switch (sites) {
  case 1: return smg_sweep_few(s, a, 1);
  case 2: return smg_sweep_few(s, a, 2);
  case 3: return smg_sweep_few(s, a, 3);
  case 4: return smg_sweep_few(s, a, 4);
  }
#endif
  return smg_sweep_sites(s, &s->c, a, sites);
}

/* The site that the last sweep moved most, or the first that it made no number. */
static int64_t smg_most_moved(const smg_state *s, const smg_gauss_work *a) {
  smg_real most = -1;
  int64_t site = -1;
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int i = 0; i < SMG_STAGES; ++i) {
      const smg_real moved = smg_own(a, k)[SMG_OWN_MOVES] * smg_number_at(a, SMG_STAGE_CHANGE, 0, i, k);
      if (most == most && !(moved <= most)) {
        site = k;
        most = moved;
      }
    }
  return site;
}

/* ---- what it begins with -------------------------------------------------------------------- */

SMG_INLINE void smg_begin_sites(const smg_state *s, const smg_gauss_work *a, int64_t k, const smg_lanes (*l)[4]) {
  if (s->history == 0) smg_lift_site(s, a, k);
  for (int b = 0; b < 4; ++b)
    for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) *smg_vector_at(a, SMG_STAGE_SLOPE, b, q, k) = l[q][b];
}

/* From rest, stage after stage: L_i from those before it alone, as an explicit method would, and these once more. */
static void smg_begin_sweeps(smg_state *s, smg_gauss_work *a, int extrapolated) {
  for (int i = 0; i < SMG_STAGES && !extrapolated; ++i) {
    (void)smg_sweep_stages(s, a);
    for (int64_t k = 0; k < smg_sites(&s->c); ++k)
      for (int q = 0; i < SMG_STAGES - 1 && q < 4 * SMG_PADDED; ++q)
        if (q % SMG_PADDED > i) smg_own(a, k)[SMG_STAGE_SLOPE + q] = 0;
  }
}

#endif
