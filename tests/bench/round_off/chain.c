/* A ring of n spins, H = sum w_i.w_(i+1): how far round-off carries H and the |w_i|^2.
 *
 *     chain h N1 N2 ..  < start        the start: n, then x y z of each spin
 *
 * prints dH and the root mean square of d|w_i|^2 over the spins after N1, N2, .. steps, of w with its compensation, in
 * quadruple precision. MODEL names the generated header, M its functions. */
#include MODEL

#include <stdio.h>
#include <stdlib.h>

#define PASTE(a, b) a##b
#define NAME(m, what) PASTE(m, what)
#define F(what) NAME(M, what)

typedef __float128 quad;

/* w and its compensation stand before the history of a saved state, whose beginning it tells. */
static smg_real *saved;
static quad part(int64_t n, int64_t k) {
  const smg_real *lost = saved + (int64_t)saved[1] - 3 * n;
  return (quad)lost[k - 3 * n] + (quad)lost[k];
}

static quad constants(const F(_state) * s, int64_t n, quad *square) {
  quad energy = 0;
  F(_save)(s, saved);
  for (int64_t i = 0; i < n; ++i) {
    square[i] = 0;
    for (int b = 0; b < 3; ++b) {
      energy += part(n, 3 * i + b) * part(n, 3 * ((i + 1) % n) + b);
      square[i] += part(n, 3 * i + b) * part(n, 3 * i + b);
    }
  }
  return energy;
}

static double scatter(int64_t n, const quad *now, const quad *before) {
  double sum = 0;
  for (int64_t i = 0; i < n; ++i) sum += (double)((now[i] - before[i]) * (now[i] - before[i]) * (quad)1e30);
  return 1e-15 * sqrt(sum / (double)n);
}

int main(int count, char **words) {
  F(_params) p;
  F(_model) model;
  F(_state) s;
  int n = 0;
  F(_defaults)(&p);
  if (scanf("%d", &n) != 1) return 1;
  p.n = n;
  if (F(_model_init)(&model, &p) != SMG_OK) return 1;
  smg_real *w = (smg_real *)calloc(3 * (size_t)n, sizeof *w);
  quad *before = (quad *)calloc((size_t)n, sizeof *before), *now = (quad *)calloc((size_t)n, sizeof *now);
  void *memory = malloc(F(_memsize)(&model));
  saved = (smg_real *)malloc(F(_savesize)(&model) * sizeof *saved);
  for (int k = 0; k < 3 * n; ++k)
    if (scanf("%lf", w + k) != 1) return 1;
  smg_status status = F(_init)(&s, &model, memory, w, 0, atof(words[1]));
  const quad energy = constants(&s, n, before);
  for (int k = 2; k < count && status == SMG_OK; ++k) {
    status = F(_steps)(&s, atoll(words[k]) - s.count);
    const quad found = constants(&s, n, now);
    printf(" %.6e %.6e", (double)(found - energy), scatter(n, now, before));
    fflush(stdout);
  }
  printf("\n");
  free(memory);
  free(saved);
  free(now);
  free(before);
  free(w);
  return (int)status;
}
