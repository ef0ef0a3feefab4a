/* smidgen method: steps of a method that asks for the right-hand side alone, whose smg_one_step comes before: from site
 * to site, or by rows of a lattice. */
#ifndef SMG_FIELD_STEPS_H
#define SMG_FIELD_STEPS_H

#include "smg_model.h"

static inline smg_status smg_step(smg_state *s) {
#if SMG_ROW_FIELDS
  return smg_field_steps(s, 1);
#else
  return smg_one_step(s);
#endif
}

#include "smg_steps.h"

#endif
