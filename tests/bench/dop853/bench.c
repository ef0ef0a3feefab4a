/* The contenders in turn, in one process.
 *
 *     bench H TOLERANCE STEPS REPEATS w ..     a line for each repeat: nanoseconds a step of every contender
 *     bench H TOLERANCE STEPS 0 w ..           the end of every contender after STEPS steps
 *     bench H TOLERANCE STEPS NAME w ..        these steps of one contender, for callgrind */
#include "contender.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define SIZE 65536
#define ROW(name) {#name, name##_start, name##_steps, name##_position, {0}}
static struct contender {
  const char *name;
  void (*start)(void *state, const double *w, double h, double tolerance);
  int (*steps)(void *state, int64_t n);
  const double *(*position)(const void *state);
  double state[SIZE / sizeof(double)];
} all[] = {ROW(hand), ROW(hand_carry), ROW(generated), ROW(generated_plain)};
enum { COUNT = sizeof all / sizeof *all };

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

int main(int argc, char **argv) {
  double w[64], h, tolerance;
  if (argc < 6) return 2;
  h = atof(argv[1]), tolerance = atof(argv[2]);
  const int64_t steps = atoll(argv[3]);
  const int repeats = atoi(argv[4]), numbers = argc - 5;
  for (int k = 0; k < numbers; ++k) w[k] = atof(argv[5 + k]);
  for (int i = 0; i < COUNT; ++i) {
    if (repeats == 0 && strcmp(argv[4], "0") && strcmp(argv[4], all[i].name)) continue;
    all[i].start(all[i].state, w, h, tolerance);
    if (!all[i].steps(all[i].state, steps)) return 1;
    printf("%s", repeats == 0 ? all[i].name : "");
    for (int k = 0; k < numbers && repeats == 0; ++k) printf(",%.17g", all[i].position(all[i].state)[k]);
    printf("%s", repeats == 0 ? "\n" : "");
  }
  for (int r = 0; r < repeats; ++r)
    for (int i = 0; i < COUNT; ++i) {
      all[i].start(all[i].state, w, h, tolerance);
      if (!all[i].steps(all[i].state, 1)) return 1; /* the size of the step is found, all is in the cache */
      const double began = now();
      if (!all[i].steps(all[i].state, steps)) return 1;
      printf("%.6g%c", (now() - began) / (double)steps, i + 1 < COUNT ? ',' : '\n');
    }
  return 0;
}
