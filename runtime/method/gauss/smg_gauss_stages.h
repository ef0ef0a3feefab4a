/* smidgen method: Gauss collocation (smg_gauss.h), its stages in the lanes of vectors. */
#ifndef SMG_GAUSS_STAGES_H
#define SMG_GAUSS_STAGES_H

#include "smg_gauss.h"
#include "smg_lane_respond.h"

/* ---- arrays ------------------------------------------------------------------------------- */

/* Where the numbers of a site begin: z, what its steps are scaled by, the four components of (r/|Z_i|^2) Z_i, of L_i,
 * and of the L_i before; a component has one number for every stage. */
enum {
  SMG_OWN_Z = 0,
  SMG_OWN_HALF = 4,
  SMG_OWN_SIZE = 5,
  SMG_OWN_UP = 6,
  SMG_OWN_INVERSE = 7,
  SMG_OWN_STAGES = 8,
  SMG_OWN_SLOPES = SMG_OWN_STAGES + 4 * SMG_PADDED,
  SMG_PAST_SLOPES = SMG_OWN_SLOPES + 4 * SMG_PADDED,
  SMG_OWN_NUMBERS = SMG_PAST_SLOPES + 4 * SMG_PADDED
};

/* Numbers of the array s->stages: of every site the above, and three components of p(Z_i) and of dH/dw there, one block
 * of stages. */
#define SMG_STAGES_SIZE(sites) ((SMG_OWN_NUMBERS + 6 * SMG_LANES) * (sites) + SMG_LANES)

/* The array from where vectors may begin. */
static inline smg_real *smg_stages_begin(const smg_state *s) {
  const size_t size = sizeof(smg_lanes), over = (size_t)((uintptr_t)s->stages % size);
  return s->stages + (over ? (size - over) / sizeof(smg_real) : 0);
}

static inline smg_lanes *smg_stage_points(const smg_state *s) { return (smg_lanes *)smg_stages_begin(s); }
static inline smg_lanes *smg_stage_gradients(const smg_state *s) { return smg_stage_points(s) + 3 * smg_sites(&s->c); }
static inline smg_real *smg_own(const smg_state *s, int64_t k) {
  return smg_stages_begin(s) + 6 * SMG_LANES * smg_sites(&s->c) + SMG_OWN_NUMBERS * k;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int q = 0; q < SMG_STAGE_NUMBERS; ++q)
      out[SMG_STAGE_NUMBERS * k + q] = smg_own(s, k)[SMG_PAST_SLOPES + q / SMG_STAGES * SMG_PADDED + q % SMG_STAGES];
}

static inline void smg_restore_history(smg_state *s, const smg_real *in);

#include "smg_state.h"

/* ---- one site: z = (z[0] + i z[1], z[2] + i z[3]) ------------------------------------------- */

/* w = 2 B(y, d), 2 B(z, z) = 2 w(z): w_1 + i w_2 = 2 conj(z_0) z_1, w_3 = |z_0|^2 - |z_1|^2, made bilinear and
 * symmetric. */
SMG_INLINE void smg_collect(const smg_real *y, const smg_real *d, smg_real *w) {
  w[0] = 2 * ((y[0] * d[2] + y[2] * d[0]) + (y[1] * d[3] + y[3] * d[1]));
  w[1] = 2 * ((y[0] * d[3] + y[3] * d[0]) - (y[1] * d[2] + y[2] * d[1]));
  w[2] = 2 * ((y[0] * d[0] + y[1] * d[1]) - (y[2] * d[2] + y[3] * d[3]));
}

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

/* What a step of site k begins with, from its w alone; returns |w|, of spheres r (smg_gauss.h). */
static inline smg_real smg_place_site(const smg_state *s, int64_t k) {
  smg_real *own = smg_own(s, k);
  const smg_real *w = s->w + 3 * k, norm = smg_kind(&s->c, k) == SMG_SPHERE ? smg_radius(&s->c, k) : smg_norm(w);
  smg_lift(w, norm, own + SMG_OWN_Z);
  own[SMG_OWN_HALF] = 0.5 * smg_h_over_kappa(&s->c, k, smg_signed_h(s->h));
  own[SMG_OWN_SIZE] = SMG_MATH(sqrt)(norm);
  own[SMG_OWN_INVERSE] = norm > 0 ? 1 / norm : 0;
  own[SMG_OWN_UP] = smg_kind(&s->c, k) == SMG_R3 ? smg_up(s->scale, w) : 1;
  return norm;
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    (void)smg_place_site(s, k);
    for (int q = 0; q < 4 * SMG_PADDED; ++q) {
      const int b = q / SMG_PADDED, j = q % SMG_PADDED;
      smg_own(s, k)[SMG_PAST_SLOPES + q] =
          in[SMG_STAGE_NUMBERS * k + SMG_STAGES * b + (j < SMG_STAGES ? j : SMG_STAGES - 1)];
    }
  }
}

/* to = from (conj(y).x)/size, a phase: |x|^2 = |y|^2 = size and x = e^(i phi) y. What belongs to y then belongs to
 * x. */
static inline void smg_turn_phase(const smg_real *y, const smg_real *x, smg_real size, const smg_real *from,
                                  smg_real *to) {
  const smg_real re = (y[0] * x[0] + y[1] * x[1] + (y[2] * x[2] + y[3] * x[3])) / size;
  const smg_real im = (y[0] * x[1] - y[1] * x[0] + (y[2] * x[3] - y[3] * x[2])) / size;
  for (int q = 0; q < 4 * SMG_PADDED;
       q += q % SMG_PADDED == SMG_PADDED - SMG_LANES ? SMG_PADDED + SMG_LANES : SMG_LANES) {
    const smg_lanes a = smg_lane_load(from + q), b = smg_lane_load(from + SMG_PADDED + q);
    smg_lane_store(to + q, re * a - im * b);
    smg_lane_store(to + SMG_PADDED + q, re * b + im * a);
  }
}

/* ---- the iteration ------------------------------------------------------------------------ */

/* out_i = from + sum_j rows[j][i] x_j of all stages i; each x_j is read from memory into all lanes. */
SMG_INLINE void smg_combine(const smg_real (*rows)[SMG_PADDED], const smg_real *x, smg_real from, smg_real *out) {
  smg_lanes sum[SMG_STAGE_BLOCKS];
  SMG_UNROLL
  for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) sum[q] = x[0] * smg_lane_load(rows[0] + SMG_LANES * q);
  SMG_UNROLL
  for (int j = 1; j < SMG_STAGES; ++j) SMG_UNROLL
  for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) sum[q] += x[j] * smg_lane_load(rows[j] + SMG_LANES * q);
  SMG_UNROLL
  for (int q = 0; q < SMG_STAGE_BLOCKS; ++q) smg_lane_store(out + SMG_LANES * q, from + sum[q]);
}

/* The L_j it begins with: the polynomial through those of the step before, or 0. */
static void smg_begin_stages(const smg_state *s, int extrapolated) {
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    smg_real *own = smg_own(s, k);
    if (s->history == 0) (void)smg_place_site(s, k);
    if (extrapolated)
      for (int q = 0; q < 4 * SMG_PADDED; q += SMG_PADDED)
        smg_combine(smg_gauss_ahead, own + SMG_PAST_SLOPES + q, 0, own + SMG_OWN_SLOPES + q);
    else
      for (int q = 0; q < 4 * SMG_PADDED; ++q) own[SMG_OWN_SLOPES + q] = 0;
  }
}

/* The points of a site, and x where the Z_i were, of the stages i, i + 1, .. */
SMG_INLINE void smg_place_points(smg_real *own, int i, smg_lanes *p) {
  smg_real *stage = own + SMG_OWN_STAGES + i;
  smg_lanes z[4], x[4];
  for (int b = 0; b < 4; ++b) z[b] = smg_lane_load(stage + SMG_PADDED * b);
  smg_point(own[SMG_OWN_SIZE] * own[SMG_OWN_SIZE], z, x, p);
  for (int b = 0; b < 4; ++b) smg_lane_store(stage + SMG_PADDED * b, x[b]);
}

/* dH/dw at the points of the stages i, i + 1, .., one a lane. */
SMG_INLINE void smg_stage_gradient(smg_state *s, int i, const smg_lanes *points, smg_lanes *gradients) {
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, smg_gauss_node[i]));
#else
  (void)i;
#endif
#if SMG_HAS_LANES
  smg_lane_gradient(&s->c, points, gradients);
#else
  smg_gradient(&s->c, points, gradients);
#endif
}

/* R = F + p x Q in place of the gradient of all sites, one stage a lane (smg_respond.h). */
SMG_INLINE void smg_respond_stages(const smg_coefficients *c, const smg_lanes *points, smg_lanes *gradients) {
#if SMG_RESPONDS
  for (int64_t k = 0; k < smg_sites(c); ++k) {
    const smg_told told = smg_told_of(c, k);
    smg_lanes room[3];
    (void)smg_lane_respond(&told, points + 3 * k, gradients + 3 * k, room);
    for (int b = 0; b < 3; ++b) gradients[3 * k + b] = room[b];
  }
#else
  (void)c, (void)points, (void)gradients;
#endif
}

/* L_i = h b_i F(Z_i) of a site and the stages of one block, from p and dH/dw there. Its change is measured in w, as
 * 2 |z| |change of L|, next to the products in it. It ends up where Z_i was, for a report. */
SMG_INLINE void smg_new_slopes(smg_real *own, int i, const smg_lanes *p, const smg_lanes *g, smg_moved *moved) {
  const smg_real size = own[SMG_OWN_SIZE], up = own[SMG_OWN_UP];
  const smg_lanes half = own[SMG_OWN_HALF] * smg_lane_load(smg_gauss_weight + i);
  const smg_lanes a[3] = {half * g[0], half * g[1], half * g[2]};
  smg_real *stage = own + SMG_OWN_STAGES + i, *slope = own + SMG_OWN_SLOPES + i;
  const smg_lanes along = own[SMG_OWN_INVERSE] * (p[0] * a[0] + p[1] * a[1] + p[2] * a[2]);
  smg_lanes x[4], next[4], change = {0};
  for (int b = 0; b < 4; ++b) x[b] = smg_lane_load(stage + SMG_PADDED * b);
  smg_turn(a, along, x, next);
  for (int b = 0; b < 4; ++b) {
    change += smg_lane_abs(next[b] - smg_lane_load(slope + SMG_PADDED * b));
    smg_lane_store(slope + SMG_PADDED * b, next[b]);
  }
  const smg_lanes strength = smg_lane_abs(a[0]) + smg_lane_abs(a[1]) + smg_lane_abs(a[2]),
                  absolute = 2 * size * up * change;
  moved->relative = smg_lane_larger(moved->relative, change / (size * strength + SMG_LEAST));
  moved->absolute = smg_lane_larger(moved->absolute, absolute);
  moved->rounding_scale = smg_lane_larger(moved->rounding_scale, 2 * size * size * up * strength);
  smg_lane_store(stage, absolute);
}

/* One sweep: every stage from the L of all as they were. Z_i = z + sum_j (a_ij/b_j) L_j. */
static smg_moved smg_sweep_stages(smg_state *s, void *with) {
  (void)with;
  const int64_t sites = smg_sites(&s->c);
  smg_real *all = smg_own(s, 0);
  smg_lanes *points = smg_stage_points(s), *gradients = smg_stage_gradients(s);
  const smg_lanes zero = {0};
  smg_moved moved = {zero, zero, zero};
  for (smg_real *own = all; own < all + SMG_OWN_NUMBERS * sites; own += SMG_OWN_NUMBERS)
    for (int b = 0; b < 4; ++b)
      smg_combine(smg_gauss_share, own + SMG_OWN_SLOPES + SMG_PADDED * b, own[b],
                  own + SMG_OWN_STAGES + SMG_PADDED * b);
  for (int i = 0; i < SMG_PADDED; i += SMG_LANES) {
    for (int64_t k = 0; k < sites; ++k) {
      smg_place_points(all + SMG_OWN_NUMBERS * k, i, points + 3 * k);
      for (int b = 0; b < 3; ++b) gradients[3 * k + b] = zero;
    }
    smg_stage_gradient(s, i, points, gradients);
    smg_respond_stages(&s->c, points, gradients);
    for (int64_t k = 0; k < sites; ++k)
      smg_new_slopes(all + SMG_OWN_NUMBERS * k, i, points + 3 * k, gradients + 3 * k, &moved);
  }
  return moved;
}

/* Are all L_j finite? A change that is not a number may be lost among the others. */
static int smg_finite_stages(const smg_state *s) {
  smg_lanes none = {0};
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int q = 0; q < 4 * SMG_PADDED; q += SMG_LANES) {
      const smg_lanes slope = smg_lane_load(smg_own(s, k) + SMG_OWN_SLOPES + q);
      none += slope - slope;
    }
  return !(smg_lane_largest(none) != 0);
}

/* The site that the last sweep moved most, or made no number. */
static int64_t smg_most_moved(const smg_state *s) {
  smg_real most = -1;
  int64_t site = -1;
  for (int64_t k = 0; k < smg_sites(&s->c); ++k)
    for (int i = 0; i < SMG_STAGES; ++i) {
      const smg_real moved = smg_own(s, k)[SMG_OWN_STAGES + i];
      if (!(moved <= most)) site = k;
      most = smg_max(most, moved);
    }
  return site;
}

/* From rest, stage after stage: L_i from those before it alone, as an explicit method would, and these once more. */
static void smg_first_stages(smg_state *s) {
  for (int i = 0; i < SMG_STAGES; ++i) {
    (void)smg_sweep_stages(s, NULL);
    for (int64_t k = 0; k < smg_sites(&s->c); ++k)
      for (int q = 0; i < SMG_STAGES - 1 && q < 4 * SMG_PADDED; ++q)
        if (q % SMG_PADDED > i) smg_own(s, k)[SMG_OWN_SLOPES + q] = 0;
  }
}

static smg_status smg_settle_stages(smg_state *s, int extrapolated) {
  smg_begin_stages(s, extrapolated);
  if (!extrapolated) smg_first_stages(s);
  const smg_status status = smg_sweep_to_rest(s, NULL);
  return smg_finite_stages(s) ? status : SMG_NOT_FINITE;
}

/* The stages of the step: from the polynomial of the step before; when that fails, or there is none, from rest. */
static smg_status smg_solve_stages(smg_state *s) {
  s->report.iterations = 0;
  if (s->history > 0 && smg_settle_stages(s, 1) == SMG_OK) return SMG_OK;
  return smg_settle_stages(s, 0);
}

/* ---- the step ----------------------------------------------------------------------------- */

/* u = 2 B(z + dz/2, dz) and the state after the step; the L_j stay, with the phase of the next step's z. */
static void smg_commit_collective(smg_state *s, int64_t k) {
  smg_real *z = smg_own(s, k), *slopes = z + SMG_OWN_SLOPES;
  smg_real dz[4], middle[4], end[4];
  for (int b = 0; b < 4; ++b) {
    dz[b] = 0;
    for (int j = 0; j < SMG_STAGES; ++j) dz[b] += slopes[SMG_PADDED * b + j];
    middle[b] = z[b] + 0.5 * dz[b];
    end[b] = z[b] + dz[b];
  }
  smg_collect(middle, dz, s->u + 3 * k);
  for (int64_t q = 3 * k; q < 3 * k + 3; ++q) smg_add_step(&s->w[q], &s->compensation[q], s->u[q]);
  const smg_real size = smg_place_site(s, k);
  if (size > 0) smg_turn_phase(end, z, size, slopes, z + SMG_PAST_SLOPES);
}

static smg_status smg_step(smg_state *s) {
  smg_begin_report(s);
  const smg_status status = smg_solve_stages(s);
  if (status != SMG_OK) return smg_end_report(s, status, smg_most_moved(s));
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_commit_collective(s, k);
  s->history = 1;
  ++s->count;
  return smg_end_report(s, SMG_OK, -1);
}

#include "smg_steps.h"

#endif
