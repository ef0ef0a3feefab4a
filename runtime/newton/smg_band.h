/* smidgen runtime: block-band systems, open or periodic (chains), in O(n) work and memory.
 *
 * Row i of the matrix holds the blocks A[(i*(2k+1) + d+k)*BS*BS ...] = block (i, i+d mod n),
 * d = -k..k; in an open chain the blocks that leave [0, n) are ignored. n >= 2k+1.
 *
 * Block LU without pivoting between blocks. A ring is cut by taking its last k rows and
 * columns as a border (separator):
 *
 *     [ T  E ] [y]   [r]      eliminating y leaves (S - F T^-1 E) z = s - F T^-1 r,
 *     [ F  S ] [z] = [s]      k x k blocks; then y by back substitution.
 *
 * Rows are scaled by the inverse of their pivot block D: Uhat = D^-1 U, Ehat = D^-1 E, rhat = D^-1 r. */
#ifndef SMG_BAND_H
#define SMG_BAND_H

#include "smg_block.h"

#define SMG_BAND_MAX 4 /* largest k */

/* A border block this small against the matrix cannot reach any result: it is dropped, which
 * also keeps its further decay out of the subnormal numbers. */
#define SMG_NEGLIGIBLE (SMG_EPS * SMG_EPS * SMG_EPS)

/* Work space of smg_band_solve, in smg_real: Uhat and Ehat of each row. */
static inline int64_t smg_band_worksize(int64_t n, int k) { return n * 2 * k * SMG_BB; }

/* One row under elimination: W[d+k] = block at column i+d, E[t] = block at border column t. */
typedef struct smg_band_row {
  smg_real W[2 * SMG_BAND_MAX + 1][SMG_BB], E[SMG_BAND_MAX][SMG_BB], r[SMG_BS];
  smg_real before;
} smg_band_row;

/* The border's k rows: F[s][c] = block at column i+c of the chain, c = 0..k. */
typedef struct smg_band_border {
  smg_real F[SMG_BAND_MAX][SMG_BAND_MAX + 1][SMG_BB];
  smg_real S[SMG_BAND_MAX][SMG_BAND_MAX][SMG_BB], s[SMG_BAND_MAX][SMG_BS];
  smg_real before[SMG_BAND_MAX];
} smg_band_border;

/* Block (i, c), c < i, of a ring of n, or NULL outside its band. */
SMG_INLINE const smg_real *smg_band_at(int64_t n, int k, const smg_real *A, int64_t i, int64_t c) {
  int64_t d = c - i;
  if (d < -k) d += n;
  return d > k ? NULL : A + (i * (2 * k + 1) + d + k) * SMG_BB;
}

SMG_INLINE void smg_block_copy_or_zero(smg_real *C, const smg_real *A) {
  if (A) smg_block_copy(C, A);
  else smg_zero(C, SMG_BB);
}

/* Row i away from both ends: its whole band lies in the chain. */
SMG_INLINE void smg_band_load(int k, const smg_real *a, const smg_real *b, smg_band_row *q) {
  SMG_UNROLL for (int d = 0; d < 2 * k + 1; d++) smg_block_copy(q->W[d], a + d * SMG_BB);
  SMG_UNROLL for (int t = 0; t < k; t++) smg_zero(q->E[t], SMG_BB);
  smg_copy(q->r, b, SMG_BS);
  q->before = smg_block_scale(q->W[k]);
}

/* Row i of a chain of m near an end: what leaves the chain goes to the border, or nowhere. */
static inline void smg_band_load_end(int64_t n, int k, int64_t m, int64_t i, const smg_real *A, const smg_real *b,
                                     smg_band_row *q) {
  smg_band_load(k, A + i * (2 * k + 1) * SMG_BB, b, q);
  for (int d = -k; d <= k; d++) {
    const int64_t c = i + d;
    if (c >= 0 && c < m) continue;
    if (m < n) smg_block_copy(q->E[c < 0 ? c + k : c - m], q->W[d + k]);
    smg_zero(q->W[d + k], SMG_BB);
  }
}

/* Subtracts L times each row above: those d = 1..count rows up; `work`, x: row i's places. */
SMG_INLINE void smg_band_eliminate(int k, int64_t count, int border, const smg_real *work, const smg_real *x,
                                   smg_band_row *q) {
  SMG_UNROLL for (int d = k; d >= 1; d--) {
    if (d > count) continue;
    const smg_real *L = q->W[k - d], *U = work - d * 2 * k * SMG_BB, *E = U + k * SMG_BB;
    SMG_UNROLL for (int c = 0; c < k; c++) {
      smg_block_submul(q->W[k - d + 1 + c], L, U + c * SMG_BB);
      if (border) smg_block_submul(q->E[c], L, E + c * SMG_BB);
    }
    smg_block_subapply(q->r, L, x - d * SMG_BS);
  }
}

/* Uhat, Ehat, rhat = D^-1 (U, E, r) into the work space and the solution's place. */
SMG_INLINE int smg_band_scale(int k, int border, smg_real *work, smg_real *x, const smg_band_row *q, int *ok) {
  smg_real inverse[SMG_BB];
  if (smg_block_inverse(inverse, q->W[k], q->before)) return 1;
  smg_block_pivot(ok, q->W[k]);
  SMG_UNROLL for (int c = 0; c < k; c++) {
    smg_block_mul(work + c * SMG_BB, inverse, q->W[k + 1 + c]);
    if (border) smg_block_mul(work + (k + c) * SMG_BB, inverse, q->E[c]);
  }
  smg_block_apply(x, inverse, q->r);
  return 0;
}

/* The border's rows at column c of the chain: their own blocks, none of them eliminated yet. */
static inline void smg_band_open_border(int64_t n, int k, int64_t c, const smg_real *A, smg_band_border *q) {
  for (int s = 0; s < k; s++)
    for (int j = 0; j <= k; j++) {
      const int64_t column = c + j;
      smg_block_copy_or_zero(q->F[s][j], column < n - k ? smg_band_at(n, k, A, n - k + s, column) : NULL);
    }
}

static inline void smg_band_cut(int64_t n, int k, const smg_real *A, const smg_real *x, smg_band_border *q) {
  smg_band_open_border(n, k, 0, A, q);
  for (int s = 0; s < k; s++) {
    for (int t = 0; t < k; t++) smg_block_copy(q->S[s][t], A + ((n - k + s) * (2 * k + 1) + t - s + k) * SMG_BB);
    smg_copy(q->s[s], x + (n - k + s) * SMG_BS, SMG_BS);
    q->before[s] = smg_block_scale(q->S[s][s]);
  }
}

/* The border after column i: S -= F Ehat, s -= F rhat, F -= F Uhat, then the window moves on
 * to the columns i+1 .. i+1+k. */
SMG_INLINE void smg_band_border_step(int64_t n, int k, int64_t i, const smg_real *A, const smg_real *work,
                                     const smg_real *x, smg_band_border *q) {
  const int64_t next = i + 1 + k;
  const int fresh = next >= n - 2 * k && next < n - k;
  SMG_UNROLL for (int s = 0; s < k; s++) {
    smg_real F[SMG_BB];
    smg_block_copy(F, q->F[s][0]);
    smg_block_subapply(q->s[s], F, x);
    SMG_UNROLL for (int c = 0; c < k; c++) {
      smg_block_submul(q->S[s][c], F, work + (k + c) * SMG_BB);
      smg_block_copy(q->F[s][c], q->F[s][c + 1]);
      smg_block_submul(q->F[s][c], F, work + c * SMG_BB);
    }
    smg_block_copy_or_zero(q->F[s][k], fresh ? smg_band_at(n, k, A, n - k + s, next) : NULL);
  }
}

/* Rows [first, last) of a chain of m: 0, or 1 + the row whose pivot is singular. */
static inline int64_t smg_band_rows(int64_t n, int k, int64_t m, int64_t first, int64_t last, int border,
                                    const smg_real *A, smg_real *x, smg_real *work, smg_band_border *q, int *ok) {
  for (int64_t i = first; i < last; i++) {
    smg_band_row row;
    smg_real *out = work + i * 2 * k * SMG_BB, *xi = x + i * SMG_BS;
    if (i < k || i >= m - k) smg_band_load_end(n, k, m, i, A, xi, &row);
    else smg_band_load(k, A + i * (2 * k + 1) * SMG_BB, xi, &row);
    smg_band_eliminate(k, i, border, out, xi, &row);
    if (smg_band_scale(k, border, out, xi, &row, ok)) return 1 + i;
    if (border) smg_band_border_step(n, k, i, A, out, xi, q);
  }
  return 0;
}

/* Block LU of the border's own k x k blocks; z becomes its solution. */
static inline int64_t smg_band_close(int k, smg_band_border *q, smg_real *z, int *ok) {
  smg_real inverse[SMG_BB], hat[SMG_BB];
  for (int p = 0; p < k; p++) {
    if (smg_block_inverse(inverse, q->S[p][p], q->before[p])) return 1 + p;
    smg_block_pivot(ok, q->S[p][p]);
    smg_block_apply(z + p * SMG_BS, inverse, q->s[p]);
    for (int t = p + 1; t < k; t++) {
      smg_block_mul(hat, inverse, q->S[p][t]);
      smg_block_copy(q->S[p][t], hat);
      for (int s = p + 1; s < k; s++) smg_block_submul(q->S[s][t], q->S[s][p], hat);
    }
    for (int s = p + 1; s < k; s++) smg_block_subapply(q->s[s], q->S[s][p], z + p * SMG_BS);
  }
  for (int p = k - 2; p >= 0; p--)
    for (int t = p + 1; t < k; t++) smg_block_subapply(z + p * SMG_BS, q->S[p][t], z + t * SMG_BS);
  return 0;
}

/* Rows [first, last) of a chain of m upwards: x_i = rhat_i - sum Uhat x_(i+c) - sum Ehat z. */
SMG_INLINE void smg_band_back(int k, int64_t m, int64_t first, int64_t last, const smg_real *z, const smg_real *work,
                              smg_real *x) {
  for (int64_t i = last - 1; i >= first; i--) {
    const smg_real *row = work + i * 2 * k * SMG_BB;
    smg_real *xi = x + i * SMG_BS;
    SMG_UNROLL for (int c = 0; c < k; c++) {
      if (z) smg_block_subapply(xi, row + (k + c) * SMG_BB, z + c * SMG_BS);
      if (i + 1 + c < m) smg_block_subapply(xi, row + c * SMG_BB, xi + (1 + c) * SMG_BS);
    }
  }
}

/* True once the fill of the rows above row i and of the border can no longer be felt. */
static inline int smg_band_decayed(int k, int64_t i, const smg_real *work, const smg_band_border *q) {
  smg_real E = 0, F = 0, S = 0;
  if (i < k) return 0;
  for (int a = 0; a < k; a++)
    for (int b = 0; b < k; b++) {
      E += smg_block_norm(work + ((i - 1 - a) * 2 * k + k + b) * SMG_BB);
      F += smg_block_norm(q->F[a][b]);
      S += smg_block_norm(q->S[a][b]);
    }
  return E <= SMG_NEGLIGIBLE && F <= SMG_NEGLIGIBLE * S;
}

/* Ring: the chain's rows 0 .. m-1, m = n-k; the fill is carried up to row `*filled`, and again
 * in the last k rows. */
static inline int64_t smg_band_ring_down(int64_t n, int k, const smg_real *A, smg_real *x, smg_real *work,
                                         smg_band_border *q, int *ok, int64_t *filled) {
  const int64_t m = n - k, end = m - k;
  int64_t i = 0, failed = 0;
  smg_band_cut(n, k, A, x, q);
  while (i < end && !failed && !smg_band_decayed(k, i, work, q)) {
    const int64_t stop = end - i < 64 ? end : i + 64;
    failed = smg_band_rows(n, k, m, i, stop, 1, A, x, work, q, ok);
    i = stop;
  }
  *filled = i;
  if (!failed && i < end) {
    failed = smg_band_rows(n, k, m, i, end, 0, A, x, work, q, ok);
    smg_band_open_border(n, k, end, A, q);
    for (int64_t j = end - k > i ? end - k : i; j < end; j++) smg_zero(work + (2 * j + 1) * k * SMG_BB, k * SMG_BB);
  }
  return failed ? failed : smg_band_rows(n, k, m, end, m, 1, A, x, work, q, ok);
}

/* The same with the border's own blocks. */
static inline int64_t smg_band_ring(int64_t n, int k, const smg_real *A, smg_real *x, smg_real *work, int *pivots,
                                    int64_t *filled) {
  smg_band_border q;
  int64_t failed = smg_band_ring_down(n, k, A, x, work, &q, pivots, filled);
  if (failed) return failed;
  failed = smg_band_close(k, &q, x + (n - k) * SMG_BS, pivots);
  return failed ? n - k + failed : 0;
}

/* Downwards and upwards. */
SMG_INLINE int64_t smg_band_cyclic(int64_t n, int k, const smg_real *A, smg_real *x, smg_real *work, int *pivots) {
  const int64_t m = n - k;
  int64_t filled = 0;
  const int64_t failed = smg_band_ring(n, k, A, x, work, pivots, &filled);
  if (failed) return failed;
  smg_band_back(k, m, m - k, m, x + m * SMG_BS, work, x);
  smg_band_back(k, m, filled, m - k, NULL, work, x);
  smg_band_back(k, m, 0, filled, x + m * SMG_BS, work, x);
  return 0;
}

SMG_INLINE int64_t smg_band_open(int64_t n, int k, const smg_real *A, smg_real *x, smg_real *work, int *pivots) {
  const int64_t failed = smg_band_rows(n, k, n, 0, n, 0, A, x, work, NULL, pivots);
  if (!failed) smg_band_back(k, n, 0, n, NULL, work, x);
  return failed;
}

/* Solves A x = b for a block band of n block rows and half-bandwidth k (a compile-time constant,
 * 1..SMG_BAND_MAX); x holds b and receives the solution, work has smg_band_worksize(n, k) reals.
 * n >= 2k+1 when periodic, n >= 1 otherwise.
 * Returns 0, or 1 + the block row whose pivot is singular to round-off (x is then spoilt).
 * *pivots: 1 when no pivot block has a real eigenvalue <= 0, else 2 or -2, the sign of the determinant. */
SMG_INLINE int64_t smg_band_solve(int64_t n, int k, int periodic, const smg_real *A, smg_real *x, smg_real *work,
                                  int *pivots) {
  *pivots = 1;
  const int64_t failed = periodic ? smg_band_cyclic(n, k, A, x, work, pivots) : smg_band_open(n, k, A, x, work, pivots);
  if (failed) *pivots = 0;
  return failed;
}

/* ---- what the matrix of a step shows of its branch ------------------------------------- */

/* The sum of abs(A - I) over a row. */
static inline smg_real smg_band_row_sum(int k, const smg_real *A, int64_t row) {
  const smg_real *at = A + row / SMG_BS * (2 * k + 1) * SMG_BB + row % SMG_BS * SMG_BS;
  smg_real sum = 0;
  for (int d = 0; d < 2 * k + 1; d++) sum = smg_add_sizes(sum, SMG_BS, at + d * SMG_BB, d == k ? row % SMG_BS : -1);
  return sum;
}

/* True when x.A x >= x.x/4 for all x: (A + A^T)/2 - I/4 has positive pivots. A and x are spoilt. */
static inline int smg_band_coercive(int64_t n, int k, int wrap, smg_real *A, smg_real *x, smg_real *work) {
  int positive = 0;
  for (int64_t i = 0; i < n; i++) {
    smg_real *row = A + i * (2 * k + 1) * SMG_BB;
    smg_block_mirror(row + k * SMG_BB, row + k * SMG_BB);
    smg_block_lower(row + k * SMG_BB);
    for (int d = 1; d <= k; d++)
      if (wrap || i + d < n) smg_block_mirror(row + (k + d) * SMG_BB, A + ((i + d) % n * (2 * k + 1) + k - d) * SMG_BB);
  }
  return smg_band_solve(n, k, wrap, A, x, work, &positive) == 0 && positive == 1;
}

#endif
