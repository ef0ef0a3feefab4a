/* smidgen runtime: the first iterate of a step, a polynomial through the increments of the steps before; its degree
 * adapts. */
#ifndef SMG_PREDICTOR_H
#define SMG_PREDICTOR_H

#include "smg_model.h"
#include "smg_polynomial.h"

#if SMG_COMPOSED
#include "smg_stage_predictor.h"
#else

/* Is it time to look which degree serves best? */
static inline int smg_time_to_choose(const smg_state *s) { return s->history < SMG_HISTORY || s->count % 16 == 0; }

/* the highest degree that so many increments serve */
#define SMG_MOST_DEGREE(history) ((history)-1)
#define SMG_LOOKED 8 /* components that are looked at together, for the compiler to take them in lanes */

static inline smg_real smg_extrapolate(const smg_state *s, int64_t k, int degree) {
  smg_real sum = 0;
  for (int j = 0; j <= degree; ++j) sum += smg_weight(degree, j) * s->past[j][k];
  return sum;
}

/* The error that every degree would have made in the components k, k + stride, .. of the step just solved, squared: the
 * backward difference of order d + 1. */
static inline void smg_predictor_misses(const smg_state *s, int64_t k, int64_t stride, int64_t size,
                                        smg_real (*miss)[SMG_LOOKED]) {
  smg_real row[SMG_HISTORY + 1][SMG_LOOKED] = {{0}};
  for (int l = 0; l < SMG_LOOKED && k + l * stride < size; ++l) {
    row[0][l] = s->u[k + l * stride];
    for (int j = 0; j < s->history; ++j) row[j + 1][l] = s->past[j][k + l * stride];
  }
  for (int d = 0; d < s->history; ++d) {
    for (int j = 0; j < s->history - d; ++j)
      for (int l = 0; l < SMG_LOOKED; ++l) row[j][l] -= row[j + 1][l];
    for (int l = 0; l < SMG_LOOKED; ++l) miss[d][l] += row[0][l] * row[0][l];
  }
}

/* Which degree would have served best? A sample of the components decides, now and then. */
static void smg_choose_degree(smg_state *s) {
  const int64_t size = 3 * smg_sites(&s->c), stride = 1 + size / 256;
  smg_real miss[SMG_HISTORY][SMG_LOOKED] = {{0}}, total[SMG_HISTORY] = {0};
  for (int64_t k = 0; k < size; k += SMG_LOOKED * stride) smg_predictor_misses(s, k, stride, size, miss);
  for (int d = 0; d < s->history; ++d)
    for (int l = 0; l < SMG_LOOKED; ++l) total[d] += miss[d][l];
  s->degree = s->history > 0 ? smg_best_degree(s->history, total) : SMG_NO_DEGREE;
}

#endif
#endif
