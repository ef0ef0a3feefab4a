/* States of one trajectory, w with its compensation, after N1, N2, .. steps: each number as two doubles.
 *
 *     states h N1 N2 ..  < start       the start: the number of sites, then x y z of each
 *
 * MODEL names the generated header, M its functions; the same text in any precision of smg_real. */
#include MODEL

#include <stdio.h>
#include <stdlib.h>

#define PASTE(a, b) a##b
#define NAME(m, what) PASTE(m, what)
#define F(what) NAME(M, what)

/* w and its compensation stand before the history of a saved state, whose beginning it tells. */
static void show(const F(_state) * s, int64_t n, smg_real *saved) {
  F(_save)(s, saved);
  const smg_real *lost = saved + (int64_t)saved[1] - n;
  for (int64_t k = 0; k < n; ++k) {
    const smg_real w = lost[k - n];
    const double hi = (double)w, lo = (double)((w - (smg_real)hi) + lost[k]);
    printf(" %.17g %.17g", hi, lo);
  }
  printf("\n");
  fflush(stdout);
}

int main(int count, char **words) {
  F(_params) p;
  F(_model) model;
  F(_state) s;
  int sites = 0;
  double x;
  F(_defaults)(&p);
  if (F(_model_init)(&model, &p) != SMG_OK) return 1;
  if (scanf("%d", &sites) != 1) return 1;
  smg_real *w = (smg_real *)calloc(3 * (size_t)sites, sizeof *w);
  void *memory = malloc(F(_memsize)(&model));
  smg_real *saved = (smg_real *)malloc(F(_savesize)(&model) * sizeof *saved);
  for (int k = 0; k < 3 * sites; ++k) {
    if (scanf("%lf", &x) != 1) return 1;
    w[k] = x;
  }
  smg_status status = F(_init)(&s, &model, memory, w, 0, atof(words[1]));
  for (int k = 0; k < 3 * sites && status == SMG_OK; ++k) s.w[k] = w[k]; /* not put on the sphere to more digits than given */
  for (int k = 2; k < count && status == SMG_OK; ++k) {
    status = F(_steps)(&s, atoll(words[k]) - s.count);
    show(&s, 3 * sites, saved);
  }
  free(memory);
  free(saved);
  free(w);
  return (int)status;
}
