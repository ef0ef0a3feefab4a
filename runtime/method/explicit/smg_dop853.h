/* smidgen method: Dormand and Prince of order 8, explicit, with error estimates of orders 5 and 3 and control of its
 * own steps.
 *
 * w' = f(t, w) = (1/kappa) grad C(w) x dH/dw. Twelve stages give one internal step of the size p, with y = w at its
 * start:
 *     k_i = p f(t + c_i p, y + sum_(j<i) a_ij k_j),   y + sum_i b_i k_i,
 * and two linear combinations of them estimate its error. smg_step takes one output step, t0 + n h to t0 + (n + 1) h,
 * by as many internal ones as the tolerance asks; the last ends exactly there. It is no symplectic method: energy and
 * leaves drift.
 *
 * Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 (method), II.10 (estimates) and II.6
 * (dense output); coefficients in smg_dop853_table.h.
 *
 * What a build may choose:
 *     SMG_TOLERANCE   error of an internal step, as part of s->scale, the largest component: 1e-12, long double 1e-15,
 *                     quad 1e-26
 *     SMG_PROJECT     1: after every internal step each site goes back to its leaf, along grad C; default 0
 *     SMG_FIXED_STEP  1: h itself is the only internal step, whatever its error; default 0
 * Arrays: s->w, s->compensation, s->u (3 a site) and s->stages, which has 45 numbers a site and 4 more. */
#ifndef SMG_DOP853_H
#define SMG_DOP853_H

#include "smg_dop853_table.h"
#include "smg_leaf.h"

#define SMG_ONTO_LEAF 0
#define SMG_NO_DEGREE -1 /* there is no predictor */

#ifndef SMG_HISTORY
#define SMG_HISTORY 0 /* increments of steps before: none are kept */
#endif
#ifndef SMG_PROJECT
#define SMG_PROJECT 0
#endif
#define SMG_LEAVES_DRIFT !SMG_PROJECT
#ifndef SMG_FIXED_STEP
#define SMG_FIXED_STEP 0
#endif
#ifndef SMG_TOLERANCE
#if defined(SMG_LONG_DOUBLE)
#define SMG_TOLERANCE 1e-15
#elif defined(SMG_QUAD)
#define SMG_TOLERANCE 1e-26
#else
#define SMG_TOLERANCE 1e-12
#endif
#endif

#define SMG_GROWTH 6                   /* how much larger the next internal step may be, */
#define SMG_SHRINK ((smg_real)1 / 3)   /* and how much smaller */
#define SMG_SAFETY (smg_real)0.9       /* of the size at which the estimate would just be the tolerance */
#define SMG_LEAST_PART (smg_real)1e-12 /* of h, the smallest internal step */
#define SMG_MOST_TRIES 10000           /* internal steps of one output step, with those refused; */
/* after every so many of them it is given up where more than that are to be expected: the first sizes may be far too
 * small */
#define SMG_LOOK_AHEAD 128
#define SMG_LEAF_ROUNDS 4 /* of Newton's method onto the leaf */

/* s->stages: fifteen vectors of 3 numbers a site, then four numbers. The places of k_2 .. k_5, which neither the
 * increment nor the estimates need, serve the estimates and then k_13 .. k_16 of the dense output: "in order of places"
 * is 1, 13, 14, 15, 16, 6, 7, .., 12. */
enum { SMG_E5 = 1, SMG_E3, SMG_STAGES_USED = 12, SMG_Y = 12, SMG_Y_COMPENSATION, SMG_Y_BEFORE, SMG_STAGE_VECTORS };

/* The four numbers: the size of the last internal step that nothing cut short (0: none yet); where the last internal
 * step began and its size (0: there is none to interpolate); are k_13 .. k_16 there? Sizes are parts of h. */
enum { SMG_NATURAL, SMG_LAST_FROM, SMG_LAST_SIZE, SMG_EXTRA_READY, SMG_KEPT };

static inline smg_real *smg_vector(const smg_state *s, int i) { return s->stages + i * (3 * smg_sites(&s->c)); }
static inline smg_real *smg_kept(const smg_state *s) { return smg_vector(s, SMG_STAGE_VECTORS); }

/* ---- the history: one number, the natural size
 * --------------------------------------------------------------------------- */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) {
  (void)c;
  return 1;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) { out[0] = smg_kept(s)[SMG_NATURAL]; }

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  smg_kept(s)[SMG_NATURAL] = in[0];
  smg_kept(s)[SMG_LAST_SIZE] = 0;
}

#define SMG_HISTORY_ARRAYS 1
static inline void smg_forget_arrays(smg_state *s) { smg_kept(s)[SMG_NATURAL] = smg_kept(s)[SMG_LAST_SIZE] = 0; }

#include "smg_right_side.h"

/* ---- one internal step
 * --------------------------------------------------------------------------------------------------- */
/* out = sum_j a_j k_j, j < count, block after block of components, each of which stays in the cache. */
static inline void smg_sum_stages(const smg_state *s, const smg_real *a, int count, smg_real *out) {
  const int64_t n = 3 * smg_sites(&s->c), block = 256;
  for (int64_t from = 0; from < n; from += block) {
    const int64_t to = from + block < n ? from + block : n;
    for (int64_t q = from; q < to; ++q) out[q] = 0;
    for (int j = 0; j < count; ++j) {
      const smg_real *k = smg_vector(s, j), weight = a[j];
      if (weight == 0) continue;
      for (int64_t q = from; q < to; ++q) out[q] += weight * k[q];
    }
  }
}

/* sum_j a_j k_j at one component, j < count, n components to a stage. The compiler knows `a` and `count`: weights that
 * are 0 are not there. */
SMG_INLINE smg_real smg_weighted(const smg_real *a, int count, const smg_real *k, int64_t n) {
  smg_real sum = -(smg_real)0;
  SMG_UNROLL
  for (int j = 0; j < count; ++j)
    if (a[j] != 0) sum += a[j] * k[j * n];
  return sum;
}

/* z = y + sum_j a_ij k_j, j < i: only the last term waits for the stage before. What y has lost to rounding is less
 * than what z loses. */
SMG_INLINE void smg_dop853_point(int i, const smg_real *y, const smg_real *k, int64_t n, smg_real *SMG_RESTRICT z) {
  for (int64_t q = 0; q < n; ++q) {
    const smg_real older = i > 1 ? y[q] + smg_weighted(smg_dop853_a[i], i - 1, k + q, n) : y[q];
    z[q] = older + smg_dop853_a[i][i - 1] * k[(i - 1) * n + q];
  }
}

/* k_(i+1), i = 1 .. 11, of the internal step of the part `size` of h from the part `from` of it. */
SMG_INLINE void smg_dop853_stage(smg_state *s, int i, smg_real from, smg_real size) {
  smg_dop853_point(i, smg_vector(s, SMG_Y), s->stages, 3 * smg_sites(&s->c), s->u);
  smg_set_time_at(&s->c, s, from + smg_dop853_c[i] * size);
  smg_right_side(&s->c, size, s->u, smg_vector(s, i));
}

/* k_2 .. k_12. */
static inline void smg_later_stages(smg_state *s, smg_real from, smg_real size) {
  smg_dop853_stage(s, 1, from, size);
  smg_dop853_stage(s, 2, from, size);
  smg_dop853_stage(s, 3, from, size);
  smg_dop853_stage(s, 4, from, size);
  smg_dop853_stage(s, 5, from, size);
  smg_dop853_stage(s, 6, from, size);
  smg_dop853_stage(s, 7, from, size);
  smg_dop853_stage(s, 8, from, size);
  smg_dop853_stage(s, 9, from, size);
  smg_dop853_stage(s, 10, from, size);
  smg_dop853_stage(s, 11, from, size);
}

/* out = r sum_j a_j k_j of all stages. */
SMG_INLINE void smg_combine_slopes(const smg_real *a, smg_real r, const smg_real *k, int64_t n,
                                   smg_real *SMG_RESTRICT out) {
  for (int64_t q = 0; q < n; ++q) out[q] = r * smg_weighted(a, SMG_STAGES_USED, k + q, n);
}

/* The square of the error of site k, as part of what is allowed: e5^4/(e5^2 + e3^2/100) of the norms of both; squares
 * that leave the range of numbers are of steps that are far too large or too small. NaN where the new w of the site is
 * no number. */
static inline smg_real smg_site_error(const smg_state *s, int64_t k) {
  const smg_real *y = smg_vector(s, SMG_Y) + 3 * k, *u = s->u + 3 * k;
  const smg_real *e5 = smg_vector(s, SMG_E5) + 3 * k, *e3 = smg_vector(s, SMG_E3) + 3 * k;
  const smg_real end[3] = {y[0] + u[0], y[1] + u[1], y[2] + u[2]}, first = smg_dot(e5, e5),
                 both = first + smg_dot(e3, e3) * (smg_real)0.01;
  if (!(smg_largest(end) <= SMG_MAX)) return (smg_real)NAN;
  if (!(both <= SMG_MAX)) return SMG_MAX; /* of e5 that does not show beside it, too */
  return first > 0 ? first * (first / both) : first;
}

/* An output step under way. Sizes are parts of h. */
typedef struct smg_pace {
  /* what is done; the internal step that is tried; the next one if nothing cuts it short */
  smg_real done, size, natural;
  /* of the error of the try, as part of what is allowed; the largest of all that were accepted */
  smg_real square, largest;
  smg_real per_allowed;         /* 1/(tolerance scale); 0: all w are 0, and nothing moves */
  int64_t worst;                /* the site of that error */
  int tries, accepted, refused; /* refused: was the last try? */
} smg_pace;

/* u = sum_i b_i k_i, and the square of its error: the largest of all sites,
 *     e5^4/(e5^2 + e3^2/100), e5 = |sum_i (b_i - b5_i) k_i|, e3 alike. */
static inline void smg_estimate(smg_state *s, smg_pace *pace) {
  const int64_t sites = smg_sites(&s->c);
  const smg_real r = pace->per_allowed;
  smg_real most = 0;
  smg_combine_slopes(smg_dop853_b, 1, s->stages, 3 * sites, s->u);
  /* where k_2 and k_3 were, which are in none of them */
  smg_combine_slopes(smg_dop853_e5, r, s->stages, 3 * sites, smg_vector(s, SMG_E5));
  smg_combine_slopes(smg_dop853_e3, r, s->stages, 3 * sites, smg_vector(s, SMG_E3));
  for (int64_t k = 0; k < sites && most == most; ++k) {
    const smg_real error = smg_site_error(s, k);
    if (error <= most) continue;
    most = error; /* NaN comes in and stays */
    pace->worst = k;
  }
  pace->square = most;
}

#if SMG_PROJECT
/* v.grad C(v) at v = w + compensation, which is |v|^2, or 2 C(v); n = grad C(w). */
static inline smg_real smg_twice_casimir(const smg_coefficients *c, int64_t k, const smg_real *w,
                                         const smg_real *compensation, smg_real *n) {
  smg_normal(c, k, w, n);
  return smg_dot(n, w) + 2 * smg_dot(n, compensation);
}

/* y of site k back on the leaf of the start of the output step: y + a n, n = grad C(y), 2 a |n|^2 = 2 C - 2 C(y),
 * repeated. */
static inline void smg_back_on_leaf(const smg_state *s, int64_t k, smg_real *y, smg_real *compensation) {
  smg_real n[3], leaf;
  if (smg_kind(&s->c, k) == SMG_SPHERE) leaf = smg_radius(&s->c, k) * smg_radius(&s->c, k);
  else leaf = smg_twice_casimir(&s->c, k, s->w + 3 * k, s->compensation + 3 * k, n);
  for (int round = 0; round < SMG_LEAF_ROUNDS; ++round) {
    const smg_real off = leaf - smg_twice_casimir(&s->c, k, y, compensation, n), square = smg_dot(n, n);
    if (!(square > 0) || smg_abs(off) <= SMG_EPS * (smg_abs(n[0] * y[0]) + smg_abs(n[1] * y[1]) + smg_abs(n[2] * y[2])))
      return;
    for (int b = 0; b < 3; ++b) smg_add_compensated(&y[b], &compensation[b], off / (2 * square) * n[b]);
  }
}
#endif

/* The increment u is taken: y + u with its rounding error carried along, and back on the leaves. */
static inline void smg_take_step(smg_state *s) {
  smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION),
           *before = smg_vector(s, SMG_Y_BEFORE);
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) {
    before[q] = y[q];
#if SMG_PLAIN_SUMS
    y[q] += s->u[q];
#else
    smg_add_compensated(&y[q], &compensation[q], s->u[q]);
#endif
  }
#if SMG_PROJECT
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_back_on_leaf(s, k, y + 3 * k, compensation + 3 * k);
#endif
  (void)compensation;
}

/* ---- control of the size
 * ------------------------------------------------------------------------------------------------- */
/* x^(-1/16), from the bits of x > 0: those of a number are nearly its logarithm (smg_lane_rough_inverse_root()), off by
 * at most 3.3 %, which the part SMG_SAFETY makes up for; of numbers other than doubles by roots. */
#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD)
static inline smg_real smg_sixteenth(smg_real x) {
  return 1 / SMG_MATH(sqrt)(SMG_MATH(sqrt)(SMG_MATH(sqrt)(SMG_MATH(sqrt)(x))));
}
#else
/* bits of 1, and a sixteenth of them, less half of what logarithms are off */
#define SMG_SIXTEENTH UINT64_C(0x43ee44d013a92c00)
typedef union smg_bits {
  smg_real number;
  uint64_t bits;
} smg_bits;

static inline smg_real smg_sixteenth(smg_real x) {
  smg_bits both;
  both.number = x;
  both.bits = SMG_SIXTEENTH - (both.bits >> 4);
  return both.number;
}
#endif

/* The error of a step of size p goes as p^8: the factor at which it meets the tolerance, within its limits. */
static inline smg_real smg_step_factor(smg_real square) {
  if (!(square > 0)) return SMG_GROWTH;
  return smg_min(SMG_GROWTH, smg_max(SMG_SHRINK, SMG_SAFETY * smg_sixteenth(square)));
}

/* k_1, at the start of an internal step. */
static inline smg_status smg_first_stage(smg_state *s, smg_pace *pace) {
  const smg_real *k = smg_vector(s, 0);
  const int64_t n = 3 * smg_sites(&s->c);
  smg_set_time_at(&s->c, s, pace->done);
  smg_right_side(&s->c, pace->size, smg_vector(s, SMG_Y), smg_vector(s, 0));
  for (int64_t q = 0; q < n; ++q) {
    if (smg_abs(k[q]) <= SMG_MAX) continue;
    pace->worst = q / 3;
    return SMG_NOT_FINITE;
  }
  return SMG_OK;
}

/* The very first size, where k_1 alone would move w by the eighth root of the tolerance; the control soon finds a
 * better one. */
static inline smg_real smg_first_size(smg_state *s) {
  const smg_real *k = smg_vector(s, 0);
  smg_real most = 0;
  smg_set_time_at(&s->c, s, 0);
  smg_right_side(&s->c, 1, smg_vector(s, SMG_Y), smg_vector(s, 0));
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) most = smg_max(most, smg_abs(k[q]));
  const smg_real may = SMG_MATH(sqrt)(SMG_MATH(sqrt)(SMG_MATH(sqrt)(s->tolerance))) * s->scale;
  return most > may ? may / most : 1;
}

/* Where the next internal step ends: exactly at 1 when it comes near, and half way when two steps will do. Its size is
 * the difference as rounded, so that the sizes of all add up to 1. */
static inline smg_real smg_next_end(smg_pace *pace) {
  const smg_real left = 1 - pace->done;
  smg_real end = pace->done + smg_min(pace->natural, left / 2);
  if (SMG_FIXED_STEP || left <= pace->natural * (smg_real)1.01) end = 1;
  else if (left > 2 * pace->natural) end = pace->done + pace->natural;
  pace->size = end - pace->done;
  return end;
}

/* At this size so many tries do not come to an end. */
static inline int smg_too_far(const smg_pace *pace) {
  return pace->tries % SMG_LOOK_AHEAD == 0 && 1 - pace->done > pace->natural * (smg_real)(SMG_MOST_TRIES - pace->tries);
}

/* The step is good. A size that the end of h cut short says little of the natural one when its error vanishes. */
static inline void smg_accept(smg_state *s, smg_pace *pace, smg_real end) {
  const smg_real factor = pace->refused ? smg_min(1, smg_step_factor(pace->square)) : smg_step_factor(pace->square);
  smg_take_step(s);
  pace->largest = smg_max(pace->largest, pace->square);
  if (factor < SMG_GROWTH || pace->size * factor > pace->natural) pace->natural = pace->size * factor;
  smg_kept(s)[SMG_LAST_FROM] = pace->done;
  pace->done = end;
  pace->refused = 0;
  ++pace->accepted;
}

/* It is not: again from the same place, with a smaller size, as long as that is one. */
static inline smg_status smg_refuse_step(smg_pace *pace) {
  const int finite = pace->square - pace->square == 0;
  pace->natural = pace->size * (finite ? smg_step_factor(pace->square) : SMG_SHRINK);
  pace->refused = 1;
  if (!SMG_FIXED_STEP && pace->natural >= SMG_LEAST_PART) return SMG_OK;
  return finite ? SMG_NO_CONVERGENCE : SMG_NOT_FINITE;
}

/* ---- an output step
 * ------------------------------------------------------------------------------------------------------ */
/* All internal steps, in the scratch arrays. */
static smg_status smg_integrate(smg_state *s, smg_pace *pace) {
  smg_status status = SMG_OK;
  pace->natural = smg_max(SMG_LEAST_PART, pace->natural > 0 ? pace->natural : smg_first_size(s));
  while (status == SMG_OK && pace->done < 1) {
    if (++pace->tries > SMG_MOST_TRIES) return SMG_NO_CONVERGENCE;
    const smg_real end = smg_next_end(pace);
    status = smg_first_stage(s, pace);
    if (status != SMG_OK) return status;
    smg_later_stages(s, pace->done, pace->size);
    smg_estimate(s, pace);
    if (SMG_FIXED_STEP ? pace->square - pace->square == 0 : pace->square <= 1) smg_accept(s, pace, end);
    else status = smg_refuse_step(pace);
    if (status == SMG_OK && smg_too_far(pace)) return SMG_NO_CONVERGENCE;
  }
  return status;
}

/* The state after the step. */
static void smg_commit_steps(smg_state *s, const smg_pace *pace) {
  const smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    for (int64_t q = 3 * k; q < 3 * k + 3; ++q) {
      s->w[q] = y[q];
      s->compensation[q] = compensation[q];
    }
    /* open leaves: orbits grow */
    if (smg_kind(&s->c, k) == SMG_NAMBU) s->scale = smg_max(s->scale, smg_largest(y + 3 * k));
  }
  smg_kept(s)[SMG_NATURAL] = pace->natural;
  smg_kept(s)[SMG_LAST_SIZE] = pace->size;
  ++s->count;
}

static smg_status smg_step(smg_state *s) {
  smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION), *kept = smg_kept(s);
  const smg_real allowed = s->tolerance * s->scale;
  smg_pace pace = {0, 0, kept[SMG_NATURAL], 0, 0, allowed > 0 ? 1 / allowed : 0, -1, 0, 0, 0};
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) {
    y[q] = s->w[q];
    compensation[q] = s->compensation[q];
  }
  kept[SMG_LAST_SIZE] = kept[SMG_EXTRA_READY] = 0;
  s->report.partner = -1;
  s->report.status = smg_integrate(s, &pace);
  s->report.site = s->report.status == SMG_OK ? -1 : pace.worst;
  s->report.iterations = pace.accepted;
  s->report.residual = SMG_MATH(sqrt)(pace.largest) * allowed;
  s->report.reached = s->report.status == SMG_OK ? 0 : pace.done; /* where it could go no further */
  if (s->report.status == SMG_OK) smg_commit_steps(s, &pace);
  return s->report.status;
}

#include "smg_steps.h"

/* ---- dense output
 * -------------------------------------------------------------------------------------------------------- */
/* The part of h that the last internal step took; 0 before a step, after a failed one and after a restart. */
static inline smg_real smg_dense_part(const smg_state *s) { return smg_kept(s)[SMG_LAST_SIZE]; }

/* k_13 = f at the end, k_14 .. k_16, in the places of k_2 .. k_5. The step is counted already: its parts of h are less
 * 1. */
static inline void smg_extra_stages(const smg_state *s) {
  const smg_real *before = smg_vector(s, SMG_Y_BEFORE), *kept = smg_kept(s);
  smg_coefficients c = s->c;
  smg_set_time_at(&c, s, 0);
  smg_right_side(&c, kept[SMG_LAST_SIZE], s->w, smg_vector(s, 1));
  for (int i = 0; i < 3; ++i) {
    smg_sum_stages(s, smg_dop853_extra[i], SMG_STAGES_USED, s->u);
    for (int64_t q = 0; q < 3 * smg_sites(&c); ++q) s->u[q] = before[q] + s->u[q];
    smg_set_time_at(&c, s, kept[SMG_LAST_FROM] + smg_dop853_c[13 + i] * kept[SMG_LAST_SIZE] - 1);
    smg_right_side(&c, kept[SMG_LAST_SIZE], s->u, smg_vector(s, 2 + i));
  }
}

/* w at the part theta of the last internal step, to order 7: with r = 1 - theta the cubic through both ends and their
 * slopes,
 *     y + theta^2 (3 - 2 theta) (w - y) + theta r (r k_1 - theta k_13),
 * and (theta r)^2 sum_i (d_1i + theta d_2i + theta r d_3i + theta^2 r d_4i) k_i. Where there is no such step it is w
 * itself. */
static inline void smg_dense(const smg_state *s, smg_real theta, smg_real *w) {
  const int64_t n = 3 * smg_sites(&s->c);
  const smg_real *y = smg_vector(s, SMG_Y_BEFORE), r = 1 - theta;
  const smg_real end = theta * theta * (3 - 2 * theta), bump = theta * r * (theta * r);
  smg_real a[SMG_STAGES_USED];
  if (!(smg_dense_part(s) > 0)) {
    for (int64_t q = 0; q < n; ++q) w[q] = s->w[q];
    return;
  }
  if (smg_kept(s)[SMG_EXTRA_READY] == 0) smg_extra_stages(s);
  smg_kept(s)[SMG_EXTRA_READY] = 1;
  for (int i = 0; i < SMG_STAGES_USED; ++i)
    a[i] = bump *
           (smg_dop853_d[0][i] + theta * (smg_dop853_d[1][i] + r * (smg_dop853_d[2][i] + theta * smg_dop853_d[3][i])));
  a[0] += theta * r * r;
  a[1] -= theta * theta * r;
  smg_sum_stages(s, a, SMG_STAGES_USED, w);
  for (int64_t q = 0; q < n; ++q) w[q] = y[q] + (end * (s->w[q] - y[q]) + w[q]);
}

#endif
