/* Interleaved timing of all designs in one process; prints CSV. */
#include "body.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}
static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}
static double energy(const body *s) {
  const double *w = s->w, *a = s->p.inverse_moment;
  return (a[0] * w[0] * w[0] + a[1] * w[1] * w[1] + a[2] * w[2] * w[2]) / 2;
}

int main(int argc, char **argv) {
  const int repeats = argc > 1 ? atoi(argv[1]) : 31;
  const int64_t steps = argc > 2 ? atoll(argv[2]) : 20000;
  const body_params p = {.1, {1, .5, .25}};
  const double w[3] = {cos(1.1), 0, sin(1.1)};
  body *s = malloc(sizeof *s * (size_t)hand_count);
  double *t = malloc(sizeof *t * (size_t)(hand_count * repeats));
  for (int d = 0; d < hand_count; d++) body_start(s + d, &p, w);
  for (int r = -1; r < repeats; r++)
    for (int d = 0; d < hand_count; d++) {
      const double start = now();
      hand_designs[d].steps(s + d, steps);
      if (r >= 0) t[d * repeats + r] = (now() - start) / (double)steps;
    }
  const double total = (double)steps * (repeats + 1);
  body z;
  body_start(&z, &p, w);
  printf("design,min ns,median ns,q3 ns,evaluations,energy error,norm error after %.0f steps\n", total);
  for (int d = 0; d < hand_count; d++) {
    double *q = t + d * repeats;
    qsort(q, (size_t)repeats, sizeof *q, ascending);
    const double *v = s[d].w;
    printf("%s,%.2f,%.2f,%.2f,%.3f,%.2e,%.2e\n", hand_designs[d].name, q[0], q[repeats / 2], q[3 * repeats / 4],
           (double)s[d].evaluations / total, energy(s + d) - energy(&z), v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1);
  }
  return 0;
}
