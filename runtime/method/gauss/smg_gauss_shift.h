/* smidgen method: what a spin's own turning adds to a change of the stages of Gauss collocation, and relaxation
 * (smg_gauss.h).
 *
 * A change of L by the part of F orthogonal to z comes back: F turns what is orthogonal to z by -i mu, mu = b.p/r. So
 * in the frozen field of the neighbours a residual R of L_i = h b_i F(Z_i), orthogonal to z, is that of the change d
 * with
 *
 *     (I + X) d = R,     X = i theta A in the basis of the L_i: X_ij = i theta b_i (a_ij/b_j),     theta = h mu.
 *
 * Colours that take turns with d = (I + X)^-1 R are the iteration of Gauss and Seidel. Parallel neighbours change the
 * field of a spin by at most mu, so that of Jacobi has the eigenvalues c m, -1 <= c <= 1, with m = X/(1 + X) for each
 * eigenvalue of X, on a line through 0. Over such a line (Young, Iterative Solution of Large Linear Systems, 6)
 * relaxation is best with omega = 2/(1 + sqrt(1 - m^2)): errors then fall by |omega - 1|, about m^2/4, a sweep, not by
 * m^2. All eigenvalues at once have theirs by one function of X,
 *
 *     d = omega (I + X)^-1 R = g^2 R,     g = 2/(1 + sqrt(1 + 2 X)),     g = (I + (X/2) g)^-1,
 *
 * by iteration on the last. D = g^2 - I. */
#ifndef SMG_GAUSS_SHIFT_H
#define SMG_GAUSS_SHIFT_H

#include "smg_gauss_site.h"

#define SMG_MOST_TURN 4 /* of theta: beyond, spins turn by more than half a circle a step, and no start is near */
/* each leaves a fifth of its error, where |X| is 1 a third: a hundredth of omega's distance from 1 */
#define SMG_ROUNDS_OF_G 5

/* D_ij/r, for a z of size r: the real part, its sum with the imaginary one and what that is more; theta that it is
 * for. */
typedef struct smg_shift_matrix {
  smg_real theta, re[SMG_STAGES][SMG_STAGES], sum[SMG_STAGES][SMG_STAGES], gap[SMG_STAGES][SMG_STAGES];
} smg_shift_matrix;

/* A matrix M, and beside it what becomes its inverse. */
typedef struct smg_shift_rows {
  smg_real re[SMG_STAGES][2 * SMG_STAGES], im[SMG_STAGES][2 * SMG_STAGES];
} smg_shift_rows;

/* row a -= (x + iy) row b */
static inline void smg_shift_less(smg_shift_rows *m, int a, int b, smg_real x, smg_real y) {
  for (int k = 0; k < 2 * SMG_STAGES; ++k) {
    const smg_real u = m->re[b][k], v = m->im[b][k];
    m->re[a][k] -= x * u - y * v;
    m->im[a][k] -= x * v + y * u;
  }
}

/* [M | I] becomes [I | M^-1] (Gauss and Jordan). M = I + i .. has its pivots off 0. */
static inline void smg_shift_invert(smg_shift_rows *m) {
  for (int b = 0; b < SMG_STAGES; ++b) {
    const smg_real x = m->re[b][b], y = m->im[b][b], size = x * x + y * y;
    smg_shift_less(m, b, b, 1 - x / size, y / size);
    for (int a = 0; a < SMG_STAGES; ++a)
      if (a != b) smg_shift_less(m, a, b, m->re[a][b], m->im[a][b]);
  }
}

/* [I + (X/2) g | I] of the g that stands on the right. */
static void smg_shift_begin(smg_shift_rows *m, smg_real theta) {
  smg_shift_rows g = *m;
  for (int i = 0; i < SMG_STAGES; ++i)
    for (int j = 0; j < SMG_STAGES; ++j) {
      smg_real re = i == j, im = 0;
      for (int k = 0; k < SMG_STAGES; ++k) {
        const smg_real x = (smg_real)0.5 * theta * smg_gauss_weight[i] * smg_gauss_share[k][i];
        re -= x * g.im[k][SMG_STAGES + j];
        im += x * g.re[k][SMG_STAGES + j];
      }
      m->re[i][j] = re;
      m->im[i][j] = im;
      m->re[i][SMG_STAGES + j] = i == j;
      m->im[i][SMG_STAGES + j] = 0;
    }
}

/* D/r from g. */
static void smg_shift_end(smg_shift_matrix *d, smg_real r, const smg_shift_rows *g) {
  for (int i = 0; i < SMG_STAGES; ++i)
    for (int j = 0; j < SMG_STAGES; ++j) {
      smg_real re = -(smg_real)(i == j), im = 0;
      for (int k = 0; k < SMG_STAGES; ++k) {
        const smg_real a = g->re[i][SMG_STAGES + k], b = g->im[i][SMG_STAGES + k], x = g->re[k][SMG_STAGES + j],
                       y = g->im[k][SMG_STAGES + j];
        re += a * x - b * y;
        im += a * y + b * x;
      }
      d->re[i][j] = re / r;
      d->sum[i][j] = (re + im) / r;
      d->gap[i][j] = (im - re) / r;
    }
}

/* D/r for this theta; of 0 it is 0. */
static void smg_shift_by(smg_shift_matrix *d, smg_real r, smg_real theta) {
  smg_shift_rows g = {{{0}}, {{0}}};
  if (!(d->theta != theta)) return;
  for (int i = 0; i < SMG_STAGES; ++i) g.re[i][SMG_STAGES + i] = 1;
  for (int n = 0; n < SMG_ROUNDS_OF_G; ++n) {
    smg_shift_begin(&g, theta);
    smg_shift_invert(&g);
  }
  smg_shift_end(d, r, &g);
  d->theta = theta;
}

#endif
