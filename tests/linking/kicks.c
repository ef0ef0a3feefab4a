/* A body in a field along z: its own rotation by the integrator, the field's by a rotation of ours, half of it before each step and half after.
 * The error falls by 4 where h is halved. */
#include "free_rigid_body.h"

#include <stdio.h>
#include <stdlib.h>

/* w turned about z by the angle -a, as w' = w x a e_z does in the time 1. */
static void turn(smg_real *w, double a) {
  const double x = w[0], y = w[1];
  w[0] = x * cos(a) + y * sin(a);
  w[1] = y * cos(a) - x * sin(a);
}

/* From 0 to 2 in so many steps. */
static int split(const free_rigid_body_model *model, void *memory, int steps, smg_real *w) {
  const double h = 2.0 / steps, field = 0.8;
  free_rigid_body_state s;
  smg_status status = free_rigid_body_init(&s, model, memory, w, 0, h);
  for (int n = 0; n < steps && status == SMG_OK; ++n) {
    turn(w, field * h / 2);
    status = free_rigid_body_set_state(&s, w);
    if (status == SMG_OK) status = free_rigid_body_step(&s);
    for (int k = 0; k < 3; ++k) w[k] = s.w[k];
    turn(w, field * h / 2);
  }
  if (status != SMG_OK) fprintf(stderr, "%s\n", smg_message(status));
  return status != SMG_OK;
}

int main(void) {
  free_rigid_body_params p;
  free_rigid_body_model model;
  smg_real w[4][3];
  double off[3];
  free_rigid_body_defaults(&p);
  if (free_rigid_body_model_init(&model, &p) != SMG_OK) return 1;
  void *memory = malloc(free_rigid_body_memsize(&model));
  if (!memory) return 1;
  for (int k = 0; k < 4; ++k) {
    w[k][0] = 0.6, w[k][1] = 0, w[k][2] = 0.8;
    if (split(&model, memory, k < 3 ? 20 << k : 20000, w[k])) return 1;
  }
  for (int k = 0; k < 3; ++k) off[k] = fabs(w[k][0] - w[3][0]) + fabs(w[k][1] - w[3][1]) + fabs(w[k][2] - w[3][2]);
  printf("halving h divides the error by %.1f and %.1f\n", off[0] / off[1], off[1] / off[2]);
  free(memory);
  return 0;
}
