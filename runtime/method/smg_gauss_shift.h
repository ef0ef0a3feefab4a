/* smidgen method: what a spin's own turning adds to a change of the stages of Gauss collocation (smg_gauss.h).
 *
 * A change of L by the part of F orthogonal to z comes back: F turns what is orthogonal to z by -i mu, mu = b.p/r. So a residual R of
 * L_i = h b_i F(Z_i), orthogonal to z and in the frozen field of the neighbours, is the residual of the change d with
 *
 *     d_i + i theta b_i sum_j (a_ij/b_j) d_j = R_i,     theta = h mu,     d = R + D R.
 *
 * One theta for all sites serves where spins feel much the same field; each sweep then leaves what neighbours change alone. On the chain
 * of 100 (four stages, h = 1) 7 sweeps do what 18 do without it, 21 if colours take turns without it. */
#ifndef SMG_GAUSS_SHIFT_H
#define SMG_GAUSS_SHIFT_H

#define SMG_MOST_TURN 4 /* of theta: beyond, spins turn by more than half a circle a step, and no start is near */

/* D_ij/r, for a z of size r: the real part, its sum with the imaginary one and what that is more; theta that it is for. */
typedef struct smg_shift_matrix {
  smg_real theta, re[SMG_STAGES][SMG_STAGES], sum[SMG_STAGES][SMG_STAGES], gap[SMG_STAGES][SMG_STAGES];
} smg_shift_matrix;

/* row a -= (re + i im) row b, of [M | N]. */
static inline void smg_shift_rows(smg_real (*re)[2 * SMG_STAGES], smg_real (*im)[2 * SMG_STAGES], int a, int b, smg_real x, smg_real y) {
  for (int k = 0; k < 2 * SMG_STAGES; ++k) {
    const smg_real u = re[b][k], v = im[b][k];
    re[a][k] -= x * u - y * v;
    im[a][k] -= x * v + y * u;
  }
}

/* [M | I] becomes [I | M^-1] (Gauss and Jordan). M = I + i theta A has its pivots near 1 + i theta a_kk, off 0. */
static inline void smg_shift_invert(smg_real (*re)[2 * SMG_STAGES], smg_real (*im)[2 * SMG_STAGES]) {
  for (int b = 0; b < SMG_STAGES; ++b) {
    const smg_real x = re[b][b], y = im[b][b], size = x * x + y * y;
    smg_shift_rows(re, im, b, b, 1 - x / size, y / size);
    for (int a = 0; a < SMG_STAGES; ++a)
      if (a != b) smg_shift_rows(re, im, a, b, re[a][b], im[a][b]);
  }
}

/* D/r for this theta; of 0 it is 0. */
static void smg_shift_by(smg_shift_matrix *d, smg_real r, smg_real theta) {
  smg_real re[SMG_STAGES][2 * SMG_STAGES], im[SMG_STAGES][2 * SMG_STAGES];
  if (!(d->theta != theta)) return;
  for (int i = 0; i < SMG_STAGES; ++i)
    for (int j = 0; j < SMG_STAGES; ++j) {
      re[i][j] = re[i][SMG_STAGES + j] = i == j;
      im[i][j] = theta * smg_gauss_weight[i] * smg_gauss_share[j][i];
      im[i][SMG_STAGES + j] = 0;
    }
  smg_shift_invert(re, im);
  for (int i = 0; i < SMG_STAGES; ++i)
    for (int j = 0; j < SMG_STAGES; ++j) {
      d->re[i][j] = (re[i][SMG_STAGES + j] - (i == j)) / r;
      d->sum[i][j] = d->re[i][j] + im[i][SMG_STAGES + j] / r;
      d->gap[i][j] = im[i][SMG_STAGES + j] / r - d->re[i][j];
    }
  d->theta = theta;
}

#endif
