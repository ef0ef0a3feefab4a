/* smidgen runtime: several steps of the method whose smg_step comes before. */
#ifndef SMG_STEPS_H
#define SMG_STEPS_H

#include "smg_model.h"
#if SMG_THERMAL
#include "smg_thermal.h"
#endif

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
#if SMG_THERMAL
  for (; count > 0 && status == SMG_OK; --count) status = smg_thermal_step(s);
#else
#if SMG_ROW_FIELDS
  return smg_field_steps(s, count);
#elif SMG_ROW_STAGES
  return smg_stage_row_steps(s, count);
#elif SMG_ROWS_IN_TIME
  for (const int64_t end = s->count + count; s->count < end && status == SMG_OK;)
    status = s->rows && smg_next_by_rows(s) ? smg_row_steps(s, end - s->count) : smg_step(s);
  return status;
#elif SMG_BY_ROWS
  if (s->rows) return smg_row_steps(s, count);
#endif
  for (; count > 0 && status == SMG_OK; --count) status = smg_step(s);
#endif
  return status;
}

#endif
