/* smidgen runtime: the sum of many values, in an order that lanes follow: the k-th one goes into the partial sum k mod
 * SMG_PARTS, with what rounding cuts off (Kahan), and partial sums are added up in their order. So the sum has the same
 * bits for any number of lanes, and does not wait for one addition after the other. */
#ifndef SMG_SUM_H
#define SMG_SUM_H

#include "smg_lanes.h"
#include "smg_own.h"

#define SMG_PARTS 16
#define SMG_HELD 256 /* values that a loop finds before they are added, at most */

typedef struct smg_sum {
  int64_t count; /* of those that are held */
  smg_real parts[SMG_PARTS], lost[SMG_PARTS], held[SMG_HELD + SMG_PARTS];
} smg_sum;

/* The sum of none. */
#define SMG_NO_SUM     \
  {                    \
    0, {0}, {0}, { 0 } \
  }

/* Those of whole rounds are added, the others stay. */
static inline void smg_add_held(smg_sum *s) {
  const int64_t whole = s->count - s->count % SMG_PARTS;
  for (int p = 0; p < SMG_PARTS; p += SMG_LANES) {
    smg_lanes sum = smg_lane_take(s->parts + p), lost = smg_lane_take(s->lost + p);
    for (int64_t k = p; k < whole; k += SMG_PARTS) smg_lane_add_compensated(&sum, &lost, smg_lane_take(s->held + k));
    smg_lane_put(s->parts + p, sum);
    smg_lane_put(s->lost + p, lost);
  }
  s->count -= whole;
  for (int64_t k = 0; k < s->count; ++k) s->held[k] = s->held[whole + k];
}

/* The place of the next n values, at most SMG_HELD. */
SMG_INLINE smg_real *smg_sum_room(smg_sum *s, int64_t n) {
  if (s->count + n > SMG_HELD + SMG_PARTS) smg_add_held(s);
  s->count += n;
  return s->held + s->count - n;
}

/* Where a loop from k on that ends at `end` has found as many as there is room for. */
static inline int64_t smg_held_end(int64_t k, int64_t end) { return end - k > SMG_HELD ? k + SMG_HELD : end; }

static inline smg_real smg_sum_of(smg_sum *s) {
  smg_real sum = 0, lost = 0;
  while (s->count % SMG_PARTS > 0) s->held[s->count++] = 0;
  smg_add_held(s);
  for (int p = 0; p < SMG_PARTS; ++p) {
    smg_add_compensated(&sum, &lost, s->parts[p]);
    smg_add_compensated(&sum, &lost, s->lost[p]);
  }
  return sum + lost;
}

/* Of the sites of all ranks, where they divide them (smg_row_parts.h). */
#if SMG_IN_PARTS
static void smg_sum_go_on(smg_sum *s);
static smg_real smg_sum_of_ranks(smg_sum *s);
#else
#define smg_sum_go_on(s) (void)0
#define smg_sum_of_ranks(s) smg_sum_of(s)
#endif

#endif
