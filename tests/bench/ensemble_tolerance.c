/* Trajectories of MEMBERS bodies to an end time in so many steps of h, within which a method may choose its own: in lanes and one by one, by
 * turns, the least of ROUNDS. argv: end time, steps, tolerance, file of 3 MEMBERS starts. Prints microseconds a trajectory of both, steps a
 * trajectory (those that the method chose, in the last step of h), lanes, how many states differ, and then the ends. MODEL, SOURCE: of a body. */
#include SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define JOINED(a, b) a##b
#define NAMED(model, word) JOINED(model, word)
#define F(word) NAMED(MODEL, word)

enum { MEMBERS = 1000, ROUNDS = 20 };
static double start[3 * MEMBERS];
static int64_t count;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double one_by_one(smg_state *s, const smg_model *model, char *mem, size_t size, double end, double tolerance) {
  for (int n = 0; n < MEMBERS; ++n) {
    (void)smg_begin_state(s + n, model, mem + size * (size_t)n, start + 3 * n, 0, end / (double)count);
    (void)smg_set_tolerance(s + n, tolerance);
  }
  const double t = now();
  for (int n = 0; n < MEMBERS; ++n) (void)F(_steps)(s + n, count);
  return now() - t;
}

static double in_lanes(smg_ensemble *e, const smg_model *model, void *mem, double end, double tolerance) {
  (void)F(_ensemble_init)(e, model, 0, MEMBERS, mem, start, 0, end / (double)count);
  for (int n = 0; n < MEMBERS; ++n) (void)smg_set_tolerance(e->member + n, tolerance);
  const double t = now();
  (void)F(_ensemble_steps)(e, 0, MEMBERS, count);
  return now() - t;
}

static void read_starts(const char *name) {
  FILE *f = fopen(name, "r");
  for (int k = 0; k < 3 * MEMBERS; ++k)
    if (!f || fscanf(f, "%lf", start + k) != 1) exit(1);
  fclose(f);
}

int main(int argc, char **argv) {
  smg_params p;
  smg_model model;
  smg_ensemble e;
  if (argc != 5) return 1;
  const double end = atof(argv[1]), tolerance = atof(argv[3]);
  double least[2] = {1e9, 1e9}, steps = 0;
  int differing = 0;
  count = atoll(argv[2]);
  F(_defaults)(&p);
  (void)F(_model_init)(&model, &p);
  read_starts(argv[4]);
  const size_t size = smg_whole_lines(F(_memsize)(&model));
  smg_state *s = malloc(sizeof *s * MEMBERS);
  char *mem = aligned_alloc(64, size * MEMBERS);
  void *all = aligned_alloc(64, smg_whole_lines(F(_ensemble_memsize)(&model, 0, MEMBERS)));
  for (int r = 0; r < ROUNDS; ++r) {
    const double t[2] = {in_lanes(&e, &model, all, end, tolerance), one_by_one(s, &model, mem, size, end, tolerance)};
    for (int k = 0; k < 2; ++k)
      if (t[k] < least[k]) least[k] = t[k];
  }
  for (int n = 0; n < MEMBERS; ++n) {
    steps += (double)(s[n].report.iterations > 0 ? s[n].report.iterations : count) / MEMBERS;
    differing += memcmp(s[n].w, e.member[n].w, 3 * sizeof(double)) != 0 || s[n].report.status != SMG_OK;
  }
  printf("%.3f %.3f %.1f %d %d\n", least[0] / MEMBERS * 1e6, least[1] / MEMBERS * 1e6, steps, SMG_LANES, differing);
  for (int n = 0; n < MEMBERS; ++n) printf("%.17g %.17g %.17g\n", e.member[n].w[0], e.member[n].w[1], e.member[n].w[2]);
  return 0;
}
