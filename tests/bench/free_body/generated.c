/* The generated step, as a contender: status, branch check, compensation and all. */
#include "free_rigid_body.h"
#include <stddef.h>

typedef struct body_params {
  double h, inverse_moment[3];
} body_params;

typedef struct generated {
  double w[3]; /* a copy for the report, first as in the others */
  free_rigid_body_model model;
  free_rigid_body_state s;
  double mem[1024];
} generated;

void generated_start(void *state, const body_params *p, const double w[3]);
void generated_steps(void *state, int64_t n);

void generated_start(void *state, const body_params *p, const double w[3]) {
  generated *g = (generated *)state;
  free_rigid_body_params q;
  free_rigid_body_defaults(&q);
  q.I1 = 1 / p->inverse_moment[0];
  q.I2 = 1 / p->inverse_moment[1];
  q.I3 = 1 / p->inverse_moment[2];
  (void)free_rigid_body_model_init(&g->model, &q);
  if (free_rigid_body_memsize(&g->model) <= sizeof g->mem) (void)free_rigid_body_init(&g->s, &g->model, g->mem, w, 0, p->h);
}

void generated_steps(void *state, int64_t n) {
  generated *g = (generated *)state;
  const smg_status status = free_rigid_body_steps(&g->s, n);
  for (int k = 0; k < 3; ++k) g->w[k] = status == SMG_OK ? g->s.w[k] : 0;
}
