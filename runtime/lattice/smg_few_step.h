/* smidgen runtime: the step of few sites that all feel each other by fixed-point iteration in lanes, u <- h X(P(w +
 * compensation + u/2)) for all sites at once, tried before Newton.
 *
 * The iteration ends where one more evaluation would move u by a small part of an ulp, as the rate at which changes
 * shrink tells. That evaluation is still made, and with it sums of bounds on the norms of the Hessian in each row: the
 * rows of J - I are at most
 *
 *     (h/2)(1/kappa) s (r sum of norms + abs(m.g)/r),
 *
 * (smg_end_site of smg_sweep.h). Newton takes the step instead if such a bound is above SMG_CONTRACTS, or if it is
 * above SMG_SLOWED and the changes did not shrink by more than that factor: true changes might then shrink as slowly
 * as those that smg_rest.h takes for round-off. Newton also takes it if the increments are longer than the largest
 * component of the state.
 *
 * Tracers, which feel the sites that carry them in place of each other, take it in blocks (smg_alone_lanes.h). */
#ifndef SMG_FEW_STEP_H
#define SMG_FEW_STEP_H

#include "smg_few.h"
#include "smg_lane_respond.h"
#include "smg_newton.h"
#include "smg_rest.h"
#include "smg_row_spin.h"

#define SMG_FEW_ROUNDS 32 /* evaluations; more of them cost more than Newton: four vortices 40 ns each, and 1200 */
/* Ulps of u that the last evaluation may move, as far as the rate tells. Sixteen spins, 1e6 steps: |w|^2 drifts by
 * 2e-20 a step or more with a twentieth of an ulp of w, by 1e-20 with one of u, and by nothing that is seen with
 * this. */
#define SMG_FEW_LEFT (SMG_LEFT * SMG_LEFT)

/* How far u/2 moved: the largest square, and the largest part of what a small component of w + u/2 is made of; the
 * largest square of u; and of the last evaluation bounds on the rows of J - I, and on the squares of the products in
 * h X. */
typedef struct smg_few_motion {
  smg_lanes square, part, size, row, products;
} smg_few_motion;

/* The sites of a step: their arrays, the first of them in the state, how many they are, and slots of an array. */
typedef struct smg_few_sites {
  smg_real *a;
  int64_t first, sites, pitch;
} smg_few_sites;

/* s->u = u extrapolated, the newest increments last: they are ready last. */
SMG_INLINE void smg_few_predict(const smg_state *s, const smg_few_sites *b) {
  const int64_t from = 3 * b->first, n = from + 3 * b->sites, whole = n - (n - from) % SMG_LANES;
  for (int64_t k = from; k < whole; k += SMG_LANES) {
    smg_lanes sum = {0};
    for (int j = s->degree; j >= 0; --j) sum += smg_weight(s->degree, j) * smg_lane_take(s->past[j] + k);
    smg_lane_put(s->u + k, sum);
  }
  for (int64_t k = whole; k < n; ++k) {
    s->u[k] = 0;
    for (int j = s->degree; j >= 0; --j) s->u[k] += smg_weight(s->degree, j) * s->past[j][k];
  }
}

/* The arrays of a step for the sites of one vector, `in` of them sites of the state: lanes beyond hold a vector that
 * nothing turns. */
SMG_INLINE smg_lane_mask smg_few_fill(const smg_state *s, smg_real h, const smg_few_sites *b, int64_t i, int64_t in) {
  smg_real *a = b->a + i;
  const int64_t pitch = b->pitch, site = b->first + i;
  smg_lanes rate = {0}, radius = smg_lane_of(1);
  smg_lane_mask small = smg_lane_all(0);
  for (int64_t l = 0; l < in; ++l) {
    smg_lane_set(&rate, (int)l, (smg_real)0.5 * smg_h_over_kappa(&s->c, site + l, h));
    smg_lane_set(&radius, (int)l, smg_radius(&s->c, site + l));
  }
  for (int q = 0; q < 3; ++q) {
    const smg_lanes w = smg_few_gather(s->w + 3 * site + q, in, q == 2);
    small |= (smg_lane_mask)(smg_lane_abs(w) < SMG_SMALL_PART * radius);
    smg_lane_put(a + (SMG_FEW_W + q) * pitch, w);
    smg_lane_put(a + (SMG_FEW_LOST + q) * pitch, smg_few_gather(s->compensation + 3 * site + q, in, 0));
    smg_lane_put(a + (SMG_FEW_U + q) * pitch, smg_few_gather(s->u + 3 * site + q, in, 0));
  }
#if SMG_OWN_RADIUS
  small |= (smg_lane_mask)(radius < smg_lane_of(SMG_SMALL_PART * s->scale));
#endif
  smg_lane_put(a + SMG_FEW_HALF * pitch, rate);
  smg_lane_put(a + SMG_FEW_RADIUS * pitch, radius);
  return small & smg_lane_below(in);
}

/* The arrays of a step from the state, u extrapolated; is a component, or a sphere, so small that it is watched on its
 * own? */
SMG_INLINE int smg_few_enter(const smg_state *s, smg_real h, const smg_few_sites *b) {
  const int64_t whole = b->sites - b->sites % SMG_LANES;
  smg_lane_mask small = smg_lane_all(0);
  smg_few_predict(s, b);
  for (int64_t i = 0; i < whole; i += SMG_LANES) small |= smg_few_fill(s, h, b, i, SMG_LANES);
  if (whole < b->sites) small |= smg_few_fill(s, h, b, whole, b->sites - whole);
  return smg_lane_any(small);
}

SMG_INLINE void smg_few_leave(const smg_state *s, const smg_few_sites *b) {
  for (int64_t k = 0; k < b->sites; ++k)
    for (int q = 0; q < 3; ++q) s->u[3 * (b->first + k) + q] = b->a[(SMG_FEW_U + q) * b->pitch + k];
}

/* m = (w + compensation + u/2)/|..|, as long as the radius: times r/|..| = (r/|..|^2) |..|, so that the root and the
 * division do not wait for each other. Both rounded correctly, they take less time than an inverse root by products, of
 * which each waits for the one before. The inverse from the evaluation before, with a correction, would take less
 * again, but creep by ulps of one sign: |w| of sixteen spins then drifted by 2e-20 a step. */
static void smg_few_midpoints(smg_real *a, int64_t sites, int64_t pitch) {
  for (int64_t i = 0; i < sites; i += SMG_LANES) {
    smg_lanes m[3], lost[3], u[3];
    smg_take_from(3, a + SMG_FEW_W * pitch + i, pitch, m);
    smg_take_from(3, a + SMG_FEW_LOST * pitch + i, pitch, lost);
    smg_take_from(3, a + SMG_FEW_U * pitch + i, pitch, u);
    smg_lane_axpy(lost, smg_lane_of((smg_real)0.5), u, 3);
    smg_lane_axpy(m, smg_lane_of(1), lost, 3);
    const smg_lanes square = smg_lane_dot(m, m),
                    s = smg_lane_take(a + SMG_FEW_RADIUS * pitch + i) / square * smg_lane_sqrt(square);
    smg_lane_scale(m, s, 3);
    smg_put_slots(a + SMG_FEW_M * pitch, pitch, i, m);
    smg_lane_put(a + SMG_FEW_ONTO * pitch + i, s);
  }
}

/* The part by which a component of w + u/2 moved, to 13 %, where it is small. */
SMG_INLINE void smg_few_watch(const smg_real *a, int64_t pitch, int64_t i, const smg_lanes *u, const smg_lanes *off,
                              smg_few_motion *moved) {
  const smg_lanes small = SMG_SMALL_PART * smg_lane_take(a + SMG_FEW_RADIUS * pitch + i);
  for (int k = 0; k < 3; ++k) {
    const smg_lanes made =
        smg_lane_abs(smg_lane_take(a + (SMG_FEW_W + k) * pitch + i)) + smg_lane_abs((smg_real)0.5 * u[k]);
    moved->part = smg_lane_max(moved->part, smg_part_moved(small, off[k], made));
  }
}

/* The square of how much smaller than others a sphere is: it is watched as if it were as large. */
SMG_INLINE smg_lanes smg_few_up(SMG_UNUSED const smg_state *s, SMG_UNUSED const smg_real *a, SMG_UNUSED int64_t pitch,
                                SMG_UNUSED int64_t i, SMG_UNUSED int small) {
#if SMG_OWN_RADIUS
  const smg_lanes r = smg_lane_take(a + SMG_FEW_RADIUS * pitch + i), most = smg_lane_larger(r, smg_lane_of(s->scale));
  if (small) return most * most / (r * r);
#endif
  return smg_lane_of(1);
}

/* u = h X(m) of the sites of one vector, `in` of them sites of the state, and how far that moved it. */
SMG_INLINE void smg_few_turn(const smg_state *s, const smg_told *told, smg_real *a, int64_t pitch, int64_t i,
                             int64_t in, int small, const smg_lanes *g, smg_few_motion *moved) {
  const smg_lanes rate = 2 * smg_lane_take(a + SMG_FEW_HALF * pitch + i);
  smg_lanes m[3], u[3], before[3], room[3];
  smg_take_from(3, a + SMG_FEW_M * pitch + i, pitch, m);
  smg_take_from(3, a + SMG_FEW_U * pitch + i, pitch, before);
  smg_lane_cross(u, m, smg_lane_respond(told, m, g, room)); /* the rate last, as in smg_increment */
  for (int k = 0; k < 3; ++k) {
    u[k] = smg_lane_first(in, rate * u[k]);
    before[k] = (smg_real)0.5 * (u[k] - before[k]);
  }
  if (small) smg_few_watch(a, pitch, i, u, before, moved);
  smg_put_slots(a + SMG_FEW_U * pitch, pitch, i, u);
  moved->square = smg_lane_max(moved->square, smg_few_up(s, a, pitch, i, small) * smg_lane_dot(before, before));
  moved->size = smg_lane_larger(moved->size, smg_few_up(s, a, pitch, i, small) * smg_lane_dot(u, u));
}

/* smg_respond_norm */
SMG_INLINE smg_lanes smg_few_norm(SMG_UNUSED const smg_told *told, const smg_lanes *m, const smg_lanes *g, smg_lanes r,
                                  smg_lanes norms) {
#if SMG_RESPONDS
  smg_lanes F[3], Q[3];
  smg_lane_told_parts(told->r, g, F, Q);
  return (smg_abs(told->r[0]) + r * smg_abs(told->r[1])) * norms * r + smg_lane_abs(smg_lane_dot(m, F)) / r +
         smg_lane_abs(smg_lane_dot(m, Q));
#else
  return r * norms + smg_lane_abs(smg_lane_dot(m, g)) / r;
#endif
}

/* Those bounds of the sites of one vector; 0 beyond the last site. */
SMG_INLINE void smg_few_rows(const smg_told *told, const smg_real *a, int64_t pitch, int64_t i, int64_t in,
                             const smg_lanes *g, smg_lanes norms, smg_few_motion *moved) {
  const smg_lanes half = smg_lane_take(a + SMG_FEW_HALF * pitch + i), r = smg_lane_take(a + SMG_FEW_RADIUS * pitch + i);
  smg_lanes m[3], room[3];
  smg_take_from(3, a + SMG_FEW_M * pitch + i, pitch, m);
  const smg_lanes *R = smg_lane_respond(told, m, g, room);
  const smg_lanes own =
      smg_lane_abs(half) * smg_lane_take(a + SMG_FEW_ONTO * pitch + i) * smg_few_norm(told, m, g, r, norms);
  const smg_lanes square = 4 * half * half * (r * r) * smg_lane_dot(R, R);
  moved->row = smg_lane_max(moved->row, smg_lane_first(in, own));
  moved->products = smg_lane_max(moved->products, smg_lane_first(in, square));
}

SMG_INLINE smg_few_motion smg_few_still(void) {
  const smg_lanes none = {0};
  const smg_few_motion still = {none, none, none, none, none};
  return still;
}

/* dH/dw of the sites of one vector. */
SMG_INLINE void smg_few_field_at(const smg_state *s, const smg_few_sites *b, int64_t i, smg_lanes *g) {
  for (int k = 0; k < 3; ++k) g[k] = smg_lane_of(0);
#if SMG_ALONE_IN_LANES
  smg_lanes m[3];
  smg_take_from(3, b->a + SMG_FEW_M * b->pitch + i, b->pitch, m);
  smg_alone_field(&s->c, s->m, m, g);
#else
  smg_few_field(&s->c, b->a + SMG_FEW_M * b->pitch, b->pitch, i, g);
#endif
}
SMG_INLINE void smg_few_norms_at(const smg_state *s, const smg_few_sites *b, int64_t i, smg_lanes *g) {
#if SMG_ALONE_IN_LANES
  smg_lanes m[3];
  smg_few_field_at(s, b, i, g);
  smg_take_from(3, b->a + SMG_FEW_M * b->pitch + i, b->pitch, m);
  g[3] = smg_lane_of(0);
  for (int k = 0; k < 3; ++k) { /* of all three columns */
    smg_lanes d[3] = {smg_lane_of(k == 0), smg_lane_of(k == 1), smg_lane_of(k == 2)},
              y[3] = {smg_lane_of(0), smg_lane_of(0), smg_lane_of(0)};
    smg_alone_change(&s->c, s->m, m, d, y);
    g[3] += smg_lane_dot(y, y);
  }
  g[3] = smg_lane_sqrt(g[3]);
#else
  for (int k = 0; k < 4; ++k) g[k] = smg_lane_of(0);
  smg_few_norms(&s->c, b->a + SMG_FEW_M * b->pitch, b->pitch, i, g);
#endif
}

/* All increments from the midpoints as they were; last: with those bounds. */
SMG_INLINE smg_few_motion smg_few_evaluate(const smg_state *s, const smg_few_sites *b, int small, int last) {
  smg_few_motion moved = smg_few_still();
  const smg_told told = smg_told_of(&s->c, b->first);
  smg_few_midpoints(b->a, b->sites, b->pitch);
  for (int64_t i = 0; i < b->sites; i += SMG_LANES) {
    smg_lanes g[4];
    if (last) smg_few_norms_at(s, b, i, g);
    else smg_few_field_at(s, b, i, g);
    if (last) smg_few_rows(&told, b->a, b->pitch, i, b->sites - i, g, g[3], &moved);
    smg_few_turn(s, &told, b->a, b->pitch, i, b->sites - i, small, g, &moved);
  }
  return moved;
}

/* Would one more evaluation move less than SMG_FEW_LEFT ulps of u, or than the user allows; or do changes shrink no
 * more? That move, along u, changes |w|, with one sign along many an orbit. */
static inline int smg_few_settled(const smg_state *s, const smg_rest *whole, const smg_rest *part, smg_real square) {
  if (smg_tolerated(s, whole->rate * whole->now) && s->tolerance > 0) return 1;
  const smg_real next = whole->rate * whole->left / (SMG_FEW_LEFT * SMG_EPS);
  return (whole->stays || next * next <= square) && smg_rest_settled(part, SMG_EPS);
}

/* Iterates until it has settled, and returns the row sums of J - I up to which the step is accepted, or 0 if it does
 * not settle soon. Changes that are round-off of the field, whose terms may cancel, need not shrink. */
SMG_INLINE smg_real smg_few_settle(smg_state *s, const smg_few_sites *b, int small) {
  smg_rest whole = smg_unknown_rest, part = smg_unknown_rest;
  for (int n = 1; n < SMG_FEW_ROUNDS; ++n) {
    const smg_few_motion moved = smg_few_evaluate(s, b, small, 0);
    const smg_real change = SMG_MATH(sqrt)(smg_lane_largest(moved.square));
    const int still = smg_still(change, s->scale);
    if (n > 3 && !(change <= SMG_CONTRACTS * whole.now) && !smg_swept_to_round_off(change, s->scale)) return 0;
    smg_rest_take(&whole, change, still);
    smg_rest_take(&part, smg_lane_largest(moved.part), still);
    s->report.iterations = n;
    if (smg_few_settled(s, &whole, &part, smg_lane_largest(moved.size)))
      return whole.rate < SMG_SLOWED ? SMG_CONTRACTS : SMG_SLOWED;
  }
  return 0;
}

/* The last evaluation: do its increments solve the step, and on the right branch? */
SMG_INLINE int smg_few_solved(smg_state *s, const smg_few_sites *b, smg_real rows) {
  const smg_few_motion moved = smg_few_evaluate(s, b, 0, 1);
  s->report.residual = SMG_MATH(sqrt)(smg_lane_largest(moved.square));
  const int solved = smg_swept_to_round_off(s->report.residual, s->scale) || smg_tolerated(s, s->report.residual);
  return solved && smg_lane_largest(moved.row) <= rows && smg_lane_largest(moved.products) <= s->scale * s->scale;
}

#if SMG_FEW_IN_LANES
#if SMG_UNIT == 2
SMG_LINKED smg_status smg_few_iterate(smg_state *s, smg_real h);
#else
/* The step, or SMG_NO_CONVERGENCE, which leaves it to Newton, and the next SMG_NEWTON_STEPS steps with it; or to
 * sweeps, which count those. */
SMG_LINKED smg_status smg_few_iterate(smg_state *s, smg_real h) {
  if (s->newton_steps > 0) {
    s->newton_steps -= !SMG_SWEPT;
    return SMG_NO_CONVERGENCE;
  }
  const smg_few_sites b = {s->few, 0, smg_sites(&s->c), smg_whole_vectors(smg_sites(&s->c))};
  const smg_real rows = smg_few_settle(s, &b, smg_few_enter(s, h, &b));
  if (rows > 0 && smg_few_solved(s, &b, rows)) {
    smg_few_leave(s, &b);
    return SMG_OK;
  }
  s->newton_steps = SMG_SWEPT ? 0 : SMG_NEWTON_STEPS;
  return SMG_NO_CONVERGENCE;
}
#endif
#endif

#endif
