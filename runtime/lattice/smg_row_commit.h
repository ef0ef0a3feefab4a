/* smidgen runtime: the state of a lattice by rows after a step, and the midpoints to begin the next one with, in one go
 * through memory. */
#ifndef SMG_ROW_COMMIT_H
#define SMG_ROW_COMMIT_H

#include "smg_predictor.h"
#include "smg_row_spin.h"
#include "smg_row_state.h"
#include "smg_row_team.h"

/* What that works with: the spins from, and where they go; increments u of the slots before `first`, and those of all
 * others of the last steps, newest first; so many of them extrapolate, with these weights. */
typedef struct smg_row_going {
  const smg_real *from, *lost_from;
  smg_real *w, *lost, *m;
  const smg_real *u, *past[SMG_ROW_HISTORY];
  int64_t pitch, early, late, first;
  smg_inverses inverses;
  smg_real weights[SMG_ROW_HISTORY];
  int terms;
} smg_row_going;

static inline smg_row_going smg_going_of(const smg_state *s, int degree) {
  const int64_t first = SMG_KEPT_FROM(&s->c);
  smg_row_going go = {SMG_ROW_FROM(s, row_w),
                      SMG_ROW_FROM(s, row_compensation),
                      s->row_w,
                      s->row_compensation,
                      s->row_m,
                      s->row_u,
                      {NULL},
                      smg_pitch(&s->c),
                      SMG_FIRST_PITCH(&s->c),
                      SMG_LATE_PITCH(&s->c),
                      first,
                      smg_inverses_of(s),
                      {0},
                      smg_terms(degree)};
  for (int j = 0; j < SMG_ROW_HISTORY; ++j) go.past[j] = s->past[j] - first;
  for (int j = 0; j < go.terms; ++j) go.weights[j] = smg_past_weight(s, degree, j);
  return go;
}

/* m = P(w + u/2) of the slots of one vector, u extrapolated; P = 1 where midpoints are no projections. */
SMG_INLINE void smg_predict_slots(const smg_row_going go, int64_t slot, int terms, const smg_lanes *w) {
  smg_lanes m[3];
  for (int k = 0; k < 3; ++k) {
    smg_lanes u = {0};
    SMG_UNROLL
    for (int j = 0; j < terms; ++j) u += go.weights[j] * smg_lane_take(go.past[j] + k * go.late + slot);
    m[k] = w[k] + (smg_real)0.5 * u;
  }
  if (SMG_ONTO_LEAF) smg_lane_stretch_to(smg_inverse_at(go.inverses, slot), 0, m);
  smg_put_slots(go.m, go.pitch, slot, m);
}

static void smg_predict_share(const smg_row_going go, smg_share part) {
  for (int64_t slot = part.from; slot < part.to; slot += SMG_LANES) {
    smg_lanes w[3];
    smg_take_slots(go.w, go.pitch, slot, w);
    smg_predict_slots(go, slot, go.terms, w);
  }
}

/* Those of all slots whose increments are kept. */
static void smg_predict_rows(const smg_state *s) {
  const smg_row_going go = smg_going_of(s, s->degree);
  SMG_TEAM(s->row_team) {
    SMG_COLOURS_AT_ONCE(colour, n, SMG_FIRST_KEPT(&s->c))
    SMG_STRIPS(&s->c, k) smg_predict_share(go, smg_strip_of_thread(&s->c, colour, n, k));
  }
}

/* w + compensation + u of the slots of one vector (Kahan). */
SMG_INLINE void smg_commit_slots(const smg_row_going go, int64_t slot, const smg_lanes *u, smg_lanes *sum) {
  smg_take_slots(go.from, go.pitch, slot, sum);
  smg_lane_add_step(3, sum, go.lost_from + slot, go.lost + slot, go.pitch, u);
  smg_put_slots(go.w, go.pitch, slot, sum);
}

/* What comes soon is fetched while there is other work: so many streams are more than processors foresee. Without it
 * 100^3 spins take 5 % longer, and lattices that a cache holds as long. */
#define SMG_SOON 16 /* slots */
SMG_INLINE void smg_fetch_slots(const smg_row_going go, int64_t slot, int terms) {
  for (int k = 0; k < 3; ++k) {
    SMG_FETCH(go.from + k * go.pitch + slot);
    SMG_FETCH(go.lost_from + k * go.pitch + slot);
    if (slot < go.first) {
      SMG_FETCH(go.u + k * go.early + slot);
      continue;
    }
    SMG_FETCH(go.m + k * go.pitch + slot);
    for (int j = 0; j == 0 || j < terms; ++j) SMG_FETCH(go.past[j] + k * go.late + slot);
  }
}

/* The same of some slots; the increments of the next step are extrapolated where they are kept, from so many as the
 * compiler knows, or from none. */
SMG_INLINE void smg_go_on_by(const smg_row_going go, smg_share part, int terms) {
  for (int64_t slot = part.from; slot < part.to; slot += SMG_LANES) {
    smg_lanes u[3], w[3];
    if (slot % SMG_WIDEST == 0 && slot + SMG_SOON < part.to) smg_fetch_slots(go, slot + SMG_SOON, terms);
    if (slot < go.first) smg_take_slots(go.u, go.early, slot, u);
    else smg_take_slots(go.past[0], go.late, slot, u);
    smg_commit_slots(go, slot, u, w);
    if (slot >= go.first && terms > 0) smg_predict_slots(go, slot, terms, w);
  }
}

#if SMG_UNIT == 2
SMG_LINKED void smg_go_on(const smg_row_going go, smg_share part);
#else
SMG_LINKED void smg_go_on(const smg_row_going go, smg_share part) {
  if (go.terms == 1) smg_go_on_by(go, part, 1);
#if SMG_COMPOSED
  else if (go.terms == 6) smg_go_on_by(go, part, 6);
  else if (go.terms == 8) smg_go_on_by(go, part, 8);
#else
  else if (go.terms == 2) smg_go_on_by(go, part, 2);
  else if (go.terms == 4) smg_go_on_by(go, part, 4);
#if SMG_COLOURS <= 2
  else if (go.terms == 5) smg_go_on_by(go, part, 5);
#endif
#endif
  else if (go.terms == 3) smg_go_on_by(go, part, 3);
  else smg_go_on_by(go, part, 0);
}
#endif

/* Sites of the first colour need a beginning where they feel their own midpoints (SMG_OWN_FIELD): w, if none is
 * extrapolated. */
static void smg_begin_first_colour(const smg_state *s, smg_share part) {
  const int64_t pitch = smg_pitch(&s->c);
  for (int k = 0; SMG_OWN_FIELD && SMG_FIRST_KEPT(&s->c) > 0 && k < 3; ++k)
    smg_copy(s->row_m + k * pitch + part.from, s->row_w + k * pitch + part.from, part.to - part.from);
}

/* The state after the step, of all threads; more: is another one to begin? */
static void smg_go_on_rows(const smg_state *s, int more) {
  const smg_row_going go = smg_going_of(s, more ? s->degree : SMG_NO_DEGREE);
  SMG_TEAM(s->row_team) {
    SMG_COLOURS_AT_ONCE(colour, n, 0) SMG_STRIPS(&s->c, k) smg_go_on(go, smg_strip_of_thread(&s->c, colour, n, k));
  }
}

#endif
