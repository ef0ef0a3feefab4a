/* ns per step of a generated integrator from a fixed start: a body, or a ring of spins. MODEL names the generated
 * header, M its functions. */
#define _POSIX_C_SOURCE 199309L
#include MODEL

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define PASTE(a, b) a##b
#define NAME(m, what) PASTE(m, what)
#define F(what) NAME(M, what)

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Spins along the smooth start of the chain; one spin alone is turned away from the axes. */
static void start(smg_real *w, int64_t n) {
  for (int64_t i = 0; i < n; ++i) {
    const double t = 1 + 6.283185307179586 * (double)i / (double)n;
    const double theta = 0.7 + 0.3 * sin(3 * t) + 0.05 * cos(9 * t);
    w[3 * i] = sin(theta) * cos(t);
    w[3 * i + 1] = sin(theta) * sin(t);
    w[3 * i + 2] = cos(theta);
  }
}

int main(void) {
  F(_params) p;
  F(_model) model;
  F(_state) s;
  F(_defaults)(&p);
  if (F(_model_init)(&model, &p) != SMG_OK) return 1;
  const int64_t n = F(_sites)(&model), steps = 300000 / n;
  smg_real *w = (smg_real *)calloc(3 * (size_t)n, sizeof *w);
  void *memory = malloc(F(_memsize)(&model));
  start(w, n);
  smg_status status = F(_init)(&s, &model, memory, w, 0, 0.1);
  if (status == SMG_OK) status = F(_steps)(&s, steps / 4 + 20);
  const double before = seconds();
  if (status == SMG_OK) status = F(_steps)(&s, steps);
  printf("%.2f\n", 1e9 * (seconds() - before) / (double)steps);
  free(memory);
  free(w);
  return (int)status;
}
