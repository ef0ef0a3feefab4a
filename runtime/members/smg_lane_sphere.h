/* smidgen method: the step of smg_single_sphere.h for SMG_LANES states at once, one a lane, each with the bits that it
 * has alone.
 *
 * The same operations in the same order, in lanes: the prediction, one Newton iteration, and what smg_sphere_again()
 * adds where that left too much. What lanes do not do they leave to smg_step(): the lane is put back into its state,
 * steps there, and is taken up again, unless the step failed. So whatever is rare stands in one place, there.
 *
 * The model adds: smg_lane_coefficients, the numbers that its kernels read, in lanes; smg_lane_fill(to, l, c) puts
 * those of one state into lane l, smg_lane_spread(to, c) into all;
 * smg_lane_motion, smg_lane_radial, smg_lane_derivative, smg_lane_slope_times, smg_lane_slope_minors,
 * smg_lane_slope_sums, as smg_single_sphere.h says. */
#ifndef SMG_LANE_SPHERE_H
#define SMG_LANE_SPHERE_H

#include "smg_lane_vec.h"
#include "smg_single_sphere.h"

#if SMG_LANES > 1

/* rows of history before they are moved back: more leave the nearest cache, fewer are moved more often */
#define SMG_LANE_ROWS 24
/* groups of lanes that step in turn, for the processor to overlap; with more their histories leave a nearest cache of
 * 32 KB */
#define SMG_GROUPS 3

/* A Newton iteration: the increment, 1/|w + W|, det(1 - E), and the square of the change. */
typedef struct smg_lane_newton {
  smg_lane_vec u;
  smg_lanes q, det, size;
} smg_lane_newton;

/* SMG_LANES states under way. */
typedef struct smg_group {
  smg_lanes w[3], compensation[3], weights[SMG_HISTORY], rows[4 * SMG_LANE_ROWS], residual;
  smg_lane_newton next;
  smg_lane_coefficients c;
  /* no lane is live that repeats another, or whose step failed; began: the count at its beginning */
  smg_lane_mask live, iterations, began;
  smg_state *state[SMG_LANES];
  int64_t taken; /* steps since then */
  int row, deep; /* the newest of the history; have rows beyond SMG_FEW_ROWS weights? */
} smg_group;

/* Groups that step in turn. alike: all have the same parameters and times, and the coefficients c. */
typedef struct smg_batch {
  smg_group group[SMG_GROUPS];
  smg_coefficients c;
  int groups, alike;
} smg_batch;

/* What a step has found: the increment with and without compensation, the state after it, and 1/|w + W|. */
typedef struct smg_lane_found {
  smg_lane_vec v, y, W;
  smg_lanes q, residual;
} smg_lane_found;

/* ---- the step, as in smg_single_sphere.h ---------------------------------------------------- */

SMG_INLINE smg_lane_mask smg_lanes_clear(smg_lanes det) {
  return (smg_lane_mask)(det > (smg_real)0.4375) & (smg_lane_mask)(det < 5);
}
/* smg_sphere_trace and smg_sphere_determinant */
SMG_INLINE smg_lanes smg_lanes_trace(smg_lane_slope D) {
#if SMG_RESPONDS
  return smg_lane_slope_trace(D);
#else
  return (void)D, smg_lane_of(0);
#endif
}
SMG_INLINE smg_lanes smg_lanes_determinant(smg_lanes det, smg_lanes t) {
#if SMG_RESPONDS
  const smg_lane_mask known = (smg_lane_mask)(det + t < 5) & (smg_lane_mask)(smg_lane_abs(t) < 1);
  return smg_lane_select(known, det + (smg_real)0.25 * t, smg_lane_of(0));
#else
  return (void)t, det;
#endif
}

SMG_INLINE smg_lane_mask smg_lanes_small(smg_lanes size) { return (smg_lane_mask)(size < SMG_SMALL); }

SMG_INLINE smg_lanes smg_lanes_bound(const smg_lane_coefficients *c, smg_lane_vec m, smg_lanes q) {
  return smg_lane_vec_largest(smg_lane_slope_sums(smg_lane_derivative(c, m, q)));
}

SMG_INLINE smg_lanes smg_lanes_predicted(const smg_group *g, int i) {
  const smg_lanes *row = g->rows + 4 * g->row + i, *a = g->weights;
  smg_lanes sum = a[SMG_FEW_ROWS - 1] * row[4 * (SMG_FEW_ROWS - 1)];
  SMG_UNROLL
  for (int j = SMG_FEW_ROWS - 2; j >= 2; --j) sum += a[j] * row[4 * j];
  if (g->deep) {
    const smg_lanes few = sum, none = {0};
    for (int j = SMG_FEW_ROWS; j < SMG_HISTORY - 1; ++j) sum += a[j] * row[4 * j];
    sum = smg_lane_select((smg_lane_mask)(a[SMG_FEW_ROWS] != none), sum, few);
  }
  sum += a[1] * row[4];
  return sum + a[0] * row[0];
}

SMG_INLINE smg_lane_vec smg_lanes_twice_midpoint(smg_lane_vec w, smg_lane_vec u) {
  return smg_lane_vec_of(2 * w.x + u.x, 2 * w.y + u.y, 2 * w.z + u.z);
}

SMG_INLINE smg_lane_vec smg_lanes_image(const smg_lane_coefficients *c, smg_lane_vec S, smg_lanes q) {
  return smg_lane_motion(c, smg_lane_vec_scale(q, S));
}

SMG_INLINE smg_lane_newton smg_lanes_newton(const smg_lane_coefficients *c, smg_lane_vec w, smg_lane_vec u,
                                            smg_lanes q) {
  smg_lane_newton found;
  const smg_lane_vec S = smg_lanes_twice_midpoint(w, u), m = smg_lane_vec_scale(q, S), g0 = smg_lane_motion(c, m),
                     e = smg_lane_radial(c, m, g0);
  const smg_lanes eps = 0.5 - smg_lane_vec_dot(S, S) * (0.5 * q * q), mu = smg_lane_vec_dot(m, u);
  const smg_lane_slope D = smg_lane_derivative(c, m, q);
  const smg_lanes trace = smg_lanes_trace(D), kept = 1 - trace,
                  t = kept + (smg_lane_slope_minors(D) - (q * q) * smg_lane_vec_dot(g0, e)), i = 1 / t;
  const smg_lane_vec g = smg_lane_vec_add(g0, smg_lane_vec_scale(eps, e)),
                     a = smg_lane_vec_add(g, smg_lane_vec_sub(smg_lane_vec_scale(mu, m), u));
  const smg_lane_vec b = smg_lane_slope_times(D, a), d = smg_lane_slope_times(D, b);
  const smg_lanes ga = smg_lane_vec_dot(g, a), gb = smg_lane_vec_dot(g, b), l = (q * q) * ga,
                  aa = smg_lane_vec_dot(a, a);
  found.q = ((q + q * (eps + q * mu)) - (0.5 * q * q * q) * aa) + (q * q * (q * i)) * (kept * ga + gb);
  found.det = smg_lanes_determinant(t, 1 - kept);
  found.size = aa + eps * eps;
  found.u = smg_lane_vec_add(g, smg_lane_vec_scale(i, smg_lane_vec_add(smg_lane_vec_scale(kept, b),
                                                                       smg_lane_vec_add(d, smg_lane_vec_scale(l, e)))));
  return found;
}

SMG_INLINE smg_lane_mask smg_lanes_settled(smg_lane_vec v, smg_lane_vec u, smg_lane_vec W) {
  return (smg_lane_mask)(smg_lane_abs(v.x - u.x) <= SMG_EPS * smg_lane_abs(W.x)) &
         (smg_lane_mask)(smg_lane_abs(v.y - u.y) <= SMG_EPS * smg_lane_abs(W.y)) &
         (smg_lane_mask)(smg_lane_abs(v.z - u.z) <= SMG_EPS * smg_lane_abs(W.z));
}

/* smg_within_ulp(d, W, v, 1) */
SMG_INLINE smg_lane_mask smg_lanes_close(smg_lanes d, smg_lanes W, smg_lanes v) {
  return (smg_lane_mask)(smg_lane_abs(d) <= SMG_EPS * smg_lane_abs(W)) |
         (smg_lane_mask)(smg_lane_abs(d) <= 8 * SMG_EPS * smg_lane_abs(v));
}

/* What another Newton iteration makes of the lanes `wanted`; returns those that it settled. */
SMG_COLD static smg_lane_mask smg_lanes_second(const smg_group *g, smg_lane_mask wanted, smg_lane_newton *n,
                                               smg_lane_found *f) {
  const smg_lane_vec w = smg_lane_vec_load(g->w);
  const smg_lane_newton next = smg_lanes_newton(&g->c, w, n->u, n->q);
  const smg_lane_vec S = smg_lanes_twice_midpoint(w, next.u);
  const smg_lanes q = 1 / smg_lane_sqrt(smg_lane_vec_dot(S, S));
  const smg_lane_vec v = smg_lanes_image(&g->c, S, q);
  n->u = smg_lane_vec_select(wanted, next.u, n->u);
  n->det = smg_lane_select(wanted, next.det, n->det);
  n->size = smg_lane_select(wanted, next.size, n->size);
  f->q = smg_lane_select(wanted, q, f->q);
  f->v = smg_lane_vec_select(wanted, v, f->v);
  return wanted & smg_lanes_settled(v, next.u, smg_lane_vec_add(w, v));
}

/* smg_sphere_again() in the lanes `left`; returns those where it is not enough. n->q: Newton's, as f->q. */
SMG_COLD static smg_lane_mask smg_lanes_again(smg_group *g, smg_lane_mask left, smg_lane_newton *n, smg_lane_found *f) {
  const smg_lane_vec w = smg_lane_vec_load(g->w), compensation = smg_lane_vec_load(g->compensation);
  const smg_lane_mask wanted = left & ~smg_lanes_small(n->size);
  smg_lane_mask settled = smg_lane_all(0);
  if (smg_lane_any(wanted)) settled = smg_lanes_second(g, wanted, n, f);
  const smg_lane_vec v = f->v, twice = smg_lane_vec_scale(smg_lane_of(2), compensation);
  const smg_lane_vec z = smg_lanes_image(&g->c, smg_lanes_twice_midpoint(w, smg_lane_vec_add(v, twice)), f->q),
                     y = smg_lane_vec_add(z, compensation), W = smg_lane_vec_add(w, y);
  settled |= smg_lanes_close(z.x - v.x, W.x, z.x) & smg_lanes_close(z.y - v.y, W.y, z.y) &
             smg_lanes_close(z.z - v.z, W.z, z.z);
  const smg_lanes bound = smg_lanes_bound(&g->c, smg_lane_vec_scale(f->q, smg_lanes_twice_midpoint(w, n->u)), f->q);
  const smg_lane_mask good = settled & smg_lanes_clear(n->det) & (smg_lane_mask)(bound <= SMG_DAMPS) &
                             smg_lanes_small(n->size) & (smg_lane_mask)(smg_lane_vec_largest(z) <= SMG_MAX);
  f->v = smg_lane_vec_select(left, z, v);
  f->y = smg_lane_vec_select(left, y, f->y);
  f->W = smg_lane_vec_select(left, W, f->W);
  f->residual = smg_lane_select(left, smg_lane_vec_largest(smg_lane_vec_sub(z, v)), f->residual);
  g->iterations = 1 - wanted; /* where a test holds its lane is -1 */
  return left & ~good;
}

/* W = w + v with its rounding error in compensation; v and q become the newest row of the history. */
SMG_INLINE void smg_lanes_commit(smg_group *g, const smg_lane_found *f) {
  if (g->row == 0) {
    for (int k = 0; k < 4 * (SMG_HISTORY - 1); ++k) g->rows[4 * (SMG_LANE_ROWS - SMG_HISTORY + 1) + k] = g->rows[k];
    g->row = SMG_LANE_ROWS - SMG_HISTORY + 1;
  }
  smg_lanes *row = g->rows + 4 * --g->row;
#if !SMG_PLAIN_SUMS
  const smg_lane_vec w = smg_lane_vec_load(g->w);
  smg_lane_vec_store(g->compensation, smg_lane_vec_sub(f->y, smg_lane_vec_sub(f->W, w)));
#endif
  smg_lane_vec_store(g->w, f->W);
  smg_lane_vec_store(row, f->v);
  row[3] = f->q;
  g->residual = f->residual;
  ++g->taken;
}

/* ---- lanes and states ------------------------------------------------------------------------ */

/* The weights of the predictor of lane l. */
static void smg_lane_degree(smg_group *g, int l, int degree) {
  for (int j = 0; j < SMG_HISTORY; ++j) smg_lane_set(g->weights + j, l, smg_sphere_weights[degree][4 * j]);
  g->deep |= degree >= SMG_FEW_ROWS;
}

/* w, compensation and the newest row of lane l, from its state. */
static void smg_lane_renew(smg_group *g, int l, const smg_state *s) {
  for (int b = 0; b < 3; ++b) {
    smg_lane_set(g->w + b, l, s->w[b]);
    smg_lane_set(g->compensation + b, l, s->compensation[b]);
  }
  for (int b = 0; b < 4; ++b) smg_lane_set(g->rows + 4 * g->row + b, l, s->rows[4 * s->row + b]);
  smg_lane_degree(g, l, s->degree);
}

/* All that lane l needs of a state but its coefficients. */
static void smg_lane_take_up(smg_group *g, int l, const smg_state *s) {
  for (int k = 4; k < 4 * SMG_HISTORY; ++k) smg_lane_set(g->rows + 4 * g->row + k, l, s->rows[4 * s->row + k]);
  smg_lane_renew(g, l, s);
}

/* Lane l as a state. */
static void smg_lane_put_back(const smg_group *g, int l) {
  smg_state *s = g->state[l];
  for (int b = 0; b < 3; ++b) {
    s->w[b] = smg_lane_get(g->w + b, l);
    s->compensation[b] = smg_lane_get(g->compensation + b, l);
  }
  s->row = SMG_ROWS - SMG_HISTORY;
  for (int k = 0; k < 4 * SMG_HISTORY; ++k) s->rows[4 * s->row + k] = smg_lane_get(g->rows + 4 * g->row + k, l);
}

/* ---- one step of a group ---------------------------------------------------------------------- */

/* smg_sphere_degree() in the lanes `due`. */
SMG_COLD static void smg_lanes_degree(smg_group *g, smg_lane_mask due) {
  smg_lanes miss[SMG_HISTORY - 1] = {{0}};
  for (int i = 0; i < 3; ++i) {
    smg_lanes row[SMG_HISTORY];
    for (int j = 0; j < SMG_HISTORY; ++j) row[j] = g->rows[4 * (g->row + j) + i];
    for (int d = 0; d + 1 < SMG_HISTORY; ++d) {
      for (int j = 0; j + 1 < SMG_HISTORY - d; ++j) row[j] -= row[j + 1];
      miss[d] += row[0] * row[0];
    }
  }
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(due, l)) continue;
    const int known = smg_rows_known(g->state[l], g->began[l] + g->taken);
    int best = 0;
    for (int d = 1; d + 1 < known; ++d)
      if (smg_lane_get(miss + d, l) < smg_lane_get(miss + best, l)) best = d;
    g->state[l]->history = known;
    g->state[l]->degree = best;
    smg_lane_degree(g, l, best);
  }
}

/* The step of lane l by smg_step(), from what it was before this one. */
SMG_COLD static void smg_lane_step_alone(smg_group *g, int l) {
  smg_state *s = g->state[l];
  smg_lane_put_back(g, l);
  s->count = g->began[l] + g->taken;
  s->report.status = smg_step(s);
  if (s->report.status != SMG_OK) g->live[l] = 0;
}

/* The lanes `alone` are where smg_step() has brought them. */
SMG_COLD static void smg_lanes_renew(smg_group *g, smg_lane_mask alone) {
  for (int l = 0; l < SMG_LANES; ++l) {
    if (!smg_lane_holds(alone & g->live, l)) continue;
    smg_lane_renew(g, l, g->state[l]);
    smg_lane_set(&g->residual, l, g->state[l]->report.residual);
    g->iterations[l] = g->state[l]->report.iterations;
  }
}

/* The lanes `left`, which one Newton iteration has not settled. */
SMG_COLD static void smg_lanes_unsettled(smg_group *g, smg_lane_mask left, smg_lane_newton *n, smg_lane_found *f) {
  const smg_lane_mask second = left & (smg_lane_mask)(n->size < SMG_SECOND);
  smg_lane_mask alone = left & ~second;
  if (smg_lane_any(second)) alone |= smg_lanes_again(g, second, n, f);
  if (smg_lane_any(alone))
    for (int l = 0; l < SMG_LANES; ++l)
      if (smg_lane_holds(alone, l)) smg_lane_step_alone(g, l);
  smg_lanes_commit(g, f);
  if (smg_lane_any(alone)) smg_lanes_renew(g, alone);
  const smg_lane_mask due = second & ~alone & (smg_lane_mask)(((g->began + g->taken) & 15) == 0);
  if (smg_lane_any(due)) smg_lanes_degree(g, due);
}

/* A step in three parts, each short enough that a processor works on several groups at once. */
SMG_INLINE void smg_lanes_predict(smg_group *g) {
  g->next.u = smg_lane_vec_of(smg_lanes_predicted(g, 0), smg_lanes_predicted(g, 1), smg_lanes_predicted(g, 2));
  g->next.q = smg_lanes_predicted(g, 3);
}

SMG_INLINE void smg_lanes_correct(smg_group *g) {
  g->next = smg_lanes_newton(&g->c, smg_lane_vec_load(g->w), g->next.u, g->next.q);
}

SMG_INLINE void smg_lanes_finish(smg_group *g) {
  smg_lane_found f;
  smg_lane_newton n = g->next;
  const smg_lane_vec w = smg_lane_vec_load(g->w);
  f.q = n.q;
  f.v = smg_lanes_image(&g->c, smg_lanes_twice_midpoint(w, n.u), n.q);
  f.y = smg_lane_vec_add(f.v, smg_lane_vec_load(g->compensation));
  f.W = smg_lane_vec_add(w, f.y);
  f.residual = smg_lane_abs(f.v.x - n.u.x) + smg_lane_abs(f.v.y - n.u.y) + smg_lane_abs(f.v.z - n.u.z);
  const smg_lane_mask fine = smg_lanes_settled(f.v, n.u, f.W) & smg_lanes_clear(n.det) & smg_lanes_small(n.size) &
                             (smg_lane_mask)(f.residual <= SMG_MAX);
  const smg_lane_mask left = g->live & ~fine;
  g->iterations = smg_lane_all(0) + 1;
  if (smg_lane_any(left)) smg_lanes_unsettled(g, left, &n, &f);
  else smg_lanes_commit(g, &f);
}

/* ---- many states ------------------------------------------------------------------------------ */

/* The states at s, one a lane, n <= SMG_LANES of them; other lanes repeat the first. alike: all have the same
 * parameters. */
static void smg_group_begin(smg_group *g, smg_state *const *s, int n, int alike) {
  g->taken = 0;
  g->row = SMG_LANE_ROWS - SMG_HISTORY;
  g->deep = 0;
  g->live = smg_lane_below(n);
  for (int l = 0; l < SMG_LANES; ++l) {
    g->state[l] = s[l < n ? l : 0];
    g->began[l] = g->state[l]->count;
    smg_lane_take_up(g, l, g->state[l]);
    if (!alike) smg_lane_fill(&g->c, l, &g->state[l]->c);
  }
  if (alike) smg_lane_spread(&g->c, &s[0]->c);
}

/* All lanes are states again. */
static void smg_group_end(smg_group *g) {
  if (g->taken == 0) return;
  for (int l = 0; l < SMG_LANES; ++l) {
    smg_state *s = g->state[l];
    if (!smg_lane_holds(g->live, l)) continue;
    smg_lane_put_back(g, l);
    s->count = g->began[l] + g->taken;
    s->report.status = SMG_OK;
    s->report.iterations = (int)g->iterations[l];
    s->report.residual = smg_lane_get(&g->residual, l);
#if SMG_TIMED
    smg_set_time(&s->c, smg_time_at(s, (smg_real)-0.5)); /* of the step just taken */
#endif
  }
}

#if SMG_TIMED
/* The time of the midpoint of the step to come, in the coefficients of all lanes. */
static void smg_batch_time(smg_batch *b) {
  if (b->alike) {
    const smg_group *g = b->group;
    smg_set_time(&b->c,
                 smg_time_at(g->state[0], (smg_real)(g->began[0] + g->taken - g->state[0]->count) + (smg_real)0.5));
    for (int k = 0; k < b->groups; ++k) smg_lane_spread(&b->group[k].c, &b->c);
    return;
  }
  for (int k = 0; k < b->groups; ++k)
    for (int l = 0; l < SMG_LANES; ++l) {
      smg_group *g = b->group + k;
      smg_state *s = g->state[l];
      if (!smg_lane_holds(g->live, l)) continue;
      smg_set_time(&s->c, smg_time_at(s, (smg_real)(g->began[l] + g->taken - s->count) + (smg_real)0.5));
      smg_lane_fill(&g->c, l, &s->c);
    }
}
#endif

/* count steps of n <= SMG_GROUPS*SMG_LANES states. */
static void smg_batch_steps(smg_state *const *s, int n, int64_t count, int alike) {
  smg_batch b;
  b.c = s[0]->c;
  b.alike = alike;
  b.groups = 0;
  for (int k = 0; k < n; ++k) b.alike &= smg_same_times(s[0], s[k]);
  for (int k = 0; k < n; k += SMG_LANES)
    smg_group_begin(b.group + b.groups++, s + k, n - k < SMG_LANES ? n - k : SMG_LANES, b.alike);
  for (int64_t k = 0; k < count; ++k) {
#if SMG_TIMED
    smg_batch_time(&b);
#endif
    for (int g = 0; g < b.groups; ++g) smg_lanes_predict(b.group + g);
    for (int g = 0; g < b.groups; ++g) smg_lanes_correct(b.group + g);
    for (int g = 0; g < b.groups; ++g) smg_lanes_finish(b.group + g);
  }
  for (int g = 0; g < b.groups; ++g) smg_group_end(b.group + g);
}

/* One step of each state that has none behind it, with all others, where there is such a one; returns how many steps
 * that were. */
static int64_t smg_lane_first_steps(smg_state *s, int64_t members, int64_t count) {
  int fresh = 0;
  for (int64_t k = 0; k < members; ++k) fresh |= s[k].report.status == SMG_OK && s[k].count == s[k].begun;
  if (!fresh || count < 1) return 0;
  for (int64_t k = 0; k < members; ++k)
    if (s[k].report.status == SMG_OK) s[k].report.status = smg_step(s + k);
  return 1;
}

/* count steps of those states that have not failed; alike: all have the same parameters. */
static void smg_lane_steps(smg_state *s, int64_t members, int64_t count, int alike) {
  smg_state *some[SMG_GROUPS * SMG_LANES];
  int n = 0;
  count -= smg_lane_first_steps(s, members, count);
  for (int64_t k = 0; k < members; ++k) {
    if (s[k].report.status == SMG_OK) some[n++] = s + k;
    if (n == SMG_GROUPS * SMG_LANES || (n > 0 && k + 1 == members)) {
      smg_batch_steps(some, n, count, alike);
      n = 0;
    }
  }
}

#else

/* One lane: states step by themselves, and the kernels stay unused. */
static inline void smg_lanes_of_one(smg_lane_coefficients *to, const smg_coefficients *c, smg_lane_vec m, smg_lanes q) {
  const smg_lane_slope D = smg_lane_derivative(to, m, q);
  smg_lane_fill(to, 0, c);
  smg_lane_spread(to, c);
  (void)smg_lane_radial(to, m, smg_lane_motion(to, smg_lane_slope_times(D, m)));
  (void)smg_lane_slope_minors(D);
  (void)smg_lane_slope_sums(D);
#if SMG_RESPONDS
  (void)smg_lane_slope_trace(D);
#endif
}

#endif
#endif
