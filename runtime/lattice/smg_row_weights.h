/* smidgen runtime: the bound of smg_row_beyond.h in the norm that fits the sites. All spins at once are a contraction
 * by the matrix of t_i B_ij, t_i = |h/2kappa| r/s_i and B_ij the norms of the Hessian's blocks, and with weights d > 0
 * its spectral radius is at most
 *
 *     max_i (1/d_i) sum_j t_i B_ij d_j
 *
 * (Gershgorin's circles of D^-1 M D; Collatz, Math. Z. 48, 1942). From d = 1 on, d <- d/2 + M d comes nearer the
 * eigenvector of the largest eigenvalue: a site with a large t_i, which decides alone where all weights are 1, is made
 * up for by others. */
#ifndef SMG_ROW_WEIGHTS_H
#define SMG_ROW_WEIGHTS_H

#include "smg_row_state.h"
#include "smg_row_piece.h"

#define SMG_WEIGHINGS 24 /* each takes half a sweep */
/* another weighing is made only if so many, each lessening the bound as much as the last one did, would be enough: they
 * lessen it less and less */
#define SMG_WEIGHING_PATIENCE 8

#if SMG_BESIDE_NORMS
/* B of each place: with the site itself, then with its neighbours. */
typedef struct smg_norms_beside {
  smg_real of[SMG_PLACES][SMG_BESIDES + 1];
} smg_norms_beside;

static inline void smg_find_norms(const smg_coefficients *c, smg_norms_beside *norms) {
  for (int64_t sub = 0; sub < SMG_PLACES; ++sub)
    for (int64_t n = 0; n <= SMG_BESIDES; ++n) norms->of[sub][n] = smg_beside_norm(c, sub, n - 1);
}

/* sum_j B_ij d_j of one vector of a run. What is read in place of a neighbour beyond an open end only adds to it. */
SMG_INLINE smg_lanes smg_weight_beside(const smg_norms_beside *norms, const smg_run *run, int blocks, const smg_real *d,
                                       int64_t j, int64_t p) {
  const smg_real *B = norms->of[run->sub];
  smg_lanes sum = B[0] * smg_lane_take(d + run->start + j), v[3];
  for (int n = 0; n < SMG_BESIDES; ++n) {
    if (!blocks && !run->b[n].there) continue;
    smg_take_beside(run, blocks, n, 1, p, d, 0, j, v);
    sum += B[n + 1] * v[0];
  }
  return sum;
}

/* The next weights of a piece, and the largest (1/d_i) sum_j t_i B_ij d_j. */
SMG_INLINE void smg_weigh_piece(const smg_coefficients *c, const smg_norms_beside *norms, smg_piece *piece,
                                const smg_real *t, const smg_real *d, smg_real *next, smg_lanes *most) {
  smg_run run;
  for (int64_t k = 0; smg_next_run(c, piece, &run); k = piece->done) {
    const int blocks = SMG_BLOCKS && run.beside;
    for (int64_t j = run.from, p = j; j < run.to; j += SMG_LANES, p = smg_next_place(p, run.length))
      smg_lane_put(piece->g + k + j - run.from,
                   smg_weight_beside(norms, &run, smg_standing_of(&run, blocks, j), d, j, p));
  }
  for (int64_t k = 0, at = piece->start; k < piece->size; k += SMG_LANES, at += SMG_LANES) {
    const smg_lanes now = smg_lane_take(d + at), pulled = smg_lane_take(t + at) * smg_lane_take(piece->g + k);
    *most = smg_lane_max(*most, smg_lane_first(piece->size - k, pulled / now));
    smg_lane_put(next + at, (smg_real)0.5 * now + pulled);
  }
}

/* That bound with the weights d; the next ones. */
static smg_real smg_weigh(const smg_state *s, smg_besides *known, const smg_norms_beside *norms, const smg_real *t,
                          const smg_real *d, smg_real *next) {
  smg_real most = 0;
  SMG_TEAM(s->row_team) {
    smg_lanes largest = {0};
    smg_piece piece;
    SMG_LINES smg_real room[SMG_PIECE_ROOM];
    smg_begin_piece(&s->c, known, room, &piece);
    for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
      smg_begin_part(&s->c, colour, smg_share_of(&s->c, colour, 1), &piece);
      while (smg_open_piece(&piece)) smg_weigh_piece(&s->c, norms, &piece, t, d, next, &largest);
    }
    SMG_ONE_BY_ONE smg_take(&most, smg_lane_largest(largest));
  }
  return most;
}

/* Is that bound at most SMG_ROW_SHOWN for some weights? t: of all slots; d: room for twice a pitch. */
static int smg_weights_show(const smg_state *s, smg_besides *known, const smg_real *t, smg_real *d) {
  const int64_t pitch = smg_pitch(&s->c);
  smg_real *next = d + pitch;
#if SMG_MANY_KINDS
  smg_norms_beside *norms = (smg_norms_beside *)(void *)((smg_real *)s->row_kinds + smg_kinds_size());
#else
  smg_norms_beside at_hand, *norms = &at_hand;
#endif
  smg_find_norms(&s->c, norms);
  for (int64_t k = 0; k < pitch; ++k) d[k - SMG_BEFORE] = next[k - SMG_BEFORE] = 1;
  for (smg_real n = 0, last = SMG_MAX; n < SMG_WEIGHINGS; ++n) {
    const smg_real bound = smg_weigh(s, known, norms, t, d, next);
    if (bound <= SMG_ROW_SHOWN) return 1;
    if (bound - SMG_WEIGHING_PATIENCE * (last - bound) > SMG_ROW_SHOWN) return 0;
    last = bound;
    smg_real *now = d;
    d = next;
    next = now;
  }
  return 0;
}
#else
static inline int smg_weights_show(SMG_UNUSED const smg_state *s, SMG_UNUSED smg_besides *known,
                                   SMG_UNUSED const smg_real *t, SMG_UNUSED smg_real *d) {
  return 0;
}
#endif

#endif
