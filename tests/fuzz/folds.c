/* Random first steps of a generated lattice (glue.h) around the end of their branch: before the end none is refused and each is the solution on the
 * branch, beyond it none is accepted.
 *
 *   folds SEED FIRST COUNT
 *
 * runs the cases FIRST .. FIRST+COUNT-1: a start, the end of its branch by continuation in h (equation.h), and steps on both sides of it. A violation
 * is one line; the last line sums up. */
#include <stdio.h>
#include <stdlib.h>

#include "draw.h"
#include "equation.h"
#include "glue.h"

#define FARTHEST 6 /* h up to which the end is looked for */
#define CENTRE 1e-4L /* a midpoint so near the centre of its sphere, in radii, runs into it */
#define UNSURE 2e-5L /* and so near, its direction is not sure: such a step may be refused (SMG_INWARD of smg_follow.h) */
static const double before[] = {0.5, 0.7, 0.9, 0.97, 0.99, 0.999}, beyond[] = {1.001, 1.01, 1.03, 1.1, 1.3, 2};
enum { BEFORE = sizeof before / sizeof *before, BEYOND = sizeof beyond / sizeof *beyond };

typedef struct tally {
  int64_t before, refused, wrong, beyond, accepted, endless, undecided, centres, unsure;
} tally;
static tally all;

/* Unit vectors: random, or nearly parallel ones. */
static void draw_spins(dice *d, int64_t sites, double *w) {
  const double along = draw_below(d, 3) ? 0 : fabs(draw_power(d, -1, 2));
  for (int64_t i = 0; i < sites; i++) {
    double size = 0;
    for (int a = 0; a < 3; a++) w[3 * i + a] = draw_normal(d) + (a == 2 ? along : 0);
    for (int a = 0; a < 3; a++) size += w[3 * i + a] * w[3 * i + a];
    for (int a = 0; a < 3; a++) w[3 * i + a] /= sqrt(size);
  }
}

/* The status of the first step with h; its increment. */
static smg_status step_of(const model *m, const double *w, void *mem, double h, double *u) {
  S s;
  smg_status status = model_init(&s, m, mem, w, 0, h);
  if (status == SMG_OK) status = model_step(&s);
  for (int64_t k = 0; k < 3 * model_sites(m); k++) u[k] = s.w[k] - w[k];
  return status;
}

static void violation(uint64_t number, const char *what, double part, double h) {
  printf("VIOLATION " NAME " case %llu at %g of the branch: %s, h=%a\n", (unsigned long long)number, part, what, h);
}

/* Is a midpoint in the centre of a sphere? A walk along a branch that ends there stops before, by less than a hundredth. */
static int in_centre(const equation *e, const real *u, real within) {
  for (int64_t i = 0; i < e->sites; i++)
    if (midpoint_size(e, i, u) < within) return 1;
  return 0;
}

static void steps_before(const equation *e, const model *m, const double *w, void *mem, real end, uint64_t number) {
  real u[3 * SITES] = {0}, along[3 * SITES] = {0}, size[SITES], s = 0;
  double found[3 * SITES];
  increment(e, e->h, u, along, size);
  for (int k = 0; k < BEFORE; k++) {
    if (walk(e, u, along, &s, end * before[k], 0.01L * end) <= 0) {
      all.undecided++;
      return;
    }
    const double h = (double)(e->h * s);
    real apart = 0;
    all.before++;
    if (step_of(m, w, mem, h, found) != SMG_OK) {
      if (in_centre(e, u, UNSURE)) all.unsure++;
      else all.refused++, violation(number, "refused", before[k], h);
      continue;
    }
    for (int64_t q = 0; q < 3 * e->sites; q++) apart = fmaxl(apart, fabsl(found[q] - u[q]));
    if (apart <= 1e-6L) continue;
    all.wrong++;
    violation(number, "on another branch", before[k], h);
  }
}

/* Those from the first-th part on. */
static void steps_beyond(const equation *e, const model *m, const double *w, void *mem, real end, uint64_t number, int first) {
  double found[3 * SITES];
  for (int k = first; k < BEYOND; k++) {
    const double h = (double)(e->h * end * beyond[k]);
    all.beyond++;
    if (step_of(m, w, mem, h, found) != SMG_OK) continue;
    all.accepted++;
    violation(number, "accepted", beyond[k], h);
  }
}

static void one_case(const model *m, const P *p, uint64_t seed, uint64_t number) {
  static const real matrix[9] = CASIMIR;
  dice d = draw_dice(seed, number);
  double w[3 * SITES];
  real u[3 * SITES], end = 0;
  equation e;
  e.p = p, e.method = METHOD, e.orientation = ORIENTATION, e.h = FARTHEST, e.t = 0;
  memcpy(e.casimir, matrix, sizeof matrix);
  if (!sites_of(p, model_sites(m), &e)) exit(2);
  draw_spins(&d, e.sites, w);
  for (int64_t k = 0; k < 3 * e.sites; k++) e.w[k] = w[k];
  void *mem = malloc(model_memsize(m));
  const int found = follow(&e, u, &end), centre = found < 0 && in_centre(&e, u, CENTRE);
  if (found < 0 && !centre) all.undecided++;
  else steps_before(&e, m, w, mem, end, number);
  if (found == 0 || centre) steps_beyond(&e, m, w, mem, end, number, centre);
  all.endless += found > 0;
  all.centres += centre;
  free(mem);
}

int main(int count, char **words) {
  model m;
  P p;
  if (count != 4) return 2;
  model_defaults(&p);
  if (model_make(&m, &p) != SMG_OK) return 2;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const uint64_t seed = strtoull(words[1], NULL, 10), first = strtoull(words[2], NULL, 10), cases = strtoull(words[3], NULL, 10);
  for (uint64_t k = first; k < first + cases; k++) one_case(&m, &p, seed, k);
  printf("SUMMARY " NAME " before %lld refused %lld wrong %lld beyond %lld accepted %lld endless %lld centres %lld unsure %lld undecided %lld\n", (long long)all.before,
         (long long)all.refused, (long long)all.wrong, (long long)all.beyond, (long long)all.accepted, (long long)all.endless,
         (long long)all.centres, (long long)all.unsure, (long long)all.undecided);
  return all.refused + all.wrong + all.accepted != 0;
}
