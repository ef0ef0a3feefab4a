/* smidgen runtime: the sites that this process has, from <= k < to: all of them, unless ranks of MPI divide the memory
 * of a model (SMG_DISTRIBUTED, -DSMG_MPI; smg_row_parts.h). Of all other sites nothing is known then, but of those
 * that terms of its own sites reach. */
#ifndef SMG_OWN_H
#define SMG_OWN_H

#include "smg_arrays.h"

/* Are the parts of ranks blocks of cells (smg_row_grid.h)? May this lattice be cut so? */
#if defined(SMG_MPI) && defined(SMG_MPI_GRID) && SMG_BY_ROWS && !SMG_ROW_TURNS
#define SMG_GRID 1
static int smg_may_cut(const smg_coefficients *c);
#else
#define SMG_GRID 0
#define smg_may_cut(c) 1
#endif

#if SMG_DISTRIBUTED && defined(SMG_MPI)
#define SMG_IN_PARTS 1
static struct { int64_t from, to; } smg_own;
#define smg_own_from(c) smg_own.from
#define smg_own_to(c) smg_own.to
/* A loop over layers, cells or sites, `per` sites each, of which there are some from `start` on. */
SMG_INLINE int64_t smg_part_begin(int64_t start, int64_t per) {
  return smg_own.from / per > start ? smg_own.from / per : start;
}
SMG_INLINE int64_t smg_part_end(int64_t end, int64_t per) { return smg_own.to / per < end ? smg_own.to / per : end; }

/* Which they are; defined by smg_row_ranks.h, as is what all ranks come to know together. */
static void smg_choose_ranks(const smg_coefficients *c);
static void smg_largest_of_ranks(smg_real *a, smg_real *b);
static smg_status smg_status_of_ranks(smg_status status, int64_t *site);
static void smg_share_ends(const smg_coefficients *c, smg_real *w);
static int smg_is_divided(void);
static size_t smg_next_saved(const smg_coefficients *c, size_t k, size_t head);
#define smg_choose_own(c) smg_choose_ranks(c)
#if SMG_GRID
enum smg_carried_where { SMG_TO_LAYERS, SMG_TO_BLOCKS, SMG_DROPPED };
#endif
#define smg_largest_of_all(a) smg_largest_of_ranks(a, a)
#else
#define SMG_IN_PARTS 0
#define smg_own_from(c) 0
#define smg_own_to(c) smg_sites(c)
#define smg_part_begin(start, per) (start)
#define smg_part_end(end, per) (end)
#define smg_choose_own(c) (void)0
#define smg_status_of_ranks(status, site) (status)
#define smg_share_ends(c, w) (void)0
#define smg_release_other(s) (void)0
#define smg_largest_of_all(a) (void)0
#define smg_is_divided() 0
#define smg_next_saved(c, k, head) ((k) + 1)
#endif

/* What has layers beside blocks (smg_row_layers.h): w by slots, and what else a saved state has. */
#define SMG_LAYERS_APART (SMG_IN_PARTS && SMG_GRID)
#if !SMG_LAYERS_APART
#define smg_hold_layers(c) (void)0
#define smg_carry_w(s, where) (void)0
#define smg_move_saved(s, where) (void)0
#endif

#endif
