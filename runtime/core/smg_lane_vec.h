/* smidgen runtime: three components of SMG_LANES vectors at once, as smg_vec.h has those of one: each lane has its
 * bits. */
#ifndef SMG_LANE_VEC_H
#define SMG_LANE_VEC_H

#include "smg_lanes.h"

typedef struct smg_lane_vec {
  smg_lanes x, y, z;
} smg_lane_vec;

SMG_INLINE smg_lane_vec smg_lane_vec_of(smg_lanes x, smg_lanes y, smg_lanes z) {
  smg_lane_vec v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
SMG_INLINE smg_lane_vec smg_lane_vec_load(const smg_lanes *w) { return smg_lane_vec_of(w[0], w[1], w[2]); }
SMG_INLINE void smg_lane_vec_store(smg_lanes *w, smg_lane_vec a) {
  w[0] = a.x;
  w[1] = a.y;
  w[2] = a.z;
}
SMG_INLINE smg_lane_vec smg_lane_vec_add(smg_lane_vec a, smg_lane_vec b) {
  return smg_lane_vec_of(a.x + b.x, a.y + b.y, a.z + b.z);
}
SMG_INLINE smg_lane_vec smg_lane_vec_sub(smg_lane_vec a, smg_lane_vec b) {
  return smg_lane_vec_of(a.x - b.x, a.y - b.y, a.z - b.z);
}
SMG_INLINE smg_lane_vec smg_lane_vec_scale(smg_lanes c, smg_lane_vec a) {
  return smg_lane_vec_of(c * a.x, c * a.y, c * a.z);
}
SMG_INLINE smg_lanes smg_lane_vec_dot(smg_lane_vec a, smg_lane_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SMG_INLINE smg_lane_vec smg_lane_vec_cross(smg_lane_vec a, smg_lane_vec b) {
  return smg_lane_vec_of(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
SMG_INLINE smg_lanes smg_lane_vec_largest(smg_lane_vec a) {
  return smg_lane_larger(smg_lane_abs(a.x), smg_lane_larger(smg_lane_abs(a.y), smg_lane_abs(a.z)));
}
/* a where the test holds, else b. */
SMG_INLINE smg_lane_vec smg_lane_vec_select(smg_lane_mask test, smg_lane_vec a, smg_lane_vec b) {
  return smg_lane_vec_of(smg_lane_select(test, a.x, b.x), smg_lane_select(test, a.y, b.y),
                         smg_lane_select(test, a.z, b.z));
}

#endif
