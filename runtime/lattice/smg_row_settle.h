/* smidgen runtime: sweeps by rows in lanes of a state that is kept by sites. */
#ifndef SMG_ROW_SETTLE_H
#define SMG_ROW_SETTLE_H

#include "smg_coupled.h"
#include "smg_row_step.h"

#define SMG_BEYOND_SWEEPS 120 /* before the branch is followed */
/* sweeps after which it is asked whether those that are left will be enough */
#define SMG_BEYOND_PATIENCE 20
/* Of a change of midpoints, the part by which a relaxed sweep moves them. Where errors change sign, or turn, from
 * one sweep to the next, relaxed sweeps converge faster, and may converge where the others do not: an eigenvalue l of a
 * sweep over two colours, each of sites that do not feel each other, becomes p with (p + o - 1)^2 = o^2 l p (Young,
 * Trans. Amer. Math. Soc. 76, 1954); l = -1 becomes two of modulus 0.2. Beyond a fold, where l > 1, p > 1 too. */
#define SMG_RELAXED (smg_real)0.8
/* of the largest ratio of two changes, what counts in the next pass */
#define SMG_FADING (smg_real)0.9

/* The sweeps of a step: what stands beside the sites; passes done, and those that are left; did a change grow? how far
 * a sweep may move midpoints; |h/2kappa| r gain/s, the largest; the ratio of a change of a colour to the one before,
 * the largest of late; a change of early sweeps; by what part of a change sweeps move midpoints. */
typedef struct smg_beyond {
  smg_besides known;
  smg_turning turn;
  smg_row_sweeping sweep;
  int64_t passes, left;
  int grew;
  smg_real most, slope, ratio, early, relax;
} smg_beyond;

/* Sweeps with h begin. */
static void smg_turn_beyond(const smg_state *s, smg_real h, smg_beyond *a) {
  a->turn = smg_turning_of(s, h);
  a->turn.relax = a->relax;
  a->grew = 0;
  a->most = SMG_MAX;
  a->ratio = 0;
  smg_begin_sweeping(&a->sweep);
}

/* Midpoints as long as their spins. */
static void smg_onto_spheres(const smg_state *s) {
  const smg_inverses inverses = smg_inverses_of(s);
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes m[3];
    smg_take_slots(s->row_m, pitch, slot, m);
    smg_lane_stretch_to(smg_inverse_at(inverses, slot), 0, m);
    smg_put_slots(s->row_m, pitch, slot, m);
  }
}

/* w, what it has lost to rounding, and predicted midpoints into slots; one rank does all. */
static void smg_begin_beyond(smg_state *s, smg_real h, smg_beyond *a) {
  smg_predict(s, s->degree);
  smg_know_rows(s, &a->known);
  smg_by_each_rank(&s->c);
  smg_begin_team(s, &a->known);
  smg_put_absent(s, 0);
  smg_to_slots(s, s->compensation, s->row_compensation);
  /* in slots without a site the midpoint is the spin, as it is along the branch: distances are those of all slots */
  smg_copy(s->row_m - SMG_BEFORE, s->row_w - SMG_BEFORE, smg_array_size(&s->c));
  smg_to_slots(s, s->mbar, s->row_m);
  smg_onto_spheres(s);
  s->row_alone = 0; /* increments are found at the end alone */
  a->passes = 0;
  a->left = SMG_BEYOND_SWEEPS * SMG_COLOURS;
  a->slope = 0;
  a->relax = 1;
  smg_turn_beyond(s, h, a);
}

/* The next pass. */
static void smg_pass_beyond(smg_state *s, smg_beyond *a) {
  smg_row_sweeping *sweep = &a->sweep;
  const smg_row_pass pass = smg_next_pass(s, sweep);
  const smg_real before = sweep->recent[pass.colour];
  const smg_row_motion moved = smg_turn_colour(s, &a->known, &a->turn, pass);
  smg_take_pass(s, pass, &moved, sweep);
  ++a->passes;
  --a->left;
  const smg_real now = sweep->recent[pass.colour];
  a->ratio = smg_max(SMG_FADING * a->ratio, before > 0 ? now / before : now > 0);
}

/* How far sweeps will still move midpoints; SMG_MAX where that is not known yet. */
static inline smg_real smg_left_beyond(const smg_beyond *a) {
  if (a->sweep.passes < 2 * SMG_COLOURS || a->ratio >= 1) return SMG_MAX;
  return a->ratio * a->sweep.whole.now / (1 - a->ratio);
}

/* Are the passes that are left too few for sweeps to come to rest? By what the second half of the first ones does. */
static int smg_late_beyond(const smg_state *s, smg_beyond *a, smg_real goal) {
  const int64_t few = SMG_BEYOND_PATIENCE * SMG_COLOURS;
  smg_real left = a->sweep.whole.now;
  if (a->sweep.passes == few / 2) a->early = left;
  if (a->sweep.passes != few) return 0;
  const smg_real ratio = left / a->early, rest = smg_max(goal, SMG_EPS * s->scale);
  for (int64_t n = a->left; n > 0 && left > rest; n -= few / 2) left *= ratio;
  return left > rest;
}

/* Sweeps to rest, or until they are as near to it as `goal`; 0 if they do not get there, or if a sweep moves midpoints
 * too far. They are not accelerated: so they leave solutions at which the determinant of the equations is negative,
 * behind a fold. */
static int smg_settle_beyond(smg_state *s, smg_beyond *a, smg_real goal) {
  smg_row_sweeping *sweep = &a->sweep;
  do {
    const smg_real before = sweep->whole.now;
    smg_pass_beyond(s, a);
    if (sweep->passes > 2 * SMG_COLOURS && sweep->whole.now > before && sweep->whole.now > SMG_NEARLY * s->scale)
      a->grew = 1;
    if (a->left < 0 || (sweep->passes >= SMG_COLOURS && !(sweep->whole.now <= a->most))) return 0;
    if (smg_late_beyond(s, a, goal)) return 0;
  } while (sweep->passes < SMG_COLOURS || !(smg_left_beyond(a) <= goal || smg_rows_at_rest(sweep, s->scale)));
  return 1;
}

#endif
