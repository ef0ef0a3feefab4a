/* smidgen method: Gauss collocation of SMG_STAGES = s = 1 .. 8 stages, of order 2s, in the variables z in C^2 of every
 * site (McLachlan, Modin, Verdier, Collective symplectic integrators): symplectic on spheres and in R^3.
 *
 * w_k = z* sigma_k z, |w| = |z|^2, sigma the Pauli matrices. H is taken at p = r w/|w|, r = |w| before the step, so
 * constant along rays, as the spherical midpoint method has it; w' = w x b, b = (1/kappa) dH/dw at p, is the image of
 *
 *     z' = F(z) = (i/2) (r/|z|^2) (b.sigma - b.p/r) z,     F orthogonal to z,
 *
 * a Hamiltonian system with H(p(z)). Gauss collocation keeps |z|^2, so |w|, and commutes with the phase of z, so it is
 * a method for w; one stage is the spherical midpoint method. One step, with L_j = h b_j F(Z_j) and the shares
 * a_ij/b_j:
 *
 *     Z_i = z + sum_j (a_ij/b_j) L_j,     dz = sum_j L_j,     u = W - w = 2 B(z + dz/2, dz),
 *
 * B(z, z) = w(z) bilinear: no difference of nearby numbers is taken. Z_i and L_i are found by fixed-point iteration
 * over all stages at once, in the lanes of vectors (smg_lanes.h): the same bits for any number of lanes. The lanes are
 * stages (smg_gauss_stages.h), or on lattices sites (smg_gauss_sweep.h); the step is one text for both
 * (smg_gauss_step.h, over the formulas of one site in smg_gauss_site.h).
 *
 * |w| of a sphere is its r, as init put it there, not the root of a sum of squares: that falls on the same few numbers
 * for good, whose rounding errors are mostly of one sign, and z too short by d makes u turn a w too short, |W| less
 * than |w| by d |u|^2/2. So |w| drifted, by some 1e-3 ulp a step of random spins (order 8, h = 0.2). With r it walks at
 * random.
 *
 * What b has along w turns no spin: with H as its formula has it off the sphere, it would turn the phase of z all the
 * same. Without it the stages of spins in the field of parallel neighbours hardly move: on the chain of 100 (h = 1,
 * four stages) the error is 190 times smaller.
 *
 * The iteration ends where the w of a step are right to s->tolerance, as its last two changes tell; 0: where nothing
 * moves but by round-off, as long runs need it. Only then are changes measured next to the size of what changes too,
 * which takes a division: a tenth of a sweep.
 *
 * Of the model it needs SMG_STAGES, SMG_HISTORY 1, and beside w, compensation and u one array, s->stages, of
 * SMG_STAGES_SIZE(sites) numbers. Where SMG_HAS_LANES says so it gives smg_lane_gradient(c, w, g) beside
 * smg_gradient(c, w, g), the same for arrays of smg_lanes, each lane a state of its own. Where SMG_ROW_STAGES says so,
 * it gives what smg_rows.h asks for, and the array s->stages has smg_stages_size(c) numbers; there is no u then. */
#ifndef SMG_GAUSS_H
#define SMG_GAUSS_H

#include "smg_gauss_step.h"

#if SMG_ROW_STAGES
#include "smg_gauss_rows.h"
#else
static smg_status smg_step(smg_state *s) {
  smg_gauss_work a = smg_work_of(s);
  return smg_collocate(s, &a);
}
#endif

#include "smg_steps.h"

#endif
