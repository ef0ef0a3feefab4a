/* A hand-written model for runtime/method/explicit/smg_dop853.h: five kinds of sites, chosen when it runs, and a driver.
 *
 *     dop853 WHAT SITES h t0 TOLERANCE ACTION [numbers]   starts on stdin, as many as there are; one line of output for each
 *
 * WHAT: 0 a rigid body on the unit sphere, H = sum w_i^2 (1 + sigma w_i)/(2 I_i), I = (1, 2, 4), sigma = 0.3;
 * 1 the same body in R^3; 2 point vortices; 3 a spin in a turning field; 4 a Nambu site, C = (x^2 + 2 y^2 + 3 z^2)/2;
 * 5 a body whose energy is no number where w_3 > 0.8. A negative WHAT: the body with sigma = 0.
 * TOLERANCE: 0, or another than the method's own. ACTION: run N; restart N M; fail N; look. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifndef TIMED
#define TIMED 1
#endif
#include "smidgen.h"

typedef struct smg_params {
  int what, sites;
  double sigma;
} smg_params;

typedef struct smg_model {
  smg_params p;
  uint64_t version;
  smg_status status;
} smg_model;

typedef struct smg_coefficients {
  const smg_model *model;
  smg_real t, h, field[3];
} smg_coefficients;

typedef struct smg_state {
  smg_coefficients c;
  uint64_t version;
  double t0, h;
  int64_t count;
  int history, degree, rest;
  smg_real *w, *compensation, *u, *stages, scale, tolerance;
  smg_report report;
} smg_state;

#define SMG_FAMILIES 1
#define SMG_TIMED TIMED
#ifndef SMG_ORIENTATION
#define SMG_ORIENTATION 1
#endif
#define SMG_OWN_PREPARE 1
#define SMG_OWN_SET_TIME 1
#define SMG_OWN_FAMILY_END 1
#define SMG_OWN_KIND 1
#define SMG_OWN_KAPPA 1
#define SMG_OWN_H_OVER_KAPPA 1
#define SMG_OWN_RADIUS 1
#define SMG_OWN_NORMAL 1
#include "smg_model.h"

static inline void smg_set_time(smg_coefficients *c, smg_real t) {
  c->t = t;
  c->field[0] = (smg_real)0.7 * SMG_MATH(cos)(2 * t);
  c->field[1] = (smg_real)0.7 * SMG_MATH(sin)(2 * t);
  c->field[2] = (smg_real)0.5;
}

static inline void smg_sizes(smg_model *model, const smg_params *p) { model->p = *p; }
static inline int smg_same_sizes(const smg_model *a, const smg_model *b) { return a->p.sites == b->p.sites; }
static inline smg_status smg_check_sizes(const smg_model *model) { return model->p.sites < 1 ? SMG_BAD_PARAMETER : SMG_OK; }
static inline int smg_prepare(smg_model *model) { return model->p.sigma - model->p.sigma == 0; }
static inline int64_t smg_sites(const smg_coefficients *c) { return c->model->p.sites; }
static inline int64_t smg_family_end(const smg_coefficients *c, int f) { return f == 0 ? c->model->p.sites : 0; }

static inline int smg_kind(const smg_coefficients *c, int64_t k) {
  (void)k;
  return c->model->p.what == 1 ? SMG_R3 : c->model->p.what == 4 ? SMG_NAMBU : SMG_SPHERE;
}

static inline smg_real smg_kappa(const smg_coefficients *c, int64_t k) { return c->model->p.what == 2 ? (smg_real)(k + 2) / 2 : 1; }

static inline smg_real smg_h_over_kappa(const smg_coefficients *c, int64_t k, smg_real h) { return h / smg_kappa(c, k); }

static inline smg_real smg_radius(const smg_coefficients *c, int64_t k) {
  (void)c;
  (void)k;
  return 1;
}

static inline void smg_normal(const smg_coefficients *c, int64_t k, const smg_real *v, smg_real *n) {
  for (int b = 0; b < 3; ++b) n[b] = smg_kind(c, k) == SMG_NAMBU ? (smg_real)(b + 1) * v[b] : v[b];
}

/* H = sum_b w_b^2 (1 + sigma w_b)/(2 I_b), I = (1, 2, 4) */
static inline void smg_body_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  for (int b = 0; b < 3; ++b) g[b] += w[b] * (1 + (smg_real)1.5 * (smg_real)c->model->p.sigma * w[b]) / (smg_real)(1 << b);
  if (c->model->p.what == 5) g[0] += SMG_MATH(sqrt)((smg_real)0.8 - w[2]) - SMG_MATH(sqrt)((smg_real)0.8 - w[2]);
}

/* H = -sum_(i<j) kappa_i kappa_j ln(2 - 2 w_i.w_j) */
static inline void smg_vortex_gradient(const smg_coefficients *c, int64_t i, int64_t j, const smg_real *w, smg_real *g) {
  const smg_real strength = 2 * smg_kappa(c, i) * smg_kappa(c, j) / (2 - 2 * smg_dot(w + 3 * i, w + 3 * j));
  for (int b = 0; b < 3; ++b) {
    g[3 * i + b] += strength * w[3 * j + b];
    g[3 * j + b] += strength * w[3 * i + b];
  }
}

static inline void smg_gradient(const smg_coefficients *c, const smg_real *w, smg_real *g) {
  for (int64_t k = 0; k < c->model->p.sites; ++k) {
    if (c->model->p.what == 3)
      for (int b = 0; b < 3; ++b) g[3 * k + b] += c->field[b];
    else if (c->model->p.what != 2) smg_body_gradient(c, w + 3 * k, g + 3 * k);
    else
      for (int64_t j = 0; j < k; ++j) smg_vortex_gradient(c, j, k, w, g);
  }
}

#include "smg_dop853.h"
#define SMG_PUBLIC(word) driver_##word
#include "smg_interface.h"

static size_t smg_layout(smg_state *s, smg_real *mem) {
  const size_t n = (size_t)smg_sites(&s->c);
  size_t used = smg_place_array(&s->w, mem, 0, 3 * n);
  used = smg_place_array(&s->compensation, mem, used, 3 * n);
  used = smg_place_array(&s->u, mem, used, 3 * n);
  return smg_place_array(&s->stages, mem, used, 42 * n + 1);
}

static smg_real number(const char *text) {
#if defined(SMG_QUAD)
  return strtoflt128(text, NULL);
#elif defined(SMG_LONG_DOUBLE)
  return strtold(text, NULL);
#else
  return strtod(text, NULL);
#endif
}

static void show(smg_real x) {
#ifdef SMG_QUAD
  char text[64];
  quadmath_snprintf(text, sizeof text, "%.34Qg", x);
  printf(" %s", text);
#else
  printf(" %.21Lg", (long double)x);
#endif
}

static void show_all(const smg_real *x, int64_t n) {
  for (int64_t k = 0; k < n; ++k) show(x[k]);
}

/* iterations in all, the largest residual, w, and how far site 0 is from its leaf, with its compensation */
static void run(smg_state *s, const smg_real *start, int64_t steps) {
  long iterations = 0;
  smg_real residual = 0;
  for (int64_t k = 0; k < steps && s->report.status == SMG_OK; ++k) {
    (void)smg_step(s);
    iterations += s->report.iterations;
    residual = smg_max(residual, s->report.residual);
  }
  printf("%d %ld", (int)s->report.status, iterations);
  show(residual);
  show_all(s->w, 3 * smg_sites(&s->c));
  show((smg_casimir(&s->c, 0, s->w) - smg_casimir(&s->c, 0, start)) / smg_casimir(&s->c, 0, start));
}

/* Saved after n steps, restored into another state, and both m steps on: are they the same? How many numbers are saved? And does
 * a state go on whatever the saved size of its internal steps is? */
static void restart(smg_state *s, const smg_real *start, int64_t n, int64_t m) {
  static const double natural[3] = {-5, 1e300, 1e-300};
  const size_t size = smg_saved_size(&s->c), bytes = size * sizeof(smg_real);
  smg_real *mem = (smg_real *)malloc(smg_memory(s->c.model)), *saved = (smg_real *)calloc(3, bytes);
  smg_state other;
  (void)smg_begin_state(&other, s->c.model, mem, start, 7, 0.001);
  (void)smg_steps(&other, 1);
  (void)smg_steps(s, n);
  smg_save_state(s, saved);
  (void)smg_steps(s, m);
  const smg_status restored = smg_restore_state(&other, saved);
  (void)smg_steps(&other, m);
  smg_save_state(s, saved + size);
  smg_save_state(&other, saved + 2 * size);
  printf("%d %d %d %d", (int)restored, (int)other.report.status, (int)size, memcmp(saved + size, saved + 2 * size, bytes) == 0);
  for (int k = 0; k < 3; ++k) {
    saved[SMG_SAVED_HEAD + 6 * smg_sites(&s->c)] = (smg_real)natural[k];
    printf(" %d %d", (int)smg_restore_state(&other, saved), (int)smg_steps(&other, m));
  }
  free(mem);
  free(saved);
}

/* n steps of which the last fails: is the saved state as it was before? */
static void fail(smg_state *s, int64_t n) {
  const size_t size = smg_saved_size(&s->c);
  smg_real *saved = (smg_real *)malloc(2 * size * sizeof *saved);
  memset(saved, 0, 2 * size * sizeof *saved); /* long double has bytes without a meaning */
  for (int64_t k = 0; k < n && s->report.status == SMG_OK; ++k) {
    smg_save_state(s, saved);
    (void)smg_step(s);
  }
  smg_save_state(s, saved + size);
  printf("%d %d %d %d", (int)s->report.status, (int)s->report.site, (int)s->count,
         memcmp(saved, saved + size, size * sizeof *saved) == 0);
  free(saved);
}

/* What the shell of a model offers without a step: field, momentum, Casimirs. */
static void look(const smg_state *s) {
  const int64_t n = smg_sites(&s->c);
  smg_real *out = (smg_real *)malloc((size_t)(3 * n) * sizeof *out);
  driver_field(s->c.model, (smg_real)s->t0, s->w, out);
  show_all(out, 3 * n);
  driver_momentum(s->c.model, s->w, out);
  show_all(out, 3);
  driver_casimirs(s->c.model, s->w, out);
  show_all(out, n);
  free(out);
}

static void act(smg_state *s, const smg_real *w, int count, char **words) {
  const int64_t n = count > 1 ? strtoll(words[1], NULL, 10) : 1;
  if (strcmp(words[0], "run") == 0) run(s, w, n);
  else if (strcmp(words[0], "restart") == 0) restart(s, w, n, strtoll(words[2], NULL, 10));
  else if (strcmp(words[0], "fail") == 0) fail(s, n);
  else look(s);
  printf("\n");
}

int main(int count, char **words) {
  if (count < 7) return 2;
  const int what = atoi(words[1]);
  const smg_params p = {what < 0 ? 0 : what, atoi(words[2]), what < 0 || what == 5 ? 0 : 0.3};
  smg_model model;
  if (smg_make_model(&model, &p, NULL) != SMG_OK) return 3;
  const double h = strtod(words[3], NULL), t0 = strtod(words[4], NULL), tolerance = strtod(words[5], NULL);
  smg_real *mem = (smg_real *)malloc(smg_memory(&model)), *w = (smg_real *)malloc((size_t)(3 * p.sites) * sizeof *w);
  int64_t got = 0;
  char text[80];
  while (scanf("%79s", text) == 1) {
    w[got++] = number(text);
    if (got < 3 * p.sites) continue;
    smg_state s;
    got = 0;
    if (p.what != 1 && p.what != 4) /* on the unit sphere to the last digit */
      for (int64_t k = 0; k < p.sites; ++k) {
        const smg_real size = smg_norm(w + 3 * k);
        for (int b = 0; b < 3; ++b) w[3 * k + b] /= size;
      }
    if (smg_begin_state(&s, &model, mem, w, t0, h) != SMG_OK) printf("%d\n", (int)s.report.status);
    else if (smg_set_tolerance(&s, tolerance) == SMG_OK) act(&s, w, count - 6, words + 6);
  }
  free(mem);
  free(w);
  return 0;
}
