/* smidgen runtime: sweeps by rows in lanes of a state that is kept by sites. */
#ifndef SMG_ROW_SETTLE_H
#define SMG_ROW_SETTLE_H

#include "smg_row_step.h"
#include "smg_swept.h"

#define SMG_BEYOND_SWEEPS 120 /* before the branch is followed */

/* The sweeps of a step: what stands beside the sites; passes that are left; did a change grow? how far a sweep may move
 * midpoints; |h/2kappa| r gain/s, the largest. */
typedef struct smg_beyond {
  smg_besides known;
  smg_turning turn;
  smg_row_sweeping sweep;
  int64_t left;
  int grew;
  smg_real most, slope;
} smg_beyond;

/* Sweeps with h begin. */
static void smg_turn_beyond(const smg_state *s, smg_real h, smg_beyond *a) {
  a->turn = smg_turning_of(s, h);
  a->grew = 0;
  a->most = SMG_MAX;
  smg_begin_sweeping(&a->sweep);
}

/* w, what it has lost to rounding, and predicted midpoints into slots; one rank does all. */
static void smg_begin_beyond(smg_state *s, smg_real h, smg_beyond *a) {
  smg_sweep_start(s);
  smg_know_rows(s, &a->known);
  smg_by_each_rank(&s->c);
  smg_begin_team(s, &a->known);
  smg_put_absent(s, 0);
  smg_to_slots(s, s->compensation, s->row_compensation);
  /* in slots without a site the midpoint is the spin, as it is along the branch: distances are those of all slots */
  smg_copy(s->row_m - SMG_BEFORE, s->row_w - SMG_BEFORE, smg_array_size(&s->c));
  smg_to_slots(s, s->m, s->row_m);
  s->row_alone = 0; /* increments are found at the end alone */
  a->left = SMG_BEYOND_SWEEPS * SMG_COLOURS;
  a->slope = 0;
  smg_turn_beyond(s, h, a);
}

/* Will sweeps move midpoints by no more than that any more? */
static inline int smg_near_rest(const smg_rest *rest, smg_real goal) {
  return goal > 0 && rest->rate * rest->now <= goal * (1 - rest->rate);
}

/* Sweeps to rest, or until they are as near to it as `goal`; 0 if they do not get there, or if a sweep moves midpoints
 * too far. They are not accelerated: so they leave solutions at which the determinant of the equations is negative,
 * behind a fold. */
static int smg_settle_beyond(smg_state *s, smg_beyond *a, smg_real goal) {
  smg_row_sweeping *sweep = &a->sweep;
  do {
    const smg_row_pass pass = smg_next_pass(s, sweep);
    const smg_real before = sweep->whole.now;
    const smg_row_motion moved = smg_turn_colour(s, &a->known, &a->turn, pass);
    smg_take_pass(s, pass, &moved, sweep);
    if (sweep->passes > 2 * SMG_COLOURS && sweep->whole.now > before && sweep->whole.now > SMG_NEARLY * s->scale)
      a->grew = 1;
    if ((sweep->passes >= SMG_COLOURS && !(sweep->whole.now <= a->most)) || --a->left < 0) return 0;
  } while (sweep->passes < SMG_COLOURS || !(smg_near_rest(&sweep->whole, goal) || smg_rows_settled(s, sweep)));
  return 1;
}

#endif
