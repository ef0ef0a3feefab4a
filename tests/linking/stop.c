/* A body stops after 500 steps and goes on in other memory: the same bits as without a stop. */
#include "free_rigid_body.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(void) {
  free_rigid_body_params p;
  free_rigid_body_model model;
  free_rigid_body_state s, again;
  const smg_real w[3] = {0.6, 0, 0.8};
  free_rigid_body_defaults(&p);
  smg_status status = free_rigid_body_model_init(&model, &p);
  if (status != SMG_OK) return 1;
  const size_t bytes = free_rigid_body_memsize(&model), numbers = free_rigid_body_savesize(&model);
  void *memory = malloc(bytes), *other = malloc(bytes);
  smg_real *saved = (smg_real *)malloc(numbers * sizeof *saved);
  if (!memory || !other || !saved) return 1;
  status = free_rigid_body_init(&s, &model, memory, w, 0.0, 0.1);
  if (status == SMG_OK) status = free_rigid_body_steps(&s, 500);
  free_rigid_body_save(&s, saved); /* these numbers may go to a file */
  if (status == SMG_OK) status = free_rigid_body_steps(&s, 500);

  if (status == SMG_OK) status = free_rigid_body_init(&again, &model, other, w, 0.0, 0.1);
  if (status == SMG_OK) status = free_rigid_body_restore(&again, saved);
  if (status == SMG_OK) status = free_rigid_body_steps(&again, 500);
  if (status != SMG_OK) {
    fprintf(stderr, "%s\n", smg_message(status));
    return 1;
  }
  printf("t = %g, %s\n", free_rigid_body_time(&again), memcmp(s.w, again.w, sizeof w) ? "other bits" : "the same bits");
  free(memory);
  free(other);
  free(saved);
  return 0;
}
