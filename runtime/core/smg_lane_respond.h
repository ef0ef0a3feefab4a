/* smidgen runtime: smg_respond.h in lanes, of sites with the same response r = f, q, F0, Q0. */
#ifndef SMG_LANE_RESPOND_H
#define SMG_LANE_RESPOND_H

#include "smg_lanes.h"
#include "smg_respond.h"

/* What is kept of a response where sites all have the same. */
typedef struct smg_told {
#if SMG_TOLD
  smg_real r[SMG_RESPONSE_SIZE];
#else
  char none;
#endif
} smg_told;

SMG_INLINE smg_told smg_told_of(const smg_coefficients *c, int64_t k) {
  smg_told told;
#if SMG_TOLD
  smg_law(c, k, told.r);
#else
  (void)c, (void)k;
  told.none = 0;
#endif
  return told;
}

#define smg_told_parts smg_lane_told_parts
#define smg_told_respond smg_lane_told_respond
#include "smg_in_lanes.h"
#include "smg_respond_template.h"
#include "smg_in_numbers.h"
#undef smg_told_parts
#undef smg_told_respond

/* R = F + m x Q, in `room`. */
SMG_INLINE const smg_lanes *smg_lane_respond(const smg_told *told, const smg_lanes *m, const smg_lanes *g,
                                             smg_lanes *room) {
#if SMG_TOLD
  return smg_lane_told_respond(told->r, m, g, room);
#else
  return (void)told, (void)m, (void)room, g;
#endif
}

#endif
