/* smidgen method: the first iterate of a stage of a composition, from the increments of the stages before it.
 *
 * Stages differ in size and sign, so no polynomial in time goes through their increments. The weights
 * smg_stage_weights[i][l], l the level, know how an increment depends on the size of its stage and on the error so far:
 * tests/coefficients/compositions.py has the functions for which they are right. The history is one for all stages, the
 * last SMG_HISTORY increments whatever their stage. */
#ifndef SMG_STAGE_PREDICTOR_H
#define SMG_STAGE_PREDICTOR_H

#include "smg_level_misses_template.h"

#define SMG_MOST_DEGREE(history) smg_highest_level(history)

/* Is it time to look which level serves best? While the history grows, and then through all stages of every sixteenth
 * step. full: increments that are kept. */
static inline int smg_time_to_choose(const smg_state *s, int full) { return s->history < full || s->count % 16 == 2; }

/* s->misses: for every level the squared errors of a step's stages so far, and of how many stages they are. After the
 * last stage the level of least error is chosen. */
static inline void smg_choose_level(smg_state *s) {
  s->misses[SMG_LEVELS] += 1;
  if (s->misses[SMG_LEVELS] < SMG_COMPOSED) return;
  s->degree = 0;
  for (int l = 1; l < SMG_LEVELS; ++l)
    if (s->misses[l] <= s->misses[s->degree]) s->degree = l;
}

/* A level has missed a value of the stage just solved by so much. */
static inline void smg_take_miss(smg_state *s, int level, smg_real miss) { s->misses[level] += miss * miss; }

/* How many increments a level takes, and the weight of the j-th in the stage under way. */
static inline int smg_terms(int level) { return level < 0 ? 0 : smg_span(level); }
static inline smg_real smg_past_weight(const smg_state *s, int level, int j) {
  return (smg_real)smg_stage_weights[s->stage][level][j];
}

#if SMG_SINGLE_SPHERE
/* The row of the stage under way, (u, gamma q), from the rows before it; q = 1/|w + W| depends on the stages as u/gamma
 * does. */
SMG_INLINE smg_vec smg_sphere_predict(smg_state *s, smg_real *q) {
  const smg_real *row = s->rows + 4 * s->row;
  const double *a = smg_stage_weights[s->stage][s->degree];
  smg_real sum[4] = {0, 0, 0, 0};
  SMG_UNROLL
  for (int j = SMG_HISTORY - 1; j >= 0; --j)
    for (int i = 0; i < 4; ++i) sum[i] += (smg_real)a[j] * row[4 * j + i];
  *q = sum[3] * (smg_real)smg_inverse_gamma[s->stage];
  return smg_vec_of(sum[0], sum[1], sum[2]);
}

/* The error that every level would have made in the newest row, squared. */
SMG_COLD static void smg_stage_misses(smg_state *s) {
  for (int i = 0; i < 3; ++i) {
    smg_real row[SMG_HISTORY + 1];
    for (int j = 0; j <= SMG_HISTORY; ++j) row[j] = s->rows[4 * (s->row + j) + i];
    smg_add_level_misses(s->stage, row, s->misses);
  }
  smg_choose_level(s);
}

/* A stage has its row in the history. */
SMG_INLINE void smg_stage_done(smg_state *s) {
  if (s->history < SMG_HISTORY) s->degree = smg_highest_level(++s->history);
  else if (smg_time_to_choose(s, SMG_HISTORY)) smg_stage_misses(s);
  ++s->stage;
}
#endif

#endif
