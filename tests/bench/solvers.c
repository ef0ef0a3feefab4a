/* Nanoseconds per block row (band) or per system (dense) of the runtime's linear solvers.
 *
 * cc -std=c11 -O3 -march=native -ffp-contract=off -DSMG_BS=2 -Iruntime tests/bench/solvers.c -lm */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "smg_band.h"
#include "smg_dense.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static smg_real draw(void) { return (smg_real)rand() / (smg_real)RAND_MAX - (smg_real)0.5; }

/* Diagonal blocks near the identity, the others of size 1/2: a chain with h of about 1. */
static void fill_band(int64_t n, int k, smg_real *A, smg_real *x) {
  for (int64_t e = 0; e < n * (2 * k + 1) * SMG_BB; e++) A[e] = draw();
  for (int64_t i = 0; i < n; i++)
    for (int e = 0; e < SMG_BS; e++) A[(i * (2 * k + 1) + k) * SMG_BB + e * (SMG_BS + 1)] += k + 1;
  for (int64_t e = 0; e < n * SMG_BS; e++) x[e] = draw();
}

static void band(int64_t n, int k, int periodic, int64_t repeats) {
  smg_real *A = malloc((size_t)(n * (2 * k + 1) * SMG_BB) * sizeof *A);
  smg_real *b = malloc((size_t)(n * SMG_BS) * sizeof *b), *x = malloc((size_t)(n * SMG_BS) * sizeof *x);
  smg_real *work = malloc((size_t)smg_band_worksize(n, k) * sizeof *work);
  int ok;
  double best = 1e300;
  if (!A || !b || !x || !work) exit(1);
  fill_band(n, k, A, b);
  for (int trial = 0; trial < 7; trial++) {
    const double start = now();
    for (int64_t r = 0; r < repeats; r++) {
      for (int64_t e = 0; e < n * SMG_BS; e++) x[e] = b[e];
      const int64_t failed = k == 1   ? smg_band_solve(n, 1, periodic, A, x, work, &ok)
                             : k == 2 ? smg_band_solve(n, 2, periodic, A, x, work, &ok)
                                      : smg_band_solve(n, 4, periodic, A, x, work, &ok);
      if (failed) exit(2);
    }
    const double each = (now() - start) / (double)repeats;
    best = each < best ? each : best;
  }
  printf("band  BS=%d k=%d %-8s n=%-8lld %8.1f ns/block row\n", SMG_BS, k, periodic ? "periodic" : "open",
         (long long)n, 1e9 * best / (double)n);
  free(A), free(b), free(x), free(work);
}

#define DENSE(N, REPEATS)                                                          \
  static void dense##N(void) {                                                     \
    static smg_real A[N * N], B[N * N], x[N], b[N];                                \
    volatile smg_real sink = 0;                                                    \
    double best = 1e300;                                                           \
    int sign;                                                                      \
    for (int e = 0; e < N * N; e++) A[e] = draw();                                 \
    for (int e = 0; e < N; e++) A[e * N + e] += 1, b[e] = draw();                  \
    for (int trial = 0; trial < 7; trial++) {                                      \
      const double start = now();                                                  \
      for (int r = 0; r < REPEATS; r++) {                                          \
        for (int e = 0; e < N * N; e++) B[e] = A[e];                               \
        for (int e = 0; e < N; e++) x[e] = b[e];                                   \
        if (smg_dense_solve(N, B, x, &sign)) exit(2);                              \
        sink = x[0], b[0] = (smg_real)r, A[0] += (smg_real)1e-9;                   \
      }                                                                            \
      const double each = (now() - start) / REPEATS;                               \
      best = each < best ? each : best;                                            \
    }                                                                              \
    (void)sink;                                                                    \
    printf("dense n=%-4d %12.1f ns/system (copy included)\n", N, 1e9 * best);      \
  }

DENSE(2, 200000)
DENSE(3, 200000)
DENSE(4, 200000)
DENSE(6, 100000)
DENSE(8, 100000)
DENSE(12, 30000)
DENSE(200, 10)
DENSE(600, 1)

int main(void) {
  for (int k = 1; k <= 2; k++) {
    band(100, k, 1, 2000), band(100, k, 0, 2000);
    band(1000000, k, 1, 1), band(1000000, k, 0, 1);
  }
  dense2(), dense3(), dense4(), dense6(), dense8(), dense12(), dense200(), dense600();
  return 0;
}
