/* smidgen runtime: smg_respond.h in lanes, of sites with the same response r = f, q, F0, Q0. */
#ifndef SMG_LANE_RESPOND_H
#define SMG_LANE_RESPOND_H

#include "smg_lanes.h"
#include "smg_respond.h"

/* What is kept of a response where sites all have the same. */
typedef struct smg_told {
#if SMG_RESPONDS
  smg_real r[SMG_RESPONSE_SIZE];
#else
  char none;
#endif
} smg_told;

SMG_INLINE smg_told smg_told_of(const smg_coefficients *c, int64_t k) {
  smg_told told;
#if SMG_RESPONDS
  smg_response(c, k, told.r);
#else
  (void)c, (void)k;
  told.none = 0;
#endif
  return told;
}

#if SMG_RESPONDS
SMG_INLINE void smg_lane_respond_parts(const smg_told *told, const smg_lanes *g, smg_lanes *F, smg_lanes *Q) {
  const smg_real *r = told->r;
  for (int b = 0; b < 3; ++b) {
    F[b] = r[0] * g[b] + r[SMG_RESPONSE_F0 + b];
    Q[b] = r[1] * g[b] + r[SMG_RESPONSE_Q0 + b];
  }
}
#endif

/* R = F + m x Q, in `room`. */
SMG_INLINE const smg_lanes *smg_lane_respond(const smg_told *told, const smg_lanes *m, const smg_lanes *g,
                                             smg_lanes *room) {
#if SMG_RESPONDS
  smg_lanes F[3], Q[3];
  smg_lane_respond_parts(told, g, F, Q);
  for (int b = 0; b < 3; ++b) {
    const int i = (b + 1) % 3, j = (b + 2) % 3;
    room[b] = F[b] + (m[i] * Q[j] - m[j] * Q[i]);
  }
  return room;
#else
  return (void)told, (void)m, (void)room, g;
#endif
}

#endif
