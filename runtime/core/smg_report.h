/* smidgen runtime: what a step says of itself. */
#ifndef SMG_REPORT_H
#define SMG_REPORT_H

#include "smg_model.h"

/* Before a step. */
static inline void smg_begin_report(smg_state *s) {
  s->report.site = s->report.partner = -1;
  s->report.reached = 0;
}

/* It ends so, at this site; -1: at none. */
static inline smg_status smg_end_report(smg_state *s, smg_status status, int64_t site) {
  s->report.site = site;
  return s->report.status = status;
}

#endif
