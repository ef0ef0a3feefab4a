/* smidgen runtime: three components by value, so that they stay in registers; a template (smg_template.h). */
#include "smg_template.h"

/* Is a at most b, and is it less? */
SMG_INLINE smg_test smg_at_most(smg_number a, smg_number b) { return (smg_test)(a <= b); }
SMG_INLINE smg_test smg_less(smg_number a, smg_number b) { return (smg_test)(a < b); }

typedef struct smg_vec {
  smg_number x, y, z;
} smg_vec;

SMG_INLINE smg_vec smg_vec_of(smg_number x, smg_number y, smg_number z) {
  const smg_vec v = {x, y, z};
  return v;
}
SMG_INLINE void smg_vec_store(smg_number *w, smg_vec a) {
  w[0] = a.x;
  w[1] = a.y;
  w[2] = a.z;
}
SMG_INLINE smg_vec smg_vec_load(const smg_number *w) { return smg_vec_of(w[0], w[1], w[2]); }
SMG_INLINE smg_vec smg_vec_add(smg_vec a, smg_vec b) { return smg_vec_of(a.x + b.x, a.y + b.y, a.z + b.z); }
SMG_INLINE smg_vec smg_vec_sub(smg_vec a, smg_vec b) { return smg_vec_of(a.x - b.x, a.y - b.y, a.z - b.z); }
SMG_INLINE smg_vec smg_vec_scale(smg_number c, smg_vec a) { return smg_vec_of(c * a.x, c * a.y, c * a.z); }
SMG_INLINE smg_number smg_vec_dot(smg_vec a, smg_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SMG_INLINE smg_vec smg_vec_cross(smg_vec a, smg_vec b) {
  return smg_vec_of(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
SMG_INLINE smg_number smg_vec_largest(smg_vec a) {
  return smg_larger(smg_abs(a.x), smg_larger(smg_abs(a.y), smg_abs(a.z)));
}
/* a where the test holds, else b. */
SMG_INLINE smg_vec smg_vec_select(smg_test test, smg_vec a, smg_vec b) {
  return smg_vec_of(smg_select(test, a.x, b.x), smg_select(test, a.y, b.y), smg_select(test, a.z, b.z));
}
SMG_INLINE smg_test smg_vec_finite(smg_vec a) {
  const smg_number most = smg_of(SMG_MAX);
  return smg_at_most(smg_abs(a.x), most) SMG_AND smg_at_most(smg_abs(a.y), most)
      SMG_AND smg_at_most(smg_abs(a.z), most);
}
