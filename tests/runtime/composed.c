/* A generated model, and a filter: numbers travel as three doubles each, so that none is lost in quad.
 *
 *     composed h t0 steps   < start   > status count iterations, then w with what it has lost to rounding
 *
 * MODEL: its name; HEADER: "name.h". */
#include <stdio.h>
#include <stdlib.h>

#include HEADER

#define JOIN(a, b) a##_##b
#define OF(a, b) JOIN(a, b)

static smg_real get(void) {
  double part[3] = {0, 0, 0};
  if (fread(part, sizeof part, 1, stdin) != 1) exit(2);
  return (smg_real)part[0] + (smg_real)part[1] + (smg_real)part[2];
}

static void put(smg_real x) {
  double part[3];
  for (int k = 0; k < 3; ++k) {
    part[k] = (double)x;
    x -= (smg_real)part[k];
  }
  if (fwrite(part, sizeof part, 1, stdout) != 1) exit(2);
}

int main(int argc, char **argv) {
  OF(MODEL, params) p;
  OF(MODEL, state) s;
  OF(MODEL, defaults)(&p);
  if (argc != 4) return 2;
  const int64_t n = 3 * OF(MODEL, sites)(&p), steps = atoll(argv[3]);
  smg_real *w = (smg_real *)malloc((size_t)n * sizeof *w);
  void *mem = malloc(OF(MODEL, memsize)(&p));
  if (!w || !mem) return 2;
  for (int64_t k = 0; k < n; ++k) w[k] = get();
  smg_status status = OF(MODEL, init)(&s, &p, mem, w, atof(argv[2]), atof(argv[1]));
  int64_t iterations = 0;
  for (int64_t k = 0; k < steps && status == SMG_OK; ++k) {
    status = OF(MODEL, step)(&s);
    iterations += s.report.iterations;
  }
  put((smg_real)status);
  put((smg_real)s.count);
  put((smg_real)iterations);
  for (int64_t k = 0; k < n; ++k) put(s.w[k] + s.compensation[k]);
  free(w);
  free(mem);
  return 0;
}
