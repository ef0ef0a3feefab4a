/* smidgen runtime: the thresholds of the solvers. Those of stagnation stand in smg_site.h, of the curve in
 * smg_follow.h, of Krylov spaces in smg_krylov.h. What each does at half and at twice its value: docs/thresholds.md;
 * "either way the same" says that the same steps are found and refused then, with drifts that cannot be told apart. */
#ifndef SMG_TOLERANCES_H
#define SMG_TOLERANCES_H

/* Iterations. A solution that Newton finds takes 3 to 8; either way the same, but with 3 % fewer iterations or 5 %
 * more, those of refusals. */
#define SMG_MAX_NEWTON 30

/* Ulps of the state and of the products in h X that settled sweeps may leave as residual: with more of them Newton
 * decides. Sweeps that solve the step leave less than half of it. */
#define SMG_SWEEP_ULPS 32

/* Steps that stay with Newton after sweeps failed, of which each costs its dozen in vain. Speed alone. */
#define SMG_NEWTON_STEPS 255

/* Row sums of J - I up to which it is a contraction. The eigenvalues of J are then 1/4 or farther from 0 (Gershgorin),
 * as far as the symmetric part of a coercive J is. Either way the same, with 9 % fewer iterations or 11 % more. */
#define SMG_CONTRACTS (smg_real)0.75

/* And up to which coercivity is tried, before the curve is followed. Speed alone: either way, and with 0, the same. */
#define SMG_CLEAR 4

/* Part of the way to the solution by which Newton's correction from W = w may miss it, without the curve being
 * followed: 1/2 is where Kantorovich's theorem ends. Two spins with random energies of degree 4, 60,000 orbits with
 * 193,000 steps beyond SMG_CONTRACTS: none ends on another branch; with 3/4, four do, without this rule 28. */
#define SMG_REACH_OF_NEWTON (smg_real)0.5

/* Row sums of J - I up to which a plain evaluation ends a step. It enlarges nothing up to 1, but a step near the cone
 * of a Nambu leaf is then refused (tests/hard/nambu.py, k = .1, u = 2). Energy of a free body on two orbits, 40000
 * steps: at h = 1.2 off by 35 and 14 ulps with 3/4, by 6 and 2 with 1 and with 2; at h = 4 by 84 and 51 with 2, by 1
 * and 21 with 1. */
#define SMG_DAMPS 2

/* Part of the round-off of an iteration that the evaluations after it may leave, and how many they may be: what is left
 * is of one sign along many an orbit, a drift. With these, errors grow like a random walk to 1e8 steps
 * (docs/round_off.md). Each either way the same over 1500 steps. */
#define SMG_LEFT (smg_real)0.05
#define SMG_REFINEMENTS 8

/* Rounds of Newton on the increment of a non-contractive step; the second is the last unless the field is rough. Either
 * way the same. */
#define SMG_ROUNDS 5

/* Part of the state: a residual below has nearly settled. One more correction squares it, 1e-18 < ulp. A thousandth or
 * a thousandfold: the same. */
#define SMG_NEARLY 1e-9

/* Ulps of round-off that a non-contractive step may leave. Either way the same; none at all loses one first step in
 * eight. */
#define SMG_ULPS 4

/* Part of the state that round-off of any kind must stay below: beyond, anything looks like it. Either way the same. */
#define SMG_BLIND (smg_real)1e-3

/* Ulps of a change that shows what rounding does to a formula: so many that the rounding of the changed formula is a
 * small part of what they do, so few that a formula with three digits left is still linear. Either way the same. */
#define SMG_PROBE 1024

/* Iterations after which only round-off can keep the residual up: Newton from an error of the size of the state has 1,
 * 2, 4, 8, 16 digits. Half of it: 1 % more iterations; twice: the same. */
#define SMG_LATE 4

/* Products in an increment beyond this many radii: a step that turns spins far, whose h X brings as many times the
 * round-off of m. Either way the same. */
#define SMG_STRONG_FIELD 4

/* Steps of the continuation in h, of the divided method alone. Half of it loses one step in 110 tried, twice finds no
 * more. */
#define SMG_CONTINUATION_STEPS 16

/* Of a single sphere (smg_sphere_template.h). The square of a Newton change whose remainder is far below round-off: a
 * larger one would leave a drift. */
#define SMG_SMALL (SMG_EPS / 64)
/* The square of a change of a tenth: from a larger one a second iteration there would not settle; Newton with a matrix
 * takes over. */
#define SMG_SECOND (smg_real)0.01
/* Newton iterations in a row: from a tenth the changes are 1e-1, 1e-2, 1e-4, 1e-8, 1e-16, and one more. */
#define SMG_MOST_IN_A_ROW 6
/* The part of the square of a change that the next one may be: those that fall by less than 4 are not Newton's of one
 * solution. */
#define SMG_FALLS (smg_real)0.0625

#endif
