/* smidgen runtime: the branch of a step followed by rows, where no bound shows what sweeps have found.
 *
 * Sweeps with a part of h are a contraction whatever the state, if it is small (smg_row_state.h): from there on the
 * midpoints of larger parts are extrapolated, by a parabola through those of the last three (of the first, 0, they are
 * w), and swept. The pace is as long as sweeps move them by a small part of what the pace does, up to the whole of
 * h. Slow sweeps may end too early: so where two paces fail, the midpoints from which they begin are swept again. */
#ifndef SMG_ROW_FOLLOW_H
#define SMG_ROW_FOLLOW_H

#include "smg_follow.h"
#include "smg_row_settle.h"

#define SMG_PATH_SWEEPS 6000 /* of all paces, before Newton takes over: on 8^3 spins it takes as long as some 70000 */
/* where sweeps do not settle, the relaxation factor is multiplied by the first number, unless it is below the second */
#define SMG_RELAXED_RATIO (smg_real)0.7
#define SMG_RELAXED_LEAST (smg_real)0.25
/* the first parts of h: of the state, how far midpoints may be off; by what factor a part is made smaller that the
 * bound does not hold for */
#define SMG_PATH_ROUGH (smg_real)1e-3
#define SMG_PATH_SMALLER (smg_real)0.8
/* the longest pace, in radii; the shortest, a part of h; the first, a part of what is certain */
#define SMG_PATH_FAR (smg_real)0.5
#define SMG_PATH_SHORTEST (smg_real)1e-6
#define SMG_PATH_FIRST (smg_real)0.5
/* parts of a pace: how far the sweeps that are left out would move midpoints; how far sweeps should move them */
#define SMG_PATH_LEFT (smg_real)0.01
#define SMG_PATH_EASY (smg_real)0.1
/* the ratio of a pace to the one before, at least and at most */
#define SMG_PATH_LESS (smg_real)0.3
#define SMG_PATH_MORE 2
/* a pace counts as this part of the one before, if it is shorter: so little what sweeps left there is of it */
#define SMG_PATH_NOISE (smg_real)0.25

/* Parts of h and their midpoints, newest first, and behind them what was foreseen; how far that is from the newest
 * ones, and how long the pace was that found these; the midpoints at which sweeps with the whole of h ended, and
 * whether they solve the step; how many parts are known. */
typedef struct smg_row_path {
  smg_real part[SMG_PATH_POINTS + 1], *m[SMG_PATH_POINTS + 1], pace, before;
  const smg_real *found;
  int solved, known;
} smg_row_path;

/* The largest part of h, to within a thirtieth, for which the bound that is known beforehand holds. */
static smg_real smg_certain_part(const smg_state *s, smg_real h) {
  smg_real part = 1;
  while (part > SMG_PATH_SHORTEST && smg_row_factor(&s->c, part * h) > SMG_ROW_BOUND) part *= SMG_PATH_SMALLER;
  for (smg_real more = part / 8; more > part / 64; more /= 2)
    if (smg_row_factor(&s->c, (part + more) * h) <= SMG_ROW_BOUND) part += more;
  return part;
}

/* to = from, arrays by slots. */
static inline void smg_rows_copy(const smg_state *s, smg_real *to, const smg_real *from) {
  smg_copy(to - SMG_BEFORE, from - SMG_BEFORE, smg_array_size(&s->c));
}

/* The largest distance between the vectors of two arrays, on small spheres as if they were as large as the others. */
static smg_real smg_rows_apart(const smg_state *s, const smg_real *from, const smg_real *to) {
  const smg_real largest = smg_at_all_sites(&s->c, smg_radius);
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  smg_lanes most = {0};
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes a[3], b[3];
    smg_take_slots(from, pitch, slot, a);
    smg_take_slots(to, pitch, slot, b);
    smg_lane_axpy(a, smg_lane_of(-1), b, 3);
    most = smg_lane_max(most, smg_as_large(largest, smg_inverse_at(smg_inverses_of(s), slot), smg_lane_dot(a, a)));
  }
  return SMG_MATH(sqrt)(smg_lane_largest(most));
}

/* Midpoints of a part of h by the polynomial through those that are known, on their spheres. */
static void smg_foresee(const smg_state *s, const smg_row_path *path, smg_real part) {
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  smg_real weights[SMG_PATH_POINTS];
  for (int j = 0; j < path->known; ++j) {
    weights[j] = 1;
    for (int k = 0; k < path->known; ++k)
      if (k != j) weights[j] *= (part - path->part[k]) / (path->part[j] - path->part[k]);
  }
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes m[3], known[3];
    for (int k = 0; k < 3; ++k) m[k] = smg_lane_of(0);
    for (int j = 0; j < path->known; ++j) {
      smg_take_slots(path->m[j], pitch, slot, known);
      smg_lane_axpy(m, smg_lane_of(weights[j]), known, 3);
    }
    smg_put_slots(s->row_m, pitch, slot, m);
  }
  smg_onto_spheres(s);
  smg_rows_copy(s, path->m[SMG_PATH_POINTS], s->row_m);
}

/* The midpoints found for a part become the newest ones. */
static void smg_keep_point(const smg_state *s, smg_row_path *path, smg_real part) {
  smg_real *oldest = path->m[SMG_PATH_POINTS];
  for (int j = SMG_PATH_POINTS; j > 0; --j) {
    path->m[j] = path->m[j - 1];
    path->part[j] = path->part[j - 1];
  }
  path->m[0] = oldest;
  path->part[0] = part;
  if (path->known < SMG_PATH_POINTS) ++path->known;
  path->before = path->pace;
  smg_rows_copy(s, oldest, s->row_m);
}

/* Sweeps with a part of h, relaxed as much as it takes, until midpoints are exact to a small part of the pace; 0 if
 * they are too slow, or if a sweep moves midpoints too far. */
static int smg_sweep_part(smg_state *s, smg_real h, smg_beyond *a, smg_real part, smg_real pace) {
  for (;; a->relax *= SMG_RELAXED_RATIO) {
    smg_turn_beyond(s, part * h, a);
    a->most = SMG_STRAIGHT * pace + SMG_NEARLY * s->scale;
    if (smg_settle_beyond(s, a, SMG_PATH_LEFT * pace)) return 1;
    if (!(a->sweep.whole.now <= a->most) || a->left < 0 || a->relax < SMG_RELAXED_LEAST) return 0;
  }
}

/* 0, three quarters of what is certain, and that. */
static int smg_begin_path(smg_state *s, smg_real h, smg_beyond *a, smg_row_path *path) {
  const smg_real certain = smg_certain_part(s, h);
  const size_t size = (size_t)smg_array_size(&s->c);
  smg_real *next = smg_paths_of(s) + size; /* behind those that are found already */
  for (int j = 0; j <= SMG_PATH_POINTS; ++j) path->m[j] = smg_place_slots(&next, size);
  path->known = 0;
  path->pace = 0;
  smg_rows_copy(s, s->row_m, s->row_w);
  smg_keep_point(s, path, 0);
  for (int k = 3; k <= 4; ++k) {
    const smg_real part = certain * (smg_real)k / 4;
    smg_foresee(s, path, part);
    smg_turn_beyond(s, part * h, a);
    if (!smg_settle_beyond(s, a, SMG_PATH_ROUGH * s->scale)) return 0;
    path->pace = smg_rows_apart(s, s->row_m, path->m[0]); /* much shorter if spins are slow */
    if (!(smg_left_beyond(a) <= SMG_PATH_LEFT * path->pace) && !smg_settle_beyond(s, a, SMG_PATH_LEFT * path->pace))
      return 0;
    smg_keep_point(s, path, part);
  }
  return 1;
}

/* By what part of the pace do these midpoints miss what was foreseen? */
static smg_real smg_missed(const smg_state *s, const smg_row_path *path, const smg_real *m) {
  const smg_real pace = smg_max(path->pace, SMG_PATH_NOISE * path->before);
  return smg_rows_apart(s, m, path->m[SMG_PATH_POINTS]) / (pace + SMG_NEARLY * s->scale);
}

/* One pace: how far what has been found, or what sweeps find, is from what was foreseen, in units of the pace. If a
 * solution that has been found misses it by less than one pace, a shorter pace is tried without sweeps. */
static smg_real smg_pace_to(smg_state *s, smg_real h, smg_beyond *a, smg_row_path *path, smg_real part) {
  smg_foresee(s, path, part);
  path->pace = smg_rows_apart(s, s->row_m, path->m[0]);
  if (!(path->pace <= SMG_PATH_FAR * s->scale)) return SMG_MAX;
  if (part == 1) {
    const smg_real missed = smg_missed(s, path, path->found);
    if (missed <= (path->solved ? 1 : SMG_STRAIGHT)) return missed;
  }
  const int rests = smg_sweep_part(s, h, a, part, path->pace);
  const smg_real missed = smg_missed(s, path, s->row_m);
  return rests || missed > SMG_STRAIGHT ? missed : SMG_MAX;
}

/* The ratio of the next pace to this one; what a pace misses is of second order in it. */
static inline smg_real smg_longer(smg_real missed) {
  const smg_real ratio = SMG_MATH(sqrt)(SMG_PATH_EASY / (missed + SMG_EPS));
  return smg_max(SMG_PATH_LESS, smg_min(SMG_PATH_MORE, ratio));
}

/* The next part of h; the last two paces are alike. */
static inline smg_real smg_next_part(smg_real part, smg_real step) {
  const smg_real left = 1 - part;
  return left <= step ? 1 : part + (left < 2 * step ? left / 2 : step);
}

/* The newest midpoints again, exact to a small part of a shorter pace. */
static int smg_refine_point(smg_state *s, smg_real h, smg_beyond *a, smg_row_path *path) {
  smg_rows_copy(s, s->row_m, path->m[0]);
  if (!smg_sweep_part(s, h, a, path->part[0], path->pace)) return 0;
  smg_rows_copy(s, path->m[0], s->row_m);
  return 1;
}

/* Up to the whole of h; 0 where paces become too short. */
static int smg_follow_rows(smg_state *s, smg_real h, smg_beyond *a, smg_row_path *path) {
  int failed = 0;
  if (!smg_begin_path(s, h, a, path)) return 0;
  for (smg_real step = SMG_PATH_FIRST * path->part[0]; a->left >= 0 && step > SMG_PATH_SHORTEST;) {
    const smg_real part = smg_next_part(path->part[0], step), missed = smg_pace_to(s, h, a, path, part);
    if (part == 1 && missed <= SMG_STRAIGHT) return 1;
    failed = missed <= SMG_STRAIGHT ? 0 : failed + 1;
    if (failed == 0) smg_keep_point(s, path, part);
    if (failed > 1 && !smg_refine_point(s, h, a, path)) return 0;
    step *= smg_longer(missed);
  }
  return 0;
}

#endif
