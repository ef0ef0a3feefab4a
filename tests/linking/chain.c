/* A ring of 64 spins: 10000 steps, then the change of energy and of the total spin. */
#include "heisenberg_chain.h"

#include <stdio.h>
#include <stdlib.h>

enum { N = 64 };

static void start(smg_real w[3 * N]) {
  const double pi = 3.141592653589793;
  for (int i = 0; i < N; i++) {
    double theta = 0.7 + 0.3 * sin(6 * pi * i / N), phi = 2 * pi * i / N;
    w[3 * i] = sin(theta) * cos(phi);
    w[3 * i + 1] = sin(theta) * sin(phi);
    w[3 * i + 2] = cos(theta);
  }
}

int main(void) {
  heisenberg_chain_params p;
  heisenberg_chain_model model;
  heisenberg_chain_state s;
  smg_real w[3 * N], before[3], after[3];
  heisenberg_chain_defaults(&p);
  p.n = N;
  start(w);
  smg_status status = heisenberg_chain_model_init(&model, &p);
  if (status != SMG_OK) return 1;
  void *memory = malloc(heisenberg_chain_memsize(&model)); /* any memory will do: it is yours */
  if (!memory) return 1;
  status = heisenberg_chain_init(&s, &model, memory, w, 0.0, 0.1);
  if (status == SMG_OK) status = heisenberg_chain_steps(&s, 10000);
  if (status != SMG_OK) {
    fprintf(stderr, "%s: step %lld, site %lld\n", smg_message(status), (long long)s.count,
            (long long)s.report.site);
    return 1;
  }
  heisenberg_chain_momentum(&model, w, before);
  heisenberg_chain_momentum(&model, s.w, after);
  double t = (double)heisenberg_chain_time(&s);
  double energy = (double)(heisenberg_chain_energy(&model, t, s.w) - heisenberg_chain_energy(&model, 0, w));
  printf("t = %g  energy changed by %.1e  spin by %.1e\n", t, energy,
         (double)fabs(after[2] - before[2]));
  free(memory);
  return 0;
}
