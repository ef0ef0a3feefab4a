/* smidgen runtime: vectors in arrays that hold all x, all y and all z, a pitch apart, and in each a number a slot: a
 * vector of lanes takes several slots. */
#ifndef SMG_SLOTS_H
#define SMG_SLOTS_H

#include "smg_lanes.h"

#define SMG_WIDEST 8 /* lanes of the widest registers there are */

/* Slots of as many whole vectors of theirs as n sites fill. */
SMG_INLINE int64_t smg_whole_vectors(int64_t n) { return (n + SMG_WIDEST - 1) / SMG_WIDEST * SMG_WIDEST; }

/* The vectors in some slots, of n components, from the first of them on; from slots of arrays of which there are more
 * than registers (SMG_ANEW). */
SMG_INLINE void smg_take_from(int n, const smg_real *at, int64_t pitch, smg_lanes *v) {
  for (int k = 0; k < n; ++k) v[k] = smg_lane_take(at + k * pitch);
}
SMG_INLINE void smg_put_at(int n, smg_real *at, int64_t pitch, const smg_lanes *v) {
  for (int k = 0; k < n; ++k) smg_lane_put(at + k * pitch, v[k]);
}
SMG_INLINE void smg_take_slots(const smg_real *all, int64_t pitch, int64_t slot, smg_lanes *v) {
  const smg_real *at = all + slot;
  SMG_ANEW(at);
  smg_take_from(3, at, pitch, v);
}
SMG_INLINE void smg_put_slots(smg_real *all, int64_t pitch, int64_t slot, const smg_lanes *v) {
  smg_put_at(3, all + slot, pitch, v);
}

/* part of the radius below which a component of a spin is watched on its own */
#define SMG_SMALL_PART (smg_real)1e-3

/* By which part of what it is made of a component moved, to 13 %, where that is small: no change of the others shows
 * whether it has settled. */
SMG_INLINE smg_lanes smg_part_moved(smg_lanes small, smg_lanes moved, smg_lanes made) {
  return smg_lane_select((smg_lane_mask)(made < small), smg_lane_abs(moved) * smg_lane_rough_inverse(made),
                         smg_lane_of(0));
}

#endif
