/* A model's steps, for callgrind: argv: steps, h, tolerance, members, file of the starts (doubles, member after member).
 * Compiled with MODEL, its name, SOURCE, its C file, LANES: as an ensemble, or states one by one, and PUSHED, how many
 * vectors the tangent map carries along. */
#include SOURCE
#include <stdio.h>
#include <stdlib.h>

#define JOINED(a, b) a##b
#define NAMED(model, word) JOINED(model, word)
#define F(word) NAMED(MODEL, word)

static double *starts(const char *name, size_t count) {
  double *w = malloc(count * sizeof *w);
  FILE *f = fopen(name, "rb");
  if (!f || !w || fread(w, sizeof *w, count, f) != count) exit(3);
  fclose(f);
  return w;
}

#if LANES
static int steps_of(const F(_model) * model, const double *w, double h, double tolerance, int64_t members, int64_t steps) {
  F(_ensemble) e;
  if (F(_ensemble_init)(&e, model, 0, members, aligned_alloc(64, (F(_ensemble_memsize)(model, 0, members) / 64 + 1) * 64), w, 0, h)) return 2;
  for (int64_t k = 0; k < members; ++k)
    if (F(_set_tolerance)(&e.member[k], tolerance) != SMG_OK) return 2;
  return F(_ensemble_steps)(&e, 0, members, steps) != 0;
}
#else
#if PUSHED
/* The vectors, of numbers between -1 and 1, through each step. */
static int advance(F(_state) * s, const F(_model) * model, int64_t steps) {
  const int64_t size = 3 * F(_sites)(model) * PUSHED;
  double *v = malloc((size_t)size * sizeof *v);
  void *mem = malloc(F(_tangent_memsize)(model));
  for (int64_t k = 0; k < size; ++k) v[k] = (double)(k * 7919 % 2001) / 1000 - 1;
  for (int64_t k = 0; k < steps; ++k)
    if (F(_step)(s) != SMG_OK || F(_tangent)(s, v, PUSHED, mem) != SMG_OK) return 1;
  free(v);
  free(mem);
  return 0;
}
#else
static int advance(F(_state) * s, const F(_model) * model, int64_t steps) { return (void)model, F(_steps)(s, steps) != SMG_OK; }
#endif

static int steps_of(const F(_model) * model, const double *w, double h, double tolerance, int64_t members, int64_t steps) {
  for (int64_t k = 0; k < members; ++k) {
    F(_state) s;
    void *mem = aligned_alloc(64, (F(_memsize)(model) / 64 + 1) * 64);
    if (F(_init)(&s, model, mem, w + 3 * F(_sites)(model) * k, 0, h) != SMG_OK || F(_set_tolerance)(&s, tolerance) != SMG_OK) return 2;
    if (advance(&s, model, steps)) return 1;
    free(mem);
  }
  return 0;
}
#endif

int main(int count, char **words) {
  F(_params) p;
  F(_model) model;
  if (count != 6) return 4;
  F(_defaults)(&p);
  if (F(_model_init)(&model, &p) != SMG_OK) return 2;
  const int64_t members = atoll(words[4]);
  return steps_of(&model, starts(words[5], (size_t)(3 * F(_sites)(&model) * members)), atof(words[2]), atof(words[3]), members, atoll(words[1]));
}
