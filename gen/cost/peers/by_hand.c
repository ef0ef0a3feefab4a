/* Dormand and Prince of order 8 as one writes it for one system: the number of components is a constant, the field is written by
 * hand and inlined, every stage is an expression, the first stage of a step is the last one of the step before, sums are plain.
 *
 * FIELD: the file of the field, in fields/: a type field_numbers with what depends on parameters alone, prepared() that fills it,
 * and field(). SITES: how many. Components stand apart, x of all sites, then y, then z, so that loops over sites are vectors;
 * NUMBERS, where it is more than 3*SITES, fills a vector with zeros. */
#include "rate.h"

#include "smg_dop853_estimates.h"
#include <math.h>

#define ALWAYS static inline __attribute__((always_inline))
#include FIELD
#ifndef NUMBERS
#define NUMBERS (3 * SITES)
#endif

typedef struct peer {
  double tolerance, first, y[NUMBERS], k[12][NUMBERS], next[NUMBERS];
  field_numbers f;
} peer;

/* z_i = y + h sum_j a_ij k_j and k_i = f(z_i); only the last term waits for the stage before. */
#define K(table, j) smg_dop853_##table[j] * k[j][q]
#define STAGE(i, older)                                                                      \
  do {                                                                                       \
    double z[NUMBERS];                                                                       \
    const double last = h * smg_dop853_a[i][i - 1];                                          \
    for (int q = 0; q < NUMBERS; ++q) z[q] = (y[q] + h * (older)) + last * k[i - 1][q];      \
    field(&p->f, z, k[i]);                                                                   \
  } while (0)
ALWAYS void stages(peer *p, double h) {
  const double *y = p->y;
  double(*k)[NUMBERS] = p->k;
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

/* next = y + h sum_i b_i k_i; returns the error as a part of what is allowed, by the method's own mean of its orders 5 and 3. */
ALWAYS double tried(peer *p, double h) {
  const double *y = p->y;
  double(*k)[NUMBERS] = p->k, five = 0, three = 0;
  for (int q = 0; q < NUMBERS; ++q) p->next[q] = y[q] + h * COMBINED(b);
  for (int q = 0; q < NUMBERS; ++q) {
    const double e5 = COMBINED(e5), e3 = COMBINED(e3);
    five += e5 * e5, three += e3 * e3;
  }
  return fabs(h) / p->tolerance * (five > 0 ? five / sqrt((five + 0.01 * three) * (3 * SITES)) : 0);
}

/* How much larger the next step may be: 0.9/error^(1/8), from a third to six. */
ALWAYS double factor(double error) {
  const double x = error > 0 ? 0.9 / sqrt(sqrt(sqrt(error))) : 6;
  return x < 1 / 3.0 ? 1 / 3.0 : x > 6 ? 6 : x;
}

/* To the time `end`; *step: the next size that nothing cuts short. Returns the steps, or -1. */
static int64_t to(peer *p, double t, double end, double *step) {
  const double way = end < t ? -1 : 1;
  int64_t steps = 0;
  int refused = 0, last = t == end;
  while (!last) {
    double h = *step;
    if ((last = way * (t + 1.01 * h - end) >= 0)) h = end - t;
    if (++steps > MOST_STEPS || t + h == t) return -1;
    stages(p, h);
    const double error = tried(p, h), more = factor(error);
    if (!(error <= 1)) {
      *step = h * (error - error == 0 ? more : 1 / 3.0), refused = 1, last = 0;
      continue;
    }
    if (!last || way * h * more > way * *step) *step = h * (refused && more > 1 ? 1 : more);
    t += h, refused = 0;
    memcpy(p->y, p->next, sizeof p->y);
    field(&p->f, p->y, p->k[0]);
  }
  return steps;
}

/* Site after site, as others have them. */
ALWAYS void apart(const double *w, double *y) {
  for (int i = 0; i < SITES; ++i)
    for (int c = 0; c < 3; ++c) y[c * SITES + i] = w[3 * i + c];
}
ALWAYS void together(const double *y, double *w) {
  for (int i = 0; i < SITES; ++i)
    for (int c = 0; c < 3; ++c) w[3 * i + c] = y[c * SITES + i];
}

void *peer_new(void *model, int kind, double tol, double first) {
  peer *p = (peer *)aligned_alloc(64, (sizeof *p + 63) / 64 * 64);
  (void)kind;
  if (!p || numbers(model) != 3 * SITES) return free(p), NULL;
  memset(p, 0, sizeof *p);
  p->tolerance = tol * ((MODEL *)model)->s.scale;
  p->first = first;
  prepared(&p->f, &((MODEL *)model)->model.p);
  return p;
}

int64_t peer_run(void *at, double t0, double *y, const double *times, int64_t count, double *out) {
  peer *p = (peer *)at;
  double t = t0, step = p->first;
  int64_t steps = 0;
  apart(y, p->y);
  field(&p->f, p->y, p->k[0]);
  for (int64_t k = 0; k < count; ++k) {
    const int64_t more = to(p, t, times[k], &step);
    if (more < 0) return -1;
    t = times[k], steps += more;
    together(p->y, out + 3 * SITES * k);
  }
  together(p->y, y);
  return steps;
}

void peer_free(void *at) { free(at); }

/* The field alone, to compare it with the generated one. */
void peer_field(void *at, const double *w, double *out);
void peer_field(void *at, const double *w, double *out) {
  peer *p = (peer *)at;
  apart(w, p->y);
  field(&p->f, p->y, p->k[0]);
  together(p->k[0], out);
}
