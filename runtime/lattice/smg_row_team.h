/* smidgen runtime: threads for the rows of a lattice. With OpenMP (-fopenmp) they share the slots of a colour, and of
 * an array, or the stages of a wavefront (smg_row_wave.h).
 *
 * Sites of a colour do not feel each other, shares begin where vectors of all widths do, and what shares find together
 * is a largest number: so the bits are those of one thread. Sites of one colour that meet across the seam of a ring go
 * one after the other: there one thread does all. */
#ifndef SMG_ROW_TEAM_H
#define SMG_ROW_TEAM_H

#include "smg_row_ranks.h"

#if defined(_OPENMP)
#include <omp.h>
#define SMG_PRAGMA(text) _Pragma(#text)
#define SMG_TEAM(threads) SMG_PRAGMA(omp parallel num_threads(threads))
#define SMG_ONE_BY_ONE SMG_PRAGMA(omp critical)
/* of the loop that follows; all of them end before what comes next */
#define SMG_TURNS_OF_TEAM SMG_PRAGMA(omp for schedule(dynamic, 1))
SMG_INLINE int smg_most_threads(void) { return omp_get_max_threads(); }
SMG_INLINE int smg_thread(void) { return omp_get_thread_num(); }
SMG_INLINE int smg_threads(void) { return omp_get_num_threads(); }
#else
#define SMG_TEAM(threads)
#define SMG_ONE_BY_ONE
#define SMG_TURNS_OF_TEAM
SMG_INLINE int smg_most_threads(void) { return 1; }
SMG_INLINE int smg_thread(void) { return 0; }
SMG_INLINE int smg_threads(void) { return 1; }
#endif

#define SMG_STRIPS_APART 4 /* for each thread */

/* The k-th of n parts of whole vectors. */
SMG_INLINE smg_share smg_part_of(smg_share all, int64_t k, int64_t n) {
  if (n == 1) return all;
  const int64_t vectors = (all.to - all.from + SMG_WIDEST - 1) / SMG_WIDEST;
  const smg_share part = {all.from + vectors * k / n * SMG_WIDEST, all.from + vectors * (k + 1) / n * SMG_WIDEST};
  return part;
}

/* The slots of n colours from one on; the part of this rank in them; that of this thread in slots of its rank, and in
 * those colours. */
SMG_INLINE smg_share smg_colours_from(const smg_coefficients *c, int64_t colour, int64_t n) {
  const smg_share all = {colour * smg_colour_slots(c), (colour + n) * smg_colour_slots(c)};
  return all;
}
SMG_INLINE smg_share smg_share_of_rank(const smg_coefficients *c, int64_t colour, int64_t n) {
  return smg_part_of_rank(c, smg_colours_from(c, colour, n));
}
SMG_INLINE smg_share smg_share_of_thread(smg_share all) { return smg_part_of(all, smg_thread(), smg_threads()); }
SMG_INLINE smg_share smg_share_of(const smg_coefficients *c, int64_t colour, int64_t n) {
  return smg_share_of_thread(smg_share_of_rank(c, colour, n));
}

/* The slots of a rank may be several strips in a colour (smg_row_grid.h): the k-th one, and what a thread has of it,
 * strips as they are where there are many. */
#if SMG_GRID
#define smg_strip_of_thread(c, colour, n, k) smg_thread_strip(c, colour, &smg_my_box, k)
static smg_share smg_work_of_rank(SMG_UNUSED const smg_coefficients *c) {
  const smg_share all = {0, smg_box_slots(&smg_my_box)};
  return all;
}
static smg_share smg_thread_strip(const smg_coefficients *c, int64_t colour, const smg_box *b, int64_t k) {
  const int64_t strips = smg_strips(c, b), threads = smg_threads();
  const smg_share strip = smg_strip(c, colour, b, k), none = {strip.to, strip.to};
  if (strips < SMG_STRIPS_APART * threads) return smg_share_of_thread(strip);
  return k * threads / strips == smg_thread() ? strip : none;
}
#else
#define SMG_STRIPS(c, k)
#define smg_strip_of_rank(c, colour, n, k) smg_share_of_rank(c, colour, n)
#define smg_strip_of_thread(c, colour, n, k) smg_share_of(c, colour, n)
#define smg_work_of_rank(c) smg_share_of_rank(c, 0, 1)
#endif

/* As many of a team as some slots are worth. */
static inline int smg_team_for(smg_share slots, int team) {
  const int64_t worth = (slots.to - slots.from) / SMG_SHARE;
  return worth < 1 ? 1 : worth < team ? (int)worth : team;
}

/* Threads for the steps of a lattice. */
static inline int smg_row_team(const smg_coefficients *c) {
  return smg_colours_meet(c) ? 1 : smg_team_for(smg_work_of_rank(c), smg_most_threads());
}

#endif
