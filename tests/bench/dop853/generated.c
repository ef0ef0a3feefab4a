/* A generated model, as it is linked: status, step control and all; NAME is the prefix of its functions here. */
#include HEADER
#define MODEL(what) JOIN(NAME_OF_MODEL, what)
#include "contender.h"

typedef struct generated {
  MODEL(model) model;
  MODEL(state) s;
  double mem[4096];
} generated;

void FUNCTION(start)(void *state, const double *w, double h, double tolerance) {
  generated *g = (generated *)state;
  MODEL(params) p;
  MODEL(defaults)(&p);
  if (MODEL(model_init)(&g->model, &p) != SMG_OK || MODEL(memsize)(&g->model) > sizeof g->mem) return;
  (void)MODEL(init)(&g->s, &g->model, g->mem, w, 0, h);
  (void)MODEL(set_tolerance)(&g->s, tolerance);
}

int FUNCTION(steps)(void *state, int64_t n) { return MODEL(steps)(&((generated *)state)->s, n) == SMG_OK; }

const double *FUNCTION(position)(const void *state) { return ((const generated *)state)->s.w; }
