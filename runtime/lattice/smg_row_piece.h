/* smidgen runtime: visits of the sites of one colour of a lattice, piece after piece (smg_row_runs.h), with the
 * gradient at their places by smg_slot_gradient of the model. */
#ifndef SMG_ROW_PIECE_H
#define SMG_ROW_PIECE_H

#include "smg_row_visit_template.h"

#endif
