/* Orbits of one rigid body, H = sum w_k^2 (1 + sigma w_k)/(2 I_k): how far round-off carries H and |w|^2.
 *
 *     body I1 I2 I3 sigma N1 N2 ..  < starts        each start: x y z h
 *
 * prints, for every start, dH and d|w|^2 after N1, N2, .. steps, of w with its compensation, in quadruple precision.
 * MODEL names the generated header, M its functions. */
#include MODEL

#include <stdio.h>
#include <stdlib.h>

#define PASTE(a, b) a##b
#define NAME(m, what) PASTE(m, what)
#define F(what) NAME(M, what)

typedef __float128 quad;

static double inertia[3], sigma;

static void constants(const F(_state) * s, quad *energy, quad *square) {
  *energy = *square = 0;
  for (int k = 0; k < 3; ++k) {
    const quad w = (quad)s->w[k] + (quad)s->compensation[k];
    *energy += w * w * (1 + sigma * w) / (2 * (quad)inertia[k]);
    *square += w * w;
  }
}

static int orbit(const double *start, int counts, char **count) {
  F(_params) p;
  F(_model) model;
  F(_state) s;
  quad before[2], now[2];
  smg_real w[3];
  F(_defaults)(&p);
  if (F(_model_init)(&model, &p) != SMG_OK) return 1;
  for (int k = 0; k < 3; ++k) w[k] = start[k];
  void *memory = malloc(F(_memsize)(&model));
  smg_status status = F(_init)(&s, &model, memory, w, 0, start[3]);
  constants(&s, before, before + 1);
  for (int n = 0; n < counts && status == SMG_OK; ++n) {
    status = F(_steps)(&s, atoll(count[n]) - s.count);
    constants(&s, now, now + 1);
    printf(" %.6e %.6e", (double)(now[0] - before[0]), (double)(now[1] - before[1]));
  }
  printf("\n");
  free(memory);
  return status;
}

int main(int count, char **words) {
  double start[4];
  int status = 0;
  for (int k = 0; k < 3; ++k) inertia[k] = atof(words[k + 1]);
  sigma = atof(words[4]);
  while (!status && scanf("%lf %lf %lf %lf", start, start + 1, start + 2, start + 3) == 4)
    status = orbit(start, count - 5, words + 5);
  return status;
}
