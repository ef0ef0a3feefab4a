/* smidgen method: the sweeps of Gauss collocation on lattices (smg_gauss_rows.h). A vector of sites goes through all
 * stages at once: the slopes at the points as they are, what the shift adds to their changes, and the new points. */
#ifndef SMG_GAUSS_SWEEP_H
#define SMG_GAUSS_SWEEP_H

#include "smg_gauss_slots.h"
#include "smg_gauss_shift.h"
#include "smg_lane_respond.h"
#include "smg_row_piece.h"

/* What sweeps work with: where the slots are; where changes are marked, or NULL; h/(2 kappa), r, 1/r, sqrt(r); how
 * strongly fields turn spins; D; the response; a piece, and the gradients of its stages. */
typedef struct smg_gauss_work {
  smg_real *w, *z, *stages, *marks;
  int64_t pitch;
  smg_real half, radius, inverse, size, strength;
  smg_shift_matrix shift;
  smg_besides known;
  smg_told told;
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_STAGES * SMG_PIECE_ROOM];
} smg_gauss_work;

/* Component k of stage i. */
SMG_INLINE smg_real *smg_sweep_stage(const smg_gauss_work *a, int i, int64_t k) {
  return a->stages + (SMG_SLOT_STAGE * i + k) * a->pitch;
}

/* The same of component b of a part, for one vector of slots. */
SMG_INLINE smg_lanes_anywhere *smg_vector_at(const smg_gauss_work *a, int part, int b, int i, int64_t slot) {
  return (smg_lanes_anywhere *)(smg_sweep_stage(a, i, part + b) + slot);
}
SMG_INLINE smg_lanes smg_number_at(const smg_gauss_work *a, int part, int b, int i, int64_t slot) {
  return *smg_vector_at(a, part, b, i, slot);
}

/* conj(-conj z_1, conj z_0).r, what r has orthogonal to z. */
SMG_INLINE void smg_part_orthogonal(const smg_lanes *z, const smg_lanes *r, smg_lanes *part) {
  part[0] = (z[0] * r[2] - z[1] * r[3]) - (z[2] * r[0] - z[3] * r[1]);
  part[1] = (z[0] * r[3] + z[1] * r[2]) - (z[2] * r[1] + z[3] * r[0]);
}

/* l += (re + i im) (-conj z_1, conj z_0) */
SMG_INLINE void smg_add_orthogonal(const smg_lanes *z, smg_lanes re, smg_lanes im, smg_lanes *l) {
  l[0] -= z[2] * re + z[3] * im;
  l[1] += z[3] * re - z[2] * im;
  l[2] += z[0] * re + z[1] * im;
  l[3] += z[0] * im - z[1] * re;
}

/* R = F + p x Q of the sites in the slots of one vector, in `room` (smg_respond.h). */
SMG_INLINE const smg_lanes *smg_slot_response(const smg_gauss_work *a, SMG_UNUSED int64_t slot, const smg_lanes *p,
                                              const smg_lanes *g, smg_lanes *room) {
#if SMG_LAW_BY_SITE
  const smg_told told = smg_told_of_slots(a->told, a->known.values + slot, a->pitch);
  return smg_lane_respond(&told, p, g, room);
#else
  return smg_lane_respond(&a->told, p, g, room);
#endif
}

/* L_i by F of the slots of one vector, with its change and that change's part for the shift; the largest change is
 * noted, and what is not a number. */
SMG_INLINE void smg_slot_slopes(const smg_gauss_work *a, int i, int64_t slot, const smg_lanes *g, const smg_lanes *z,
                                smg_lanes *l, smg_lanes *part, smg_lanes *change) {
  const int64_t pitch = a->pitch;
  smg_lanes p[3], x[4], d[4], turn[3], room[3];
  smg_take_slots(smg_sweep_stage(a, i, SMG_SLOT_POINT), pitch, slot, p);
  smg_take_four(smg_sweep_stage(a, i, SMG_STAGE_X), pitch, slot, x);
  smg_take_four(smg_sweep_stage(a, i, SMG_STAGE_SLOPE), pitch, slot, d);
  smg_slope(a->half * smg_stage_entry(smg_gauss_weight, i), a->inverse, smg_slot_response(a, slot, p, g, room), p, x,
            turn, l);
  smg_lane_waxpy(d, smg_lane_of(-1), d, l, 4);
  smg_part_orthogonal(z, d, part);
  *change =
      smg_lane_max(*change, (smg_lane_abs(d[0]) + smg_lane_abs(d[1])) + (smg_lane_abs(d[2]) + smg_lane_abs(d[3])));
}

/* L_i += (D part)_i/r, three products for each of complex numbers: (x + iy)(p + iq) = x(p + q) - (x + y)q + i (x(p + q)
 * + (y - x)p). */
SMG_INLINE void smg_shift_slopes(const smg_gauss_work *a, const smg_lanes *z, const smg_lanes (*part)[2],
                                 smg_lanes (*l)[4]) {
  smg_lanes sum[SMG_STAGES];
  SMG_UNROLL
  for (int j = 0; j < SMG_STAGES; ++j) sum[j] = part[j][0] + part[j][1];
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes both = a->shift.re[i][0] * sum[0], less = a->shift.sum[i][0] * part[0][1],
              more = a->shift.gap[i][0] * part[0][0];
    SMG_UNROLL
    for (int j = 1; j < SMG_STAGES; ++j) {
      both += a->shift.re[i][j] * sum[j];
      less += a->shift.sum[i][j] * part[j][1];
      more += a->shift.gap[i][j] * part[j][0];
    }
    smg_add_orthogonal(z, both - less, both + more, l[i]);
  }
}

/* sum_i = z + sum_j (a_ij/b_j) L_j of one component, stages i and i' = s + 1 - i together: half of the products
 * (smg_gauss_table.h). */
SMG_INLINE void smg_combine_halves(smg_lanes z, int b, const smg_lanes (*l)[4], smg_lanes (*sum)[4]) {
  enum { HALF = SMG_STAGES / 2, ODD = SMG_STAGES % 2 };
  smg_lanes even[HALF + 1], odd[HALF + 1], all = {0}, middle;
  SMG_UNROLL
  for (int j = 0; j < HALF; ++j) {
    even[j] = l[j][b] + l[SMG_STAGES - 1 - j][b];
    odd[j] = l[j][b] - l[SMG_STAGES - 1 - j][b];
    all += even[j];
  }
  if (ODD) all += even[HALF] = l[HALF][b];
  middle = z + (smg_real)0.5 * all;
  if (ODD) sum[HALF][b] = middle;
  SMG_UNROLL
  for (int i = 0; i < HALF; ++i) {
    smg_lanes p = smg_gauss_cross[i][0] * even[0], q = smg_gauss_cross[0][i] * odd[0];
    SMG_UNROLL
    for (int j = 1; j < HALF; ++j) {
      p += smg_gauss_cross[i][j] * even[j];
      q += smg_gauss_cross[j][i] * odd[j];
    }
    if (ODD) p += smg_gauss_cross[i][HALF] * even[HALF];
    if (ODD) sum[HALF][b] -= smg_gauss_cross[i][HALF] * odd[i];
    sum[i][b] = middle + (p - q);
    sum[SMG_STAGES - 1 - i][b] = middle - (p + q);
  }
}

/* Z_i = z + sum_j (a_ij/b_j) L_j as x and p, of the slots of one vector. */
SMG_INLINE void smg_join_slots(const smg_gauss_work *a, int64_t slot, const smg_lanes *z, const smg_lanes (*l)[4]) {
  smg_lanes sum[SMG_STAGES][4];
  SMG_UNROLL
  for (int b = 0; b < 4; ++b) smg_combine_halves(z[b], b, l, sum);
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes x[4], p[3];
    smg_point(a->radius, smg_least(a->radius), sum[i], x, p);
    smg_put_four(smg_sweep_stage(a, i, SMG_STAGE_X), a->pitch, slot, x);
    smg_put_slots(smg_sweep_stage(a, i, SMG_SLOT_POINT), a->pitch, slot, p);
  }
}

/* L as it was, and no change, in all lanes but the first `in`. */
SMG_INLINE void smg_only_first(const smg_gauss_work *a, int64_t slot, int64_t in, smg_lanes (*l)[4],
                               smg_lanes *change) {
  *change = smg_lane_first(in, *change);
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes as_it_was[4];
    smg_take_four(smg_sweep_stage(a, i, SMG_STAGE_SLOPE), a->pitch, slot, as_it_was);
    smg_lane_choose(l[i], smg_lane_below(in), l[i], as_it_was, 4);
  }
}

/* The slots of one vector, k of the piece: `in` of them belong to it, the others stay as they are. */
SMG_INLINE void smg_sweep_slots(const smg_gauss_work *a, int64_t k, int64_t in, smg_lanes *change) {
  const int64_t slot = a->piece.start + k;
  smg_lanes z[4], l[SMG_STAGES][4], part[SMG_STAGES][2], moved = {0};
  smg_take_four(a->z, a->pitch, slot, z);
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes g[3];
    smg_take_slots(a->gradient + 3 * SMG_PIECE_ROOM * i, SMG_PIECE_ROOM, k, g);
    smg_slot_slopes(a, i, slot, g, z, l[i], part[i], &moved);
  }
  if (a->shift.theta != 0) smg_shift_slopes(a, z, (const smg_lanes(*)[2])part, l);
  if (in < SMG_LANES) smg_only_first(a, slot, in, l, &moved);
  if (a->marks) smg_lane_put(a->marks + slot, moved);
  *change = smg_lane_max(*change, moved);
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) smg_put_four(smg_sweep_stage(a, i, SMG_STAGE_SLOPE), a->pitch, slot, l[i]);
  smg_join_slots(a, slot, z, (const smg_lanes(*)[4])l);
}

/* The next piece of a colour, all stages; 0 where the colour ends. */
static int smg_sweep_piece(smg_state *s, smg_gauss_work *a, smg_lanes *change) {
  const smg_lattice_row at = a->piece.at;
  const int64_t from = a->piece.from;
  smg_lanes most = *change;
  for (int i = 0; i < SMG_STAGES; ++i) {
    a->piece.at = at;
    a->piece.from = from;
    a->piece.g = a->gradient + 3 * SMG_PIECE_ROOM * i;
#if SMG_TIMED
    smg_set_time(&s->c, smg_time_at(s, smg_gauss_node[i]));
#endif
    if (!smg_next_piece(&s->c, smg_sweep_stage(a, i, SMG_SLOT_POINT), &a->piece)) return 0;
  }
  for (int64_t k = 0; k < a->piece.size; k += SMG_LANES) smg_sweep_slots(a, k, a->piece.size - k, &most);
  *change = most;
  return 1;
}

static smg_moved smg_sweep_stages(smg_state *s, void *with) {
  smg_gauss_work *a = (smg_gauss_work *)with;
  smg_lanes change = {0};
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    smg_begin_colour(&s->c, colour, &a->piece);
    while (smg_sweep_piece(s, a, &change)) continue;
  }
  const smg_moved moved = {change / (a->size * a->strength + SMG_LEAST), 2 * a->size * change,
                           smg_lane_of(2 * a->radius * a->strength)};
  return moved;
}

#define SMG_LOOKS 16 /* spins of a piece that are looked at: theta by their mean is as good as by that of all */

/* p and R of the k-th spin of a piece. */
static void smg_look_at_spin(SMG_UNUSED const smg_coefficients *c, const smg_gauss_work *a, int64_t k, smg_real *p,
                             smg_real *R) {
  const int64_t slot = a->piece.start + k;
  for (int b = 0; b < 3; ++b) p[b] = smg_sweep_stage(a, SMG_STAGES / 2, SMG_SLOT_POINT + b)[slot];
  for (int b = 0; b < 3; ++b) R[b] = a->piece.g[SMG_PIECE_ROOM * b + k];
#if SMG_TOLD
  smg_real r[SMG_RESPONSE_SIZE], room[3];
  smg_law(c, 0, r);
#if SMG_LAW_BY_SITE
  for (int n = 0, at = SMG_LAW_FIRST; n < SMG_RESPONSE_SIZE; ++n)
    if (SMG_LAW_BY_SITE >> n & 1) r[n] = a->known.values[slot + at++ * a->pitch];
#endif
  smg_copy(R, smg_told_respond(r, p, R, room), 3);
#endif
}

/* What a piece of the first colour tells of the fields: the largest |h b/2|, and theta, the mean h b.p/r, in eighths,
 * so that D is seldom made anew. */
static smg_real smg_look_at_fields(smg_state *s, smg_gauss_work *a) {
  smg_real sum = 0, most = 0, looks = 0, p[3], R[3];
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, smg_gauss_node[SMG_STAGES / 2]));
#endif
  smg_begin_colour(&s->c, 0, &a->piece);
  (void)smg_next_piece(&s->c, smg_sweep_stage(a, SMG_STAGES / 2, SMG_SLOT_POINT), &a->piece);
  for (int64_t k = 0; k < a->piece.size; k += 1 + a->piece.size / SMG_LOOKS, ++looks) {
    smg_look_at_spin(&s->c, a, k, p, R);
    sum += p[0] * R[0] + p[1] * R[1] + p[2] * R[2];
    most = smg_max(most, smg_abs(R[0]) + smg_abs(R[1]) + smg_abs(R[2]));
  }
  a->strength = smg_abs(a->half) * most;
  const smg_real theta = 2 * a->half * a->inverse * sum / looks;
  if (!(smg_abs(theta) <= SMG_MOST_TURN)) return theta > 0 ? SMG_MOST_TURN : theta < 0 ? -SMG_MOST_TURN : 0;
  return (smg_real)(int)(8 * theta) / 8;
}

/* ---- what it begins and ends with ------------------------------------------------------------ */

SMG_INLINE void smg_take_z(const smg_gauss_work *a, int64_t slot, smg_lanes *z) {
  smg_take_four(a->z, a->pitch, slot, z);
}

SMG_INLINE smg_lanes smg_over_length(SMG_UNUSED const smg_state *s, const smg_gauss_work *a, SMG_UNUSED int64_t slot,
                                     smg_lanes x) {
  return a->inverse * x;
}

SMG_INLINE void smg_add_to_sites(SMG_UNUSED smg_state *s, const smg_gauss_work *a, int64_t slot, const smg_lanes *u,
                                 smg_lanes *z) {
  smg_lanes w[3];
  smg_take_slots(a->w, a->pitch, slot, w);
  smg_real *lost = a->w + SMG_SLOT_LOST * a->pitch + slot;
  smg_lane_add_step(3, w, lost, lost, a->pitch, u);
  smg_put_slots(a->w, a->pitch, slot, w);
  smg_lift(w, a->radius, z);
  smg_put_four(a->z, a->pitch, slot, z);
}

/* The L_j and the points of their stages. */
SMG_INLINE void smg_begin_sites(SMG_UNUSED const smg_state *s, const smg_gauss_work *a, int64_t slot,
                                const smg_lanes (*l)[4]) {
  smg_lanes z[4];
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) smg_put_four(smg_sweep_stage(a, i, SMG_STAGE_SLOPE), a->pitch, slot, l[i]);
  smg_take_z(a, slot, z);
  smg_join_slots(a, slot, z, l);
}

/* D for the fields there. */
static void smg_begin_sweeps(smg_state *s, smg_gauss_work *a, SMG_UNUSED int extrapolated) {
  smg_shift_by(&a->shift, a->radius, smg_look_at_fields(s, a));
}

/* The site that moves most, or the first that is no number. */
typedef struct smg_slots_moved {
  const smg_real *marks;
  smg_real most;
  int64_t site;
} smg_slots_moved;

SMG_INLINE void smg_look_at_mark(void *context, int64_t site, int64_t slot) {
  smg_slots_moved *found = (smg_slots_moved *)context;
  if (found->most != found->most || found->marks[slot] <= found->most) return;
  found->most = found->marks[slot];
  found->site = site;
}

/* After a step that failed: by one more sweep, with marks in place of z, which the next step lifts anew. */
static int64_t smg_most_moved(smg_state *s, smg_gauss_work *a) {
  smg_slots_moved found = {a->z, -1, -1};
  smg_zero(a->z, smg_slots(&s->c));
  a->marks = a->z;
  (void)smg_sweep_stages(s, a);
  smg_each_slot(&s->c, &found, smg_look_at_mark);
  return found.site;
}

#endif
