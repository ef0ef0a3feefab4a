/* smidgen runtime: the levels of the predictor of stages (smg_stage_predictor.h), each with weights of its own. */
#ifndef SMG_LEVELS_H
#define SMG_LEVELS_H

#include "smg_model.h"

#define SMG_LEVELS 4

/* How many stages a level looks back. */
static inline int smg_span(int level) {
  static const int span[SMG_LEVELS] = {1, 3, 6, 8};
  return span[level];
}

/* The highest level that `stages` of them serve. */
static inline int smg_highest_level(int stages) {
  int level = 0;
  while (level + 1 < SMG_LEVELS && smg_span(level + 1) <= stages) ++level;
  return level;
}

#endif
