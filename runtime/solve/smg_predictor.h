/* smidgen runtime: the first iterate of a step, a polynomial through the increments of the steps before; its degree adapts. */
#ifndef SMG_PREDICTOR_H
#define SMG_PREDICTOR_H

#include "smg_model.h"

#if SMG_COMPOSED
#include "smg_stage_predictor.h"
#else

/* Is it time to look which degree serves best? */
static inline int smg_time_to_choose(const smg_state *s) { return s->history < SMG_HISTORY || s->count % 16 == 0; }

/* The polynomial of degree d through the last d + 1 increments, one step on: weights (-1)^j C(d+1, j+1). */
static inline smg_real smg_weight(int degree, int j) {
  static const smg_real weights[7][7] = {{1}, {2, -1}, {3, -3, 1}, {4, -6, 4, -1}, {5, -10, 10, -5, 1}, {6, -15, 20, -15, 6, -1}, {7, -21, 35, -35, 21, -7, 1}};
  return weights[degree][j];
}

static inline smg_real smg_extrapolate(const smg_state *s, int64_t k, int degree) {
  smg_real sum = 0;
  for (int j = 0; j <= degree; ++j) sum += smg_weight(degree, j) * s->past[j][k];
  return sum;
}

/* The error that every degree would have made in component k of the step just solved, squared: the backward difference of
 * order d + 1. */
static inline void smg_predictor_misses(const smg_state *s, int64_t k, smg_real *miss) {
  smg_real row[SMG_HISTORY + 1];
  row[0] = s->u[k];
  for (int j = 0; j < s->history; ++j) row[j + 1] = s->past[j][k];
  for (int d = 0; d < s->history; ++d) {
    for (int j = 0; j < s->history - d; ++j) row[j] -= row[j + 1];
    miss[d] += row[0] * row[0];
  }
}

/* Which degree would have served best? A sample of the components decides, now and then. */
static void smg_choose_degree(smg_state *s) {
  const int64_t size = 3 * smg_sites(&s->c), stride = 1 + size / 256;
  smg_real miss[SMG_HISTORY] = {0};
  for (int64_t k = 0; k < size; k += stride) smg_predictor_misses(s, k, miss);
  s->degree = s->history > 0 ? 0 : -1;
  for (int d = 1; d < s->history; ++d)
    if (miss[d] < miss[s->degree]) s->degree = d;
}

#endif
#endif
