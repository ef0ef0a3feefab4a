/* The step equation in extended precision, from the field (1/kappa) dH/dw alone:
 *
 *   F(u) = u - h X(m),  X_i = orientation * (A m_i) x b_i(m),  m_i = P_i(w_i + u_i/2),
 *
 * P the projection of the method, b the field of a long-double build. Moser-Veselov divides h X by
 * q = (1 + sqrt(1 - h^2 |b|^2))/2. Also the branch of solutions that begins with u = 0 at h = 0. */
#ifndef FUZZ_EQUATION_H
#define FUZZ_EQUATION_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define SITES 64 /* largest model */
#define SMALL 20 /* sites of the largest model whose branch is followed */
#define EFFORT 2000 /* Newton iterations that the search for a branch may take */

enum { SPHERICAL, CLASSICAL, VESELOV };
enum { ON_SPHERE, ON_R3, ON_NAMBU };

typedef long double real;

typedef struct equation {
  const void *p;
  int64_t sites;
  int method, kind[SITES];
  real casimir[9], level[SITES], strongest, orientation, t, h, w[3 * SITES]; /* strongest: the largest |h/kappa| */
} equation;

void reference_field(const void *p, real t, const real *w, real *b);

static real dot(const real *a, const real *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(real *c, const real *a, const real *b) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* n = grad C(v) = A v on a Nambu factor, v elsewhere. */
static void normal(const equation *e, int64_t i, const real *v, real *n) {
  for (int a = 0; a < 3; a++) n[a] = e->kind[i] == ON_NAMBU ? dot(e->casimir + 3 * a, v) : v[a];
}

/* |v|^2 or 2 C(v) */
static real casimir(const equation *e, int64_t i, const real *v) {
  real n[3];
  normal(e, i, v, n);
  return dot(v, n);
}

/* The point where the field is taken. */
static void project(const equation *e, int64_t i, const real *mbar, real *m) {
  const real c = casimir(e, i, mbar);
  real s = e->method == SPHERICAL ? sqrtl(e->level[i] / c) : 1;
  if (e->kind[i] == ON_R3 && !(e->level[i] > 0)) s = 1; /* the zero vector stays */
  for (int a = 0; a < 3; a++) m[a] = s * mbar[a];
}

/* m, where the field is taken, for the increments u. */
static void midpoints(const equation *e, const real *u, real *m) {
  for (int64_t i = 0; i < e->sites; i++) {
    real mbar[3];
    for (int a = 0; a < 3; a++) mbar[a] = e->w[3 * i + a] + u[3 * i + a] / 2;
    project(e, i, mbar, m + 3 * i);
  }
}

/* x = h X at m; size_i: |h| |n_i| |b_i|, the terms of the product. */
static void product(const equation *e, real h, const real *m, real *x, real *size) {
  real b[3 * SITES];
  reference_field(e->p, e->t, m, b);
  for (int64_t i = 0; i < e->sites; i++) {
    real n[3], k = e->orientation * h;
    const real b2 = dot(b + 3 * i, b + 3 * i);
    if (e->method == VESELOV) k /= (1 + sqrtl(1 - h * h * b2)) / 2;
    normal(e, i, m + 3 * i, n);
    cross(x + 3 * i, n, b + 3 * i);
    for (int a = 0; a < 3; a++) x[3 * i + a] *= k;
    size[i] = fabsl(k) * sqrtl(dot(n, n) * b2);
  }
}

static void increment(const equation *e, real h, const real *u, real *x, real *size) {
  real m[3 * SITES];
  midpoints(e, u, m);
  product(e, h, m, x, size);
}

static real largest(const real *x, int64_t n) {
  real most = 0;
  for (int64_t k = 0; k < n; k++)
    if (!(fabsl(x[k]) <= most)) most = fabsl(x[k]);
  return most;
}

/* Adds to size_i what rounding the numbers v does to h X_i = map(v)_i, in units: sum_k |d(h X_i)/dv_k| |w| of the site of k. */
static void sensitive(const equation *e, void (*map)(const equation *, real, const real *, real *, real *), real *v, real *size) {
  real x[3 * SITES], y[3 * SITES], spare[SITES];
  map(e, e->h, v, x, spare);
  for (int64_t k = 0; k < 3 * e->sites; k++) {
    const real *w = e->w + 3 * (k / 3), kept = v[k], unit = sqrtl(dot(w, w));
    real most[SITES] = {0};
    for (int sign = -1; sign < 2; sign += 2) {
      v[k] = kept + sign * 0x1p-50L * unit;
      map(e, e->h, v, y, spare);
      for (int64_t i = 0; i < e->sites; i++) {
        const real d[3] = {y[3 * i] - x[3 * i], y[3 * i + 1] - x[3 * i + 1], y[3 * i + 2] - x[3 * i + 2]};
        const real moved = sqrtl(dot(d, d)) * 0x1p50L;
        if (!(moved <= most[i])) most[i] = moved == moved ? moved : INFINITY;
      }
    }
    v[k] = kept;
    for (int64_t i = 0; i < e->sites; i++) size[i] += most[i];
  }
}

/* The same for the levels of Nambu factors: near its cone C(w) = w.n/2 is a difference of large terms. */
static void sensitive_levels(equation *e, real *u, real *size) {
  real x[3 * SITES], y[3 * SITES], spare[SITES], n[3];
  increment(e, e->h, u, x, spare);
  for (int64_t i = 0; i < e->sites; i++) {
    if (e->kind[i] != ON_NAMBU || e->method != SPHERICAL) continue;
    const real *w = e->w + 3 * i, kept = e->level[i];
    normal(e, i, w, n);
    e->level[i] = kept + 0x1p-50L * sqrtl(dot(w, w) * dot(n, n));
    increment(e, e->h, u, y, spare);
    e->level[i] = kept;
    const real d[3] = {y[3 * i] - x[3 * i], y[3 * i + 1] - x[3 * i + 1], y[3 * i + 2] - x[3 * i + 2]};
    const real moved = sqrtl(dot(d, d)) * 0x1p50L;
    size[i] += moved == moved ? moved : INFINITY;
  }
}

/* The same for W: near a fold, with W near -w or a field of large derivatives, no W of this precision leaves less. And for
 * the point m where the field is taken: of two vortices at the distance l the formula itself loses 1/l^2. */
static void sensitivity(equation *e, real *u, real *size) {
  real m[3 * SITES];
  midpoints(e, u, m);
  sensitive(e, increment, u, size);
  sensitive(e, product, m, size);
  sensitive_levels(e, u, size);
}

/* ---- the branch from h = 0 ---------------------------------------------------------------- */

/* Gauss elimination with partial pivoting: x = A^-1 x. Returns the sign of det A, 0 when singular. */
static int eliminate(int n, real (*A)[3 * SMALL], real *x, real *y) {
  int sign = 1;
  for (int c = 0; c < n; c++) {
    int p = c;
    for (int i = c + 1; i < n; i++)
      if (fabsl(A[i][c]) > fabsl(A[p][c])) p = i;
    if (!(fabsl(A[p][c]) > 0)) return 0;
    for (int j = 0; p != c && j < n; j++) {
      const real t = A[p][j];
      A[p][j] = A[c][j], A[c][j] = t;
    }
    if (p != c) {
      real t = x[p];
      x[p] = x[c], x[c] = t, t = y[p], y[p] = y[c], y[c] = t, sign = -sign;
    }
    if (A[c][c] < 0) sign = -sign;
    for (int i = c + 1; i < n; i++) {
      const real l = A[i][c] / A[c][c];
      for (int j = c; j < n; j++) A[i][j] -= l * A[c][j];
      x[i] -= l * x[c], y[i] -= l * y[c];
    }
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++) x[i] -= A[i][j] * x[j], y[i] -= A[i][j] * y[j];
    x[i] /= A[i][i], y[i] /= A[i][i];
  }
  return sign;
}

/* |mbar| of a site, by which differences must be small where W is near -w; never 0. */
static real midpoint_size(const equation *e, int64_t i, const real *u) {
  const real *w = e->w + 3 * i;
  const real mbar[3] = {w[0] + u[3 * i] / 2, w[1] + u[3 * i + 1] / 2, w[2] + u[3 * i + 2] / 2};
  return sqrtl(dot(mbar, mbar)) + 1e-7L * sqrtl(dot(w, w)) + 1e-25L * largest(e->w, 3 * e->sites);
}

/* One Newton iteration of F(u) = 0, the Jacobian by differences. `along` becomes h du/dh.
 * Returns the size of the change, or -1 where det J <= 0 or a value is not finite. */
static real newton(const equation *e, real h, real *u, real *along) {
  const int n = 3 * (int)e->sites;
  static real J[3 * SMALL][3 * SMALL];
  real x[3 * SITES], moved[3 * SITES], size[SITES], r[3 * SMALL];
  increment(e, h, u, x, size);
  for (int j = 0; j < n; j++) {
    const real kept = u[j], d = 1e-9L * midpoint_size(e, j / 3, u);
    u[j] += d;
    increment(e, h, u, moved, size);
    u[j] = kept;
    for (int i = 0; i < n; i++) J[i][j] = (i == j) - (moved[i] - x[i]) / d;
  }
  for (int i = 0; i < n; i++) r[i] = x[i] - u[i], along[i] = x[i];
  if (!(largest(r, n) < LDBL_MAX) || eliminate(n, J, r, along) <= 0) return -1;
  for (int i = 0; i < n; i++) u[i] += r[i];
  return largest(r, n);
}

/* Newton at s*h from the guess u; 1 when it contracts at once, so that no other branch is met. */
static int corrected(const equation *e, real s, real *u, real *along, int *spent) {
  const real size = largest(e->w, 3 * e->sites);
  real last = INFINITY;
  for (int it = 0; it < 7; it++) {
    ++*spent;
    const real change = newton(e, s * e->h, u, along);
    if (!(change >= 0) || (it == 0 && change > 0.02L * size) || (it > 0 && change > last / 4 && change > 1e-14L * size))
      return 0;
    if (change <= 1e-15L * size) return 1;
    last = change;
  }
  return 0;
}

/* A walk along the branch from *s to the end `to`, in steps that adapt: 1. 0 when it ends before in a fold, where du/dh
 * grows without bound; -1 when it cannot tell. */
static int walk(const equation *e, real *u, real *along, real *s, real to, real step) {
  const int64_t n = 3 * e->sites;
  const real sign = to > *s ? 1 : -1, size = largest(e->w, n);
  int spent = 0;
  while (spent < EFFORT && sign * (to - *s) > 0 && step > 1e-13L * *s) {
    const real next = sign * (to - *s) > step ? *s + sign * step : to, rise = *s > 0 ? (next - *s) / *s : next;
    real guess[3 * SITES], slope[3 * SITES];
    for (int64_t q = 0; q < n; q++) guess[q] = u[q] + rise * along[q];
    if (corrected(e, next, guess, slope, &spent)) {
      memcpy(u, guess, sizeof(real) * (size_t)n), memcpy(along, slope, sizeof(real) * (size_t)n);
      *s = next, step *= 2;
    } else
      step /= 2;
  }
  if (!(sign * (to - *s) > 0)) return 1;
  for (int64_t i = 0; i < e->sites; i++)
    if (midpoint_size(e, i, u) < 1e-4L * size) return -1; /* W near -w: no differences are taken there */
  return spent < EFFORT && largest(along, n) > 100 * size ? 0 : -1;
}

/* The solution at h that the branch from u = 0, h = 0 leads to; *s: how far it goes. */
static int follow(const equation *e, real *u, real *s) {
  real along[3 * SITES] = {0}, size[SITES], step = 0.0625L;
  memset(u, 0, sizeof(real) * (size_t)(3 * e->sites));
  increment(e, e->h, u, along, size);
  if (!(largest(along, 3 * e->sites) < LDBL_MAX)) return 0;
  while (step * largest(along, 3 * e->sites) > 0.05L * largest(e->w, 3 * e->sites)) step /= 2;
  *s = 0;
  return walk(e, u, along, s, 1, step);
}

/* Does the branch through the solution u of h lead back to u = 0? It must where h is so small that u is the only one. */
static int leads_back(const equation *e, const real *solution) {
  const int64_t n = 3 * e->sites;
  real u[3 * SITES], along[3 * SITES], rest[3 * SITES] = {0}, size[SITES], s = 1;
  int spent = 0;
  memcpy(u, solution, sizeof(real) * (size_t)n);
  increment(e, e->h, rest, along, size);
  const real end = fminl(0.5L, 1e-3L * largest(e->w, n) / largest(along, n));
  if (!corrected(e, 1, u, along, &spent)) return -1;
  const int found = walk(e, u, along, &s, end, 0.0625L);
  return found <= 0 ? found : largest(u, n) < 0.1L * largest(e->w, n);
}

#endif
