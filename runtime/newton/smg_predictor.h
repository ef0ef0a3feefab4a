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
#define SMG_SUMS 8 /* that the errors of the components are added up in, by turns */

static inline smg_real smg_extrapolate(const smg_state *s, int64_t k, int degree) {
  smg_real sum = 0;
  for (int j = 0; j <= degree; ++j) sum += smg_weight(degree, j) * s->past[j][k];
  return sum;
}

/* miss[d] += the error, squared, that every degree would have made in the component k of the step just solved. */
static inline void smg_component_misses(const smg_state *s, int64_t k, smg_real *miss) {
  smg_real row[SMG_HISTORY + 1] = {s->u[k]};
  for (int j = 0; j < s->history; ++j) row[j + 1] = s->past[j][k];
  smg_add_misses(s->history, row, miss);
}

/* Which degree would have served best? A sample of the components decides, now and then. */
static void smg_choose_degree(smg_state *s) {
  const int64_t size = 3 * smg_sites(&s->c), stride = 1 + size / 256;
  smg_real miss[SMG_SUMS][SMG_HISTORY] = {{0}}, total[SMG_HISTORY] = {0};
  for (int64_t n = 0; n * stride < size; ++n) smg_component_misses(s, n * stride, miss[n % SMG_SUMS]);
  for (int l = 0; l < SMG_SUMS; ++l) smg_axpy(total, 1, miss[l], s->history);
  s->degree = s->history > 0 ? smg_best_degree(s->history, total) : SMG_NO_DEGREE;
}

#endif
#endif
