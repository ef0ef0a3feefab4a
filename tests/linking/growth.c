/* How fast a body leaves its unstable axis: the growth of a vector that the tangent map carries along. */
#include "free_rigid_body.h"

#include <stdio.h>

int main(void) {
  free_rigid_body_params p;
  free_rigid_body_model model;
  free_rigid_body_state s;
  smg_real memory[1024], w[3] = {0, 1, 0}, v[3] = {1, 0, 0}; /* v is tangent to the sphere at w */
  double sum = 0, last = 0;
  free_rigid_body_defaults(&p);
  if (free_rigid_body_model_init(&model, &p) != SMG_OK) return 1;
  if (free_rigid_body_memsize(&model) > sizeof memory || free_rigid_body_tangent_memsize(&model) > 0) return 1;
  smg_status status = free_rigid_body_init(&s, &model, memory, w, 0.0, 0.1);
  while (status == SMG_OK && s.count < 2000) {
    status = free_rigid_body_step(&s);
    if (status == SMG_OK) status = free_rigid_body_tangent(&s, v, 1, NULL);
    const smg_real size = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int b = 0; b < 3; b++) v[b] /= size;
    sum += log(size);
    if (s.count == 1000) last = sum; /* the first half turns v into the direction that grows */
  }
  if (status != SMG_OK) return 2;
  printf("|v| grows like exp(%.6f t)\n", (sum - last) / 100);
  return 0;
}
