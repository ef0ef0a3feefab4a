/* smidgen method: each sublattice turned in the frozen field of the others, for H linear in every single site:
 * explicit, of order 2, the energy kept to round-off. It is NOT symplectic: it is made of parts w_k' = w_k x b_k of the
 * motion that are no Hamiltonian motions by themselves, since the others, which H moves too, stand still meanwhile.
 *
 * b_k = (1/kappa_k) dH/dw_k depends on the others alone, and H = w_k.dH/dw_k + what w_k is not in: a turn of w_k about
 * b_k by whatever angle keeps H, and the volume. The angle is that whose half has the tangent |g|, g = (h/2) b_k: right
 * to third order, and easy to take (smg_turn_template.h). With the last turn of a stage the length comes some of the
 * way back to what it was.
 *
 * Sites of one colour do not feel each other, so that their order is of no account. A step is the symmetric splitting:
 * the colours one after the other for h/2, the last for h, and back. With SMG_COMPOSED it is so many of these
 * (smg_explicit_step.h).
 *
 * On a lattice whose sites are alike it goes by rows, sites in lanes (smg_sublattice_rows.h), where SMG_ROW_TURNS says
 * so.
 *
 * Of the model it needs smg_colours(c), smg_each_of_colour(c, colour, context, visit), smg_pull(c, at, all, g): g +=
 * dH/dw of the site `at`; and beside w, compensation and u the arrays
 * s->points, 3 numbers a site, and s->inverse, 1. */
#ifndef SMG_SUBLATTICE_ROTATIONS_H
#define SMG_SUBLATTICE_ROTATIONS_H

#define SMG_ONTO_LEAF 0
#define SMG_TURNS_ADDED 1

#include "smg_model.h"
#include "smg_explicit.h"

/* What a visit works on: the state, and h; last: of the turns of a stage, which brings lengths back as well. */
typedef struct smg_sublattice_turning {
  smg_state *s;
  smg_real h;
  int last;
} smg_sublattice_turning;

/* One site about the field of the others. */
static inline void smg_turn_in_field(void *context, smg_lattice_site at) {
  const smg_sublattice_turning *turning = (const smg_sublattice_turning *)context;
  const smg_state *s = turning->s;
  smg_real g[3] = {0, 0, 0};
  smg_pull(&s->c, at, s->points, g);
  smg_scale(g, 0.5 * smg_h_over_kappa(&s->c, at.k, turning->h), 3);
  smg_turn_one(g, s->inverse[at.k], turning->last, s->points + 3 * at.k, s->u + 3 * at.k);
}

/* Colour after colour, and back. */
static inline void smg_stage(smg_state *s, smg_real h) {
  const int64_t n = smg_colours(&s->c);
  for (int64_t k = 0; k < 2 * n - 1; ++k) {
    smg_sublattice_turning turning = {s, smg_turn_h(k, n, h), k >= n - 1};
    smg_each_of_colour(&s->c, smg_there_and_back(k, n), &turning, smg_turn_in_field);
  }
}

#include "smg_explicit_step.h"

#endif
