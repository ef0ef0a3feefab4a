/* smidgen runtime: the thresholds of the solvers; those of stagnation stand in smg_site.h, of the curve in smg_follow.h. */
#ifndef SMG_TOLERANCES_H
#define SMG_TOLERANCES_H

#define SMG_MAX_NEWTON 30 /* iterations; a solution that Newton finds takes 3 to 8 */
#define SMG_SWEEP_ULPS 32 /* ulps of the state and of the products in h X that settled sweeps may leave as residual */
#define SMG_NEWTON_STEPS 255 /* steps that stay with Newton after sweeps failed */
#define SMG_CONTRACTS (smg_real)0.75 /* row sums of J - I up to which it is taken for a contraction, */
#define SMG_CLEAR 4 /* and up to which coercivity is tried */
#define SMG_DAMPS 1 /* row sums of J - I beyond which one more plain evaluation might enlarge what is left */
#define SMG_LEFT (smg_real)0.05 /* part of the round-off of an iteration that the evaluations after it may leave, */
#define SMG_REFINEMENTS 8 /* and how many they may be: what is left is of one sign along many an orbit, a drift */
#define SMG_ROUNDS 5 /* of Newton on the increment of a non-contractive step, from where the residual is nearly settled */
#define SMG_NEARLY 1e-9 /* part of the state; one more correction squares it */
#define SMG_NARROW (smg_real)1e12 /* what round-off may grow by near the cone C = 0 of a Nambu factor */
#define SMG_ULPS 4 /* of round-off that a non-contractive step may leave, */
#define SMG_BLIND (smg_real)1e-3 /* as long as it is less than that of the state: beyond, anything looks like round-off */
#define SMG_LATE 4 /* iterations after which only round-off can keep the residual up */
#define SMG_STRONG_FIELD 4 /* products in an increment beyond this many radii: a step that turns spins far */
#define SMG_CONTINUATION_STEPS 16 /* steps of the continuation in h */

#endif
