/* smidgen runtime: how far polynomials of every degree have missed a value; a template (smg_template.h). */
#include "smg_template.h"

/* miss[d] += the error, squared, that each of so many degrees would have made in the newest value, row[0]: the backward
 * difference of order d + 1. row, which holds degrees + 1 values, is used up. */
SMG_INLINE void smg_add_misses(int degrees, smg_number *row, smg_number *miss) {
  for (int d = 0; d < degrees; ++d) {
    for (int j = 0; j < degrees - d; ++j) row[j] -= row[j + 1];
    miss[d] += row[0] * row[0];
  }
}
