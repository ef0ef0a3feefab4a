/* smidgen runtime: random numbers that a counter gives, without a state: Philox4x32-10 (Salmon, Moraes, Dror, Shaw,
 * "Parallel random numbers: as easy as 1, 2, 3", SC 2011), and normals from them by Box and Muller with a logarithm,
 * cosine and sine made of sums, products and quotients alone, so that every compiler and every libm gives the same
 * bits, and without branches, so that compilers draw for several sites at once. */
#ifndef SMG_RANDOM_H
#define SMG_RANDOM_H

#include <string.h>

#include "smidgen.h"

/* What numbers are drawn for: the field `use` of the counter, 8 bits. A number is never given twice. */
enum {
  SMG_USE_NOISE = 0,    /* 0 to 63: two halves of a step, 32 turns each */
  SMG_USE_UNIFORM = 64, /* in formulas: of a site, or of two */
  SMG_USE_NORMAL = 65,
  SMG_USE_START = 66 /* the directions of a random start (gen/language/draws.py), step: its family */
};

typedef struct smg_philox {
  uint32_t word[4];
} smg_philox;

static inline smg_philox smg_philox_round(smg_philox x, uint32_t key0, uint32_t key1) {
  const uint64_t a = (uint64_t)0xD2511F53u * x.word[0], b = (uint64_t)0xCD9E8D57u * x.word[2];
  const smg_philox next = {
      {(uint32_t)(b >> 32) ^ x.word[1] ^ key0, (uint32_t)b, (uint32_t)(a >> 32) ^ x.word[3] ^ key1, (uint32_t)a}};
  return next;
}

/* Four random words: ten rounds of the counter under the key. */
static inline smg_philox smg_philox_of(smg_philox counter, uint64_t key) {
  uint32_t key0 = (uint32_t)key, key1 = (uint32_t)(key >> 32);
  for (int k = 0; k < 10; ++k, key0 += 0x9E3779B9u, key1 += 0xBB67AE85u)
    counter = smg_philox_round(counter, key0, key1);
  return counter;
}

/* The counter: step 48 bits, site 40, use 8, member 32. */
static inline smg_philox smg_counter(int64_t step, int64_t site, int use, uint32_t member) {
  const uint64_t n = (uint64_t)step, k = (uint64_t)site;
  const smg_philox counter = {{(uint32_t)n, (uint32_t)((n >> 32 & 0xFFFFu) | (k & 0xFFFFu) << 16),
                               (uint32_t)((k >> 16 & 0xFFFFFFu) | (uint64_t)use << 24), member}};
  return counter;
}

/* A word as a number, by a conversion that all vector registers have; the bits of a number, and back. */
static inline double smg_word_number(uint32_t k) { return (double)(int32_t)(k ^ 0x80000000u) + 2147483648.0; }
static inline uint64_t smg_bits_of_number(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof x);
  return bits;
}
static inline double smg_number_of_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* -2 ln((k + 1/2)/2^32). With u = m/2^e, m from sqrt(1/2) to sqrt(2), and f = (m - 1)/(m + 1),
 * ln u = 2 (f + f^3/3 + f^5/5 + ..) - e ln 2. */
static inline double smg_minus_two_log(uint32_t k) {
  const double u = (smg_word_number(k) + 0.5) / 4294967296.0;
  const uint64_t root = 0x3FE6A09E667F3BCDu;                                /* the bits of sqrt(1/2) */
  const uint64_t part = smg_bits_of_number(u) - root + 0x3FF0000000000000u; /* its exponent is that of u/sqrt(1/2) */
  const double e = 1023 - (int32_t)(part >> 52), m = smg_number_of_bits((part & 0xFFFFFFFFFFFFFu) + root);
  const double f = (m - 1) / (m + 1), y = f * f;
  const double series =
      1 + y * (1.0 / 3 +
               y * (1.0 / 5 +
                    y * (1.0 / 7 +
                         y * (1.0 / 9 +
                              y * (1.0 / 11 + y * (1.0 / 13 + y * (1.0 / 15 + y * (1.0 / 17 + y * (1.0 / 19)))))))));
  return 1.3862943611198906 * e - 4 * f * series;
}

/* 1 - cos x and sin(x)/x from y = x^2 up to 0.9, by their series. Quotients of constants cost nothing. */
static inline double smg_one_minus_cos(double y) {
  return y * (0.5 - y * (1.0 / 24 -
                         y * (1.0 / 720 - y * (1.0 / 40320 - y * (1.0 / 3628800 -
                                                                  y * (1.0 / 479001600 -
                                                                       y * (1.0 / 87178291200.0 -
                                                                            y * (1.0 / 20922789888000.0 -
                                                                                 y * (1.0 / 6402373705728000.0)))))))));
}
static inline double smg_sine_ratio(double y) {
  return 1 - y * (1.0 / 6 -
                  y * (1.0 / 120 -
                       y * (1.0 / 5040 -
                            y * (1.0 / 362880 - y * (1.0 / 39916800 - y * (1.0 / 6227020800.0 -
                                                                           y * (1.0 / 1307674368000.0 -
                                                                                y * (1.0 / 355687428096000.0))))))));
}

/* (a, b) = r (cos, sin)(2 pi k/2^32): the angle is a whole number of quarters and at most an eighth of a turn more. */
static inline void smg_polar(double r, uint32_t k, double *a, double *b) {
  const uint32_t quarters = ((k >> 29) + 1) / 2;
  const double x = (int32_t)(k - (quarters << 30)) * 1.4629180792671596e-9; /* 2 pi/2^32 */
  const uint64_t c = smg_bits_of_number(r * (1 - smg_one_minus_cos(x * x))),
                 s = smg_bits_of_number(r * (x * smg_sine_ratio(x * x))),
                 swapped = (c ^ s) & (0 - (uint64_t)(quarters & 1));
  *a = smg_number_of_bits(c ^ swapped ^ (uint64_t)((quarters + 1) & 2) << 62);
  *b = smg_number_of_bits(s ^ swapped ^ (uint64_t)(quarters & 2) << 62);
}

/* Three independent normal numbers, of mean 0 and variance 1. */
static inline void smg_three_normals(smg_philox random, double *x) {
  double left;
  smg_polar(sqrt(smg_minus_two_log(random.word[0])), random.word[1], x, x + 1);
  smg_polar(sqrt(smg_minus_two_log(random.word[2])), random.word[3], x + 2, &left);
}

/* Disorder: the words of a site, and of two in either order. The step of a site is 0, which no pair has. */
static inline smg_philox smg_words_of_site(int64_t seed, int64_t i, int use) {
  return smg_philox_of(smg_counter(0, i, use, 0), (uint64_t)seed);
}
static inline smg_philox smg_words_of_bond(int64_t seed, int64_t i, int64_t j, int use) {
  return smg_philox_of(
      smg_counter((i < j ? j : i) == -1 ? (int64_t)1 << 47 : (i < j ? j : i) + 1, i < j ? i : j, use, 0),
      (uint64_t)seed);
}

/* A number in (0, 1), of 52 bits; a normal one, of mean 0 and variance 1. */
static inline double smg_uniform_number(smg_philox random) {
  return ((double)((int64_t)random.word[0] << 20 | random.word[1] >> 12) + 0.5) / 4503599627370496.0;
}
static inline double smg_normal_number(smg_philox random) {
  double x, left;
  smg_polar(sqrt(smg_minus_two_log(random.word[0])), random.word[1], &x, &left);
  return x;
}

#endif
