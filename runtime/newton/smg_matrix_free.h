/* smidgen runtime: Newton's matrix by its products with vectors alone: the diagonal blocks D are stored, of the others
 * the row sums of their entries' sizes. J x = D x + G sum_j B_ij S_j^T x_j of each site; systems are solved by GMRES,
 * preconditioned by D. */
#ifndef SMG_MATRIX_FREE_H
#define SMG_MATRIX_FREE_H

#include "smg_krylov.h"
#include "smg_matrix_unkept.h"
#include "smg_midpoint.h"
#include "smg_rules.h"

/* of a Newton correction, relative: each iteration gains as many digits; half or twice: the same */
#define SMG_KRYLOV_TOLERANCE (smg_real)1e-5
#define SMG_KRYLOV_ROUNDOFF SMG_EPS /* of a column of the tangent map: to stagnation */
/* products with J that the iterations of this step may still take */
#define SMG_PRODUCTS_LEFT(s) (s)->work[smg_krylov_worksize(smg_order(s)) - 1]

static inline int64_t smg_order(const smg_state *s) { return SMG_BS * smg_coupled(&s->c); }

static inline void smg_clear(const smg_state *s) {
  smg_zero(s->A, SMG_BS * smg_order(s));
  smg_zero(s->sums, smg_order(s));
  smg_zero(s->mean, smg_order(s));
}

static inline void smg_add_block(const smg_state *s, int64_t row, int64_t column, const smg_real *block) {
  if (row == column) smg_block_add(s->A + SMG_BB * row, block);
  else smg_row_sums(SMG_BS, block, s->sums + SMG_BS * row);
}

/* J_ij += G_i B S_j^T for the Hessian block B of one term, y = B S_j^T. The same block of J^T is S_i B G_j^T, z = B
 * G_j^T, so that (J + J^T)/2 has half the sum of both. */
static inline void smg_add_hessian(const smg_state *s, int64_t i, int64_t j, const smg_real *y, const smg_real *z) {
  const int64_t row = smg_row(&s->c, i), column = smg_row(&s->c, j);
  smg_real block[SMG_BB], mirror[SMG_BB];
  smg_frame_block(s->G + 3 * SMG_BS * i, y, block);
  smg_add_block(s, row, column, block);
  if (i == j) return;
  smg_frame_block(s->S + 3 * SMG_BS * i, z, mirror);
  smg_block_add(mirror, block);
  smg_scale(mirror, (smg_real)0.5, SMG_BB);
  smg_row_sums(SMG_BS, mirror, s->mean + SMG_BS * row);
}

static inline void smg_assembled(const smg_state *s) {
  for (int64_t i = 0; i < smg_coupled(&s->c); ++i)
    smg_diagonal_sums(SMG_BS, s->A + SMG_BB * i, s->sums + SMG_BS * i, s->mean + SMG_BS * i);
}

/* x = U x, the rows of small sites as if they were as large as others: GMRES solves systems to a part of all of x, and
 * would leave those of spheres 1e-9 times as large as others to round-off of these. */
static inline void smg_enlarge(const smg_state *s, smg_real *x) {
  for (int64_t i = 0; i < smg_coupled(&s->c); ++i)
    smg_scale(x + SMG_BS * i, smg_site_up(s, smg_site(&s->c, i)), SMG_BS);
}

/* z = D^-1 U^-1 x with the diagonal block D of each site, or U^-1 x where it has no inverse. */
static void smg_undo_all(const smg_state *s, const smg_real *x, smg_real *z) {
  for (int64_t i = 0; i < smg_coupled(&s->c); ++i) {
    smg_multiple(z + SMG_BS * i, 1 / smg_site_up(s, smg_site(&s->c, i)), x + SMG_BS * i, SMG_BS);
    (void)smg_block_solve(s->A + SMG_BB * i, z + SMG_BS * i);
  }
}

/* y = J z, that is D z + G sum_j B_ij S_j^T z_j of each site; or J^T z, D^T z + S sum_j B_ij G_j^T z_j. */
static void smg_apply(const smg_state *s, int transposed, const smg_real *z, smg_real *y) {
  const smg_coefficients *c = &s->c;
  const smg_real *from = transposed ? s->G : s->S, *to = transposed ? s->S : s->G;
  SMG_PRODUCTS_LEFT(s) -= 1;
  const int across = transposed ? 1 : SMG_BS, down = transposed ? SMG_BS : 1;
  for (int64_t row = 0; row < smg_coupled(c); ++row) {
    const int64_t k = smg_site(c, row);
    smg_zero(s->hessian_v + 3 * k, 3);
    smg_zero(s->v + 3 * k, 3);
    for (int l = 0; l < SMG_BS; ++l) smg_axpy(s->v + 3 * k, z[SMG_BS * row + l], from + 3 * (SMG_BS * k + l), 3);
  }
  smg_hessian_vector(s);
  for (int64_t row = 0; row < smg_coupled(c); ++row) {
    const int64_t k = smg_site(c, row);
    const smg_real *D = s->A + SMG_BB * row;
    for (int r = 0; r < SMG_BS; ++r) {
      smg_real sum = smg_dot(to + 3 * (SMG_BS * k + r), s->hessian_v + 3 * k);
      for (int l = 0; l < SMG_BS; ++l) sum += D[across * r + down * l] * z[SMG_BS * row + l];
      y[SMG_BS * row + r] = sum;
    }
  }
}

/* y = U J D^-1 U^-1 x. */
static void smg_times(void *of, const smg_real *x, smg_real *y) {
  const smg_state *s = (const smg_state *)of;
  smg_undo_all(s, x, s->product);
  smg_apply(s, 0, s->product, y);
  smg_enlarge(s, y);
}

/* y = J x. */
static void smg_product(void *of, const smg_real *x, smg_real *y) { smg_apply((const smg_state *)of, 0, x, y); }

/* y = (J + J^T) x/2. */
static void smg_times_mean(void *of, const smg_real *x, smg_real *y) {
  const smg_state *s = (const smg_state *)of;
  smg_apply(s, 0, x, s->product);
  smg_apply(s, 1, x, y);
  smg_axpy(y, 1, s->product, smg_order(s));
  smg_scale(y, (smg_real)0.5, smg_order(s));
}

/* The block row with the largest row sum. */
static int64_t smg_worst_row(const smg_state *s) {
  int64_t worst = 0;
  for (int64_t k = 1; k < smg_order(s); ++k)
    if (s->sums[k] > s->sums[worst]) worst = k;
  return worst / SMG_BS;
}

/* s->x = J^-1 s->x by GMRES; 0, or 1 + a row where that may have failed. */
static int64_t smg_solve_free(const smg_state *s, smg_real tolerance, smg_real products) {
  const smg_krylov a = {(void *)(uintptr_t)s, smg_times, smg_order(s), s->work};
  smg_enlarge(s, s->x);
  if (smg_krylov_solve(&a, s->x, tolerance, smg_min(SMG_KRYLOV_PRODUCTS, products))) return 1 + smg_worst_row(s);
  smg_undo_all(s, s->x, s->x);
  return 0;
}

/* The same to a Newton correction's accuracy. *sign: 0, it is not known. */
static int64_t smg_factor(const smg_state *s, int *sign) {
  *sign = 0;
  return smg_solve_free(s, SMG_KRYLOV_TOLERANCE, SMG_PRODUCTS_LEFT(s));
}

/* The largest row sum of abs((J + J^T)/2 - I); not known where torques are among the fields, since their B_ji are not
 * B_ij^T. */
static inline smg_real smg_mean_bound(const smg_state *s) {
  return SMG_TORQUES ? SMG_MAX : smg_most(s->mean, smg_order(s));
}

/* The sign of det J at the last point. */
static int smg_sign(smg_state *s) {
  const smg_krylov a = {s, smg_product, smg_order(s), s->work}, mean = {s, smg_times_mean, smg_order(s), s->work};
  return smg_krylov_sign(&a, &mean, smg_mean_bound(s));
}

/* The sum of abs(J - I) over a row. */
static inline smg_real smg_row_sum(const smg_state *s, int64_t row) { return s->sums[row]; }

/* Is x.J x >= x.x/4 for every x? By Gershgorin's circles of (J + J^T)/2, or by Lanczos, while products are left. */
static inline int smg_coercive(const smg_state *s) {
  const smg_real mean = smg_mean_bound(s);
  const smg_krylov a = {(void *)(uintptr_t)s, smg_times_mean, smg_order(s), s->work};
  return smg_contracts(mean) || (SMG_PRODUCTS_LEFT(s) > 0 && smg_krylov_coercive(&a, mean));
}

/* The matrix for many right-hand sides: nothing is kept. */
static inline int64_t smg_solve_kept(const smg_state *s, SMG_UNUSED const smg_real *keep) {
  return smg_solve_free(s, SMG_KRYLOV_ROUNDOFF, SMG_KRYLOV_PRODUCTS);
}

#endif
