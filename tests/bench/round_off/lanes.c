/* Eight free bodies at once in the lanes of vectors (gcc's extensions): what the last evaluation costs there.
 *
 *     lanes [N ..]  < starts       prints ns per step and trajectory; with N: dH and d|w|^2 of each start after N steps
 *
 * Every step: start values from the last seven increments; Newton for u = h X(m), m = S/|S|, S = 2w + u, of the kind
 * (1 - E)^-1 (F(u) - u), E = h DX(m) (1 - m m^T)/|S|, no status and no branch check; then
 *     PLAIN  v = h X(m) once more, W = w + (v + compensation);
 *     WIDE   V = h X(m) at m = P(w + compensation + v/2) in pairs of doubles, plus the first-order remainder E d/(1 - E),
 *            d = V - v, and W + compensation as a pair. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#ifdef WIDE
enum { LANES = 8, NEWTON = 1 }; /* the last evaluation takes the remainder along */
#else
enum { LANES = 8, NEWTON = 2 };
#endif
typedef double real __attribute__((vector_size(8 * LANES)));
typedef struct { real x, y, z; } vec;
typedef struct { real hi, lo; } wide;

static inline real all(double a) { return a - (real){0}; }

#ifdef __AVX512F__
static inline real root(real a) { return (real)_mm512_sqrt_pd((__m512d)a); }
#else
static inline real root(real a) {
  real r;
  for (int l = 0; l < LANES; ++l) r[l] = sqrt(a[l]);
  return r;
}
#endif

static inline vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec mul(real a, vec b) { return (vec){a * b.x, a * b.y, a * b.z}; }
static inline real dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* I = (1, 2, 4): h X(m) = h (m2 m3 a, m3 m1 b, m1 m2 c), a = 1/I3 - 1/I2, .. */
static const double A = -0.25, B = 0.75, C = -0.5;

static inline vec motion(real h, vec m) { return (vec){h * A * m.y * m.z, h * B * m.z * m.x, h * C * m.x * m.y}; }

/* h DX(m) d */
static inline vec derivative(real h, vec m, vec d) {
  return (vec){h * A * (m.y * d.z + m.z * d.y), h * B * (m.z * d.x + m.x * d.z), h * C * (m.x * d.y + m.y * d.x)};
}

/* E d, E = h DX(m) (1 - m m^T)/|S| */
static inline vec linear(real h, vec m, real q, vec d) { return derivative(h, m, mul(q, sub(d, mul(dot(m, d), m)))); }

/* (1 - E)^-1 d to order E^3: h is small here */
static inline vec resolve(real h, vec m, real q, vec d) {
  const vec e = linear(h, m, q, d), f = linear(h, m, q, e), g = linear(h, m, q, f);
  return add(d, add(e, add(f, g)));
}

#ifdef WIDE
static inline wide sum(real a, real b) {
  const real s = a + b, c = s - a;
  return (wide){s, (a - (s - c)) + (b - c)};
}
#ifdef __AVX512F__
static inline real fused(real a, real b, real c) { return (real)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c); }
#else
static inline real fused(real a, real b, real c) {
  real r;
  for (int l = 0; l < LANES; ++l) r[l] = fma(a[l], b[l], c[l]);
  return r;
}
#endif
static inline wide ordered(real a, real b) {
  const real s = a + b;
  return (wide){s, b - (s - a)};
}
static inline wide product(real a, real b) {
  const real p = a * b;
  return (wide){p, fused(a, b, -p)};
}
static inline wide plus(wide a, wide b) {
  const wide s = sum(a.hi, b.hi);
  return ordered(s.hi, s.lo + (a.lo + b.lo));
}
static inline wide times(wide a, wide b) {
  const wide p = product(a.hi, b.hi);
  return ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
static inline wide scaled(real a, wide b) {
  const wide p = product(a, b.hi);
  return ordered(p.hi, p.lo + a * b.lo);
}
static inline wide inverse_root(wide a) {
  const real q = 1 / root(a.hi);
  const wide r = plus((wide){all(1), all(0)}, scaled(-q, scaled(q, a)));
  return ordered(q, 0.5 * q * (r.hi + r.lo));
}

/* W + compensation = w + compensation + V + e */
static inline void last(real h, vec *w, vec *compensation, vec *v) {
  const real *p = &w->x, *c = &compensation->x, *u = &v->x, factor[3] = {h * A, h * B, h * C};
  wide s[3], m[3], V[3];
  for (int k = 0; k < 3; ++k) s[k] = plus(sum(p[k], c[k]), (wide){0.5 * u[k], all(0)});
  const wide square = plus(plus(times(s[0], s[0]), times(s[1], s[1])), times(s[2], s[2])), q = inverse_root(square);
  for (int k = 0; k < 3; ++k) m[k] = times(q, s[k]);
  for (int k = 0; k < 3; ++k) V[k] = scaled(factor[k], times(m[(k + 1) % 3], m[(k + 2) % 3]));
  vec d = {(V[0].hi - u[0]) + V[0].lo, (V[1].hi - u[1]) + V[1].lo, (V[2].hi - u[2]) + V[2].lo};
  const vec n = {m[0].hi, m[1].hi, m[2].hi}, e = sub(resolve(h, n, 0.5 * q.hi, d), d);
  const real *rest = &e.x;
  for (int k = 0; k < 3; ++k) {
    const wide W = plus(sum((&w->x)[k], (&compensation->x)[k]), plus(V[k], (wide){rest[k], all(0)}));
    (&w->x)[k] = W.hi;
    (&compensation->x)[k] = W.lo;
    (&v->x)[k] = V[k].hi;
  }
}
#else
/* W = w + (v + compensation), Kahan */
static inline void last(real h, vec *w, vec *compensation, vec *v) {
  const vec S = add(add(mul(all(2), *w), *v), mul(all(2), *compensation));
  *v = motion(h, mul(1 / root(dot(S, S)), S));
  const vec y = add(*v, *compensation), W = add(*w, y);
  *compensation = sub(y, sub(W, *w));
  *w = W;
}
#endif

typedef struct { vec w, compensation, past[7]; real h; long count; } bodies;

static inline void step(bodies *s) {
  const vec *p = s->past;
  const vec even = add(mul(all(7), sub(p[0], p[5])), mul(all(21), sub(p[4], p[1]))), odd = mul(all(35), sub(p[2], p[3]));
  vec u = add(add(even, odd), p[6]);
  for (int k = 0; k < (s->count < 9 ? 8 : NEWTON); ++k) { /* the first steps have no increments to extrapolate */
    const vec S = add(mul(all(2), s->w), u);
    const real q = 1 / root(dot(S, S));
    const vec m = mul(q, S);
    u = add(u, resolve(s->h, m, q, sub(motion(s->h, m), u)));
  }
  last(s->h, &s->w, &s->compensation, &u);
  for (int k = 6; k > 0; --k) s->past[k] = s->past[k - 1];
  s->past[0] = u;
  ++s->count;
}

static void constants(const bodies *s, int l, __float128 *found) {
  static const double inertia[3] = {1, 2, 4};
  found[0] = found[1] = 0;
  for (int k = 0; k < 3; ++k) {
    const __float128 w = (__float128)(&s->w.x)[k][l] + (__float128)(&s->compensation.x)[k][l];
    found[0] += w * w / (2 * inertia[k]);
    found[1] += w * w;
  }
}

static void begin(bodies *s, double start[LANES][4]) {
  s->count = 0;
  for (int l = 0; l < LANES; ++l) {
    for (int k = 0; k < 3; ++k) {
      (&s->w.x)[k][l] = start[l][k];
      (&s->compensation.x)[k][l] = 0;
      for (int j = 0; j < 7; ++j) (&s->past[j].x)[k][l] = 0;
    }
    s->h[l] = start[l][3];
  }
}

/* dH and d|w|^2 of eight starts after each count of steps */
static void drift(double start[LANES][4], int counts, char **count) {
  bodies s;
  __float128 before[LANES][2], now[2];
  double found[LANES][16][2];
  long done = 0;
  begin(&s, start);
  for (int l = 0; l < LANES; ++l) constants(&s, l, before[l]);
  for (int n = 0; n < counts; ++n) {
    for (; done < atol(count[n]); ++done) step(&s);
    for (int l = 0; l < LANES; ++l) {
      constants(&s, l, now);
      for (int q = 0; q < 2; ++q) found[l][n][q] = (double)(now[q] - before[l][q]);
    }
  }
  for (int l = 0; l < LANES; ++l, printf("\n"))
    for (int n = 0; n < counts; ++n) printf(" %.6e %.6e", found[l][n][0], found[l][n][1]);
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void pace(void) {
  enum { STEPS = 200000 };
  double start[LANES][4];
  bodies s;
  for (int l = 0; l < LANES; ++l) {
    start[l][0] = cos(1.1 + 0.01 * l);
    start[l][1] = 0;
    start[l][2] = sin(1.1 + 0.01 * l);
    start[l][3] = 0.1;
  }
  begin(&s, start);
  for (int n = 0; n < STEPS / 4; ++n) step(&s);
  const double before = seconds();
  for (int n = 0; n < STEPS; ++n) step(&s);
  printf("%.3f %g\n", 1e9 * (seconds() - before) / STEPS / LANES, s.w.x[0]);
}

int main(int count, char **words) {
  double start[LANES][4];
  if (count < 2) return pace(), 0;
  for (int l = 0;; l = (l + 1) % LANES) {
    if (scanf("%lf %lf %lf %lf", start[l], start[l] + 1, start[l] + 2, start[l] + 3) != 4) return l;
    if (l == LANES - 1) drift(start, count - 1, words + 1);
  }
}
