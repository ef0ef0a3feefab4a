/* The most that one step takes: MODEL.c with its calls of the field counted, on a painted stack. argv: a file of h, then starts of 3*sites numbers each. Prints, the
 * largest over all steps: evaluations of dH/dw and of d2H/dw2 of a site (of all together, divided by the sites), iterations, bytes of stack, and the bytes of a state's memory. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#define TEXT_OF(x) #x
#define FILE_OF(model) TEXT_OF(model.c)
#define JOIN(a, b) a##_##b
#define NAME_OF(model, word) JOIN(model, word)
#define NAME(word) NAME_OF(MODEL, word)

static long long gradients, hessians, columns; /* of sites; of the Hessian of one alone */
static long long of_all(long long sites, long long *counted) { return *counted += sites; }
static long long of_some(long long sites, long long first, long long at_once) {
  return gradients += sites - first < at_once ? sites - first : at_once;
}

#include FILE_OF(MODEL)

enum { STACK = 1 << 22, STEPS = 3 };
static unsigned char stack[STACK] __attribute__((aligned(4096)));
static NAME(state) s;
static NAME(model) model;

static void *nothing(void *of) { return of; }
static void *step(void *of) {
  (void)NAME(step)((NAME(state) *)of);
  return of;
}

static long used(void *(*run)(void *), void *of) {
  pthread_attr_t how;
  pthread_t thread;
  long k = 0;
  for (long j = 0; j < STACK; ++j) stack[j] = 0xa5;
  if (pthread_attr_init(&how) || pthread_attr_setstack(&how, stack, STACK) || pthread_create(&thread, &how, run, of)) exit(2);
  pthread_join(thread, NULL);
  while (k < STACK && stack[k] == 0xa5) ++k;
  return STACK - k;
}

int main(int argc, char **argv) {
  NAME(params) p;
  long long most_gradients = 0, most_hessians = 0;
  long most_stack = 0, iterations = 0, failed = 0;
  FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
  NAME(defaults)(&p);
  if (!file || NAME(model_init)(&model, &p) != SMG_OK) return 3;
  const int64_t sites = NAME(sites)(&model);
  const long empty = used(nothing, NULL);
  void *mem = malloc(NAME(memsize)(&model));
  double *w = malloc((size_t)(3 * sites) * sizeof *w), h;
  while (fread(&h, sizeof h, 1, file) == 1 && fread(w, sizeof *w, (size_t)(3 * sites), file) == (size_t)(3 * sites)) {
    if (NAME(init)(&s, &model, mem, w, 0, h) != SMG_OK) continue;
    for (int k = 0; k < STEPS; ++k) {
      gradients = hessians = columns = 0;
      const long bytes = used(step, &s) - empty;
      if (bytes > most_stack) most_stack = bytes;
      hessians += columns / SMG_BS;
      if (gradients > most_gradients) most_gradients = gradients;
      if (hessians > most_hessians) most_hessians = hessians;
      if (s.report.iterations > iterations) iterations = s.report.iterations;
      failed += s.report.status != SMG_OK;
    }
  }
  printf("%g %g %ld %ld %lu %ld\n", (double)most_gradients / (double)sites, (double)most_hessians / (double)sites, iterations, most_stack,
         (unsigned long)NAME(memsize)(&model), failed);
  return 0;
}
