/* smidgen runtime: which level of the predictor of stages would have served best; a template (smg_template.h). */
#include "smg_levels.h"
#include "smg_template.h"

/* miss[l] += the error, squared, that every level would have made in the newest value of a stage, row[0]. */
SMG_INLINE void smg_add_level_misses(int stage, const smg_number *row, smg_number *miss) {
  for (int l = 0; l < SMG_LEVELS; ++l) {
    smg_number off = row[0];
    for (int j = 0; j < smg_span(l); ++j) off -= (smg_real)smg_stage_weights[stage][l][j] * row[j + 1];
    miss[l] += off * off;
  }
}
