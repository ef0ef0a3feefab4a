/* Random bad steps and starts of one generated model (glue.h): no crash, no hang, OK is true, failure changes nothing.
 *
 *   bad_steps SEED FIRST COUNT BRANCHES
 *
 * runs the cases FIRST .. FIRST+COUNT-1; one in BRANCHES of the accepted steps, and as many of those said to have no
 * solution, are compared with continuation in h. A violation is one line; the last line sums up. */
#define _XOPEN_SOURCE 700
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>

#include "draw.h"
#include "equation.h"
#include "glue.h"

#define RESIDUAL 8 /* ulps of scale */
#define NORM 4     /* ulps of |w| */
#define PATIENCE 30 /* seconds of processor time that one case may take, sanitizers included */
#define STEPS 4    /* steps of a case */

typedef struct tally {
  int64_t steps, status[8], skipped, followed, undecided, ill, violations;
  real residual, norm;
  double slowest;
} tally;

typedef struct trial {
  uint64_t seed, number;
  int step, verbose;
  int64_t sites;
  P p;
  model m;
  double arrays[ARRAY_ROOM], w[3 * SITES], before[3 * SITES], t0, h;
  S s;
  unsigned char *mem;
  double *now; /* the state after the step, saved */
  size_t bytes;
} trial;

static tally all;

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Parameters and state as they went into the step, to the last bit. */
static void describe_case(const trial *t) {
  printf(" ");
  print_parameters(&t->p);
  printf("\n  report: status %d iterations %d residual %.3Lg site %lld\n", (int)t->s.report.status, t->s.report.iterations,
         (real)t->s.report.residual, (long long)t->s.report.site);
  for (int64_t k = 0; k < 3 * t->sites; k++)
    printf("  w[%lld] = %a (%.17g) -> %.17g\n", (long long)k, t->before[k], t->before[k], (double)t->s.w[k]);
}

static void violation(const trial *t, const char *what, real value, real allowed) {
  printf("VIOLATION " NAME " case %llu step %d: %s %.3Lg (allowed %.3Lg) h=%a t0=%a\n", (unsigned long long)t->number, t->step,
         what, value, allowed, t->h, t->t0);
  all.violations++;
  if (t->verbose) describe_case(t);
}

/* ---- starts ------------------------------------------------------------------------------- */

static void unit_vector(dice *d, double *w) {
  double size = 0;
  while (!(size > 0.1)) {
    for (int a = 0; a < 3; a++) w[a] = draw_normal(d);
    size = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  }
  for (int a = 0; a < 3; a++) w[a] /= size;
}

static void axis_vector(dice *d, double *w, double tiny) {
  const int a = draw_below(d, 3);
  w[a] = draw_sign(d), w[(a + 1) % 3] = tiny, w[(a + 2) % 3] = 0;
}

/* Nearly along the vector before, or against it; `near` = 0: exactly. */
static void aligned_vector(dice *d, double *w, const double *before, double near) {
  double v[3], size = 0;
  unit_vector(d, v);
  for (int a = 0; a < 3; a++) w[a] = before[a] + near * v[a], size += w[a] * w[a];
  const double sign = draw_sign(d);
  for (int a = 0; a < 3; a++) w[a] = sign * (near == 0 ? before[a] : w[a] / sqrt(size));
}

static void bad_vector(dice *d, double *w, int kind, const double *before) {
  if (kind == 1) axis_vector(d, w, 0);
  if (kind == 2) axis_vector(d, w, draw_bits(d) & 1 ? 1e-300 : draw_power(d, -320, -8));
  if (kind == 3) aligned_vector(d, w, before, 0);
  if (kind == 4) aligned_vector(d, w, before, fabs(draw_power(d, -17, -1)));
  if (kind == 5) w[draw_below(d, 3)] = draw_bad(d);
  if (kind == 6) w[0] = w[1] = w[2] = 0;
  const double scale = kind == 7 ? 1 + draw_power(d, -16, -9) : kind == 8 ? draw_power(d, -323, 308) : 1;
  for (int a = 0; a < 3; a++) w[a] *= scale;
}

static double radius_of(const equation *e, int64_t i, dice *d) {
  if (e->kind[i] == ON_SPHERE) return (double)sqrtl(e->level[i]);
  return draw_below(d, 2) ? 1 : fabs(draw_power(d, -1, 1));
}

static void draw_start(dice *d, const equation *e, double *w) {
  const int kind = draw_below(d, 16), every = draw_below(d, 4) == 0;
  const int64_t one = draw_below(d, (int)e->sites);
  for (int64_t i = 0; i < e->sites; i++) {
    unit_vector(d, w + 3 * i);
    if (every || i == one) bad_vector(d, w + 3 * i, kind, i ? w + 3 * i - 3 : w);
  }
  for (int64_t i = 0; i < e->sites; i++) {
    const double r = radius_of(e, i, d);
    for (int a = 0; a < 3; a++) w[3 * i + a] *= r;
  }
}

/* ---- judgement ---------------------------------------------------------------------------- */

/* w + compensation, where the trajectory truly is, of a saved state: the two stand before its history, whose beginning it tells. */
static void true_state(const double *saved, int64_t sites, real *w) {
  const double *lost = saved + (int64_t)saved[1] - 3 * sites;
  for (int64_t k = 0; k < 3 * sites; k++) w[k] = (real)lost[k - 3 * sites] + (real)lost[k];
}

/* The levels of r3 and of Nambu factors are those of the state at hand. */
static void levels(equation *e) {
  for (int64_t i = 0; i < e->sites; i++)
    if (e->kind[i] != ON_SPHERE) e->level[i] = casimir(e, i, e->w + 3 * i);
}

/* The round-off of a step is measured by scale_i = |w_i| + |h| |n_i| |b_i|: of the state and of the product h (A m) x b.
 * `fully`: also what rounding W does to the equation, which is costly and taken only where it matters. */
static void scales(equation *e, real *u, int fully, real *x, real *scale) {
  increment(e, e->h, u, x, scale);
  if (fully) sensitivity(e, u, scale);
  for (int64_t i = 0; i < e->sites; i++) scale[i] += sqrtl(dot(e->w + 3 * i, e->w + 3 * i));
}

/* The largest residual |u - h X| in ulps of scale. */
static real residual_of(const equation *e, const real *u, const real *x, const real *scale) {
  real most = 0;
  for (int64_t k = 0; k < 3 * e->sites; k++) {
    const real r = fabsl(u[k] - x[k]), unit = DBL_EPSILON * scale[k / 3] + 4 * DBL_TRUE_MIN;
    if (r > 0 && !(r <= most * unit)) most = r / unit;
    if (r != r) return r;
  }
  return most;
}

/* The largest change of |w| of spheres and of R^3, in ulps of |w| itself. */
static real norm_of(const equation *e, const real *u) {
  real most = 0;
  for (int64_t i = 0; i < e->sites; i++) {
    const real *w = e->w + 3 * i;
    const real W[3] = {w[0] + u[3 * i], w[1] + u[3 * i + 1], w[2] + u[3 * i + 2]};
    const real off = fabsl(sqrtl(dot(W, W)) - sqrtl(dot(w, w))), unit = DBL_EPSILON * sqrtl(dot(w, w)) + 4 * DBL_TRUE_MIN;
    if (e->kind[i] != ON_NAMBU && off > 0 && !(off <= most * unit)) most = off / unit;
    if (off != off) return off;
  }
  return most;
}

static void check_equation(const trial *t, equation *e, real *u) {
  real x[3 * SITES], scale[SITES];
  scales(e, u, 0, x, scale);
  real r = residual_of(e, u, x, scale);
  const real off = norm_of(e, u);
  if (!(r <= RESIDUAL)) {
    all.ill++;
    scales(e, u, 1, x, scale);
    r = residual_of(e, u, x, scale);
    if (largest(u, 3 * e->sites) <= LDBL_MAX && !(largest(scale, e->sites) + r <= LDBL_MAX)) { /* rounding leads to where there is no field */
      all.undecided++;
      return;
    }
  }
  if (!(r <= all.residual)) all.residual = r;
  if (!(off <= all.norm)) all.norm = off;
  if (!(r <= RESIDUAL)) violation(t, "residual", r, RESIDUAL);
  if (!(off <= NORM)) violation(t, "norm", off, NORM);
}

/* Forward from h = 0 another solution or none is found, and backward from this one h = 0 is not reached. */
static void check_branch(const trial *t, const equation *e, const real *u) {
  real other[3 * SITES], reached = 0, apart = 0;
  const int found = follow(e, other, &reached);
  all.followed++;
  for (int64_t k = 0; k < 3 * e->sites; k++)
    if (!(fabsl(other[k] - u[k]) <= apart)) apart = fabsl(other[k] - u[k]);
  const real allowed = 1e-6L * largest(e->w, 3 * e->sites);
  if (found > 0 && apart <= allowed) return;
  const int back = leads_back(e, u);
  if (back > 0 || (back < 0 && found <= 0)) all.undecided++;
  else if (found > 0) violation(t, "wrong branch, apart", apart, allowed);
  else violation(t, "no branch that reaches h; it ends at", reached, 1);
}

/* Is the field at w a number, and so small that products of it are? */
static int moderate_at(const trial *t, const equation *e, const double *w) {
  double b[3 * SITES];
  model_field(&t->m, (double)e->t, w, b);
  for (int64_t k = 0; k < 3 * e->sites; k++)
    if (!(fabs(b[k]) < 1e150)) return 0;
  return 1;
}

/* The same at m and two ulps beside it. Not where two vortices are one in double. */
static int moderate_field(const trial *t, const equation *e, const real *m) {
  double w[3 * SITES];
  for (int64_t k = 0; k < 3 * e->sites; k++) w[k] = (double)m[k];
  for (int64_t k = 0; k < 3 * e->sites; k++)
    for (int side = -2; side <= 2; side++) {
      const double kept = w[k];
      w[k] = kept * (1 + side * DBL_EPSILON);
      if (!moderate_at(t, e, w)) return 0;
      w[k] = kept;
    }
  return 1;
}

/* "Proved to have no solution" is wrong where continuation finds one; "not finite" where the model has a field there, too. */
static void check_refusal(const trial *t, const equation *e, smg_status status, const char *what) {
  real u[3 * SITES], m[3 * SITES], reached = 0;
  const int found = follow(e, u, &reached);
  all.followed++;
  midpoints(e, u, m);
  if (found > 0 && (status == SMG_NO_SOLUTION || moderate_field(t, e, m))) violation(t, what, reached, 0);
}

/* ---- one case ----------------------------------------------------------------------------- */

static real rate(const equation *e) {
  const real none[3 * SITES] = {0};
  real x[3 * SITES], size[SITES];
  increment(e, e->h, none, x, size);
  return largest(x, 3 * e->sites) / largest(e->w, 3 * e->sites);
}

static void judge(trial *t, equation *e, smg_status status, int64_t branches, dice *d) {
  real W[3 * SITES], u[3 * SITES];
  const int chosen = e->sites <= SMALL && draw_below(d, (int)branches) == 0;
  if (status == SMG_OK) {
    true_state(t->now, e->sites, W);
    for (int64_t k = 0; k < 3 * e->sites; k++) u[k] = W[k] - e->w[k];
    check_equation(t, e, u);
    if (chosen && !CLOSED && rate(e) > 0.1L) check_branch(t, e, u);
  } else if (chosen && status == SMG_NO_SOLUTION)
    check_refusal(t, e, status, "said to have no solution, yet continuation reaches");
  else if (chosen && status == SMG_NOT_FINITE && rate(e) < 1e3L && e->strongest < 1e300L &&
           largest(e->w, 3 * e->sites) < 1e75L && moderate_field(t, e, e->w)) /* products are numbers */
    check_refusal(t, e, status, "said not to be finite, yet continuation reaches");
}

static void run_steps(trial *t, equation *e, int64_t branches, dice *d) {
  const size_t size = sizeof(double) * model_savesize(&t->m);
  double *before = (double *)malloc(size);
  t->now = (double *)malloc(size);
  for (t->step = 1; t->step <= STEPS; t->step++) {
    const S s = t->s;
    model_save(&s, before);
    memcpy(t->before, t->s.w, sizeof(double) * 3 * (size_t)e->sites);
    t->sites = e->sites;
    true_state(before, e->sites, e->w);
    levels(e);
    e->t = (real)(t->t0 + ((double)s.count + 0.5) * t->h);
    const double begin = seconds();
    const smg_status status = model_step(&t->s);
    const double took = seconds() - begin;
    if (took > all.slowest) all.slowest = took;
    all.steps++, all.status[status]++;
    if (status != t->s.report.status) violation(t, "report has another status", t->s.report.status, status);
    model_save(&t->s, t->now);
    judge(t, e, status, branches, d);
    if (status == SMG_OK) continue;
    if (memcmp(before, t->now, size)) violation(t, "failed, yet changed", 0, 0); /* all that the next step reads */
    break;
  }
  free(t->now);
  free(before);
}

static int describe(trial *t, equation *e) {
  static const real matrix[9] = CASIMIR;
  e->p = &t->p, e->method = METHOD, e->orientation = ORIENTATION, e->h = (real)t->h;
  memcpy(e->casimir, matrix, sizeof matrix);
  return sites_of(&t->p, model_sites(&t->m), e);
}

static void one_case(trial *t, int64_t branches) {
  dice d = draw_dice(t->seed, t->number);
  equation e;
  t->step = 0, t->mem = NULL;
  draw_parameters(&d, &t->p, t->arrays);
  t->h = draw_step(&d), t->t0 = draw_time(&d);
  smg_status status = model_make(&t->m, &t->p);
  if (status == SMG_OK && !(model_sites(&t->m) <= SITES)) {
    all.skipped++;
    return;
  }
  if (status == SMG_OK && !describe(t, &e)) violation(t, "sites", (real)model_sites(&t->m), (real)e.sites);
  if (status == SMG_OK) {
    draw_start(&d, &e, t->w);
    t->bytes = model_memsize(&t->m);
    t->mem = (unsigned char *)malloc(t->bytes);
    memset(t->mem, 0xa5, t->bytes);
    memset(&t->s, 0xa5, sizeof t->s);
    status = model_init(&t->s, &t->m, t->mem, t->w, t->t0, t->h);
  }
  if (status == SMG_OK) run_steps(t, &e, branches, &d);
  else all.steps++, all.status[status]++; /* a start refused is a step refused */
  free(t->mem);
}

static int number(const char *text) { return (int)strtoll(text, NULL, 10); }

int main(int count, char **words) {
  static trial t;
  const struct itimerval patience = {{0, 0}, {PATIENCE, 0}};
  if (count != 5) return 2;
  t.seed = (uint64_t)number(words[1]);
  const int first = number(words[2]), cases = number(words[3]), branches = number(words[4]);
  t.verbose = cases == 1;
  setvbuf(stdout, NULL, _IOLBF, 0);
  for (int k = first; k < first + cases; k++) {
    t.number = (uint64_t)k;
    setitimer(ITIMER_VIRTUAL, &patience, NULL); /* a step that hangs ends the program */
    one_case(&t, branches);
  }
  printf("SUMMARY " NAME " steps %lld skipped %lld followed %lld undecided %lld ill %lld violations %lld residual %.2Lf norm %.2Lf "
         "slowest %.4f status", (long long)all.steps, (long long)all.skipped, (long long)all.followed,
         (long long)all.undecided, (long long)all.ill, (long long)all.violations, all.residual, all.norm, all.slowest);
  for (int k = 0; k < 8; k++) printf(" %lld", (long long)all.status[k]);
  printf("\n");
  return all.violations != 0;
}
