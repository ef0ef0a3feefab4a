/* smidgen runtime: Newton's method on the midpoints of all coupled sites, and the branch of its solution.
 *
 * J = I - (h/2) DX(m) P'(mbar), SMG_BS unknowns a site. How its blocks are stored and solved is told by the header of
 * the matrix, one of smg_matrix_*.h: smg_clear, smg_add_block, smg_factor, smg_row_sum, smg_coercive; and, for the
 * tangent map, smg_kept_size, smg_keep_matrix, smg_solve_kept. */
#ifndef SMG_NEWTON_H
#define SMG_NEWTON_H

#include "smg_coupled.h"
#include "smg_noise.h"

/* Where the row of a site stands in the matrix: a sparse one has its rows in an order of elimination. */
static inline int64_t smg_block_row(int64_t row) {
#if SMG_ORDER
  return smg_block_rows[row];
#else
  return row;
#endif
}

/* J_ij += G_i B S_j^T for the Hessian block B of one term, y = B S_j^T. */
#if !SMG_MATRIX_FREE
static inline void smg_add_hessian(const smg_state *s, int64_t i, int64_t j, const smg_real *y,
                                   SMG_UNUSED const smg_real *z) {
  smg_real block[SMG_BB];
  smg_frame_block(s->G + 3 * SMG_BS * i, y, block);
  smg_add_block(s, smg_row(&s->c, i), smg_row(&s->c, j), block);
}
#endif

/* The frame of the site of a row, its own block of J, and the right-hand side of its residual in the frame. */
SMG_INLINE void smg_row_frame(const smg_state *s, smg_real h, int64_t row, smg_real *own) {
  const int64_t k = smg_site(&s->c, row);
  smg_newton_frame(&s->c, k, h, s->m + 3 * k, s->s[k], s->g + 3 * k, s->r + 3 * k, s->G + 3 * SMG_BS * k,
                   s->S + 3 * SMG_BS * k, own, s->x + SMG_BS * smg_block_row(row));
}

/* Frames of all coupled sites, then the sum of the blocks of all terms. */
static void smg_assemble(const smg_state *s, smg_real h) {
  smg_clear(s);
  SMG_UNROLL_FEW
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    smg_real own[SMG_BB];
    smg_row_frame(s, h, row, own);
    smg_add_block(s, row, row, own);
  }
  smg_hessian_blocks(s);
#if SMG_MATRIX_FREE
  smg_assembled(s);
#endif
}

/* d = J^-1 r for the midpoints from its solution s->x in the frames. */
static void smg_correct_all(const smg_state *s, smg_real h, smg_real *d) {
  SMG_UNROLL_FEW
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    d[3 * k] = d[3 * k + 1] = d[3 * k + 2] = 0;
    smg_newton_correct(&s->c, k, h, s->m + 3 * k, s->s[k], s->g + 3 * k, s->r + 3 * k, s->S + 3 * SMG_BS * k,
                       s->x + SMG_BS * smg_block_row(row), d + 3 * k);
  }
}

/* Is the matrix singular, at the block row bad - 1? Then the report tells the site that this belongs to. */
static int smg_singular(smg_state *s, int64_t bad) {
  int64_t row = 0;
  if (bad == 0) return 0;
  while (smg_block_row(row) != bad - 1) ++row;
  s->report.site = smg_site(&s->c, row);
  return 1;
}

/* The largest sum of abs(J - I) over the rows of one block row, and over all; NaN where there is one. */
SMG_INLINE smg_real smg_site_row_sum(const smg_state *s, int64_t place) {
  smg_real most = 0;
  for (int64_t r = SMG_BS * place; r < SMG_BS * (place + 1); ++r) most = smg_max(most, smg_row_sum(s, r));
  return most;
}

static inline smg_real smg_row_bound(const smg_state *s) {
  smg_real most = 0;
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) most = smg_max(most, smg_site_row_sum(s, row));
  return most;
}

/* d = J^-1 r for the midpoints, by the frames and the matrix of the last evaluation; 0, or 1 + the place of a singular
 * row. *bound: the largest row sum of abs(J - I); *sign: that of det J. */
static int64_t smg_correction(smg_state *s, smg_real h, smg_real *d, smg_real *bound, int *sign) {
  smg_assemble(s, h);
  *bound = smg_row_bound(s);
  const int64_t bad = smg_factor(s, sign);
  if (bad == 0) smg_correct_all(s, h, d);
  return bad;
}

/* Does a correction d of the midpoints w lead to `end`, or miss it by no more than a part of the way? */
static int smg_leads_to(const smg_state *s, const smg_real *d, const smg_real *end) {
  smg_real off = 0, way = 0;
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    for (int64_t b = 3 * k; b < 3 * k + 3; ++b) {
      way = smg_max(way, smg_site_up(s, k) * smg_abs(end[b] - s->w[b]));
      off = smg_max(off, smg_site_up(s, k) * smg_abs(end[b] - s->w[b] - d[b]));
    }
  }
  return off <= SMG_REACH_OF_NEWTON * way;
}

/* Does the curve from W = w lead to the solution, as far as its beginning tells? There J - I grows like h: so where J
 * is coercive for h, it is for less. And Newton's correction from there must lead to the solution. */
static int smg_begins_well(smg_state *s, smg_real h) {
  smg_real *end = s->mbar, *d = s->curve, bound;
  int sign;
  s->mbar = s->w;
  (void)smg_evaluate(s, h);
  smg_assemble(s, h);
  const int well = smg_coercive(s) && smg_correction(s, h, d, &bound, &sign) == 0 && smg_leads_to(s, d, end);
  s->mbar = end;
  (void)smg_evaluate(s, h);
  return well;
}

/* Is the solution certainly on the branch of W = w at h = 0? J - I is a contraction; or the row sums of J - I are at
 * most SMG_CLEAR, the symmetric part of J is at least 1/4, which keeps it clear of singular matrices, where branches
 * meet, and the curve begins well. What is not certain must be followed. */
static int smg_on_branch(smg_state *s, smg_real h, smg_real bound) {
  if (smg_contracts(bound)) return 1;
  if (!(bound <= SMG_CLEAR)) return 0;
  smg_assemble(s, h);
  return smg_coercive(s) && smg_begins_well(s, h);
}

/* Is the increment u, whose plain evaluation left the residuals r, right to the round-off of each site? noise: that of
 * the field, or NULL where it is not known. Increments of others are no better known than their fields, and move the
 * residual of a site by that times its row of J - I: where three vortices collapse, 1 step in 7 next to the fold was
 * refused for it. Rows that sum to more than 1 count as 1: between sites that nearly meet they sum to thousands, and
 * hundreds of times the round-off would pass. */
static int smg_within_round_off(const smg_state *s, smg_real h, const smg_real *noise) {
  const smg_coefficients *c = &s->c;
  const smg_real most = noise ? smg_most(noise, smg_sites(c)) : 0;
  for (int64_t row = 0; row < smg_coupled(c); ++row) {
    const int64_t k = smg_site(c, row);
    const smg_real products = smg_product_scale(c, k, h, s->m + 3 * k, s->g + 3 * k),
                   bound = smg_site_row_sum(s, smg_block_row(row));
    const smg_real own = noise ? 2 * (noise[k] + smg_min(bound, 1) * most) : 0;
    if (!(smg_largest(s->r + 3 * k) <= smg_round_off(smg_largest(s->w + 3 * k), products, bound, own, s->scale)))
      return 0;
  }
  return 1;
}

/* The same where the terms of the field cancel: two vortices 1/1000 apart lose a million ulps in it, whatever is done.
 * u: the increments whose evaluation left the residuals s->r; d and what follows it: room for 12 numbers a site. */
static int smg_within_noise(smg_state *s, smg_real h, const smg_real *u, smg_real *d) {
  const int64_t n = 3 * smg_sites(&s->c);
  smg_real *noise = d + n, *even = d + 2 * n, *up = d + 3 * n;
  smg_copy(d, u, n);
  smg_axpy(d, 2, s->r, n); /* h X */
  smg_noise_of_all(s, h, d, up, even, noise);
  smg_copy(s->u, u, n);
  smg_waxpy(s->r, -1, u, d, n);
  smg_scale(s->r, 0.5, n);
  return smg_within_round_off(s, h, noise);
}

/* Every increment without its part along grad C, where that is round-off. Without Nambu sites only where the products
 * are beyond the state: in smaller steps it would cost the momentum, which equal and opposite increments keep. */
static void smg_tangential_all(smg_state *s, smg_real rounding_scale) {
  if (!SMG_COUPLED_NAMBU && !(rounding_scale > s->scale)) return;
  SMG_UNROLL_FEW
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    smg_tangential(&s->c, k, s->w + 3 * k, s->compensation + 3 * k, s->u + 3 * k);
  }
}

/* The residuals that a plain evaluation at the increments `before` leaves; s->u keeps them. */
static void smg_increment_residual(smg_state *s, smg_real h, smg_real *before) {
  const int64_t n = 3 * smg_sites(&s->c);
  smg_copy(before, s->u, n);
  (void)smg_refine(s, h);
  smg_waxpy(s->r, -1, before, s->u, n);
  smg_scale(s->r, 0.5, n);
  s->report.residual = smg_most(s->r, n);
  smg_copy(s->u, before, n);
}

/* The end of a non-contractive step. Plain evaluations would hardly lessen what is left, or enlarge it, so Newton
 * corrects the increment u itself: at least twice, since what one correction leaves is of one sign along many an orbit,
 * a drift. u = 2 (mbar - w), so it moves by twice what mbar does. */
static smg_status smg_refine_by_newton(smg_state *s, smg_real h, smg_real rounding_scale) {
  smg_real *before = s->curve, *d = s->curve + 3 * smg_sites(&s->c);
  int sign;
  for (int round = 0;; ++round) {
    smg_increment_residual(s, h, before);
    smg_assemble(s, h);
    if (round > 1 && smg_within_round_off(s, h, NULL)) return SMG_OK;
    if (round == SMG_ROUNDS) break;
    ++s->report.iterations;
    if (smg_factor(s, &sign) > 0) return SMG_SINGULAR;
    smg_correct_all(s, h, d);
    for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
      const int64_t k = 3 * smg_site(&s->c, row);
      smg_waxpy(s->u + k, 2, d + k, before + k, 3);
    }
    smg_tangential_all(s, rounding_scale);
  }
  return smg_within_noise(s, h, before, d) ? SMG_OK : SMG_NO_CONVERGENCE;
}

/* The end of a contractive step: plain evaluations until a twentieth of the round-off of the iteration is left. They
 * move midpoints by round-off alone, but where the field jumps. */
static smg_status smg_refine_plain(smg_state *s, smg_real h, smg_real bound, smg_real rounding_scale) {
  smg_real left = 1;
  for (int n = 0; smg_refines(n, left); ++n) {
    const smg_real moved = smg_refine(s, h).absolute;
    if (!(moved <= SMG_NEARLY * s->scale)) return moved <= SMG_MAX ? SMG_NO_CONVERGENCE : SMG_NOT_FINITE;
    left *= bound;
  }
  smg_tangential_all(s, rounding_scale);
  return SMG_OK;
}

/* The way that Newton's loop took: the largest bounds on J - I, now and on the way; is the step non-contractive? */
typedef struct smg_newton_path {
  smg_real bound, most;
  int noncontractive;
} smg_newton_path;

/* Newton on mbar from where it stands, to stagnation. */
static smg_status smg_newton_loop(smg_state *s, smg_real h, smg_newton_path *path, smg_change *now) {
  smg_change last = {SMG_MAX, SMG_MAX, 0};
  int sign;
  for (int it = 0;; ++it) {
    *now = smg_evaluate(s, h);
    s->report.iterations = it;
    s->report.residual = now->absolute;
    if (!(now->absolute <= SMG_MAX)) return SMG_NOT_FINITE;
    path->noncontractive = smg_strong_field(now, s->scale) || !smg_contracts(path->bound) || it > 2 * SMG_LATE;
    const int done = smg_stagnates(now, &last, s->scale, it, path->bound) || smg_tolerated(s, now->absolute);
    /* its end is another */
    if (it > 0 && (done || (path->noncontractive && now->absolute <= SMG_NEARLY * s->scale))) return SMG_OK;
    if (done) { /* the sweeps have solved it */
      smg_assemble(s, h);
      path->bound = smg_row_bound(s);
      return SMG_OK;
    }
    if (it == SMG_MAX_NEWTON) return SMG_NO_CONVERGENCE;
    if (smg_singular(s, smg_correction(s, h, s->curve, &path->bound, &sign))) return SMG_SINGULAR;
    path->most = smg_max(path->most, path->bound); /* on the way too: another branch may look as calm */
    smg_axpy(s->mbar, 1, s->curve, 3 * smg_sites(&s->c));
    last = *now;
  }
}

/* Newton, its branch, and the end of the step. */
static smg_status smg_newton(smg_state *s, smg_real h) {
  smg_newton_path path = {0, 0, 0};
  smg_change now;
  smg_status status = smg_newton_loop(s, h, &path, &now);
  if (status != SMG_OK) return status;
  const int certified = smg_on_branch(s, h, smg_max(path.most, path.bound));
  if (path.noncontractive || !smg_contracts(path.bound)) status = smg_refine_by_newton(s, h, now.rounding_scale);
  else if (!(s->tolerance > 0)) status = smg_refine_plain(s, h, path.bound, now.rounding_scale);
  return status != SMG_OK ? status : certified ? SMG_OK : SMG_WRONG_BRANCH;
}

#endif
