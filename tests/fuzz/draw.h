/* Random numbers, and the bad ones: NaN, infinities, zeros, denormals, the ends of the range. */
#ifndef FUZZ_DRAW_H
#define FUZZ_DRAW_H

#include <float.h>
#include <math.h>
#include <stdint.h>

typedef struct dice {
  uint64_t state;
} dice;

/* splitmix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
static uint64_t draw_bits(dice *d) {
  uint64_t z = d->state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* Every case has dice of its own, so that one alone can be repeated. */
static dice draw_dice(uint64_t seed, uint64_t number) {
  dice d = {seed * 0x2545f4914f6cdd1du + number};
  (void)draw_bits(&d);
  return d;
}

static double draw_between(dice *d, double a, double b) {
  return a + (b - a) * (double)(draw_bits(d) >> 11) * 0x1p-53;
}

static int draw_below(dice *d, int n) { return (int)(draw_bits(d) % (uint64_t)n); }

static double draw_sign(dice *d) { return draw_bits(d) & 1 ? 1 : -1; }

/* +-10^U(a, b) */
static double draw_power(dice *d, double a, double b) {
  return draw_sign(d) * (double)powl(10, (long double)draw_between(d, a, b));
}

static double draw_normal(dice *d) {
  const double u = draw_between(d, 0x1p-53, 1);
  return sqrt(-2 * log(u)) * cos(6.283185307179586 * draw_between(d, 0, 1));
}

static double draw_bad(dice *d) {
  static const double bad[] = {NAN, INFINITY, 0, DBL_TRUE_MIN, DBL_MIN, DBL_MAX, 1e-300, 1e300, 1e-160, 1e160};
  const int k = draw_below(d, 12);
  return k < 10 ? draw_sign(d) * bad[k] : draw_power(d, -323, 308);
}

/* A step: mostly where something happens, sometimes anywhere, sometimes no step at all. */
static double draw_step(dice *d) {
  const int k = draw_below(d, 20);
  if (k < 11) return draw_power(d, -3, 1.5);
  if (k < 15) return draw_power(d, -20, 8);
  return k < 18 ? draw_power(d, -323, 308) : draw_bad(d);
}

static double draw_time(dice *d) {
  const int k = draw_below(d, 10);
  return k < 6 ? 0 : k < 8 ? draw_between(d, -10, 10) : k < 9 ? draw_power(d, -10, 20) : draw_bad(d);
}

/* A value in place of the parameter's own. */
static double draw_real(dice *d, double value) {
  const int k = draw_below(d, 20);
  if (k < 13) return value;
  if (k < 16) return value * draw_between(d, -2, 2);
  return k < 19 ? draw_power(d, -12, 12) : draw_bad(d);
}

static int64_t draw_integer(dice *d, int64_t value) {
  static const int64_t bad[] = {INT64_MAX, INT64_MIN, 0, -1, 1000000000, INT64_MAX / 3};
  const int k = draw_below(d, 20);
  return k < 15 ? value : k < 18 ? draw_below(d, 9) : bad[draw_below(d, 6)];
}

#endif
