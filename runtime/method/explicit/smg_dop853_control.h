/* smidgen method: what an internal step of smg_dop853.h works with: what a build may choose, the limits of the control
 * of its size, and its vectors. */
#ifndef SMG_DOP853_CONTROL_H
#define SMG_DOP853_CONTROL_H

#include "smg_small.h"

#ifndef SMG_PROJECT
#define SMG_PROJECT 0
#endif
#ifndef SMG_FIXED_STEP
#define SMG_FIXED_STEP 0
#endif

#define SMG_GROWTH 6                   /* how much larger the next internal step may be, */
#define SMG_SHRINK ((smg_real)1 / 3)   /* and how much smaller */
#define SMG_SAFETY (smg_real)0.9       /* of the size at which the estimate would just be the tolerance */
#define SMG_LEAST_PART (smg_real)1e-12 /* of h, the smallest internal step */
#define SMG_MOST_TRIES 10000           /* internal steps of one output step, with those refused; */
/* after every so many of them it is given up where more than that are to be expected: the first sizes may be far too
 * small */
#define SMG_LOOK_AHEAD 128
#define SMG_LEAF_ROUNDS 4 /* of Newton's method onto the leaf */

/* s->stages: fourteen vectors of 3 numbers a site, then one number. The places of k_2 and k_3, which neither the
 * increment nor the estimates need, serve the estimates. */
enum { SMG_E5 = 1, SMG_E3, SMG_Y = 12, SMG_Y_COMPENSATION, SMG_STAGE_VECTORS };

/* Bits of 1, and a sixteenth of them, less half of what logarithms are off. */
#define SMG_SIXTEENTH UINT64_C(0x43ee44d013a92c00)

#endif
