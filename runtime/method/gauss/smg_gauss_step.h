/* smidgen method: one step of Gauss collocation (smg_gauss.h), with stages or sites in lanes. Of the layout
 * (smg_gauss_stages.h, smg_gauss_sweep.h) it asks, with `a` what sweeps work with and k a site or the first of
 * SMG_AT_ONCE slots,
 *
 *     smg_places(c)                    k = 0, SMG_AT_ONCE, .. below that
 *     smg_vector_at(a, part, b, q, k)  the q-th vector of stages of component b of x, L or the L before: the part
 *                                      SMG_STAGE_X, SMG_STAGE_SLOPE, SMG_STAGE_PAST
 *     smg_number_at(a, part, b, j, k)  the same of the stage j
 *     smg_past_number(s, b, j, slot)   where that of the L before is, of one site
 *     smg_each_slot(c, context, visit) every site, with its slot
 *     smg_lift_sites(s)                z of all sites from w
 *     smg_take_z(a, k, z)              z
 *     smg_over_length(s, a, k, x)      x/|w|
 *     smg_add_to_sites(s, a, k, u, z)  the state after the step: w + u, and its z
 *     smg_begin_sites(s, a, k, l)      the iteration begins with these L_j; smg_begin_sweeps(s, a, extrapolated), when
 *                                      all sites have them
 *     smg_most_moved(s, a)             the site that the last sweep moved most, or made no number */
#ifndef SMG_GAUSS_STEP_H
#define SMG_GAUSS_STEP_H

#include "smg_gauss_site.h"
#if SMG_ROW_STAGES
#include "smg_gauss_sweep.h"
#else
#include "smg_gauss_stages.h"
#endif

/* ---- the history ----------------------------------------------------------------------------- */

/* The numbers of a history on their way between an array by sites and where steps have them. */
typedef struct smg_past {
  const smg_state *s;
  const smg_real *in;
  smg_real *out;
} smg_past;

SMG_INLINE void smg_past_of_site(void *context, int64_t site, int64_t slot) {
  const smg_past *a = (const smg_past *)context;
  for (int q = 0; q < SMG_STAGE_NUMBERS; ++q) {
    smg_real *there = smg_past_number(a->s, q / SMG_STAGES, q % SMG_STAGES, slot);
    if (a->in) *there = a->in[SMG_STAGE_NUMBERS * site + q];
    else a->out[SMG_STAGE_NUMBERS * site + q] = *there;
  }
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  smg_past all = {s, NULL, out};
  smg_each_slot(&s->c, &all, smg_past_of_site);
}

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  smg_past all = {s, in, NULL};
  smg_lift_sites(s);
  smg_each_slot(&s->c, &all, smg_past_of_site);
}

/* ---- the step -------------------------------------------------------------------------------- */

/* The L_j that the iteration begins with, by the polynomial through those of the step before. */
SMG_INLINE void smg_slopes_ahead(const smg_gauss_work *a, int64_t k, smg_lanes (*l)[4]) {
  SMG_UNROLL
  for (int b = 0; b < 4; ++b) {
    smg_of_site past[SMG_STAGES];
    smg_lanes next[SMG_STAGE_VECTORS];
    SMG_UNROLL
    for (int j = 0; j < SMG_STAGES; ++j) past[j] = smg_number_at(a, SMG_STAGE_PAST, b, j, k);
    smg_combine(smg_gauss_ahead, past, next);
    SMG_UNROLL
    for (int q = 0; q < SMG_STAGE_VECTORS; ++q) l[q][b] = next[q];
  }
}

/* The L_j as the next step wants them: times the phase conj(y).z/r that takes y to z, |y|^2 = |z|^2 = r. */
SMG_INLINE void smg_turn_slopes(const smg_state *s, const smg_gauss_work *a, int64_t k, const smg_of_site *y,
                                const smg_of_site *z) {
  const smg_of_site re = smg_over_length(s, a, k, y[0] * z[0] + y[1] * z[1] + (y[2] * z[2] + y[3] * z[3]));
  const smg_of_site im = smg_over_length(s, a, k, y[0] * z[1] - y[1] * z[0] + (y[2] * z[3] - y[3] * z[2]));
  for (int q = 0; q < SMG_STAGE_VECTORS; ++q)
    for (int b = 0; b < 4; b += 2) {
      const smg_lanes x = *smg_vector_at(a, SMG_STAGE_SLOPE, b, q, k),
                      v = *smg_vector_at(a, SMG_STAGE_SLOPE, b + 1, q, k);
      *smg_vector_at(a, SMG_STAGE_PAST, b, q, k) = re * x - im * v;
      *smg_vector_at(a, SMG_STAGE_PAST, b + 1, q, k) = re * v + im * x;
    }
}

/* dz = sum L_j, u = 2 B(z + dz/2, dz) and the state after the step. */
static void smg_commit_all(smg_state *s, const smg_gauss_work *a) {
  for (int64_t k = 0; k < smg_places(&s->c); k += SMG_AT_ONCE) {
    smg_of_site z[4], dz[4], end[4], u[3];
    smg_take_z(a, k, z);
    for (int b = 0; b < 4; ++b) {
      dz[b] = smg_number_at(a, SMG_STAGE_SLOPE, b, 0, k);
      for (int j = 1; j < SMG_STAGES; ++j) dz[b] += smg_number_at(a, SMG_STAGE_SLOPE, b, j, k);
      end[b] = z[b] + dz[b];
    }
    smg_collect(z, dz, u);
    smg_add_to_sites(s, a, k, u, z);
    smg_turn_slopes(s, a, k, end, z);
  }
}

static void smg_begin_stages(smg_state *s, void *with, int extrapolated) {
  smg_gauss_work *a = (smg_gauss_work *)with;
  for (int64_t k = 0; k < smg_places(&s->c); k += SMG_AT_ONCE) {
    smg_lanes l[SMG_STAGE_VECTORS][4];
    if (extrapolated) smg_slopes_ahead(a, k, l);
    else smg_lane_zero(l[0], 4 * SMG_STAGE_VECTORS);
    smg_begin_sites(s, a, k, (const smg_lanes(*)[4])l);
  }
  smg_begin_sweeps(s, a, extrapolated);
}

static smg_status smg_collocate(smg_state *s, smg_gauss_work *a) {
  smg_begin_report(s);
  const smg_status status = smg_solve_stages(s, a);
  if (status != SMG_OK) return smg_end_report(s, status, smg_most_moved(s, a));
  smg_commit_all(s, a);
  s->history = 1;
  ++s->count;
  return smg_end_report(s, SMG_OK, -1);
}

#endif
