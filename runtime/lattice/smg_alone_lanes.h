/* smidgen runtime: sites that are solved alone, several in lanes, by the iteration of smg_few_step.h, tried before each
 * is solved by Newton.
 *
 * Blocks are cut alike for all SMG_LANES. A site whose equation is no contraction at its extrapolated midpoint is left
 * to Newton; the others are iterated together, and accepted where it is one at their solution too, as a site alone is
 * by Newton (smg_site_newton). */
#ifndef SMG_ALONE_LANES_H
#define SMG_ALONE_LANES_H

#include "smg_few_step.h"

#define SMG_ALONE_BLOCK 64 /* sites: as many as there are bits */

/* Which sites of a block serve, as bits: those of the others no longer move. */
static uint64_t smg_alone_served(const smg_state *s, const smg_few_sites *b) {
  const smg_told told = smg_told_of(&s->c, b->first);
  uint64_t served = 0;
  smg_few_midpoints(b->a, b->sites, b->pitch);
  for (int64_t i = 0; i < b->sites; i += SMG_LANES) {
    smg_few_motion found = smg_few_still();
    smg_lanes g[4];
    smg_few_norms_at(s, b, i, g);
    smg_few_rows(&told, b->a, b->pitch, i, b->sites - i, g, g[3], &found);
    for (int l = 0; l < SMG_LANES && i + l < b->sites; ++l)
      if (smg_contracts(smg_lane_get(&found.row, l)) && smg_lane_get(&found.products, l) <= s->scale * s->scale)
        served |= (uint64_t)1 << (i + l);
      else b->a[SMG_FEW_HALF * b->pitch + i + l] = 0;
  }
  return served;
}

/* The increments of a block of sites from the first on, as bits those of which they solve the step. */
static uint64_t smg_solve_block(smg_state *s, smg_real h, int64_t first, int64_t sites) {
  SMG_LINES smg_real room[SMG_FEW_ARRAYS * SMG_ALONE_BLOCK];
  const smg_few_sites b = {room, first, sites, SMG_ALONE_BLOCK};
  const int small = smg_few_enter(s, h, &b);
  const uint64_t served = smg_alone_served(s, &b);
  const smg_real rows = served ? smg_few_settle(s, &b, small) : 0;
  if (!(rows > 0 && smg_few_solved(s, &b, rows))) return 0;
  smg_few_leave(s, &b);
  return served;
}

/* Is the n-th site solved with the others of its block? *solved: of that block. */
static int smg_solved_in_lanes(smg_state *s, smg_real h, int64_t n, uint64_t *solved) {
  const int64_t left = smg_alone(&s->c) - n;
  if (n % SMG_ALONE_BLOCK == 0)
    *solved = smg_solve_block(s, h, smg_alone_site(&s->c, n), left < SMG_ALONE_BLOCK ? left : SMG_ALONE_BLOCK);
  return *solved >> n % SMG_ALONE_BLOCK & 1;
}

#endif
