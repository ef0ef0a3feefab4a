/* Dormand and Prince of order 8 by hand, for one system: SYSTEM 1 is the free body, 2 four vortices; NAME the prefix of its functions.
 *
 * The method and the control of its step are those of runtime/method/explicit/smg_dop853.h. All else is what one writes for one system: a
 * number of components that the compiler knows, the field without a derivative that is 0, every stage an expression, the first
 * stage of a step the last one of the step before, no status but an end that is finite. CARRY: sums with a carry, as generated. */
#include "smg_dop853_estimates.h"
#include "contender.h"
#include <math.h>
#include <string.h>

#define ALWAYS static inline __attribute__((always_inline))

#if SYSTEM == 1
#define SITES 1
/* w' = w x I^-1 w */
typedef struct field_numbers {
  double d[3];
} field_numbers;
ALWAYS void prepare(field_numbers *f) {
  const double a[3] = {1, 1 / 2.0, 1 / 4.0}; /* 1/I of the spec's defaults */
  f->d[0] = a[2] - a[1], f->d[1] = a[0] - a[2], f->d[2] = a[1] - a[0];
}
ALWAYS void field(const field_numbers *f, const double *w, double *k) {
  k[0] = f->d[0] * (w[1] * w[2]);
  k[1] = f->d[1] * (w[2] * w[0]);
  k[2] = f->d[2] * (w[0] * w[1]);
}
#else
#define SITES 4
/* w_i' = sum_j s gamma_j w_i x w_j/(2 - 2 w_i.w_j), s = 1/(2 pi) */
typedef struct field_numbers {
  double strength[SITES];
} field_numbers;
ALWAYS void prepare(field_numbers *f) {
  for (int i = 0; i < SITES; ++i) f->strength[i] = 0.15915494309189535;
}
ALWAYS void field(const field_numbers *f, const double *w, double *k) {
  double g[3 * SITES] = {0};
#pragma GCC unroll 4
  for (int i = 0; i < SITES; ++i)
#pragma GCC unroll 4
    for (int j = i + 1; j < SITES; ++j) {
      const double *v = w + 3 * i, *u = w + 3 * j, x = 1 / (2 - 2 * (v[0] * u[0] + v[1] * u[1] + v[2] * u[2]));
      const double a = x * f->strength[j], b = x * f->strength[i];
      for (int q = 0; q < 3; ++q) g[3 * i + q] += a * u[q], g[3 * j + q] += b * v[q];
    }
#pragma GCC unroll 4
  for (int i = 0; i < SITES; ++i) {
    const double *v = w + 3 * i, *u = g + 3 * i;
    k[3 * i] = v[1] * u[2] - v[2] * u[1];
    k[3 * i + 1] = v[2] * u[0] - v[0] * u[2];
    k[3 * i + 2] = v[0] * u[1] - v[1] * u[0];
  }
}
#endif
#define N (3 * SITES)

typedef struct hand {
  double w[N], carry[N], h, tolerance, natural; /* natural: the last size that nothing cut short, as a part of h */
  field_numbers f;
} hand;

/* z_i = y + p sum_j a_ij k_j and k_i = f(z_i); the weights are constants of the text, and only the last term waits for the stage before. */
#define K(table, j) smg_dop853_##table[j] * k[j][q]
#define STAGE(i, older)                                                                    \
  do {                                                                                     \
    double z[N];                                                                           \
    const double last = p * smg_dop853_a[i][i - 1];                                        \
    for (int q = 0; q < N; ++q) z[q] = (y[q] + p * (older)) + last * k[i - 1][q];          \
    field(&s->f, z, k[i]);                                                                 \
  } while (0)
ALWAYS void later_stages(const hand *s, const double *y, double p, double (*k)[N]) {
  STAGE(1, 0);
  STAGE(2, K(a[2], 0));
  STAGE(3, K(a[3], 0));
  STAGE(4, K(a[4], 0) + K(a[4], 2));
  STAGE(5, K(a[5], 0) + K(a[5], 3));
  STAGE(6, K(a[6], 0) + K(a[6], 3) + K(a[6], 4));
  STAGE(7, K(a[7], 0) + K(a[7], 3) + K(a[7], 4) + K(a[7], 5));
  STAGE(8, K(a[8], 0) + K(a[8], 3) + K(a[8], 4) + K(a[8], 5) + K(a[8], 6));
  STAGE(9, K(a[9], 0) + K(a[9], 3) + K(a[9], 4) + K(a[9], 5) + K(a[9], 6) + K(a[9], 7));
  STAGE(10, K(a[10], 0) + K(a[10], 3) + K(a[10], 4) + K(a[10], 5) + K(a[10], 6) + K(a[10], 7) + K(a[10], 8));
  STAGE(11, K(a[11], 0) + K(a[11], 3) + K(a[11], 4) + K(a[11], 5) + K(a[11], 6) + K(a[11], 7) + K(a[11], 8) + K(a[11], 9));
}
#define COMBINED(t) (K(t, 0) + K(t, 5) + K(t, 6) + K(t, 7) + K(t, 8) + K(t, 9) + K(t, 10) + K(t, 11))

/* u = p sum_i b_i k_i; returns the error as a part of what is allowed, the largest of all sites. */
ALWAYS double increment(double p, double allowed, double (*k)[N], double *u) {
  const double r = p / allowed;
  double e5[N], e3[N], most = 0;
  for (int q = 0; q < N; ++q) u[q] = p * COMBINED(b);
  for (int q = 0; q < N; ++q) e5[q] = r * COMBINED(e5), e3[q] = r * COMBINED(e3);
  for (int i = 0; i < N; i += 3) {
    const double a = e5[i] * e5[i] + e5[i + 1] * e5[i + 1] + e5[i + 2] * e5[i + 2];
    const double b = e3[i] * e3[i] + e3[i + 1] * e3[i + 1] + e3[i + 2] * e3[i + 2];
    const double e = a > 0 ? a * (a / (a + 0.01 * b)) : 0;
    most = e > most ? e : most;
  }
  return sqrt(most);
}

ALWAYS double factor(double error) {
  const double x = error > 0 ? 0.9 / sqrt(sqrt(sqrt(error))) : 6;
  return x < 1 / 3.0 ? 1 / 3.0 : x > 6 ? 6 : x;
}

ALWAYS void take(double *y, double *carry, const double *u) {
  for (int q = 0; q < N; ++q) {
#if CARRY
    const double x = u[q] + carry[q], sum = y[q] + x;
    carry[q] = x - (sum - y[q]);
    y[q] = sum;
#else
    (void)carry;
    y[q] += u[q];
#endif
  }
}

/* The time h, by as many steps as the tolerance asks; 0 where the end is no number. */
static int one_step(hand *s) {
  double y[N], carry[N], k[12][N], u[N], done = 0, natural = s->natural > 0 ? s->natural : 1;
  int refused = 0;
  memcpy(y, s->w, sizeof y), memcpy(carry, s->carry, sizeof carry);
  field(&s->f, y, k[0]);
  while (done < 1) {
    const double left = 1 - done, half = natural < left / 2 ? natural : left / 2;
    const double end = left <= natural * 1.01 ? 1 : left > 2 * natural ? done + natural : done + half, size = end - done;
    later_stages(s, y, s->h * size, k);
    const double error = increment(s->h * size, s->tolerance, k, u);
    double more = factor(error);
    if (error <= 1) {
      take(y, carry, u);
      if (refused && more > 1) more = 1;
      if (more < 6 || size * more > natural) natural = size * more;
      done = end, refused = 0;
      if (end < 1) field(&s->f, y, k[0]);
    } else {
      natural = size * (error - error == 0 ? more : 1 / 3.0), refused = 1;
      if (natural < 1e-12) return 0;
    }
  }
  memcpy(s->w, y, sizeof y), memcpy(s->carry, carry, sizeof carry);
  s->natural = natural;
  return y[0] - y[0] == 0;
}

void FUNCTION(start)(void *state, const double *w, double h, double tolerance) {
  hand *s = (hand *)state;
  memset(s, 0, sizeof *s);
  memcpy(s->w, w, sizeof s->w);
  prepare(&s->f);
  s->h = h, s->tolerance = tolerance;
  for (int q = 0; q < N; ++q) s->natural = fmax(s->natural, fabs(w[q])); /* the largest component is the unit of the tolerance */
  s->tolerance *= s->natural, s->natural = 0;
}

int FUNCTION(steps)(void *state, int64_t n) {
  while (n-- > 0)
    if (!one_step((hand *)state)) return 0;
  return 1;
}

const double *FUNCTION(position)(const void *state) { return ((const hand *)state)->w; }
