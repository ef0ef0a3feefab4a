/* What a generator can emit for one sphere: nothing here knows the rigid body but the kernels `field` and
 * `turn`. Unknowns u = W - w and q = 1/|S|, S = w + W; m = q S; the step equation u = h X(m), X = m x b(m).
 *
 *   predict   u and q by extrapolation of degree DEGREE from the last steps
 *   Newton    q <- q (3 - |S|^2 q^2)/2;  (1 - E) d = h X(m) - u,  E = h q DX(m) (1 - m m^T);  u <- u + d
 *   verify    u <- h X(m) once more: W must not change by more than one unit in its last place
 *   branch    E m = 0, so the other eigenvalues of T = 1 - E have the sum tr T - 1 and the product det T;
 *             det T > 0 and tr T > 1 leave no real one <= 0; else the slow path decides exactly
 *   commit    W = w + (u + carry) */
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
  double w[3], carry[3];
  double last[4], before[4], older[4];
  int64_t k, count;
  smg_report report;
  double u[ROWS][4];
} generic;

/* b(m) = (1/kappa) dH/dm */
ALWAYS void field(const body_params *p, const double m[3], double b[3]) {
  b[0] = p->inverse_moment[0] * m[0], b[1] = p->inverse_moment[1] * m[1], b[2] = p->inverse_moment[2] * m[2];
}

/* DX(m) = -[b]_x + [m]_x B, B = Db diagonal here: the zero terms are left out by the generator. */
ALWAYS void turn(const body_params *p, const double m[3], const double b[3], double D[9]) {
  const double *B = p->inverse_moment;
  D[0] = 0, D[1] = b[2] - m[2] * B[1], D[2] = m[1] * B[2] - b[1];
  D[3] = m[2] * B[0] - b[2], D[4] = 0, D[5] = b[0] - m[0] * B[2];
  D[6] = b[1] - m[1] * B[0], D[7] = m[0] * B[1] - b[0], D[8] = 0;
}

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

/* The two newest rows by component: a wide load of what was just stored by halves would have to wait. */
ALWAYS void predict(generic *s, double u[4]) {
  const double(*q)[4] = s->u + s->k;
  const double *c = weights[DEGREE];
  double a[4];
  for (int i = 0; i < 4; i++) a[i] = c[DEGREE] * q[DEGREE][i];
  for (int j = DEGREE - 1; j >= 2; j--)
    for (int i = 0; i < 4; i++) a[i] += c[j] * q[j][i];
  for (int i = 0; i < 4; i++) s->older[i] = a[i];
  for (int i = 0; i < 4; i++) u[i] = (s->older[i] + c[1] * s->before[i]) + c[0] * s->last[i];
}

/* m = q S after one step of Newton's inverse square root; v = h X(m). Returns the new q. */
ALWAYS double image(const generic *s, const double u[3], double q, double m[3], double b[3], double v[3]) {
  const double *w = s->w, h = s->p.h;
  const double S0 = 2 * w[0] + u[0], S1 = 2 * w[1] + u[1], S2 = 2 * w[2] + u[2];
  const double f = 1.5 - (S0 * S0 + S1 * S1 + S2 * S2) * (.5 * q * q);
  q *= f;
  m[0] = S0 * q, m[1] = S1 * q, m[2] = S2 * q;
  field(&s->p, m, b);
  v[0] = h * (m[1] * b[2] - m[2] * b[1]);
  v[1] = h * (m[2] * b[0] - m[0] * b[2]);
  v[2] = h * (m[0] * b[1] - m[1] * b[0]);
  return q;
}

/* u <- u + (1 - E)^-1 r; det and trace of 1 - E for the branch. */
ALWAYS void newton(const generic *s, double q, const double m[3], const double b[3], const double r[3], double u[3],
                   double *det, double *trace) {
  const double g = s->p.h * q;
  double D[9];
  turn(&s->p, m, b, D);
  const double e0 = g * (D[0] * m[0] + D[1] * m[1] + D[2] * m[2]), e1 = g * (D[3] * m[0] + D[4] * m[1] + D[5] * m[2]),
               e2 = g * (D[6] * m[0] + D[7] * m[1] + D[8] * m[2]);
  const double a00 = 1 - (g * D[0] - e0 * m[0]), a01 = e0 * m[1] - g * D[1], a02 = e0 * m[2] - g * D[2];
  const double a10 = e1 * m[0] - g * D[3], a11 = 1 - (g * D[4] - e1 * m[1]), a12 = e1 * m[2] - g * D[5];
  const double a20 = e2 * m[0] - g * D[6], a21 = e2 * m[1] - g * D[7], a22 = 1 - (g * D[8] - e2 * m[2]);
  const double c0 = a11 * a22 - a12 * a21, c1 = a12 * a20 - a10 * a22, c2 = a10 * a21 - a11 * a20;
  *det = a00 * c0 + (a01 * c1 + a02 * c2), *trace = a00 + a11 + a22;
  const double i = 1 / *det;
  u[0] += i * (c0 * r[0] + ((a02 * a21 - a01 * a22) * r[1] + (a01 * a12 - a02 * a11) * r[2]));
  u[1] += i * (c1 * r[0] + ((a00 * a22 - a02 * a20) * r[1] + (a02 * a10 - a00 * a12) * r[2]));
  u[2] += i * (c2 * r[0] + ((a01 * a20 - a00 * a21) * r[1] + (a00 * a11 - a01 * a10) * r[2]));
}

ALWAYS void commit(generic *s, const double W[3], const double y[3], const double v[3], double q) {
  if (s->k == 0) {
    memcpy(s->u + ROWS - DEGREE, s->u, sizeof *s->u * DEGREE);
    s->k = ROWS - DEGREE;
  }
  double *row = s->u[--s->k];
  for (int i = 0; i < 3; i++) {
    s->carry[i] = y[i] - (W[i] - s->w[i]);
    s->w[i] = W[i];
    s->before[i] = s->last[i];
    s->last[i] = row[i] = v[i];
  }
  s->before[3] = s->last[3], s->last[3] = row[3] = q;
  s->count++;
}

ALWAYS double larger(double a, double b) { return a > b ? a : b; }

/* det and trace of T = 1 - E: has the pair of other eigenvalues a real member <= 0? */
static int wrong_branch(double det, double trace) {
  const double sum = trace - 1;
  return !(det > 0) || (sum <= 0 && sum * sum >= 4 * det);
}

/* Near a zero of W_i one unit of W_i lies below the round-off of u_i, and u may alternate between neighbours
 * for ever: after a few tries a change of some units of u_i, relative to u_i, also counts as stagnation. */
#define TRIES 4
#define UNITS (8 * DBL_EPSILON)

/* u <- v where the residual r = v - u is round-off of u, else a Newton iteration. */
static void improve(const generic *s, double q, const double m[3], const double b[3], const double v[3], double u[3],
                    double *det, double *trace) {
  const double r[3] = {v[0] - u[0], v[1] - u[1], v[2] - u[2]};
  const double size = larger(fabs(r[0]), larger(fabs(r[1]), fabs(r[2])));
  const double scale = larger(fabs(v[0]), larger(fabs(v[1]), fabs(v[2])));
  newton(s, q, m, b, r, u, det, trace);
  if (size <= 64 * DBL_EPSILON * scale) memcpy(u, v, 3 * sizeof *u);
}

/* Newton from u to stagnation with honest square roots: the first steps, hard steps, failures. */
__attribute__((noinline, cold)) static smg_status slow(generic *s, double u[3], int evaluations) {
  double m[3], b[3], v[3], y[3], V[3], det, trace;
  for (int k = evaluations; k < CAP; k++) {
    const double S0 = 2 * s->w[0] + u[0], S1 = 2 * s->w[1] + u[1], S2 = 2 * s->w[2] + u[2];
    const double q = image(s, u, 1 / sqrt(S0 * S0 + S1 * S1 + S2 * S2), m, b, v);
    int done = 1;
    double change = 0;
    for (int i = 0; i < 3; i++) {
      y[i] = v[i] + s->carry[i], V[i] = s->w[i] + y[i];
      const double d = fabs(V[i] - (s->w[i] + (u[i] + s->carry[i])));
      done &= d <= DBL_EPSILON * fabs(V[i]) || (k > evaluations + TRIES && d <= UNITS * fabs(v[i]));
      change = larger(d, change);
      if (!(fabs(v[i]) <= DBL_MAX)) return s->report.status = SMG_NOT_FINITE;
    }
    s->report.iterations = k + 1, s->report.residual = change;
    improve(s, q, m, b, v, u, &det, &trace);
    if (!done) continue;
    if (wrong_branch(det, trace)) return s->report.status = SMG_WRONG_BRANCH;
    commit(s, V, y, v, q);
    return s->report.status = SMG_OK;
  }
  return s->report.status = SMG_NO_CONVERGENCE;
}

STEP smg_status PASTE(generic_step_, DEGREE)(generic *s) {
  double p[4], u[3] = {0, 0, 0}, v[3], m[3], b[3], y[3], U[3], V[3], d[3], det, trace;
  if (s->count <= DEGREE) return slow(s, u, 0);
  predict(s, p);
  double q = image(s, p, p[3], m, b, v);
  const double r[3] = {v[0] - p[0], v[1] - p[1], v[2] - p[2]};
  for (int i = 0; i < 3; i++) u[i] = p[i];
  newton(s, q, m, b, r, u, &det, &trace);
  q = image(s, u, q, m, b, v);
  int same = 1;
  for (int i = 0; i < 3; i++) {
    U[i] = s->w[i] + (u[i] + s->carry[i]);
    y[i] = v[i] + s->carry[i], V[i] = s->w[i] + y[i];
    d[i] = fabs(V[i] - U[i]);
    same = same && d[i] <= DBL_EPSILON * fabs(V[i]);
  }
  const double change = larger(d[0], larger(d[1], d[2]));
  if (!(same && det > .125 && trace > 1.125 && change <= DBL_MAX)) return slow(s, v, 2);
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
}
void PASTE(generic_steps_, DEGREE)(void *state, int64_t n) {
  generic *s = (generic *)state;
  for (int64_t i = 0; i < n; i++)
    if (PASTE(generic_step_, DEGREE)(s)) return;
}
