/* smidgen runtime: an ensemble, states of one model side by side, each with the bits that it has alone.
 *
 * Its memory holds the states, then the arrays of each. A member whose step fails stays where it is, as m_step() leaves
 * it, and takes no more; its report says why. Members of a single sphere step SMG_LANES at a time where the method has
 * smg_lane_steps(), all others one by one, by smg_steps() of the method, which comes before.
 * Two threads may step different members at once. */
#ifndef SMG_ENSEMBLE_H
#define SMG_ENSEMBLE_H

#include "smg_set_state.h"

#if SMG_LANE_SPHERE && SMG_LANES > 1
#define SMG_MEMBERS_AT_ONCE SMG_LANES
#else
#define SMG_MEMBERS_AT_ONCE 1
#endif
#define SMG_ENSEMBLE_LINE 64 /* bytes of a line of the cache: no two threads write to one */

SMG_INLINE size_t smg_whole_lines(size_t bytes) {
  return (bytes + SMG_ENSEMBLE_LINE - 1) / SMG_ENSEMBLE_LINE * SMG_ENSEMBLE_LINE;
}

/* The model of member k: its own, or that of all. */
static inline const smg_model *smg_model_of(const smg_model *model, int own, int64_t k) {
  return own ? model + k : model;
}

/* Bytes of the arrays of one member, 0 where it cannot have any. */
static size_t smg_member_memory(const smg_model *model) {
  return model->status == SMG_OK ? smg_whole_lines(smg_memory(model)) : 0;
}

static size_t smg_ensemble_memory(const smg_model *model, int own, int64_t members) {
  size_t bytes = smg_whole_lines((size_t)members * sizeof(smg_state));
  if (!own) return bytes + (size_t)members * smg_member_memory(model);
  for (int64_t k = 0; k < members; ++k) bytes += smg_member_memory(model + k);
  return bytes;
}

/* How many of the members first .. first + count - 1 have failed, in the start or since. */
static int64_t smg_ensemble_failed(const smg_ensemble *e, int64_t first, int64_t count) {
  int64_t failed = 0;
  for (int64_t k = first; k < first + count; ++k) failed += e->member[k].report.status != SMG_OK;
  return failed;
}

/* Every member at its start: w holds 3*sites numbers of each, one after the other, as many as the first has. Returns
 * how many cannot begin: SMG_BAD_PARAMETER also for another number of sites. Without memory none can, and there are no
 * members. */
static int64_t smg_begin_ensemble(smg_ensemble *e, const smg_model *model, int own, int64_t members, void *mem,
                                  const smg_real *w, double t0, double h) {
  const int64_t sites = smg_sites_of(model);
  char *at = (char *)mem + smg_whole_lines((size_t)members * sizeof(smg_state));
  e->member = (smg_state *)mem;
  e->members = mem ? members : 0;
  e->own = own;
  for (int64_t k = 0; k < e->members; ++k) {
    const smg_model *its = smg_model_of(model, own, k);
    if (smg_sites_of(its) == sites) (void)smg_begin_state(e->member + k, its, at, w ? w + 3 * sites * k : NULL, t0, h);
    else smg_blank(e->member + k, its, t0, h); /* with SMG_BAD_PARAMETER */
#if SMG_THERMAL
    e->member[k].member = (uint32_t)k;
#endif
    at += smg_member_memory(its);
  }
  return mem ? smg_ensemble_failed(e, 0, members) : members;
}

/* count steps of the members first .. first + members - 1, where none failed before. Returns how many of them have
 * failed. */
static int64_t smg_ensemble_steps(smg_ensemble *e, int64_t first, int64_t members, int64_t count) {
  for (int64_t k = first; k < first + members; ++k)
    if (e->member[k].report.status == SMG_OK) (void)smg_is_ready(e->member + k);
#if SMG_MEMBERS_AT_ONCE > 1
  if (count > 0) smg_lane_steps(e->member + first, members, count, !e->own);
#else
  for (int64_t k = first; k < first + members; ++k)
    if (e->member[k].report.status == SMG_OK) e->member[k].report.status = smg_steps(e->member + k, count);
#endif
  return smg_ensemble_failed(e, first, members);
}

#endif
