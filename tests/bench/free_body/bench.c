/* All designs, hand-written and generic, interleaved in one process.
 *
 *     bench [repeats] [steps]      nanoseconds a step as CSV: minimum, quartiles, errors at the end
 *     bench samples [count]        state before and after single steps, for check.py */
#include "body.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define GENERIC(d)                                                            \
  void generic_start_##d(void *state, const body_params *p, const double *w); \
  void generic_steps_##d(void *state, int64_t n);
GENERIC(5) GENERIC(6)

void generated_start(void *state, const body_params *p, const double *w);
void generated_steps(void *state, int64_t n);

typedef struct contender {
  const char *name;
  void (*start)(void *state, const body_params *p, const double *w);
  void (*steps)(void *state, int64_t n);
  size_t w; /* where w lies in the state */
  char *state;
  double *ns;
} contender;

static void hand_start(void *state, const body_params *p, const double *w) { body_start((body *)state, p, w); }
static const contender generics[] = {{"generated", generated_start, generated_steps, 0},
                                     {"generic 5", generic_start_5, generic_steps_5, sizeof(body_params), 0, 0},
                                     {"generic 6", generic_start_6, generic_steps_6, sizeof(body_params), 0, 0}};
static const body_params params = {.1, {1, .5, .25}};

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}
static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}
static double energy(const double *w) {
  const double *a = params.inverse_moment;
  return (a[0] * w[0] * w[0] + a[1] * w[1] * w[1] + a[2] * w[2] * w[2]) / 2;
}
static const double *position(const contender *c) { return (const double *)(const void *)(c->state + c->w); }

static int contenders(contender **out, const double *w, int repeats) {
  const int n = hand_count + (int)(sizeof generics / sizeof *generics);
  contender *c = (contender *)calloc((size_t)n, sizeof *c);
  for (int i = 0; i < n; i++) {
    if (i < hand_count) c[i].name = hand_designs[i].name, c[i].start = hand_start, c[i].steps = hand_designs[i].steps;
    else c[i] = generics[i - hand_count];
    c[i].state = (char *)calloc(1, 1 << 16);
    c[i].ns = (double *)calloc((size_t)repeats, sizeof(double));
    c[i].start(c[i].state, &params, w);
  }
  *out = c;
  return n;
}

static void measure(contender *c, int n, int repeats, int64_t steps) {
  for (int r = -1; r < repeats; r++)
    for (int i = 0; i < n; i++) {
      const double start = now();
      c[i].steps(c[i].state, steps);
      if (r >= 0) c[i].ns[r] = (now() - start) / (double)steps;
    }
}

static void table(contender *c, int n, int repeats, double total, const double *w0) {
  printf("design,min ns,q1 ns,median ns,q3 ns,energy error,norm error,w after %.0f steps\n", total);
  for (int i = 0; i < n; i++) {
    double *q = c[i].ns;
    const double *w = position(c + i);
    qsort(q, (size_t)repeats, sizeof *q, ascending);
    printf("%s,%.2f,%.2f,%.2f,%.2f,%.2e,%.2e,%.9f %.9f %.9f\n", c[i].name, q[0], q[repeats / 4], q[repeats / 2], q[3 * repeats / 4],
           energy(w) - energy(w0), w[0] * w[0] + w[1] * w[1] + w[2] * w[2] - 1, w[0], w[1], w[2]);
  }
}

static void samples(contender *c, int n, int count) {
  for (int i = 0; i < n; i++)
    for (int k = 0; k < count; k++) {
      c[i].steps(c[i].state, 97);
      const double *w = position(c + i);
      printf("%s,%.17g,%.17g,%.17g,", c[i].name, w[0], w[1], w[2]);
      c[i].steps(c[i].state, 1);
      printf("%.17g,%.17g,%.17g\n", w[0], w[1], w[2]);
    }
}

int main(int argc, char **argv) {
  const int sampling = argc > 1 && !strcmp(argv[1], "samples");
  const int repeats = argc > 1 && !sampling ? atoi(argv[1]) : 31;
  const int64_t steps = argc > 2 ? atoll(argv[2]) : 20000;
  const double w0[3] = {cos(1.1), 0, sin(1.1)};
  contender *c;
  const int n = contenders(&c, w0, repeats);
  if (sampling) {
    samples(c, n, argc > 2 ? atoi(argv[2]) : 100);
    return 0;
  }
  measure(c, n, repeats, steps);
  table(c, n, repeats, (double)steps * (repeats + 1), w0);
  return 0;
}
