/* smidgen runtime: the words of templates, for one number.
 *
 * A template is a header (smg_*_template.h) whose text is compiled for one number, and between smg_in_lanes.h and
 * smg_in_numbers.h once more for the numbers in SMG_LANES lanes, by the same operations in the same order: so each lane
 * has the bits that one number has. smg_number is a number or its lanes, smg_test what a comparison says of them. The
 * function of lanes that a template calls smg_x is called smg_lane_x elsewhere. */
#ifndef SMG_TEMPLATE_H
#define SMG_TEMPLATE_H

#include "smg_small.h"

typedef smg_real smg_number;
typedef int smg_test, smg_count;

/* x in every lane. */
SMG_INLINE smg_real smg_of(smg_real x) { return x; }

/* The same test in every lane. */
SMG_INLINE smg_test smg_all(int test) { return test; }

/* a where the test holds, else b. */
SMG_INLINE smg_real smg_select(smg_test test, smg_real a, smg_real b) { return test ? a : b; }

/* Both tests, and one of them. For one number the second is left out where the first decides: 5 % of the instructions
 * of a step of a single sphere. */
#define SMG_AND &&
#define SMG_OR ||
SMG_INLINE smg_test smg_not(smg_test test) { return !test; }

/* Does it hold anywhere? */
SMG_INLINE int smg_any(smg_test test) { return test; }

/* One more than n where it holds. */
SMG_INLINE smg_count smg_counted(smg_count n, smg_test test) { return n + test; }

/* As a number. */
SMG_INLINE smg_real smg_number_of(smg_count n) { return (smg_real)n; }

SMG_INLINE smg_real smg_sqrt(smg_real x) { return SMG_MATH(sqrt)(x); }

/* The smaller and the larger; b where either is not a number. */
SMG_INLINE smg_real smg_smaller(smg_real a, smg_real b) { return a < b ? a : b; }
SMG_INLINE smg_real smg_larger(smg_real a, smg_real b) { return a > b ? a : b; }

#endif
