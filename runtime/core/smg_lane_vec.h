/* smidgen runtime: smg_lane_vec, three numbers of each lane by value. */
#ifndef SMG_LANE_VEC_H
#define SMG_LANE_VEC_H

#include "smg_lanes.h"
#include "smg_template.h"

#include "smg_in_lanes.h"
#include "smg_vec_template.h"
#include "smg_in_numbers.h"

#endif
