/* smidgen runtime: the tangent map of a step by rows in lanes (smg_tangent.h).
 *
 * Across its midpoint m a spin's own equation has the derivative
 *
 *     a dm + b m x dm = R,   R = P dw + (h/2) m x (f y + q m x y),   a = rho - (h/2) m.Q,   b = (h/2) m.F/r^2,
 *
 * y = B dm the change of its gradient, P across m (smg_row_beyond.h). So dm = (a R - b m x R)/(a^2 + b^2 r^2), and
 * sweeps over the colours solve the equations of all spins: they are the derivatives of those that found the midpoints,
 * and a contraction by the same factor. Where midpoints are no projections, dm - dm x g = R (smg_row_spin.h). */
#ifndef SMG_ROW_TANGENT_H
#define SMG_ROW_TANGENT_H

#include "smg_row_step.h"

/* Visits with the change of the gradient. */
#define smg_slot_gradient smg_changed_slot_gradient
#define smg_run_gradient smg_changed_run_gradient
#define smg_next_piece smg_changed_next_piece
#define smg_each_vector smg_changed_each_vector
#include "smg_row_visit_template.h"
#undef smg_slot_gradient
#undef smg_run_gradient
#undef smg_next_piece
#undef smg_each_vector

/* A column under way, by slots: dw; a and b over a^2 + b^2 r^2; dm, and what it is without the neighbours; g = dH/dw at
 * m. How far dm moves, or the largest square of a residual. */
typedef struct smg_row_push {
  smg_state *s;
  smg_besides *known;
  smg_turning turn;
  smg_real *v, *slopes, *x, *z, *g;
  smg_lanes most;
} smg_row_push;

static inline size_t smg_row_push_size(const smg_coefficients *c) {
  return (size_t)(6 * smg_array_size(c) + SMG_WIDEST);
}

/* m = P(w - u/2) of all slots, w the state after the step and u its increments. */
static void smg_push_midpoints(const smg_row_push *q, const smg_real *u) {
  const smg_share all = {0, smg_slots(&q->s->c)};
  smg_row_going go = smg_going_of(q->s, SMG_NO_DEGREE);
  go.m = q->turn.m;
  go.past[0] = u;
  go.late = q->turn.pitch;
  go.weights[0] = -1;
  go.terms = 1;
  smg_predict_share(go, all);
}

/* rho of the slots of one vector, as m.u = 0; 1 where midpoints are no projections. */
SMG_INLINE smg_lanes smg_push_rho(const smg_row_push *q, int64_t slot, const smg_lanes *m) {
  smg_lanes w[3];
  if (!SMG_ONTO_LEAF) return smg_lane_of(1);
  smg_take_slots(q->turn.w, q->turn.pitch, slot, w);
  return smg_inverse_at(q->turn.inverses, slot) * smg_lane_dot(w, m);
}

/* g, a and b of the slots of one vector; 0 where no site is. */
SMG_INLINE void smg_push_slopes(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  const smg_row_push *q = (const smg_row_push *)context;
  smg_lanes m[3], *F = g;
  smg_first_lanes(in, g);
  smg_put_slots(q->g, q->turn.pitch, slot, g);
  smg_take_slots(q->turn.m, q->turn.pitch, slot, m);
  smg_lanes ab[3] = {smg_push_rho(q, slot, m)};
#if SMG_TOLD
  const smg_told told = smg_told_at(q->turn, slot);
  smg_lanes field[3], Q[3];
  smg_lane_told_parts(told.r, g, F = field, Q);
  ab[0] -= q->turn.half * smg_lane_dot(m, Q);
#endif
  const smg_lanes along = q->turn.half * smg_lane_dot(m, F);
  ab[1] = smg_inverse_at(q->turn.inverses, slot) * along;
  const smg_lanes square = ab[0] * ab[0] + ab[1] * along;
  for (int k = 0; k < 2; ++k) ab[k] = smg_lane_select((smg_lane_mask)(square > 0), ab[k] / square, ab[2]);
  smg_first_lanes(in, ab);
  smg_put_slots(q->slopes, q->turn.pitch, slot, ab);
}

/* dm of the slots of one vector, from R. */
SMG_INLINE void smg_push_solved(const smg_row_push *q, int64_t slot, const smg_lanes *m, const smg_lanes *R,
                                smg_lanes *dm) {
  smg_lanes ab[3];
  smg_take_slots(SMG_ONTO_LEAF ? q->slopes : q->g, q->turn.pitch, slot, ab);
  if (SMG_ONTO_LEAF) {
    smg_lane_cross(dm, m, R);
    for (int k = 0; k < 3; ++k) dm[k] = ab[0] * R[k] - ab[1] * dm[k];
  } else {
    smg_lane_scale(ab, smg_lane_of(q->turn.half), 3);
    smg_lane_midpoint(R, ab, dm);
  }
}

/* v without its part along m, where midpoints are projections. */
SMG_INLINE void smg_push_across(const smg_row_push *q, int64_t slot, const smg_lanes *m, smg_lanes *v) {
  if (SMG_ONTO_LEAF) smg_lane_axpy(v, -(smg_inverse_at(q->turn.inverses, slot) * smg_lane_dot(m, v)), m, 3);
}

/* dm of sites that have no neighbours, where sweeps begin. */
static void smg_push_begin(const smg_row_push *q) {
  for (int64_t slot = 0, slots = smg_slots(&q->s->c); slot < slots; slot += SMG_LANES) {
    smg_lanes m[3], R[3], z[3];
    smg_take_slots(q->turn.m, q->turn.pitch, slot, m);
    smg_take_slots(q->v, q->turn.pitch, slot, R);
    smg_push_across(q, slot, m, R);
    smg_push_solved(q, slot, m, R, z);
    smg_put_slots(q->z, q->turn.pitch, slot, z);
    smg_put_slots(q->x, q->turn.pitch, slot, z);
  }
}

/* (h/2) m x (f y + q m x y), and its dm. */
SMG_INLINE void smg_push_neighbours(const smg_row_push *q, int64_t slot, const smg_lanes *m, const smg_lanes *y,
                                    smg_lanes *R) {
  smg_lanes room[3];
  const smg_told told = smg_told_at(q->turn, slot);
  smg_lane_cross(R, m, smg_lane_respond_change(&told, m, y, room));
  smg_lane_scale(R, smg_lane_of(q->turn.half), 3);
}

/* dm of the slots of one vector in the field of their neighbours, whose change is y. */
SMG_INLINE void smg_push_vector(void *context, int64_t slot, int64_t in, smg_lanes *y) {
  smg_row_push *q = (smg_row_push *)context;
  smg_lanes m[3], R[3], x[3], z[3], dm[3];
  smg_take_slots(q->turn.m, q->turn.pitch, slot, m);
  smg_take_slots(q->x, q->turn.pitch, slot, x);
  smg_take_slots(q->z, q->turn.pitch, slot, z);
  smg_push_neighbours(q, slot, m, y, R);
  smg_push_solved(q, slot, m, R, dm);
  smg_lane_axpy(z, smg_lane_of(1), dm, 3);
  if (in < SMG_LANES) smg_lane_choose(z, smg_lane_below(in), z, x, 3);
  smg_put_slots(q->x, q->turn.pitch, slot, z);
  smg_lane_axpy(x, smg_lane_of(-1), z, 3);
  q->most = smg_lane_max(q->most, smg_lane_dot(x, x));
}

/* dW = 2 d - dw in place of dw, d = dw + (h/2) (dm x R + m x dR); the residual d - rho dm of those across m. */
SMG_INLINE void smg_push_end(void *context, int64_t slot, int64_t in, smg_lanes *y) {
  smg_row_push *q = (smg_row_push *)context;
  smg_lanes m[3], g[3], dm[3], v[3], d[3], e[3], room[3];
  smg_take_slots(q->turn.m, q->turn.pitch, slot, m);
  smg_take_slots(q->g, q->turn.pitch, slot, g);
  smg_take_slots(q->x, q->turn.pitch, slot, dm);
  smg_take_slots(q->v, q->turn.pitch, slot, v);
  const smg_told told = smg_told_at(q->turn, slot);
  smg_lane_cross(e, dm, smg_lane_respond(&told, m, g, room));
#if SMG_TOLD
  smg_lane_told_turn(told.r, m, g, dm, e);
#endif
  smg_push_neighbours(q, slot, m, y, d);
  smg_lane_axpy(d, smg_lane_of(q->turn.half), e, 3);
  smg_lane_axpy(d, smg_lane_of(1), v, 3);
  smg_lane_waxpy(e, -smg_push_rho(q, slot, m), dm, d, 3);
  smg_push_across(q, slot, m, e);
  const smg_lanes none = {0},
                  there = smg_lane_select((smg_lane_mask)(smg_lane_dot(m, m) > 0), smg_lane_dot(e, e), none);
  q->most = smg_lane_max(q->most, smg_lane_first(in, there));
  for (int k = 0; k < 3; ++k) v[k] = smg_lane_select(smg_lane_below(in), 2 * d[k] - v[k], v[k]);
  smg_put_slots(q->v, q->turn.pitch, slot, v);
}

/* A visit of n colours from one on, by all threads: the largest of them. */
SMG_INLINE smg_real smg_push_colours(smg_row_push *q, int64_t first, int64_t n, smg_vector_visit *visit) {
  q->most = smg_lane_of(0);
  SMG_TEAM(q->s->row_team) {
    smg_row_push mine = *q;
    for (int64_t colour = first; colour < first + n; ++colour)
      smg_changed_each_vector(&q->s->c, q->known, q->x, colour, smg_share_of(&q->s->c, colour, 1), &mine, visit);
    SMG_ONE_BY_ONE q->most = smg_lane_max(q->most, mine.most);
  }
  return smg_lane_largest(q->most);
}

/* Has dm come to rest? The next change is at most the bound times those of all colours: an ulp, as the end is as good
 * as another sweep, or what the tolerance leaves; or it is round-off and shrinks no more. */
static int smg_push_rests(const smg_state *s, const smg_row_sweeping *sweep) {
  const smg_real change = smg_recent(sweep->recent, -1);
  return s->row_bound * change <= SMG_EPS * s->scale || sweep->whole.stays ||
         smg_tolerated(s, smg_left_by_sweeps(s) * change);
}

/* Sweeps until then. Is what they leave in the equation round-off, or within the tolerance? */
static int smg_settle_push(smg_row_push *q) {
  smg_row_sweeping sweep;
  smg_begin_sweeping(&sweep);
  do {
    const smg_row_pass pass = {sweep.passes % SMG_COLOURS, SMG_FROM_BEFORE, 1, 1, 0};
    smg_row_motion moved = smg_at_rest();
    moved.square = smg_lane_of(smg_push_colours(q, pass.colour, 1, smg_push_vector));
    smg_take_pass(q->s, pass, &moved, &sweep);
  } while (sweep.passes < SMG_COLOURS || (sweep.passes < SMG_ROW_PASSES && !smg_push_rests(q->s, &sweep)));
  const smg_real left = SMG_MATH(sqrt)(smg_push_colours(q, 0, SMG_COLOURS, smg_push_end));
  const smg_real more = smg_left_by_sweeps(q->s); /* solutions are no larger than 1 + more times what they come from */
  return smg_swept_to_round_off(left, q->s->scale * (1 + more)) || smg_tolerated(q->s, left * more);
}

/* One column v, by sites; while sweeps are judged it is as large as the state. */
static smg_status smg_push_row_column(smg_row_push *q, smg_real *v) {
  smg_state *s = q->s;
  const int64_t n3 = 3 * smg_sites(&s->c);
  smg_real most = (smg_real)1e-300;
  for (int64_t k = 0; k < n3; ++k) smg_take(&most, smg_abs(v[k]));
  if (!(most <= SMG_MAX)) return SMG_NOT_FINITE;
  smg_scale(v, s->scale / most, n3);
  smg_to_slots(s, v, q->v);
  smg_push_begin(q);
  if (!smg_settle_push(q)) return smg_end_report(s, SMG_NO_CONVERGENCE, -1);
  smg_to_sites(s, q->v, v);
  smg_scale(v, most / s->scale, n3);
  return SMG_OK;
}

/* What all columns have alike, of the step of the size h that was just taken; in slots of no site dw is 0. */
static void smg_begin_push(smg_state *s, smg_real h, smg_besides *known, smg_real *mem, smg_row_push *q) {
  const size_t size = (size_t)smg_array_size(&s->c);
  smg_real *next = smg_line_from(mem), **all[] = {&q->v, &q->slopes, &q->x, &q->z, &q->g, &q->turn.m};
  smg_know_rows(s, known);
  smg_by_each_rank(&s->c);
  smg_begin_team(s, known);
  smg_put_absent(s, 0);
  q->s = s;
  q->known = known;
  q->turn = smg_turning_of(s, h);
  smg_zero(next, (int64_t)size);
  for (int n = 0; n < 6; ++n) *all[n] = smg_place_slots(&next, size);
  known->points = q->turn.m;
#if SMG_COMPOSED
  smg_push_midpoints(q, s->past[0]);
#else
  smg_newest_increments(s, q->z);
  smg_push_midpoints(q, q->z);
#endif
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    smg_each_vector(&s->c, known, q->turn.m, colour, smg_colours_from(&s->c, colour, 1), q, smg_push_slopes);
}

#endif
