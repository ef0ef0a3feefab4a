/* Interleaved timing of all designs in one process; prints CSV.
 *
 *     bench [repeats] [steps per repeat] */
#include "body.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define GENERIC(d)                                                           \
  void generic_start_##d(void *state, const body_params *p, const double *w); \
  void generic_steps_##d(void *state, int64_t n);
GENERIC(5) GENERIC(6) GENERIC(7) GENERIC(8)

typedef struct contender {
  const char *name;
  void (*start)(void *state, const body_params *p, const double *w);
  void (*steps)(void *state, int64_t n);
  size_t w; /* where w lies in the state */
} contender;

static void hand_start(void *state, const body_params *p, const double *w) { body_start((body *)state, p, w); }
static const contender generics[] = {{"generic 5", generic_start_5, generic_steps_5, sizeof(body_params)},
                                     {"generic 6", generic_start_6, generic_steps_6, sizeof(body_params)},
                                     {"generic 7", generic_start_7, generic_steps_7, sizeof(body_params)},
                                     {"generic 8", generic_start_8, generic_steps_8, sizeof(body_params)}};

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}
static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}
static double energy(const double *w, const double *a) {
  return (a[0] * w[0] * w[0] + a[1] * w[1] * w[1] + a[2] * w[2] * w[2]) / 2;
}

int main(int argc, char **argv) {
  const int repeats = argc > 1 ? atoi(argv[1]) : 31, extra = sizeof generics / sizeof *generics;
  const int64_t steps = argc > 2 ? atoll(argv[2]) : 20000;
  const int n = hand_count + extra;
  const body_params p = {.1, {1, .5, .25}};
  const double w0[3] = {cos(1.1), 0, sin(1.1)};
  contender *c = malloc(sizeof *c * (size_t)n);
  char **s = malloc(sizeof *s * (size_t)n);
  double *t = malloc(sizeof *t * (size_t)(n * repeats));
  for (int i = 0; i < n; i++) {
    if (i < hand_count) c[i] = (contender){hand_designs[i].name, hand_start, hand_designs[i].steps, 0};
    else c[i] = generics[i - hand_count];
    s[i] = malloc(1 << 16);
    c[i].start(s[i], &p, w0);
  }
  for (int r = -1; r < repeats; r++)
    for (int i = 0; i < n; i++) {
      const double start = now();
      c[i].steps(s[i], steps);
      if (r >= 0) t[i * repeats + r] = (now() - start) / (double)steps;
    }
  printf("design,min ns,median ns,q3 ns,energy error,norm error,w after %.0f steps\n", (double)steps * (repeats + 1));
  for (int i = 0; i < n; i++) {
    double *q = t + i * repeats, w[3];
    qsort(q, (size_t)repeats, sizeof *q, ascending);
    memcpy(w, s[i] + c[i].w, sizeof w);
    printf("%s,%.2f,%.2f,%.2f,%.2e,%.2e,%.9f %.9f %.9f\n", c[i].name, q[0], q[repeats / 2], q[3 * repeats / 4],
           energy(w, p.inverse_moment) - energy(w0, p.inverse_moment), w[0] * w[0] + w[1] * w[1] + w[2] * w[2] - 1, w[0], w[1], w[2]);
  }
  return 0;
}
