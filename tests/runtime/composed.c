/* A generated model, and a filter.
 *
 *     composed h t0 steps   < start   > status count iterations, then w with its rounding errors, which lattices by rows
 *                                         keep elsewhere
 *
 * MODEL: its name; HEADER: "name.h". */
#include HEADER
#include "triples.h"

#define JOIN(a, b) a##_##b
#define OF(a, b) JOIN(a, b)

int main(int argc, char **argv) {
  OF(MODEL, params) p;
  OF(MODEL, model) model;
  OF(MODEL, state) s;
  OF(MODEL, defaults)(&p);
  if (argc != 4 || OF(MODEL, model_init)(&model, &p) != SMG_OK) return 2;
  const int64_t n = 3 * OF(MODEL, sites)(&model), steps = atoll(argv[3]);
  smg_real *w = (smg_real *)malloc((size_t)n * sizeof *w);
  void *mem = malloc(OF(MODEL, memsize)(&model));
  if (!w || !mem) return 2;
  for (int64_t k = 0; k < n; ++k) w[k] = triple_number();
  smg_status status = OF(MODEL, init)(&s, &model, mem, w, atof(argv[2]), atof(argv[1]));
  int64_t iterations = 0;
  for (int64_t k = 0; k < steps && status == SMG_OK; ++k) {
    status = OF(MODEL, step)(&s);
    iterations += s.report.iterations;
  }
  triple_put((smg_real)status);
  triple_put((smg_real)s.count);
  triple_put((smg_real)iterations);
  for (int64_t k = 0; k < n; ++k) triple_put(s.w[k] + (s.compensation ? s.compensation[k] : 0));
  free(w);
  free(mem);
  return 0;
}
