/* What a generator can emit for one sphere. Nothing here knows the rigid body but three kernels, which follow from
 * b = (1/kappa) dH/dw by symbolic differentiation: hX = h m x b(m), its derivative, and e = h DX(m)m.
 * Unknowns: u = W - w and q = 1/|S|, S = w + W = 2w + u; m = q S; the step equation is u = h X(m).
 *
 * Newton. With g = h X(m) + eps e, eps = (1 - q^2 |S|^2)/2, the linearised pair is
 *     (1 - E) d = g - u,   E = M (1 - m m^T),   M = h q DX(m),   q <- q (1 + eps - q m.d).
 * As m.X = 0 and div X = 0: m.M v = -q g.v, tr E = 0, E m = 0. With a = (1 - m m^T)(g - u):
 *     E (g - u) = M a =: c,   E c = M c + q^2 (g.a) e,   det(1 - E) = 1 + e2(M) - q^2 g.e,
 * e2 the sum of the principal 2 x 2 minors, and by Cayley and Hamilton (1 - E)^-1 = 1 + (E + E^2)/det(1 - E):
 * no matrix is factored. The eigenvalues of T = 1 - E are 1 and 1 +- sqrt(-e2(E)), so that T has a real one
 * <= 0 exactly when det T <= 0: that is the branch check.
 * Then u <- h X(m) once more, which must not change W by more than one unit in its last place. */
#include "body.h"
#include "smidgen.h"

#ifndef STEP
#define STEP __attribute__((noinline)) static
#endif
#define ALWAYS static inline __attribute__((always_inline))
#ifndef DEGREE
#define DEGREE 6
#endif
#define PASTE_(a, b) a##b
#define PASTE(a, b) PASTE_(a, b)

typedef struct generic {
  body_params p;
  double w[3], compensation[3];
  double constant[3], older[4];
  int64_t k;
  smg_report report;
  double u[ROWS][4];
} generic;

/* Three components by value: they stay in registers, and are never stored by halves and loaded whole. */
typedef struct vec {
  double x, y, z;
} vec;
ALWAYS vec load(const double *w) { return (vec){w[0], w[1], w[2]}; }
ALWAYS vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
ALWAYS vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
ALWAYS vec scale(double c, vec a) { return (vec){c * a.x, c * a.y, c * a.z}; }
ALWAYS double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ALWAYS double larger(double a, double b) { return a > b ? a : b; }
ALWAYS double largest(vec a) { return larger(fabs(a.x), larger(fabs(a.y), fabs(a.z))); }

/* h X(m), X = m x b(m); what depends on parameters and h alone is formed once, at the start. */
ALWAYS vec motion(const generic *s, vec m) {
  const double *D = s->constant;
  return (vec){D[0] * (m.y * m.z), D[1] * (m.z * m.x), D[2] * (m.x * m.y)};
}

/* e = h DX(m)m, from g = h X(m): X has degree two here, and the generator finds e = 2 g. */
ALWAYS vec radial(const generic *s, vec m, vec g) {
  (void)s, (void)m;
  return add(g, g);
}

/* M = c h DX(m): the generator leaves out what is zero, here the diagonal. */
typedef struct matrix {
  double xy, xz, yx, yz, zx, zy;
} matrix;
ALWAYS matrix derivative(const generic *s, vec m, double c) {
  const double *D = s->constant, x = c * D[0], y = c * D[1], z = c * D[2];
  return (matrix){x * m.z, x * m.y, y * m.z, y * m.x, z * m.y, z * m.x};
}
ALWAYS vec apply(matrix M, vec v) {
  return (vec){M.xy * v.y + M.xz * v.z, M.yx * v.x + M.yz * v.z, M.zx * v.x + M.zy * v.y};
}
ALWAYS double minors(matrix M) { return -(M.xy * M.yx + M.xz * M.zx + M.yz * M.zy); }

/* Row p: u_{n+1} = sum_j (-1)^j C(p+1, j+1) u_{n-j} */
static const double weights[9][9] = {{1},
                                     {2, -1},
                                     {3, -3, 1},
                                     {4, -6, 4, -1},
                                     {5, -10, 10, -5, 1},
                                     {6, -15, 20, -15, 6, -1},
                                     {7, -21, 35, -35, 21, -7, 1},
                                     {8, -28, 56, -70, 56, -28, 8, -1},
                                     {9, -36, 84, -126, 126, -84, 36, -9, 1}};

/* Rows older than two steps in pairs of lanes, through memory; the two newest by component. */
ALWAYS vec predict(generic *s, double *q) {
  double(*const row)[4] = s->u + s->k;
  const double *c = weights[DEGREE], *l = row[0], *b = row[1], *t = s->older;
  double a[4];
  for (int i = 0; i < 4; i++) a[i] = c[DEGREE] * row[DEGREE][i];
  for (int j = DEGREE - 1; j >= 2; j--)
    for (int i = 0; i < 4; i++) a[i] += c[j] * row[j][i];
  for (int i = 0; i < 4; i++) s->older[i] = a[i];
  *q = (t[3] + c[1] * b[3]) + c[0] * l[3];
  return (vec){(t[0] + c[1] * b[0]) + c[0] * l[0], (t[1] + c[1] * b[1]) + c[0] * l[1], (t[2] + c[1] * b[2]) + c[0] * l[2]};
}

ALWAYS vec sum(vec w, vec u) { return (vec){2 * w.x + u.x, 2 * w.y + u.y, 2 * w.z + u.z}; }

/* One Newton iteration from (u, q); returns the new u, det T, and the square of the change. The new q is off by
 * an eighth of that square: below SMALL it is as good as rounded. */
#define SMALL DBL_EPSILON
ALWAYS vec newton(const generic *s, vec w, vec u, double *inverse, double *det, double *size) {
  const double q = *inverse;
  const vec S = sum(w, u), m = scale(q, S), g0 = motion(s, m), e = radial(s, m, g0);
  const double eps = .5 - dot(S, S) * (.5 * q * q), mu = dot(m, u);
  const matrix M = derivative(s, m, q);
  const double t = 1 + (minors(M) - (q * q) * dot(g0, e)), i = 1 / t;
  const vec g = add(g0, scale(eps, e)), a = add(g, sub(scale(mu, m), u)), c = apply(M, a), d = apply(M, c);
  const double ga = dot(g, a), gc = dot(g, c), l = (q * q) * ga;
  *inverse = (q + q * (eps + q * mu)) + (q * q * (q * i)) * (ga + gc);
  *det = t, *size = dot(a, a) + eps * eps;
  return add(g, scale(i, add(c, add(d, scale(l, e)))));
}

/* h X(m), m = q S */
ALWAYS vec image(const generic *s, vec S, double q) { return motion(s, scale(q, S)); }

ALWAYS void commit(generic *s, vec W, vec y, vec v, double q) {
  if (s->k == 0) {
    memcpy(s->u + ROWS - DEGREE, s->u, sizeof *s->u * DEGREE);
    s->k = ROWS - DEGREE;
  }
  double *row = s->u[--s->k];
  s->compensation[0] = y.x - (W.x - s->w[0]), s->compensation[1] = y.y - (W.y - s->w[1]), s->compensation[2] = y.z - (W.z - s->w[2]);
  s->w[0] = W.x, s->w[1] = W.y, s->w[2] = W.z;
  row[0] = v.x, row[1] = v.y, row[2] = v.z, row[3] = q;
}

/* Near a zero of W_i one unit of W_i lies below the round-off of u_i, and u may alternate between neighbours
 * for ever: after a few tries a change of some units of u_i, relative to u_i, also counts as stagnation. */
#define TRIES 4
#define UNITS (8 * DBL_EPSILON)

ALWAYS int within(double d, double V, double v, int late) {
  return d <= DBL_EPSILON * fabs(V) || (late && d <= UNITS * fabs(v));
}

/* Newton from u to stagnation with honest square roots: the first steps, hard steps, failures.
 * Where the residual v - u is round-off of u, v itself is tried in turn with Newton. */
__attribute__((noinline, cold)) static smg_status slow(generic *s, vec u, int evaluations, double det, int known) {
  const vec w = load(s->w), compensation = load(s->compensation);
  for (int k = evaluations; k < CAP; k++) {
    const vec S = sum(w, u);
    double q = 1 / sqrt(dot(S, S));
    const vec v = image(s, S, q), y = add(v, compensation), V = add(w, y), d = sub(v, u);
    if (!(fabs(v.x) + fabs(v.y) + fabs(v.z) <= DBL_MAX)) return s->report.status = SMG_NOT_FINITE;
    const int late = k > evaluations + TRIES;
    const int done = within(fabs(d.x), V.x, v.x, late) & within(fabs(d.y), V.y, v.y, late) & within(fabs(d.z), V.z, v.z, late);
    s->report.iterations = k + 1, s->report.residual = largest(d);
    if (done && known) {
      if (!(det > 0)) return s->report.status = SMG_WRONG_BRANCH;
      commit(s, V, y, v, q);
      return s->report.status = SMG_OK;
    }
    double next = q, size;
    const int settled = largest(sub(v, u)) <= 64 * DBL_EPSILON * largest(v);
    const vec n = newton(s, w, u, &next, &det, &size);
    known = 1, u = settled && k % 2 ? v : n;
  }
  return s->report.status = SMG_NO_CONVERGENCE;
}

STEP smg_status PASTE(generic_step_, DEGREE)(generic *s) {
  const vec w = load(s->w), compensation = load(s->compensation);
  double q, det, size;
  const vec p = predict(s, &q), u = newton(s, w, p, &q, &det, &size), v = image(s, sum(w, u), q);
  const vec y = add(v, compensation), V = add(w, y);
  const double dx = fabs(v.x - u.x), dy = fabs(v.y - u.y), dz = fabs(v.z - u.z), change = dx + dy + dz;
  if (!(det > .125 && size < SMALL)) return slow(s, size < .01 ? u : (vec){0, 0, 0}, 1, 0, 0);
  if (!(dx <= DBL_EPSILON * fabs(V.x) && dy <= DBL_EPSILON * fabs(V.y) && dz <= DBL_EPSILON * fabs(V.z) && change <= DBL_MAX))
    return slow(s, v, 2, det, 1);
  commit(s, V, y, v, q);
  s->report.iterations = 2, s->report.residual = change;
  return s->report.status = SMG_OK;
}

void PASTE(generic_start_, DEGREE)(void *state, const body_params *p, const double w[3]);
void PASTE(generic_steps_, DEGREE)(void *state, int64_t n);
void PASTE(generic_start_, DEGREE)(void *state, const body_params *p, const double w[3]) {
  generic *s = (generic *)state;
  memset(s, 0, sizeof *s);
  s->p = *p, s->k = ROWS - DEGREE - 1;
  memcpy(s->w, w, sizeof s->w);
  for (int i = 0; i < 3; i++) s->constant[i] = p->h * (p->inverse_moment[(i + 2) % 3] - p->inverse_moment[(i + 1) % 3]);
}
void PASTE(generic_steps_, DEGREE)(void *state, int64_t n) {
  generic *s = (generic *)state;
  for (int64_t i = 0; i < n; i++)
    if (PASTE(generic_step_, DEGREE)(s)) return;
}
