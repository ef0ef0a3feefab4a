/* smidgen runtime: the polynomial through values at equal steps, newest first: one step on, and which degree would have
 * served best. */
#ifndef SMG_POLYNOMIAL_H
#define SMG_POLYNOMIAL_H

#include "smg_misses_template.h"

#define SMG_MOST_HISTORY 12 /* values that the weights below serve */

/* The polynomial of degree d through the last d + 1 values, one step on: weights (-1)^j C(d+1, j+1). */
static inline smg_real smg_weight(int degree, int j) {
  static const smg_real weights[SMG_MOST_HISTORY][SMG_MOST_HISTORY] = {
      {1},
      {2, -1},
      {3, -3, 1},
      {4, -6, 4, -1},
      {5, -10, 10, -5, 1},
      {6, -15, 20, -15, 6, -1},
      {7, -21, 35, -35, 21, -7, 1},
      {8, -28, 56, -70, 56, -28, 8, -1},
      {9, -36, 84, -126, 126, -84, 36, -9, 1},
      {10, -45, 120, -210, 252, -210, 120, -45, 10, -1},
      {11, -55, 165, -330, 462, -462, 330, -165, 55, -11, 1},
      {12, -66, 220, -495, 792, -924, 792, -495, 220, -66, 12, -1}};
  return weights[degree][j];
}

/* The degree that missed by least, of at least one. */
static inline int smg_best_degree(int degrees, const smg_real *miss) {
  int best = 0;
  for (int d = 1; d < degrees; ++d)
    if (miss[d] < miss[best]) best = d;
  return best;
}

#endif
