/* One model with thresholds multiplied by factors. Arguments: the number of random starts, the steps from the first two of them (one
 * from the others), h ..; standard input: a factor for each threshold. A line of the output is a trial: h, steps wanted, status, steps
 * done, iterations, the first and the last component, the largest change of a Casimir, of the momentum and of the energy, in ulps. */
#include <stdio.h>
#include <stdlib.h>

static double factor_of[128];

#include SOURCE

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(name) JOIN(NAME, name)

static unsigned long seed;
static double uniform(void) {
  seed = seed * 6364136223846793005ul + 1442695040888963407ul;
  return (double)(seed >> 33) / 1073741824.0 - 1;
}

/* A point of the sphere, uniformly. */
static void draw(smg_real *w) {
  double size;
  do {
    for (int b = 0; b < 3; ++b) w[b] = uniform();
    size = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  } while (!(size > 0.1 && size < 1));
  for (int b = 0; b < 3; ++b) w[b] /= size;
}

static double largest(long n, const double *a, const double *b) {
  double most = 0;
  for (long k = 0; k < n; ++k) most = fabs(a[k] - b[k]) > most ? fabs(a[k] - b[k]) : most;
  return most / DBL_EPSILON;
}

static void trial(const OF(_model) *model, void *mem, double *w, double h, int steps) {
  OF(_state) s;
  const long n = (long)OF(_sites)(model);
  double casimirs[2][512], momentum[2][12];
  long iterations = 0;
  int status = OF(_init)(&s, model, mem, w, 0, h);
  OF(_casimirs)(model, s.w, casimirs[0]);
  OF(_momentum)(model, s.w, momentum[0]);
  const double energy = OF(_energy)(model, 0, s.w);
  while (status == SMG_OK && s.count < steps) {
    status = OF(_step)(&s);
    iterations += s.report.iterations;
  }
  OF(_casimirs)(model, s.w, casimirs[1]);
  OF(_momentum)(model, s.w, momentum[1]);
  printf("%g %d %d %ld %ld %.17g %.17g %.3g %.3g %.3g\n", h, steps, status, (long)s.count, iterations, s.w[0], s.w[3 * n - 1], largest(n, casimirs[0], casimirs[1]),
         largest(3, momentum[0], momentum[1]), fabs(OF(_energy)(model, 0, s.w) - energy) / DBL_EPSILON);
}

int main(int argc, char **argv) {
  OF(_params) p;
  OF(_model) model;
  double w[1536];
  int factors = 0;
  while (scanf("%lf", factor_of + factors) == 1) ++factors;
  OF(_defaults)(&p);
  if (OF(_model_init)(&model, &p) != SMG_OK) return 1;
  void *mem = malloc(OF(_memsize)(&model));
  for (int k = 0; k < atoi(argv[1]); ++k)
    for (int j = 3; j < argc; ++j) {
      seed = (unsigned long)k + 1;
      for (long i = 0; i < (long)OF(_sites)(&model); ++i) draw(w + 3 * i);
      trial(&model, mem, w, atof(argv[j]), k < 2 ? atoi(argv[2]) : 1);
    }
  return 0;
}
