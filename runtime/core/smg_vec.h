/* smidgen runtime: three components by value, so that they stay in registers. */
#ifndef SMG_VEC_H
#define SMG_VEC_H

#include "smg_small.h"

typedef struct smg_vec {
  smg_real x, y, z;
} smg_vec;

SMG_INLINE smg_vec smg_vec_of(smg_real x, smg_real y, smg_real z) {
  smg_vec v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
SMG_INLINE void smg_vec_store(smg_real *w, smg_vec a) {
  w[0] = a.x;
  w[1] = a.y;
  w[2] = a.z;
}
SMG_INLINE smg_vec smg_vec_load(const smg_real *w) { return smg_vec_of(w[0], w[1], w[2]); }
SMG_INLINE smg_vec smg_vec_add(smg_vec a, smg_vec b) { return smg_vec_of(a.x + b.x, a.y + b.y, a.z + b.z); }
SMG_INLINE smg_vec smg_vec_sub(smg_vec a, smg_vec b) { return smg_vec_of(a.x - b.x, a.y - b.y, a.z - b.z); }
SMG_INLINE smg_vec smg_vec_scale(smg_real c, smg_vec a) { return smg_vec_of(c * a.x, c * a.y, c * a.z); }
SMG_INLINE smg_real smg_vec_dot(smg_vec a, smg_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SMG_INLINE smg_vec smg_vec_cross(smg_vec a, smg_vec b) {
  return smg_vec_of(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
SMG_INLINE smg_real smg_larger(smg_real a, smg_real b) { return a > b ? a : b; }
SMG_INLINE smg_real smg_vec_largest(smg_vec a) {
  return smg_larger(smg_abs(a.x), smg_larger(smg_abs(a.y), smg_abs(a.z)));
}

#endif
