/* smidgen runtime: systems A x = b by the products A x alone.
 *
 * GMRES with restarts (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986): the residual b - A x is made least over
 * the Krylov space of b, by an orthonormal basis V of it (modified Gram-Schmidt), A V = V H, and Givens rotations that
 * make H triangular. Systems of up to SMG_KRYLOV_WHOLE unknowns keep a basis of SMG_KRYLOV_BASIS vectors, larger ones
 * one of SMG_KRYLOV_SHORT. */
#ifndef SMG_KRYLOV_H
#define SMG_KRYLOV_H

#include "smg_arrays.h"
#include "smg_dense.h"

#define SMG_KRYLOV_BASIS 60
#define SMG_KRYLOV_SHORT 10
#define SMG_KRYLOV_WHOLE 20000  /* with the long basis 10 MB of doubles */
#define SMG_KRYLOV_PRODUCTS 400 /* products before a system is given up; half or twice: nothing changes */
/* products that the iterations of a step may take together: with the sweeps before, 60 Newton iterations and what one
 * more basis or Lanczos takes, some 1500 evaluations of all sites at most. The curve, and tangent maps, have no such
 * bound */
#define SMG_KRYLOV_A_STEP 600
#define SMG_KRYLOV_LEFT (1000 * SMG_EPS) /* of b, that round-off may leave */
/* unknowns up to which the sign of det A is asked of elimination: 7e7 products, 3 MB of doubles */
#define SMG_KRYLOV_DENSE 600
#define SMG_LANCZOS_STEPS 40            /* these two: see smg_krylov_coercive; half or twice: the same */
#define SMG_LANCZOS_PART (smg_real)0.05 /* of the spread of the eigenvalues, that the least Ritz value may miss */

/* A of n unknowns; `times` puts A x into y. work: smg_krylov_worksize(n) numbers. */
typedef struct smg_krylov {
  void *of;
  void (*times)(void *of, const smg_real *x, smg_real *y);
  int64_t n;
  smg_real *work;
} smg_krylov;

/* Vectors of the basis; no more than there are unknowns. */
static inline int smg_krylov_basis(int64_t n) {
  const int most = n <= SMG_KRYLOV_WHOLE ? SMG_KRYLOV_BASIS : SMG_KRYLOV_SHORT;
  return n < most ? (int)n : most;
}

/* The basis and one more vector of it, b, and x; or a matrix and a vector; after them how many products are left. */
static inline size_t smg_krylov_worksize(int64_t n) {
  const int64_t vectors = smg_krylov_basis(n) + 3;
  return (size_t)((n <= SMG_KRYLOV_DENSE && n >= vectors ? n + 1 : vectors) * n + 1);
}

static inline smg_real smg_krylov_dot(int64_t n, const smg_real *a, const smg_real *b) {
  smg_real sum = 0;
  for (int64_t k = 0; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

/* v becomes a vector of length 1, unless it is 0; its length before. */
static inline smg_real smg_krylov_unit(int64_t n, smg_real *v) {
  const smg_real length = SMG_MATH(sqrt)(smg_krylov_dot(n, v, v));
  if (length > 0) smg_divide(v, length, n);
  return length;
}

/* The upper triangle of H by columns, its right-hand side, and the rotations that made it so. */
typedef struct smg_krylov_small {
  smg_real H[SMG_KRYLOV_BASIS][SMG_KRYLOV_BASIS + 1], rhs[SMG_KRYLOV_BASIS + 1], cosine[SMG_KRYLOV_BASIS],
      sine[SMG_KRYLOV_BASIS];
} smg_krylov_small;

/* v = A V_j made orthogonal to V_0 .. V_j; the coefficients are column j of H. */
static inline void smg_krylov_extend(const smg_krylov *a, smg_real *V, int j, smg_real *column) {
  const int64_t n = a->n;
  smg_real *v = V + (j + 1) * n;
  a->times(a->of, V + j * n, v);
  for (int i = 0; i <= j; ++i) {
    column[i] = smg_krylov_dot(n, V + i * n, v);
    smg_axpy(v, -column[i], V + i * n, n);
  }
  column[j + 1] = smg_krylov_unit(n, v);
}

/* Rotates column j of H as those before it, and then its last entry away. */
static inline void smg_krylov_rotate(smg_krylov_small *q, int j) {
  smg_real *h = q->H[j];
  for (int i = 0; i < j; ++i) {
    const smg_real upper = h[i];
    h[i] = q->cosine[i] * upper + q->sine[i] * h[i + 1];
    h[i + 1] = q->cosine[i] * h[i + 1] - q->sine[i] * upper;
  }
  const smg_real size = SMG_MATH(sqrt)(h[j] * h[j] + h[j + 1] * h[j + 1]);
  q->cosine[j] = size > 0 ? h[j] / size : 1;
  q->sine[j] = size > 0 ? h[j + 1] / size : 0;
  h[j] = size;
  q->rhs[j + 1] = -q->sine[j] * q->rhs[j];
  q->rhs[j] *= q->cosine[j];
}

/* x += V y, H y = rhs, with the first `used` vectors; 0 where H is singular. */
static inline int smg_krylov_add(int64_t n, const smg_real *V, smg_krylov_small *q, int used, smg_real *x) {
  for (int i = used - 1; i >= 0; --i) {
    if (!(q->H[i][i] > 0)) return 0;
    q->rhs[i] /= q->H[i][i];
    for (int l = 0; l < i; ++l) q->rhs[l] -= q->H[i][l] * q->rhs[i];
  }
  for (int i = 0; i < used; ++i) smg_axpy(x, q->rhs[i], V + i * n, n);
  return 1;
}

/* x holds b and receives the solution, to a residual of `tolerance` times that of x = 0. Returns 0, or 1 where
 * it was not reached: A is singular to round-off, or too few products were allowed: no basis is begun after `limit`. */
static inline int smg_krylov_solve(const smg_krylov *a, smg_real *x, smg_real tolerance, smg_real limit) {
  const int64_t n = a->n;
  const int most = smg_krylov_basis(n);
  smg_real *V = a->work, *b = V + (most + 1) * n, *y = b + n;
  const smg_real unit = smg_most(x, n); /* b is solved for in units of its largest entry */
  smg_real last = SMG_MATH(sqrt)((smg_real)n);
  if (!(unit > 0)) return unit != unit;
  for (int64_t k = 0; k < n; ++k) b[k] = V[k] = x[k] / unit;
  smg_zero(y, n);
  const smg_real size = SMG_MATH(sqrt)(smg_krylov_dot(n, b, b)), goal = tolerance * size;
  smg_krylov_small q;
  for (int products = 0; products < limit; ++products) {
    int j = 0;
    q.rhs[0] = SMG_MATH(sqrt)(smg_krylov_dot(n, V, V));
    if (!(q.rhs[0] > goal) || !(q.rhs[0] <= last)) break; /* solved, or round-off */
    last = q.rhs[0] / 2;
    smg_divide(V, q.rhs[0], n);
    while (j < most && smg_abs(q.rhs[j]) > goal) {
      smg_krylov_extend(a, V, j, q.H[j]);
      smg_krylov_rotate(&q, j++);
    }
    products += j;
    if (!smg_krylov_add(n, V, &q, j, y)) return 1;
    a->times(a->of, y, V);
    smg_waxpy(V, -1, V, b, n);
  }
  smg_multiple(x, unit, y, n);
  return !(SMG_MATH(sqrt)(smg_krylov_dot(n, V, V)) <= smg_max(2 * goal, SMG_KRYLOV_LEFT * size));
}

/* v = a random vector of length 1, the same each time. */
static inline void smg_krylov_random(int64_t n, smg_real *v) {
  uint32_t random = 1;
  for (int64_t k = 0; k < n; ++k) {
    random = random * 1664525u + 1013904223u; /* a linear congruence, Knuth's constants */
    v[k] = (smg_real)(random >> 8) / 8388608 - 1;
  }
  (void)smg_krylov_unit(n, v);
}

/* Lanczos' matrix T, of which beta2 has the squares beside the diagonal: are all k Ritz values beyond the shift? Where
 * the pivots of T - shift are positive. */
static inline int smg_krylov_beyond(const smg_real *alpha, const smg_real *beta2, int k, smg_real shift) {
  smg_real pivot = 1;
  for (int j = 0; j < k && pivot > 0; ++j) pivot = alpha[j] - shift - (j > 0 ? beta2[j - 1] / pivot : 0);
  return pivot > 0;
}

/* Lanczos: is x.A x >= x.x/4 for all x, A symmetric with its eigenvalues within `spread` of 1? After k steps from a
 * random start of n components the least Ritz value exceeds the least eigenvalue by more than e (max - min) with a
 * chance of at most 1.648 sqrt(n) exp(-sqrt(e) (2k - 1)) (Kuczynski and Wozniakowski, SIAM J. Matrix Anal. Appl. 13,
 * 1992): 4e-8 sqrt(n) for SMG_LANCZOS_PART and SMG_LANCZOS_STEPS. Of fewer steps e is larger by as much as keeps that
 * chance; the first that shows it are the last. */
static inline int smg_krylov_coercive(const smg_krylov *a, smg_real spread) {
  const int64_t n = a->n;
  smg_real *v = a->work, *before = v + n, *next = v + 2 * n, beta = 0;
  smg_real alphas[SMG_LANCZOS_STEPS], beta2[SMG_LANCZOS_STEPS];
  smg_krylov_random(n, v);
  smg_zero(before, n);
  for (int j = 0; j < SMG_LANCZOS_STEPS && j < n; ++j) {
    a->times(a->of, v, next);
    const smg_real alpha = smg_krylov_dot(n, v, next);
    const smg_real fewer = (smg_real)(2 * SMG_LANCZOS_STEPS - 1) / (smg_real)(2 * j + 1),
                   e = SMG_LANCZOS_PART * 2 * spread;
    alphas[j] = alpha;
    if (!smg_krylov_beyond(alphas, beta2, j + 1, (smg_real)0.25 + e)) return 0;
    if (smg_krylov_beyond(alphas, beta2, j + 1, (smg_real)0.25 + e * fewer * fewer)) return 1;
    for (int64_t k = 0; k < n; ++k) next[k] -= alpha * v[k] + beta * before[k];
    beta = smg_krylov_unit(n, next);
    beta2[j] = beta * beta;
    if (!(beta > SMG_EPS)) break; /* an invariant subspace */
    smg_copy(before, v, n);
    smg_copy(v, next, n);
  }
  return 1;
}

/* The sign of det A, A with its mean (A + A^T)/2 within `spread` of 1: that is positive where the mean is. 0, not
 * known, where A is singular to round-off or there are more than SMG_KRYLOV_DENSE unknowns. */
static inline int smg_krylov_sign(const smg_krylov *a, const smg_krylov *mean, smg_real spread) {
  const int64_t n = a->n;
  if (spread < 1 || smg_krylov_coercive(mean, spread)) return 1;
  if (n > SMG_KRYLOV_DENSE) return 0;
  smg_real *A = a->work, *unit = A + n * n;
  int sign;
  smg_zero(unit, n);
  for (int64_t i = 0; i < n; ++i) { /* the columns of A, as rows */
    unit[i] = 1;
    a->times(a->of, unit, A + i * n);
    unit[i] = 0;
  }
  return smg_dense_factor(n, A, unit, &sign) ? 0 : sign;
}

#endif
