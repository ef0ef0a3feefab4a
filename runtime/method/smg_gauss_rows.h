/* smidgen method: Gauss collocation (smg_gauss.h) on lattices, sites in the lanes of vectors.
 *
 * Components stand by slots (smg_rows.h): those of a colour follow each other, the gradient of a row comes from vectors as they stand.
 * A sweep takes the colours in turn, each with the points of the others as they are by then, all stages of a piece while it is in the
 * nearest cache; what a site's own turning adds is known, and sweeps are relaxed as is best for it (smg_gauss_shift.h). */
#ifndef SMG_GAUSS_ROWS_H
#define SMG_GAUSS_ROWS_H

#include "smg_row_piece.h"
#include "smg_row_slots.h"
#include "smg_gauss_shift.h"

/* ---- arrays ------------------------------------------------------------------------------- */

/* Numbers of the slots, component after component: w, what it has lost, z; and of every stage p, x = (r/|Z_i|^2) Z_i, L_i, and the L_i before. */
enum {
  SMG_SLOT_W = 0, SMG_SLOT_LOST = 3, SMG_SLOT_Z = 6, SMG_SLOT_STAGES = 10,
  SMG_SLOT_POINT = 0, SMG_SLOT_X = 3, SMG_SLOT_SLOPE = 7, SMG_SLOT_PAST = 11, SMG_SLOT_STAGE = 15,
  SMG_SLOT_COMPONENTS = SMG_SLOT_STAGES + SMG_SLOT_STAGE * SMG_STAGES
};

static inline int64_t smg_stages_size(const smg_coefficients *c) { return SMG_WIDEST + SMG_SLOT_COMPONENTS * smg_pitch(c); }

/* Slot 0 of a component, and of a component of stage i. */
static inline smg_real *smg_slot_component(const smg_state *s, int64_t k);
static inline smg_real *smg_slot_stage(const smg_state *s, int i, int64_t k) { return smg_slot_component(s, SMG_SLOT_STAGES + SMG_SLOT_STAGE * i + k); }

/* The history: the L_j of the step before, s->history = 1 once there are any. */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }
static inline size_t smg_history_size(const smg_coefficients *c) { return (size_t)(SMG_STAGE_NUMBERS * smg_sites(c)); }
static inline void smg_save_history(const smg_state *s, smg_real *out);
static inline void smg_restore_history(smg_state *s, const smg_real *in);

#include "smg_state.h"

static inline smg_real *smg_slot_component(const smg_state *s, int64_t k) { return smg_line_from(s->stages) + SMG_BEFORE + k * smg_pitch(&s->c); }

/* One of the numbers of a history on its way between sites and slots. */
typedef struct smg_past_slots {
  const smg_state *s;
  const smg_real *in;
  smg_real *out;
} smg_past_slots;

SMG_INLINE void smg_past_of_site(void *context, int64_t site, int64_t slot) {
  const smg_past_slots *a = (const smg_past_slots *)context;
  for (int q = 0; q < SMG_STAGE_NUMBERS; ++q) {
    smg_real *there = smg_slot_stage(a->s, q % SMG_STAGES, SMG_SLOT_PAST + q / SMG_STAGES) + slot;
    if (a->in) *there = a->in[SMG_STAGE_NUMBERS * site + q];
    else a->out[SMG_STAGE_NUMBERS * site + q] = *there;
  }
}

static inline void smg_save_history(const smg_state *s, smg_real *out) {
  smg_past_slots all = {s, NULL, out};
  smg_each_slot(&s->c, &all, smg_past_of_site);
}
static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  smg_past_slots all = {s, in, NULL};
  smg_each_slot(&s->c, &all, smg_past_of_site);
}

/* Four components of some slots. */
SMG_INLINE void smg_take_four(const smg_real *all, int64_t pitch, int64_t slot, smg_lanes *v) {
  for (int k = 0; k < 4; ++k) v[k] = smg_lane_take(all + k * pitch + slot);
}
SMG_INLINE void smg_put_four(smg_real *all, int64_t pitch, int64_t slot, const smg_lanes *v) {
  for (int k = 0; k < 4; ++k) smg_lane_put(all + k * pitch + slot, v[k]);
}

/* ---- z and w -------------------------------------------------------------------------------- */

/* A z with w(z) = w: the larger of z_0, z_1 is real and positive, sqrt((|w| + |w_3|)/2); nothing cancels. */
SMG_INLINE void smg_lift(const smg_lanes *w, smg_lanes *z) {
  const smg_lanes zero = {0}, norm = smg_lane_sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const smg_lanes large = smg_lane_sqrt((smg_real)0.5 * (norm + smg_lane_abs(w[2]))), part = (smg_real)0.5 / large;
  const smg_lanes re = w[0] * part, im = w[1] * part;
  const smg_lane_mask south = (smg_lane_mask)(w[2] < zero);
  z[0] = smg_lane_select(south, re, large);
  z[1] = smg_lane_select(south, -im, zero);
  z[2] = smg_lane_select(south, large, re);
  z[3] = smg_lane_select(south, zero, im);
}

/* w = 2 B(y, d), 2 B(z, z) = 2 w(z): w_1 + i w_2 = 2 conj(z_0) z_1, w_3 = |z_0|^2 - |z_1|^2, made bilinear and symmetric. */
SMG_INLINE void smg_collect(const smg_lanes *y, const smg_lanes *d, smg_lanes *w) {
  w[0] = 2 * ((y[0] * d[2] + y[2] * d[0]) + (y[1] * d[3] + y[3] * d[1]));
  w[1] = 2 * ((y[0] * d[3] + y[3] * d[0]) - (y[1] * d[2] + y[2] * d[1]));
  w[2] = 2 * ((y[0] * d[0] + y[1] * d[1]) - (y[2] * d[2] + y[3] * d[3]));
}

static void smg_lift_slots(const smg_state *s) {
  const int64_t pitch = smg_pitch(&s->c), end = smg_slots(&s->c);
  const smg_real *from = smg_slot_component(s, SMG_SLOT_W);
  smg_real *to = smg_slot_component(s, SMG_SLOT_Z);
  for (int64_t slot = 0; slot < end; slot += SMG_LANES) {
    smg_lanes w[3], z[4];
    smg_take_slots(from, pitch, slot, w);
    smg_lift(w, z);
    smg_put_four(to, pitch, slot, z);
  }
}

/* w and what it has lost into slots; empty ones hold a spin that nothing turns. */
static void smg_enter_slots(const smg_state *s) {
  smg_real *w = smg_slot_component(s, SMG_SLOT_W);
  const int64_t pitch = smg_pitch(&s->c);
  for (int64_t slot = 0; slot < smg_slots(&s->c); ++slot) w[2 * pitch + slot] = smg_radius(&s->c, 0);
  smg_to_slots(s, s->w, w);
  smg_to_slots(s, s->compensation, smg_slot_component(s, SMG_SLOT_LOST));
  smg_lift_slots(s);
}
static void smg_leave_slots(const smg_state *s) {
  smg_to_sites(s, smg_slot_component(s, SMG_SLOT_W), s->w);
  smg_to_sites(s, smg_slot_component(s, SMG_SLOT_LOST), s->compensation);
}

/* ---- the iteration -------------------------------------------------------------------------- */

/* What sweeps work with: where the slots are; where changes are marked, or NULL; h/(2 kappa), r, 1/r, sqrt(r); how
 * strongly fields turn spins; D; a piece, and the gradients of its stages. */
typedef struct smg_slot_sweep {
  smg_real *w, *z, *stages, *marks;
  int64_t pitch;
  smg_real half, radius, inverse, size, strength;
  smg_shift_matrix shift;
  smg_besides known;
  smg_piece piece;
  SMG_LINES smg_real gradient[3 * SMG_STAGES * SMG_PIECE_ROOM];
} smg_slot_sweep;

/* Component k of stage i. */
SMG_INLINE smg_real *smg_sweep_stage(const smg_slot_sweep *a, int i, int64_t k) { return a->stages + (SMG_SLOT_STAGE * i + k) * a->pitch; }

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

/* L_i by F of the slots of one vector, with its change and that change's part for the shift; the largest change is noted, and what is not a number. */
SMG_INLINE void smg_slot_slopes(const smg_slot_sweep *a, int i, int64_t slot, const smg_lanes *g, const smg_lanes *z, smg_lanes *l, smg_lanes *part, smg_lanes *change) {
  const int64_t pitch = a->pitch;
  const smg_real half = a->half * smg_gauss_weight[i];
  const smg_lanes t[3] = {half * g[0], half * g[1], half * g[2]};
  smg_lanes p[3], x[4], d[4];
  smg_take_slots(smg_sweep_stage(a, i, SMG_SLOT_POINT), pitch, slot, p);
  smg_take_four(smg_sweep_stage(a, i, SMG_SLOT_X), pitch, slot, x);
  smg_take_four(smg_sweep_stage(a, i, SMG_SLOT_SLOPE), pitch, slot, d);
  smg_turn(t, a->inverse * (p[0] * t[0] + p[1] * t[1] + p[2] * t[2]), x, l);
  for (int b = 0; b < 4; ++b) d[b] = l[b] - d[b];
  smg_part_orthogonal(z, d, part);
  *change = smg_lane_max(*change, (smg_lane_abs(d[0]) + smg_lane_abs(d[1])) + (smg_lane_abs(d[2]) + smg_lane_abs(d[3])));
}

/* L_i += (D part)_i/r, three products for each of complex numbers: (x + iy)(p + iq) = x(p + q) - (x + y)q + i (x(p + q) + (y - x)p). */
SMG_INLINE void smg_shift_slopes(const smg_slot_sweep *a, const smg_lanes *z, const smg_lanes (*part)[2], smg_lanes (*l)[4]) {
  smg_lanes sum[SMG_STAGES];
  SMG_UNROLL
  for (int j = 0; j < SMG_STAGES; ++j) sum[j] = part[j][0] + part[j][1];
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes both = a->shift.re[i][0] * sum[0], less = a->shift.sum[i][0] * part[0][1], more = a->shift.gap[i][0] * part[0][0];
    SMG_UNROLL
    for (int j = 1; j < SMG_STAGES; ++j) {
      both += a->shift.re[i][j] * sum[j];
      less += a->shift.sum[i][j] * part[j][1];
      more += a->shift.gap[i][j] * part[j][0];
    }
    smg_add_orthogonal(z, both - less, both + more, l[i]);
  }
}

/* sum_i = z + sum_j (a_ij/b_j) L_j of one component, stages i and i' = s + 1 - i together: half of the products (smg_gauss_table.h). */
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
SMG_INLINE void smg_join_slots(const smg_slot_sweep *a, int64_t slot, const smg_lanes *z, const smg_lanes (*l)[4]) {
  smg_lanes sum[SMG_STAGES][4];
  SMG_UNROLL
  for (int b = 0; b < 4; ++b) smg_combine_halves(z[b], b, l, sum);
  SMG_UNROLL
  for (int i = 0; i < SMG_STAGES; ++i) {
    smg_lanes x[4], p[3];
    smg_point(a->radius, sum[i], x, p);
    smg_put_four(smg_sweep_stage(a, i, SMG_SLOT_X), a->pitch, slot, x);
    smg_put_slots(smg_sweep_stage(a, i, SMG_SLOT_POINT), a->pitch, slot, p);
  }
}

/* L as it was, and no change, in all lanes but the first `in`. */
SMG_INLINE void smg_only_first(const smg_slot_sweep *a, int64_t slot, int64_t in, smg_lanes (*l)[4], smg_lanes *change) {
  const smg_lanes none = {0};
  *change = smg_lane_select(smg_lane_below(in), *change, none);
  for (int i = 0; i < SMG_STAGES; ++i)
    for (int b = 0; b < 4; ++b) l[i][b] = smg_lane_select(smg_lane_below(in), l[i][b], smg_lane_take(smg_sweep_stage(a, i, SMG_SLOT_SLOPE + b) + slot));
}

/* The slots of one vector, k of the piece: `in` of them belong to it, the others stay as they are. */
SMG_INLINE void smg_sweep_slots(const smg_slot_sweep *a, int64_t k, int64_t in, smg_lanes *change) {
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
  for (int i = 0; i < SMG_STAGES; ++i) smg_put_four(smg_sweep_stage(a, i, SMG_SLOT_SLOPE), a->pitch, slot, l[i]);
  smg_join_slots(a, slot, z, (const smg_lanes(*)[4])l);
}

/* The next piece of a colour, all stages; 0 where the colour ends. */
static int smg_sweep_piece(smg_state *s, smg_slot_sweep *a, smg_lanes *change) {
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
  smg_slot_sweep *a = (smg_slot_sweep *)with;
  smg_lanes change = {0};
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    smg_begin_colour(&s->c, colour, &a->piece);
    while (smg_sweep_piece(s, a, &change)) continue;
  }
  smg_real bad = 0; /* or not a number, where a lane is not: among others it may be lost */
  for (int l = 0; l < SMG_LANES; ++l) bad += ((const smg_real *)&change)[l] - ((const smg_real *)&change)[l];
  change += bad;
  const smg_moved moved = {change / (a->size * a->strength + SMG_LEAST), 2 * a->size * change, smg_lane_of(2 * a->radius * a->strength)};
  return moved;
}

/* L_j by the polynomial through those of the step before, or 0. */
SMG_INLINE void smg_ahead_slots(const smg_slot_sweep *a, int64_t slot, int extrapolated, smg_lanes (*l)[4]) {
  SMG_UNROLL
  for (int b = 0; b < 4; ++b) {
    smg_lanes past[SMG_STAGES];
    SMG_UNROLL
    for (int j = 0; j < SMG_STAGES; ++j) past[j] = extrapolated ? smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_PAST + b) + slot) : smg_lane_of(0);
    SMG_UNROLL
    for (int i = 0; i < SMG_STAGES; ++i) {
      l[i][b] = smg_gauss_ahead[0][i] * past[0];
      SMG_UNROLL
      for (int j = 1; j < SMG_STAGES; ++j) l[i][b] += smg_gauss_ahead[j][i] * past[j];
    }
  }
}

/* What the iteration begins with. */
static void smg_begin_slots(const smg_state *s, const smg_slot_sweep *a, int extrapolated) {
  const int64_t end = smg_slots(&s->c);
  for (int64_t slot = 0; slot < end; slot += SMG_LANES) {
    smg_lanes z[4], l[SMG_STAGES][4];
    smg_ahead_slots(a, slot, extrapolated, l);
    SMG_UNROLL
    for (int i = 0; i < SMG_STAGES; ++i) smg_put_four(smg_sweep_stage(a, i, SMG_SLOT_SLOPE), a->pitch, slot, l[i]);
    smg_take_four(a->z, a->pitch, slot, z);
    smg_join_slots(a, slot, z, (const smg_lanes(*)[4])l);
  }
}

#define SMG_LOOKS 16 /* spins of a piece that are looked at: theta by their mean is as good as by that of all */

/* What a piece of the first colour tells of the fields: the largest |h b/2|, and theta, the mean h b.p/r, in eighths, so that D is
 * seldom made anew. */
static smg_real smg_look_at_fields(smg_state *s, smg_slot_sweep *a) {
  const smg_real *p = smg_sweep_stage(a, SMG_STAGES / 2, SMG_SLOT_POINT), *g = a->piece.g;
  smg_real sum = 0, most = 0, looks = 0;
#if SMG_TIMED
  smg_set_time(&s->c, smg_time_at(s, smg_gauss_node[SMG_STAGES / 2]));
#endif
  smg_begin_colour(&s->c, 0, &a->piece);
  (void)smg_next_piece(&s->c, p, &a->piece);
  for (int64_t k = 0; k < a->piece.size; k += 1 + a->piece.size / SMG_LOOKS, ++looks) {
    const smg_real *b = g + k, *q = p + a->piece.start + k;
    sum += q[0] * b[0] + q[a->pitch] * b[SMG_PIECE_ROOM] + q[2 * a->pitch] * b[2 * SMG_PIECE_ROOM];
    most = smg_max(most, smg_abs(b[0]) + smg_abs(b[SMG_PIECE_ROOM]) + smg_abs(b[2 * SMG_PIECE_ROOM]));
  }
  a->strength = smg_abs(a->half) * most;
  const smg_real theta = 2 * a->half * a->inverse * sum / looks;
  if (!(smg_abs(theta) <= SMG_MOST_TURN)) return theta > 0 ? SMG_MOST_TURN : theta < 0 ? -SMG_MOST_TURN : 0;
  return (smg_real)(int)(8 * theta) / 8;
}

static smg_status smg_settle_slots(smg_state *s, smg_slot_sweep *a, int extrapolated) {
  smg_begin_slots(s, a, extrapolated);
  smg_shift_by(&a->shift, a->radius, smg_look_at_fields(s, a));
  return smg_sweep_to_rest(s, a);
}

/* The site that moves most, or is no number. */
typedef struct smg_most_moved {
  const smg_real *marks;
  smg_real most;
  int64_t site;
} smg_most_moved;

SMG_INLINE void smg_look_at_mark(void *context, int64_t site, int64_t slot) {
  smg_most_moved *found = (smg_most_moved *)context;
  if (found->marks[slot] <= found->most) return;
  found->most = found->marks[slot];
  found->site = site;
}

/* After a step that failed: by one more sweep, with marks in place of z, which the next step lifts anew. */
static int64_t smg_moving_site(smg_state *s, smg_slot_sweep *a) {
  smg_most_moved found = {a->z, -1, -1};
  for (int64_t slot = 0; slot < smg_slots(&s->c); ++slot) a->z[slot] = 0;
  a->marks = a->z;
  (void)smg_sweep_stages(s, a);
  smg_each_slot(&s->c, &found, smg_look_at_mark);
  return found.site;
}

/* ---- the step ----------------------------------------------------------------------------- */

/* w + u of the slots of one vector, with the rounding error of w carried along. */
SMG_INLINE void smg_add_to_slots(smg_real *w, int64_t pitch, int64_t slot, const smg_lanes *u, smg_lanes *sum) {
  for (int k = 0; k < 3; ++k) {
    smg_real *at = w + k * pitch + slot, *lost = at + SMG_SLOT_LOST * pitch;
    const smg_lanes old = smg_lane_take(at), y = u[k] + smg_lane_take(lost);
#if SMG_PLAIN_SUMS
    sum[k] = old + u[k];
    (void)y;
#else
    sum[k] = old + y;
    smg_lane_put(lost, y - (sum[k] - old));
#endif
    smg_lane_put(at, sum[k]);
  }
}

/* The L_j of the slots of one vector as the next step wants them: times the phase conj(y).z/r that takes y to z. */
SMG_INLINE void smg_turn_slopes(const smg_slot_sweep *a, int64_t slot, const smg_lanes *y, const smg_lanes *z) {
  const smg_lanes re = a->inverse * (y[0] * z[0] + y[1] * z[1] + (y[2] * z[2] + y[3] * z[3]));
  const smg_lanes im = a->inverse * (y[0] * z[1] - y[1] * z[0] + (y[2] * z[3] - y[3] * z[2]));
  for (int j = 0; j < SMG_STAGES; ++j)
    for (int b = 0; b < 4; b += 2) {
      const smg_lanes x = smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b) + slot), v = smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b + 1) + slot);
      smg_lane_put(smg_sweep_stage(a, j, SMG_SLOT_PAST + b) + slot, re * x - im * v);
      smg_lane_put(smg_sweep_stage(a, j, SMG_SLOT_PAST + b + 1) + slot, re * v + im * x);
    }
}

/* u = 2 B(z + dz/2, dz) and the state after the step. */
static void smg_commit_all(const smg_state *s, const smg_slot_sweep *a) {
  const int64_t end_slot = smg_slots(&s->c), pitch = a->pitch;
  for (int64_t slot = 0; slot < end_slot; slot += SMG_LANES) {
    smg_lanes z[4], dz[4], middle[4], end[4], u[3], w[3];
    smg_take_four(a->z, pitch, slot, z);
    for (int b = 0; b < 4; ++b) {
      dz[b] = smg_lane_take(smg_sweep_stage(a, 0, SMG_SLOT_SLOPE + b) + slot);
      for (int j = 1; j < SMG_STAGES; ++j) dz[b] += smg_lane_take(smg_sweep_stage(a, j, SMG_SLOT_SLOPE + b) + slot);
      middle[b] = z[b] + (smg_real)0.5 * dz[b];
      end[b] = z[b] + dz[b];
    }
    smg_collect(middle, dz, u);
    smg_add_to_slots(a->w, pitch, slot, u, w);
    smg_lift(w, z);
    smg_put_four(a->z, pitch, slot, z);
    smg_turn_slopes(a, slot, end, z);
  }
}

/* From the polynomial of the step before; when that fails, or there is none, from rest. */
static smg_status smg_slot_step(smg_state *s, smg_slot_sweep *a) {
  s->report.site = s->report.partner = -1;
  s->report.reached = 0;
  s->report.iterations = 0;
  smg_status status = s->history > 0 ? smg_settle_slots(s, a, 1) : SMG_NO_CONVERGENCE;
  if (status != SMG_OK) status = smg_settle_slots(s, a, 0);
  s->report.status = status;
  if (status != SMG_OK) {
    s->report.site = smg_moving_site(s, a);
    return status;
  }
  smg_commit_all(s, a);
  s->history = 1;
  ++s->count;
  return SMG_OK;
}

static void smg_begin_sweep(const smg_state *s, smg_slot_sweep *a) {
  a->w = smg_slot_component(s, SMG_SLOT_W);
  a->z = smg_slot_component(s, SMG_SLOT_Z);
  a->stages = smg_slot_component(s, SMG_SLOT_STAGES);
  a->pitch = smg_pitch(&s->c);
  a->radius = smg_radius(&s->c, 0);
  a->inverse = 1 / a->radius;
  a->size = SMG_MATH(sqrt)(a->radius);
  a->half = (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, smg_signed_h(s->h));
  a->marks = NULL;
  a->shift.theta = 0;
  smg_forget_besides(&a->known);
  smg_begin_piece(&s->c, &a->known, a->gradient, &a->piece);
}

/* count steps, or fewer: the first that fails is the last. */
static smg_status smg_steps(smg_state *s, int64_t count) {
  smg_status status = SMG_OK;
  smg_slot_sweep sweep;
  smg_begin_sweep(s, &sweep);
  smg_enter_slots(s);
  while (count-- > 0 && status == SMG_OK) status = smg_slot_step(s, &sweep);
  smg_leave_slots(s);
  return status;
}

static smg_status smg_step(smg_state *s) { return smg_steps(s, 1); }

#endif
