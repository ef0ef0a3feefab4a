/* smidgen runtime: the first iterate of a step, a polynomial through the increments of the steps before; its degree
 * adapts. */
#ifndef SMG_PREDICTOR_H
#define SMG_PREDICTOR_H

#include "smg_lane_misses.h"
#include "smg_model.h"
#include "smg_polynomial.h"

#if SMG_COMPOSED
#include "smg_stage_predictor.h"
#else

/* Is it time to look which degree serves best? full: increments that are kept. */
static inline int smg_time_to_choose(const smg_state *s, int full) { return s->history < full || s->count % 16 == 0; }

/* the highest degree that so many increments serve */
#define SMG_MOST_DEGREE(history) ((history)-1)
/* that the errors of the components are added up in, by turns: those of SMG_LANES components at once */
#define SMG_SUMS 8
#if SMG_LANES > SMG_SUMS
#error "smg_predictor.h: a vector has more lanes than there are sums"
#endif

/* How many increments a degree takes, and the weight of the j-th. */
static inline int smg_terms(int degree) { return degree + 1; }
static inline smg_real smg_past_weight(SMG_UNUSED const smg_state *s, int degree, int j) {
  return smg_weight(degree, j);
}

#endif

/* Component k of the increment of the step, or of the stage, under way. */
static inline smg_real smg_extrapolate(const smg_state *s, int64_t k, int degree) {
  smg_real sum = 0;
  for (int j = 0; j < smg_terms(degree); ++j) sum += smg_past_weight(s, degree, j) * s->past[j][k];
  return sum;
}

/* Those from the k-th on, as many as there are lanes. */
static inline smg_lanes smg_extrapolate_some(const smg_state *s, int64_t k, int degree) {
  smg_lanes sum = smg_lane_of(0);
  for (int j = 0; j < smg_terms(degree); ++j) sum += smg_past_weight(s, degree, j) * smg_lane_take(s->past[j] + k);
  return sum;
}

#if SMG_COMPOSED
/* Which level would have served best in the stage just solved? A sample of the components decides. */
static void smg_choose_degree(smg_state *s) {
  const int64_t size = 3 * smg_sites(&s->c), stride = 1 + size / 256;
  if (s->history < SMG_HISTORY) {
    s->degree = smg_highest_level(s->history + 1);
    return;
  }
  for (int64_t k = 0; k < size; k += stride)
    for (int l = 0; l < SMG_LEVELS; ++l) smg_take_miss(s, l, s->u[k] - smg_extrapolate(s, k, l));
  smg_choose_level(s);
}
#else
/* The components k, k + stride, .. of a, as many as there are lanes; 0 beyond the last one. */
static inline smg_lanes smg_sampled(const smg_real *a, int64_t k, int64_t stride, int64_t size) {
  smg_real x[SMG_LANES] = {0};
  if (stride == 1 && k + SMG_LANES <= size) return smg_lane_take(a + k);
  for (int l = 0; l < SMG_LANES && k + l * stride < size; ++l) x[l] = a[k + l * stride];
  return smg_lane_take(x);
}

/* miss[d] += the error, squared, that every degree would have made in these components of the step just solved. */
static inline void smg_sampled_misses(const smg_state *s, int64_t k, int64_t stride, int64_t size, smg_lanes *miss) {
  smg_lanes row[SMG_HISTORY + 1];
  row[0] = smg_sampled(s->u, k, stride, size);
  for (int j = 0; j < s->history; ++j) row[j + 1] = smg_sampled(s->past[j], k, stride, size);
  smg_lane_add_misses(s->history, row, miss);
}

/* Which degree would have served best? A sample of the components decides, now and then. */
static void smg_choose_degree(smg_state *s) {
  const int64_t size = 3 * smg_sites(&s->c), stride = 1 + size / 256;
  smg_lanes miss[SMG_SUMS / SMG_LANES][SMG_HISTORY];
  smg_real total[SMG_HISTORY] = {0};
  for (int k = 0; k < SMG_SUMS / SMG_LANES; ++k)
    for (int d = 0; d < s->history; ++d) miss[k][d] = smg_lane_of(0);
  for (int64_t n = 0; n * stride < size; n += SMG_LANES)
    smg_sampled_misses(s, n * stride, stride, size, miss[n / SMG_LANES % (SMG_SUMS / SMG_LANES)]);
  for (int l = 0; l < SMG_SUMS; ++l)
    for (int d = 0; d < s->history; ++d) total[d] += smg_lane_get(&miss[l / SMG_LANES][d], l % SMG_LANES);
  s->degree = s->history > 0 ? smg_best_degree(s->history, total) : SMG_NO_DEGREE;
}

#endif
#endif
