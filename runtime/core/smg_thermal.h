/* smidgen runtime: thermal noise, a map around the whole step of any method:
 *
 *     N(h/2) o step o N(h/2).
 *
 * N(h/2) turns the vector of each site about a Gaussian vector whose components have the variance 2 x',
 * x' = x - x^2/6, x = D h/2: the means of spherical harmonics of degree l then fall by exp(-l (l + 1) x) up to terms of
 * x^3, as those of Brownian motion on the sphere do, so that the whole is of weak order 2 and keeps exp(-H/kT) up to
 * h^2. x' serves to x = 1; beyond, there are several turns.
 * D = smg_diffusion(c, k) = alpha kT/(|kappa| r), of Gilbert's form divided by 1 + alpha^2.
 *
 * The numbers are those of the step, the site and the half in it, whoever asks for them and when: threads, ranks, saves
 * and restores change no bit. A turn of w is no increment of the motion: history and compensation begin anew. */
#ifndef SMG_THERMAL_H
#define SMG_THERMAL_H

#include "smg_random.h"
#include "smg_set_state.h"

#define SMG_MOST_TURNS 32                 /* x beyond: directions are forgotten to e^-64, as they are at 32 */
#define SMG_THERMAL_STEPS 281474976710656 /* 2^48: steps that a counter tells apart */

static inline void smg_set_seed(smg_state *s, uint64_t seed, uint32_t member) {
  s->seed = seed;
  s->member = member;
}

#if SMG_NOISE_WITHIN
/* A method with the noise in its own step (smg_angles.h). */
static smg_status smg_thermal_step(smg_state *s) {
  return s->count < SMG_THERMAL_STEPS ? smg_step(s) : (s->report.status = SMG_BAD_PARAMETER);
}
#else
/* Sites whose noise is drawn together. */
#define SMG_HEATED 64

/* w turned about theta by |theta|. The quaternion (q, p theta) of the angle |theta|/8, which needs no root, is squared
 * three times; the product with w is divided by its length, so that |w| stays whatever q and p are rounded to. */
SMG_INLINE void smg_turn_about(const double *theta, smg_real *w) {
  const double y = (theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]) / 256;
  double less = smg_one_minus_cos(y), p = smg_sine_ratio(y) / 16; /* less = 1 - q */
  for (int k = 0; k < 3; ++k) {
    p = 2 * p * (1 - less);
    less = 2 * less * (2 - less);
  }
  const smg_real v[3] = {-p * theta[0], -p * theta[1], -p * theta[2]}; /* the turn is by v x w */
  smg_real u[3];
  smg_turn_increment(1 - less, v, w, u);
  smg_axpy(w, 1, u, 3);
}

/* Sites whose noise is found together: the turns of each, 0 where it is cold, the deviation of their components, and
 * the most turns of a site. */
typedef struct smg_heat_block {
  int64_t first;
  int sites, most;
  double turns[SMG_HEATED], deviation[SMG_HEATED], theta[3][SMG_HEATED];
} smg_heat_block;

static inline void smg_begin_heat(const smg_state *s, smg_heat_block *b) {
  b->most = 0;
  for (int i = 0; i < b->sites; ++i) {
    const smg_real D = smg_diffusion(&s->c, b->first + i);
    const double x = (double)smg_max(0, smg_min(SMG_MOST_TURNS - (smg_real)0.5, D * (smg_real)(s->h / 2))),
                 part = x / (floor(x) + 1);
    const int turns = x > 0 ? (int)x + 1 : 0;
    b->deviation[i] = sqrt(2 * (part - part * part / 6));
    b->turns[i] = turns;
    b->most = turns > b->most ? turns : b->most;
  }
}

/* The vectors of a turn, 0 at sites that have no more. */
static inline void smg_draw_heat(const smg_state *s, int64_t step, int turn, int half, smg_heat_block *b) {
  for (int i = 0; i < b->sites; ++i) {
    const double deviation = turn < b->turns[i] ? b->deviation[i] : 0;
    double x[3];
    smg_three_normals(
        smg_philox_of(smg_counter(step, b->first + i, SMG_USE_NOISE + 2 * turn + half, s->member), s->seed), x);
    for (int k = 0; k < 3; ++k) b->theta[k][i] = deviation * x[k];
  }
}

static inline void smg_apply_heat(const smg_heat_block *b, smg_real *w) {
  for (int i = 0; i < b->sites; ++i, w += 3) {
    const double theta[3] = {b->theta[0][i], b->theta[1][i], b->theta[2][i]};
    smg_turn_about(theta, w);
  }
}

/* The part of all sites that one of several threads has: the noise of one half of a step. */
static void smg_heat_share(smg_state *s, int64_t step, int half, int thread, int threads) {
  const int64_t from = smg_own_from(&s->c), all = smg_own_to(&s->c) - from, end = from + all * (thread + 1) / threads;
  smg_heat_block b;
  for (b.first = from + all * thread / threads; b.first < end; b.first += b.sites) {
    b.sites = (int)(end - b.first < SMG_HEATED ? end - b.first : SMG_HEATED);
    smg_begin_heat(s, &b);
    for (int turn = 0; turn < b.most; ++turn) {
      smg_draw_heat(s, step, turn, half, &b);
      smg_apply_heat(&b, s->w + 3 * b.first);
    }
  }
}

/* Does noise turn any site? Where kT is 0 a step is that without noise. */
static int smg_is_hot(const smg_state *s) {
  int64_t k = smg_sites(&s->c);
  while (k > 0 && !(smg_diffusion(&s->c, k - 1) > 0)) --k;
  return k > 0;
}

/* N(h/2) of all sites. */
static void smg_heat(smg_state *s, int64_t step, int half) {
#if SMG_BY_ROWS
  SMG_TEAM(smg_row_team(&s->c)) { smg_heat_share(s, step, half, smg_thread(), smg_threads()); }
#else
  smg_heat_share(s, step, half, 0, 1);
#endif
  smg_share_ends(&s->c, s->w);
  smg_forget_history(s);
  smg_forget_compensation(s);
}

/* Another step, at the same time. */
static void smg_retime(smg_state *s, double h, int64_t count) {
  s->h = h;
  s->count = count;
  smg_set_size(s, smg_signed_h(h));
  smg_forget_history(s);
}

/* Where a smaller step may help. */
static inline int smg_may_halve(smg_status status) {
  return status == SMG_NO_CONVERGENCE || status == SMG_NO_SOLUTION || status == SMG_WRONG_BRANCH ||
         status == SMG_SINGULAR;
}

/* A rare state that heat has made has no step of this size: two of half of it, between the same noise. */
static smg_status smg_two_halves(smg_state *s) {
  const double h = s->h;
  const int64_t count = s->count;
  smg_retime(s, h / 2, 2 * count);
  smg_status status = smg_step(s);
  if (status == SMG_OK) status = smg_step(s);
  smg_retime(s, h, count + (status == SMG_OK));
  s->halved += status == SMG_OK;
  return status;
}

/* The state is as it was before a step that fails. */
static smg_status smg_thermal_step(smg_state *s) {
  if (s->count >= SMG_THERMAL_STEPS) return s->report.status = SMG_BAD_PARAMETER;
  if (!smg_is_hot(s)) return smg_step(s);
  const int64_t from = 3 * smg_own_from(&s->c), numbers = 3 * smg_own_to(&s->c) - from;
  smg_copy(s->unturned + from, s->w + from, numbers);
  smg_heat(s, s->count, 0);
  smg_status status = smg_step(s);
  if (smg_may_halve(status)) status = smg_two_halves(s);
  if (status == SMG_OK) smg_heat(s, s->count - 1, 1); /* of the step that was counted just now */
  else {
    smg_copy(s->w + from, s->unturned + from, numbers);
    smg_forget_compensation(s);
  }
  return status;
}
#endif

#endif
