/* smidgen method: the rows of smg_extrapolation.h, and their weights W_j/j in parts of 1/smg_tableau_unit. */
#ifndef SMG_TABLEAU_H
#define SMG_TABLEAU_H

#include "smg_small.h"

enum { SMG_TABLEAU_ROWS = 6 };
static const smg_real smg_tableau_weights[SMG_TABLEAU_ROWS] = {-66, 84480, -3247695, 23068672, -48828125, 30233088};
static const smg_real smg_tableau_unit = 19958400;

/* The part m/n of the step, n = 2j. */
SMG_INLINE smg_real smg_tableau_part(int j, int m) { return (smg_real)m / (smg_real)(2 * j); }

#endif
