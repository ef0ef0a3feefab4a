/* Steps of a Heisenberg ferromagnet by the generated solver and by KINSOL of SUNDIALS, by turns: ns a spin and step, iterations, how far the state
 * of smidgen is from the others at the end, and by how much its energy a spin has changed.
 *
 * SOURCE: the model `cubic` of tests/bench/lattices.py; argv: h, steps of a turn, a file with w. KINSOL has the residual u - h X(P(w + u/2)), its
 * products with vectors and, one way, a preconditioner, the block of each site, all written by hand for this lattice; it begins with a polynomial through
 * the last increments, and ends at a residual of 1e-12. Debian compiles the library without optimisation, so operations on vectors, where most of its time would
 * go, are replaced by those below. */
#include SOURCE
#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <time.h>

enum { N = 20, SITES = N * N * N, NUMBERS = 3 * SITES, ROUNDS = 5, KEPT = 3 };
enum { BY_NEWTON, BY_NEWTON_WITH_BLOCKS, BY_ANDERSON, WAYS };

/* The state of a lattice by KINSOL; g, m, size: gradients, midpoints and |w + u/2| of the u last evaluated. */
typedef struct lattice {
  double h, w[NUMBERS], g[NUMBERS], m[NUMBERS], size[SITES], past[KEPT][NUMBERS];
  int taken;
  long iterations;
  void *kinsol;
  N_Vector u, ones;
  SUNContext context;
} lattice;

/* ---- operations on vectors ------------------------------------------------------------------- */

static double *of(N_Vector v) { return N_VGetArrayPointer(v); }
static void linear_sum(double a, N_Vector x, double b, N_Vector y, N_Vector z) {
  const double *p = of(x), *q = of(y);
  double *r = of(z);
  for (int k = 0; k < NUMBERS; ++k) r[k] = a * p[k] + b * q[k];
}
static void scale_by(double a, N_Vector x, N_Vector z) {
  const double *p = of(x);
  double *r = of(z);
  for (int k = 0; k < NUMBERS; ++k) r[k] = a * p[k];
}
static void products_of(N_Vector x, N_Vector y, N_Vector z) {
  const double *p = of(x), *q = of(y);
  double *r = of(z);
  for (int k = 0; k < NUMBERS; ++k) r[k] = p[k] * q[k];
}
static void quotients_of(N_Vector x, N_Vector y, N_Vector z) {
  const double *p = of(x), *q = of(y);
  double *r = of(z);
  for (int k = 0; k < NUMBERS; ++k) r[k] = p[k] / q[k];
}
static void constant(double c, N_Vector z) {
  double *r = of(z);
  for (int k = 0; k < NUMBERS; ++k) r[k] = c;
}

/* Sums and largest numbers in eight parts, so that the compiler uses lanes. */
static double dot_product(N_Vector x, N_Vector y) {
  const double *p = of(x), *q = of(y);
  double part[8] = {0}, sum = 0;
  for (int k = 0; k < NUMBERS; k += 8)
    for (int l = 0; l < 8; ++l) part[l] += p[k + l] * q[k + l];
  for (int l = 0; l < 8; ++l) sum += part[l];
  return sum;
}
static double weighted_norm(N_Vector x, N_Vector weights) {
  const double *p = of(x), *q = of(weights);
  double part[8] = {0}, sum = 0;
  for (int k = 0; k < NUMBERS; k += 8)
    for (int l = 0; l < 8; ++l) part[l] += p[k + l] * q[k + l] * p[k + l] * q[k + l];
  for (int l = 0; l < 8; ++l) sum += part[l];
  return sqrt(sum);
}
static double largest(N_Vector x) {
  const double *p = of(x);
  double part[8] = {0}, most = 0;
  for (int k = 0; k < NUMBERS; k += 8)
    for (int l = 0; l < 8; ++l) part[l] = part[l] > fabs(p[k + l]) ? part[l] : fabs(p[k + l]);
  for (int l = 0; l < 8; ++l) most = most > part[l] ? most : part[l];
  return most;
}

/* Copies of the vector have them too. */
static N_Vector new_vector(SUNContext context) {
  N_Vector v = N_VNew_Serial(NUMBERS, context);
  v->ops->nvlinearsum = linear_sum;
  v->ops->nvscale = scale_by;
  v->ops->nvprod = products_of;
  v->ops->nvdiv = quotients_of;
  v->ops->nvconst = constant;
  v->ops->nvdotprod = dot_product;
  v->ops->nvwl2norm = weighted_norm;
  v->ops->nvmaxnorm = largest;
  return v;
}

/* ---- the step equation ----------------------------------------------------------------------- */

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void cross(const double *a, const double *b, double *c) {
  for (int k = 0; k < 3; ++k) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* g = -(the sum of all neighbours), which is linear: of midpoints, or of their changes. */
static void fields(const double *m, double *g) {
  for (int z = 0; z < N; ++z)
    for (int y = 0; y < N; ++y)
      for (int x = 0; x < N; ++x) {
        const int beside[6] = {(x + 1) % N + N * (y + N * z), (x + N - 1) % N + N * (y + N * z), x + N * ((y + 1) % N + N * z),
                               x + N * ((y + N - 1) % N + N * z), x + N * (y + N * ((z + 1) % N)), x + N * (y + N * ((z + N - 1) % N))};
        double *sum = g + 3 * (x + N * (y + N * z));
        sum[0] = sum[1] = sum[2] = 0;
        for (int k = 0; k < 6; ++k)
          for (int i = 0; i < 3; ++i) sum[i] -= m[3 * beside[k] + i];
      }
}

static void midpoints(lattice *s, const double *u) {
  for (int i = 0; i < SITES; ++i) {
    double *m = s->m + 3 * i;
    for (int k = 0; k < 3; ++k) m[k] = s->w[3 * i + k] + 0.5 * u[3 * i + k];
    s->size[i] = sqrt(dot(m, m));
    for (int k = 0; k < 3; ++k) m[k] /= s->size[i];
  }
  fields(s->m, s->g);
}

/* h X(P(w + u/2)), and u less that. */
static int increments(N_Vector u, N_Vector to, void *context) {
  lattice *s = context;
  double *v = N_VGetArrayPointer(to);
  midpoints(s, N_VGetArrayPointer(u));
  for (int i = 0; i < SITES; ++i) {
    cross(s->m + 3 * i, s->g + 3 * i, v + 3 * i);
    for (int k = 0; k < 3; ++k) v[3 * i + k] *= s->h;
  }
  return 0;
}
static int residual(N_Vector u, N_Vector to, void *context) {
  increments(u, to, context);
  N_VLinearSum(1, u, -1, to, to);
  return 0;
}

/* dm = (ds - m (m.ds))/|s|, ds = v/2. */
static void change(const lattice *s, int i, const double *v, double *dm) {
  const double *m = s->m + 3 * i, along = dot(m, v);
  for (int k = 0; k < 3; ++k) dm[k] = 0.5 * (v[k] - along * m[k]) / s->size[i];
}

/* v - h (dm x g + m x dg) */
static int product(N_Vector v_, N_Vector to, N_Vector u, booleantype *fresh, void *context) {
  static double dm[NUMBERS], dg[NUMBERS];
  lattice *s = context;
  const double *v = N_VGetArrayPointer(v_);
  double *y = N_VGetArrayPointer(to);
  (void)u;
  *fresh = 0; /* the midpoints are those of the residual before */
  for (int i = 0; i < SITES; ++i) change(s, i, v + 3 * i, dm + 3 * i);
  fields(dm, dg);
  for (int i = 0; i < SITES; ++i) {
    double a[3], b[3];
    cross(dm + 3 * i, s->g + 3 * i, a);
    cross(s->m + 3 * i, dg + 3 * i, b);
    for (int k = 0; k < 3; ++k) y[3 * i + k] = v[3 * i + k] - s->h * (a[k] + b[k]);
  }
  return 0;
}

/* v = D^-1 v of one site, D the derivative with respect to itself: columns by change(), then Cramer's rule. */
static void undo(const lattice *s, int i, double *v) {
  double column[3][3], bc[3], ca[3], ab[3];
  for (int k = 0; k < 3; ++k) {
    double unit[3] = {0, 0, 0}, dm[3], turned[3];
    unit[k] = 1;
    change(s, i, unit, dm);
    cross(dm, s->g + 3 * i, turned);
    for (int l = 0; l < 3; ++l) column[k][l] = unit[l] - s->h * turned[l];
  }
  cross(column[1], column[2], bc);
  cross(column[2], column[0], ca);
  cross(column[0], column[1], ab);
  const double det = dot(column[0], bc), x[3] = {dot(bc, v) / det, dot(ca, v) / det, dot(ab, v) / det};
  for (int k = 0; k < 3; ++k) v[k] = x[k];
}
static int precondition(N_Vector u, N_Vector scale, N_Vector f, N_Vector fscale, N_Vector v, void *context) {
  double *x = N_VGetArrayPointer(v);
  (void)u, (void)scale, (void)f, (void)fscale;
  for (int i = 0; i < SITES; ++i) undo(context, i, x + 3 * i);
  return 0;
}

static int refused(int flag, const char *what) {
  const int bad = flag != KIN_SUCCESS && flag != KIN_INITIAL_GUESS_OK;
  if (bad) fprintf(stderr, "KINSOL: %s: %d\n", what, flag);
  return bad;
}

static int begin(lattice *s, int way, const double *w, double h) {
  s->h = h;
  s->taken = 0;
  s->iterations = 0;
  for (int k = 0; k < NUMBERS; ++k) s->w[k] = w[k];
  if (refused(SUNContext_Create(NULL, &s->context), "context")) return 0;
  s->u = new_vector(s->context);
  s->ones = new_vector(s->context);
  N_VConst(1, s->ones);
  s->kinsol = KINCreate(s->context);
  if (way == BY_ANDERSON && refused(KINSetMAA(s->kinsol, 5), "MAA")) return 0;
  if (refused(KINInit(s->kinsol, way == BY_ANDERSON ? increments : residual, s->u), "init")) return 0;
  KINSetUserData(s->kinsol, s);
  KINSetFuncNormTol(s->kinsol, 1e-12);
  KINSetScaledStepTol(s->kinsol, 1e-16);
  KINSetNumMaxIters(s->kinsol, 2000);
  KINSetMaxNewtonStep(s->kinsol, 1e6);
  if (way == BY_ANDERSON) return 1;
  const SUNLinearSolver gmres = SUNLinSol_SPGMR(s->u, way == BY_NEWTON ? SUN_PREC_NONE : SUN_PREC_RIGHT, 60, s->context);
  if (refused(KINSetLinearSolver(s->kinsol, gmres, NULL), "solver") || refused(KINSetJacTimesVecFn(s->kinsol, product), "products")) return 0;
  return way == BY_NEWTON || !refused(KINSetPreconditioner(s->kinsol, NULL, precondition), "preconditioner");
}

/* The polynomial through the last increments. */
static void extrapolate(const lattice *s, double *u) {
  static const double weight[KEPT + 1][KEPT] = {{0, 0, 0}, {1, 0, 0}, {2, -1, 0}, {3, -3, 1}};
  const double *a = weight[s->taken < KEPT ? s->taken : KEPT];
  for (int k = 0; k < NUMBERS; ++k) u[k] = a[0] * s->past[0][k] + a[1] * s->past[1][k] + a[2] * s->past[2][k];
}

static int step(lattice *s, int way) {
  double *u = N_VGetArrayPointer(s->u);
  long iterations = 0;
  extrapolate(s, u);
  if (refused(KINSol(s->kinsol, s->u, way == BY_ANDERSON ? KIN_FP : KIN_NONE, s->ones, s->ones), "solution")) return 0;
  KINGetNumNonlinSolvIters(s->kinsol, &iterations);
  s->iterations += iterations;
  for (int k = 0; k < NUMBERS; ++k) {
    s->past[2][k] = s->past[1][k];
    s->past[1][k] = s->past[0][k];
    s->past[0][k] = u[k];
    s->w[k] += u[k];
  }
  ++s->taken;
  return 1;
}

static double energy(const double *w) {
  static double g[NUMBERS];
  double sum = 0;
  fields(w, g);
  for (int i = 0; i < SITES; ++i) sum += 0.5 * dot(w + 3 * i, g + 3 * i);
  return sum / SITES;
}

int main(int argc, char **words) {
  static double w[NUMBERS];
  static lattice other[WAYS];
  smg_params p;
  smg_model model;
  cubic_state s;
  if (argc < 4) return 2;
  const double h = atof(words[1]);
  const int steps = atoi(words[2]);
  FILE *start = fopen(words[3], "rb");
  if (!start || fread(w, sizeof *w, NUMBERS, start) != NUMBERS) return 2;
  cubic_defaults(&p);
  if (cubic_model_init(&model, &p) != SMG_OK || cubic_init(&s, &model, malloc(cubic_memsize(&model)), w, 0, h) != SMG_OK) return 3;
  double least[WAYS + 1] = {1e9, 1e9, 1e9, 1e9}, apart = 0, energies = 0;
  for (int way = 0; way < WAYS; ++way)
    if (!begin(other + way, way, w, h)) return 4;
  for (int round = 0; round < ROUNDS; ++round) {
    double t = now();
    if (cubic_steps(&s, steps) != SMG_OK) return 5;
    if ((t = now() - t) < least[WAYS]) least[WAYS] = t;
    for (int way = 0; way < WAYS; ++way) {
      t = now();
      for (int k = 0; k < steps && least[way] > 0; ++k)
        if (!step(other + way, way)) least[way] = 0; /* it gives up */
      t = now() - t;
      if (t < least[way]) least[way] = t;
    }
  }
  for (int way = 0; way < WAYS; ++way)
    for (int k = 0; k < NUMBERS && least[way] > 0; ++k) apart = fmax(apart, fabs(s.w[k] - other[way].w[k]));
  energies = fabs(energy(s.w) - energy(w));
  printf("%.1f %d %d %.1e %.1e", least[WAYS] / steps / SITES * 1e9, s.rows, s.report.iterations, apart, energies);
  for (int way = 0; way < WAYS; ++way) printf(" %.1f %.1f", least[way] / steps / SITES * 1e9, (double)other[way].iterations / (steps * ROUNDS));
  printf("\n");
  return 0;
}
