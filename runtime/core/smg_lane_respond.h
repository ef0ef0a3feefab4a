/* smidgen runtime: smg_respond.h in lanes. */
#ifndef SMG_LANE_RESPOND_H
#define SMG_LANE_RESPOND_H

#include "smg_lanes.h"
#include "smg_respond.h"

#if SMG_LAW_BY_SITE
typedef smg_lanes smg_lane_told_number;
#else
typedef smg_real smg_lane_told_number;
#endif

/* What is kept of a response: numbers where sites all have the same, else lanes. */
typedef struct smg_told {
#if SMG_TOLD
  smg_lane_told_number r[SMG_RESPONSE_SIZE];
#else
  char none;
#endif
} smg_told;

SMG_INLINE smg_told smg_told_of(SMG_UNUSED const smg_coefficients *c, SMG_UNUSED int64_t k) {
  smg_told told;
#if SMG_LAW_BY_SITE
  smg_real r[SMG_RESPONSE_SIZE];
  smg_law(c, k, r);
  for (int n = 0; n < SMG_RESPONSE_SIZE; ++n) told.r[n] = smg_lane_of(r[n]);
#elif SMG_TOLD
  smg_law(c, k, told.r);
#else
  told.none = 0;
#endif
  return told;
}

#define smg_told_number smg_lane_told_number
#define smg_told_parts smg_lane_told_parts
#define smg_told_respond smg_lane_told_respond
#define smg_told_change smg_lane_told_change
#define smg_told_turn smg_lane_told_turn
#include "smg_in_lanes.h"
#include "smg_respond_template.h"
#include "smg_in_numbers.h"
#undef smg_told_parts
#undef smg_told_respond
#undef smg_told_change
#undef smg_told_turn
#undef smg_told_number

#if SMG_LAW_BY_SITE
/* The response of the sites in some slots; values: those that differ from site to site, a pitch apart. */
SMG_INLINE smg_told smg_told_of_slots(smg_told told, const smg_real *values, int64_t pitch) {
  for (int k = 0, n = SMG_LAW_FIRST; k < SMG_RESPONSE_SIZE; ++k)
    if (SMG_LAW_BY_SITE >> k & 1) told.r[k] = smg_lane_take(values + n++ * pitch);
  return told;
}
#endif

/* R = F + m x Q, in `room`. */
SMG_INLINE const smg_lanes *smg_lane_respond(SMG_UNUSED const smg_told *told, SMG_UNUSED const smg_lanes *m,
                                             const smg_lanes *g, SMG_UNUSED smg_lanes *room) {
#if SMG_TOLD
  return smg_lane_told_respond(told->r, m, g, room);
#else
  return g;
#endif
}

/* The change of R, y that of g, in `room`. */
SMG_INLINE const smg_lanes *smg_lane_respond_change(SMG_UNUSED const smg_told *told, SMG_UNUSED const smg_lanes *m,
                                                    const smg_lanes *y, SMG_UNUSED smg_lanes *room) {
#if SMG_TOLD
  return smg_lane_told_change(told->r, m, y, room);
#else
  return y;
#endif
}

#endif
