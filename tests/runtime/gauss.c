/* Models written by hand around smg_gauss.h, and a filter: numbers travel as three doubles each, so that none is lost in quad.
 *
 *     gauss h t0 steps [back]   < start   > status iterations site count, then w and compensation
 *
 * back: as many steps of -h after them. SMG_FIELD: 0 the free body, 1 the irreversible body, 2 four vortices on a sphere of
 * radius 2, 3 a spin of radius 1/2 and two bodies in R^3 with coupling and field that depend on time, 5 a field that is NaN. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smidgen.h"

typedef struct { int nothing; } smg_params;
typedef struct { smg_params p; smg_real t, h; } smg_coefficients;
typedef struct {
  smg_coefficients c;
  double t0, h;
  int64_t count;
  int history, degree;
  smg_real *w, *compensation, *u, *stages;
  smg_real scale, tolerance;
  smg_report report;
} smg_state;

#define SMG_HISTORY 1
#define SMG_ORIENTATION 1
#define SMG_TIMED (SMG_FIELD == 3)
#if SMG_FIELD == 2
#define SITES 4
#define RADIUS 2
#elif SMG_FIELD == 3
#define SITES 3
#define RADIUS 0.5
#else
#define SITES 1
#define RADIUS 1
#endif
#define SMG_FAMILIES (SMG_FIELD == 3 ? 2 : 1)

#include "smg_model.h"

static inline void smg_sizes(smg_coefficients *c, const smg_params *p) {
  c->p = *p;
  c->t = c->h = 0;
}
static inline smg_status smg_check_sizes(const smg_coefficients *c) { return c->p.nothing ? SMG_BAD_PARAMETER : SMG_OK; }
static inline int smg_prepare(smg_coefficients *c) { return c->t - c->t == 0; }
static inline void smg_set_time(smg_coefficients *c, smg_real t) { c->t = t; }
static inline int64_t smg_sites(const smg_coefficients *c) {
  (void)c;
  return SITES;
}
static inline int64_t smg_family_end(const smg_coefficients *c, int f) {
  (void)c;
  return SMG_FIELD == 3 && f == 0 ? 1 : SITES;
}
static inline int smg_kind(const smg_coefficients *c, int64_t k) {
  (void)c;
  return SMG_FIELD == 3 && k > 0 ? SMG_R3 : SMG_SPHERE;
}
static inline smg_real smg_kappa(const smg_coefficients *c, int64_t k) {
  static const double kappa[4] = {1, -0.5, 0.75, 2};
  (void)c;
  return SITES == 1 ? 1 : (smg_real)kappa[k];
}
static inline smg_real smg_h_over_kappa(const smg_coefficients *c, int64_t k, smg_real h) { return h / smg_kappa(c, k); }
static inline smg_real smg_radius(const smg_coefficients *c, int64_t k) {
  (void)c;
  (void)k;
  return RADIUS;
}
static inline void smg_normal(const smg_coefficients *c, int64_t k, const smg_real *v, smg_real *n) {
  (void)c;
  (void)k;
  for (int b = 0; b < 3; ++b) n[b] = v[b];
}

#if SMG_FIELD < 2
/* H = sum_k w_k^2/(2 I_k) + sigma w_k^3/(2 I_k), I = (1, 2, 4), sigma = 0 or 2/3. */
static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  const smg_real sigma = SMG_FIELD ? (smg_real)2 / 3 : 0;
  (void)c;
  for (int b = 0; b < 3; ++b) g[b] += (w[b] + (smg_real)1.5 * sigma * w[b] * w[b]) / (1 << b);
}
#elif SMG_FIELD == 2
/* H = -sum kappa_i kappa_j log |w_i - w_j|^2 / 2. */
static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  for (int i = 0; i < SITES; ++i)
    for (int j = i + 1; j < SITES; ++j) {
      const smg_real *v = w + 3 * i, *x = w + 3 * j;
      const smg_real d = 2 * RADIUS * RADIUS - 2 * smg_dot(v, x), a = smg_kappa(c, i) * smg_kappa(c, j) / d;
      for (int b = 0; b < 3; ++b) g[3 * i + b] += a * x[b], g[3 * j + b] += a * v[b];
    }
}
#elif SMG_FIELD == 3
/* H = (1 + t/4) w_0.w_1 + w_1.w_2 + t^2 (1 - t/2) (w_0.e_1 + w_2.e_3) + (w_1.e_2)^2. */
static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  const smg_real t = c->t, a = 1 + t / 4;
  for (int b = 0; b < 3; ++b) {
    g[b] += a * w[3 + b];
    g[3 + b] += a * w[b] + w[6 + b];
    g[6 + b] += w[3 + b];
  }
  g[0] += t * t * (1 - t / 2);
  g[8] += t * t * (1 - t / 2);
  g[4] += 2 * w[4];
}
#else
static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  (void)c;
  for (int b = 0; b < 3; ++b) g[b] += SMG_MATH(sqrt)(-1 - w[b] * w[b]);
}
#endif

#include "smg_gauss.h"
#include "smg_saved.h"

#define STAGES_SIZE SMG_STAGES_SIZE(SITES)

static size_t smg_layout(smg_state *s, smg_real *mem) {
  size_t used = 0;
  used = smg_place_array(&s->w, mem, used, 3 * SITES);
  used = smg_place_array(&s->compensation, mem, used, 3 * SITES);
  used = smg_place_array(&s->u, mem, used, 3 * SITES);
  return smg_place_array(&s->stages, mem, used, STAGES_SIZE);
}

static smg_real get(void) {
  double part[3] = {0, 0, 0};
  if (fread(part, sizeof part, 1, stdin) != 1) exit(2);
  return (smg_real)part[0] + (smg_real)part[1] + (smg_real)part[2];
}

static void put(smg_real x) {
  double part[3];
  for (int k = 0; k < 3; ++k) {
    part[k] = (double)x;
    x -= (smg_real)part[k];
  }
  if (fwrite(part, sizeof part, 1, stdout) != 1) exit(2);
}

/* What a saved state restores, after a start anywhere, goes on with the same bits; a failed step leaves no trace in it. */
static void check_saved(smg_state *s, const smg_real *start) {
  static smg_real before[SMG_SAVED_HEAD + (6 + 4 * SMG_STAGES) * SITES], after[sizeof before / sizeof *before];
  static smg_real mem[9 * SITES + STAGES_SIZE];
  smg_state other;
  if (smg_saved_size(&s->c.p) != sizeof before / sizeof *before) exit(3);
  smg_save_state(s, before);
  if (smg_begin_state(&other, &s->c.p, mem, start, 0, 1) != SMG_OK || smg_restore_state(&other, before) != SMG_OK) exit(4);
  const smg_status status = smg_step(s);
  if (smg_step(&other) != status || other.report.iterations != s->report.iterations) exit(5);
  smg_save_state(s, after);
  if (status != SMG_OK && memcmp(before, after, sizeof before)) exit(6);
  smg_save_state(&other, before);
  for (size_t k = 0; k < sizeof before / sizeof *before; ++k)
    if (before[k] != after[k]) exit(7);
}

int main(int count, char **words) {
  static smg_real mem[9 * SITES + STAGES_SIZE];
  smg_params p = {0};
  smg_state s;
  smg_real start[3 * SITES], extra[3 * SMG_FAMILIES + 3 * SITES];
  if (count < 4 || smg_memory(&p) != sizeof mem) return 1;
  for (int k = 0; k < 3 * SITES; ++k) start[k] = get();
  if (smg_check_params(&p) != SMG_OK) return 10;
  const smg_status begun = smg_begin_state(&s, &p, mem, start, atof(words[2]), atof(words[1]));
  if (begun != SMG_OK || smg_sites_of(&p) != SITES) return 10 + (int)begun;
  for (int k = 0; k < 3 * SITES; ++k) s.w[k] = start[k]; /* also where it is off its sphere by round-off */
  const int64_t steps = atoll(words[3]);
  int64_t most = 0;
  for (int64_t n = 0; n < steps && s.report.status == SMG_OK; ++n) {
    if (n == 3 || steps == 1) check_saved(&s, start);
    else (void)smg_steps(&s, 1);
    if (s.report.iterations > most) most = s.report.iterations;
  }
  if (count > 4) {
    s.h = -s.h;
    s.history = 0;
    (void)smg_steps(&s, steps);
  }
  smg_field_of(&p, 0, s.w, extra);
  smg_momentum_of(&p, s.w, extra);
  smg_casimirs_of(&p, s.w, extra);
  put((smg_real)s.report.status);
  put((smg_real)most);
  put((smg_real)s.report.site);
  put((smg_real)s.count);
  for (int k = 0; k < 3 * SITES; ++k) put(s.w[k]);
  for (int k = 0; k < 3 * SITES; ++k) put(s.compensation[k]);
  return 0;
}
