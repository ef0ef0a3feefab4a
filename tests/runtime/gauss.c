/* Models written by hand around smg_gauss.h, and a filter.
 *
 *     gauss FIELD h t0 steps [back]   < start   > status iterations site count, then w and compensation
 *
 * back: as many steps of -h after them. FIELD: 0 the free body, 1 the irreversible body, 2 four vortices on a sphere of
 * radius 2, 5 a field that is NaN; with TIMED 1 alone: 3 a spin of radius 1/2 and two bodies in R^3 with coupling and field that
 * depend on time. */
#include <string.h>

#include "smidgen.h"
#include "triples.h"

#ifndef TIMED
#define TIMED 0
#endif
enum { BODY = 1, VORTICES = 2, IN_TIME = 3, UNREAL = 5, MOST_SITES = 4 };
typedef struct { int field; } smg_params;
typedef struct { smg_params p; uint64_t version; smg_status status; } smg_model;
typedef struct { const smg_model *model; smg_real t, h; } smg_coefficients;
typedef struct {
  smg_coefficients c;
  uint64_t version;
  double t0, h;
  int64_t count;
  int history, degree;
  smg_real *w, *compensation, *u, *stages;
  smg_real scale, tolerance;
  smg_report report;
} smg_state;

#define SMG_HISTORY 1
#define SMG_ORIENTATION 1
#define SMG_TIMED TIMED
#define SMG_FAMILIES 2

#define SMG_OWN_SET_TIME 1
#define SMG_OWN_FAMILY_END 1
#define SMG_OWN_KIND 1
#define SMG_OWN_KAPPA 1
#define SMG_OWN_H_OVER_KAPPA 1
#define SMG_OWN_RADIUS 1
#define SMG_OWN_NORMAL 1
#include "smg_model.h"

static inline void smg_sizes(smg_model *model, const smg_params *p) { model->p = *p; }
static inline int smg_same_sizes(const smg_model *a, const smg_model *b) { return a->p.field == b->p.field; }
static inline smg_status smg_check_sizes(const smg_model *model) { return (model->p.field == IN_TIME) == TIMED ? SMG_OK : SMG_BAD_PARAMETER; }
static inline void smg_set_time(smg_coefficients *c, smg_real t) { c->t = t; }
static inline int64_t smg_sites(const smg_coefficients *c) { return c->model->p.field == VORTICES ? 4 : c->model->p.field == IN_TIME ? 3 : 1; }
static inline int64_t smg_family_end(const smg_coefficients *c, int f) { return c->model->p.field == IN_TIME && f == 0 ? 1 : smg_sites(c); }
static inline int smg_kind(const smg_coefficients *c, int64_t k) { return c->model->p.field == IN_TIME && k > 0 ? SMG_R3 : SMG_SPHERE; }
static inline smg_real smg_kappa(const smg_coefficients *c, int64_t k) {
  static const double kappa[4] = {1, -0.5, 0.75, 2};
  return smg_sites(c) == 1 ? 1 : (smg_real)kappa[k];
}
static inline smg_real smg_h_over_kappa(const smg_coefficients *c, int64_t k, smg_real h) { return h / smg_kappa(c, k); }
static inline smg_real smg_radius(const smg_coefficients *c, int64_t k) {
  (void)k;
  return c->model->p.field == VORTICES ? 2 : c->model->p.field == IN_TIME ? (smg_real)0.5 : 1;
}
static inline void smg_normal(const smg_coefficients *c, int64_t k, const smg_real *v, smg_real *n) {
  (void)c;
  (void)k;
  for (int b = 0; b < 3; ++b) n[b] = v[b];
}

/* H = sum_k w_k^2/(2 I_k) + sigma w_k^3/(2 I_k), I = (1, 2, 4), sigma = 0 or 2/3. */
static inline void smg_body_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  const smg_real sigma = c->model->p.field == BODY ? (smg_real)2 / 3 : 0;
  for (int b = 0; b < 3; ++b) g[b] += (w[b] + (smg_real)1.5 * sigma * w[b] * w[b]) / (1 << b);
}

/* H = -sum kappa_i kappa_j log |w_i - w_j|^2 / 2. */
static inline void smg_vortex_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const smg_real *v = w + 3 * i, *x = w + 3 * j;
      const smg_real d = 8 - 2 * smg_dot(v, x), a = smg_kappa(c, i) * smg_kappa(c, j) / d;
      for (int b = 0; b < 3; ++b) g[3 * i + b] += a * x[b], g[3 * j + b] += a * v[b];
    }
}

/* H = (1 + t/4) w_0.w_1 + w_1.w_2 + t^2 (1 - t/2) (w_0.e_1 + w_2.e_3) + (w_1.e_2)^2. */
static inline void smg_timed_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
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

static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  if (c->model->p.field == VORTICES) smg_vortex_gradient(c, w, g);
  else if (c->model->p.field == IN_TIME) smg_timed_gradient(c, w, g);
  else if (c->model->p.field != UNREAL) smg_body_gradient(c, w, g);
  else
    for (int b = 0; b < 3; ++b) g[b] += SMG_MATH(sqrt)(-1 - w[b] * w[b]);
}

#include "smg_gauss.h"
#define SMG_PUBLIC(word) gauss_##word
#include "smg_interface.h"

static size_t smg_layout(smg_state *s, smg_real *mem) {
  const size_t n = (size_t)smg_sites(&s->c);
  size_t used = 0;
  used = smg_place_array(&s->w, mem, used, 3 * n);
  used = smg_place_array(&s->compensation, mem, used, 3 * n);
  used = smg_place_array(&s->u, mem, used, 3 * n);
  return smg_place_array(&s->stages, mem, used, SMG_STAGES_SIZE(n));
}

static smg_real *room(size_t bytes) {
  smg_real *mem = (smg_real *)calloc(1, bytes); /* long double has bytes without a meaning */
  if (!mem) exit(2);
  return mem;
}

/* What a saved state restores, after a start anywhere, goes on with the same bits; a failed step leaves no trace in it. */
static void check_saved(smg_state *s, const smg_real *start) {
  const size_t size = smg_saved_size(&s->c), bytes = size * sizeof(smg_real);
  smg_real *before = room(bytes), *after = room(bytes), *mem = room(smg_memory(s->c.model));
  smg_state other;
  if (size != (size_t)(SMG_SAVED_HEAD + (6 + 4 * SMG_STAGES) * smg_sites(&s->c))) exit(3);
  smg_save_state(s, before);
  if (smg_begin_state(&other, s->c.model, mem, start, 0, 1) != SMG_OK || smg_restore_state(&other, before) != SMG_OK) exit(4);
  const smg_status status = smg_step(s);
  if (smg_step(&other) != status || other.report.iterations != s->report.iterations) exit(5);
  smg_save_state(s, after);
  if (status != SMG_OK && memcmp(before, after, bytes)) exit(6);
  smg_save_state(&other, before);
  for (size_t k = 0; k < size; ++k)
    if (before[k] != after[k]) exit(7);
  free(before);
  free(after);
  free(mem);
}

/* Steps, checked once on the way; the most iterations that one took. */
static int64_t taken(smg_state *s, const smg_real *start, int64_t steps) {
  int64_t most = 0;
  for (int64_t n = 0; n < steps && s->report.status == SMG_OK; ++n) {
    if (n == 3 || steps == 1) check_saved(s, start);
    else (void)smg_steps(s, 1);
    if (s->report.iterations > most) most = s->report.iterations;
  }
  return most;
}

int main(int count, char **words) {
  if (count < 5) return 1;
  const smg_params p = {atoi(words[1])};
  smg_model model;
  smg_state s;
  smg_real start[3 * MOST_SITES], extra[3 * SMG_FAMILIES + 3 * MOST_SITES];
  if (smg_make_model(&model, &p, NULL) != SMG_OK) return 10;
  const int64_t sites = smg_sites_of(&model), steps = atoll(words[4]);
  smg_real *mem = room(smg_memory(&model));
  for (int k = 0; k < 3 * sites; ++k) start[k] = triple_number();
  const smg_status begun = smg_begin_state(&s, &model, mem, start, atof(words[3]), atof(words[2]));
  if (begun != SMG_OK) return 10 + (int)begun;
  for (int k = 0; k < 3 * sites; ++k) s.w[k] = start[k]; /* also where it is off its sphere by round-off */
  const int64_t most = taken(&s, start, steps);
  if (count > 5) {
    s.h = -s.h;
    s.history = 0;
    (void)smg_steps(&s, steps);
  }
  gauss_field(&model, 0, s.w, extra);
  gauss_momentum(&model, s.w, extra);
  gauss_casimirs(&model, s.w, extra);
  triple_put((smg_real)s.report.status);
  triple_put((smg_real)most);
  triple_put((smg_real)s.report.site);
  triple_put((smg_real)s.count);
  for (int k = 0; k < 3 * sites; ++k) triple_put(s.w[k]);
  for (int k = 0; k < 3 * sites; ++k) triple_put(s.compensation[k]);
  free(mem);
  return 0;
}
