/* smidgen runtime: smg_misses_template.h in lanes. */
#ifndef SMG_LANE_MISSES_H
#define SMG_LANE_MISSES_H

#include "smg_lanes.h"

#define smg_add_misses smg_lane_add_misses
#include "smg_in_lanes.h"
#include "smg_misses_template.h"
#include "smg_in_numbers.h"
#undef smg_add_misses

#endif
