/* smidgen runtime: the proof of smg_krylov_coercive() by rows in lanes. With v the changes of midpoints m across them,
 * the equation rho m - h/2 m x dH/dw = w has the derivative
 *
 *     K v = rho v - h/2 (m x B v + (m.dH/dw/r^2) v x m),
 *
 * whose symmetric part lacks the last term: in units of 1/sqrt(rho), where v = q y, q = 1/sqrt(rho), it is
 *
 *     y - h/4 q P (m x B q y - B (m x q y)),
 *
 * P across m. Where that is positive, K is regular, with a positive determinant. B x is the gradient at x without that
 * at 0, where the Hessian is the same at all states. */
#ifndef SMG_ROW_MEAN_H
#define SMG_ROW_MEAN_H

#include "smg_krylov.h"
#include "smg_row_end.h"

#define SMG_ROW_MEANS \
  (SMG_MATRIX_FREE && SMG_CONSTANT_HESSIAN && !SMG_TOLD && !SMG_TORQUES && !SMG_PUSHES && SMG_SITE_VALUES == 0)

#if SMG_ROW_MEANS
/* What it works with, by slots: B x of no spins; x = P q y, m x that, and B x; where a visit puts B; q. */
typedef struct smg_row_mean {
  const smg_state *s;
  smg_besides *known;
  smg_turning turn;
  smg_real *rest, *x, *turned, *across, *field, *q;
} smg_row_mean;

/* v without its part along m. */
SMG_INLINE void smg_mean_across(const smg_turning turn, const smg_lanes *m, smg_lanes *v) {
  smg_lane_axpy(v, -(turn.inverses * smg_lane_dot(m, v)), m, 3);
}

/* q of all slots, 0 where there is no spin; the largest 1/rho. */
static smg_real smg_mean_scales(const smg_row_mean *a) {
  smg_lanes most = {0};
  for (int64_t slot = 0, slots = smg_slots(&a->s->c); slot < slots; slot += SMG_LANES) {
    smg_lanes w[3], m[3];
    smg_take_slots(a->turn.w, a->turn.pitch, slot, w);
    smg_take_slots(a->turn.m, a->turn.pitch, slot, m);
    const smg_lanes inverse = 1 / (a->turn.inverses * smg_lane_dot(w, m));
    const smg_lane_mask there = (smg_lane_mask)(smg_lane_dot(w, w) > 0);
    most = smg_lane_max(most, smg_lane_select(there, inverse, smg_lane_of(0)));
    smg_lane_put(a->q + slot, smg_lane_select(there, smg_lane_sqrt(inverse), smg_lane_of(0)));
  }
  return smg_lane_largest(most);
}

/* B x of the slots of one vector, whose gradient at x is g. */
SMG_INLINE void smg_mean_field(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  const smg_row_mean *a = (const smg_row_mean *)context;
  smg_lanes rest[3];
  smg_take_slots(a->rest, a->turn.pitch, slot, rest);
  smg_lane_axpy(g, smg_lane_of(-1), rest, 3);
  smg_first_lanes(in, g);
  smg_put_slots(a->field, a->turn.pitch, slot, g);
}

/* B x of all slots into `field`. */
static void smg_mean_fields(smg_row_mean *a, const smg_real *x, smg_real *field) {
  a->field = field;
  SMG_TEAM(a->s->row_team) {
    for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
      smg_each_vector(&a->s->c, a->known, x, colour, smg_share_of(&a->s->c, colour, 1), a, smg_mean_field);
  }
}

/* z = the symmetric part times y. */
static void smg_mean_times(void *of, const smg_real *y, smg_real *z) {
  smg_row_mean *a = (smg_row_mean *)of;
  const int64_t pitch = a->turn.pitch, slots = smg_slots(&a->s->c);
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes m[3], x[3], turned[3];
    smg_take_slots(a->turn.m, pitch, slot, m);
    smg_take_slots(y + SMG_BEFORE, pitch, slot, x);
    smg_mean_across(a->turn, m, x);
    smg_lane_scale(x, smg_lane_take(a->q + slot), 3);
    smg_lane_cross(turned, m, x);
    smg_put_slots(a->x, pitch, slot, x);
    smg_put_slots(a->turned, pitch, slot, turned);
  }
  smg_mean_fields(a, a->x, a->across);
  smg_mean_fields(a, a->turned, a->x);
  smg_copy(z, y, 3 * pitch);
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes m[3], field[3], less[3], v[3], out[3];
    smg_take_slots(a->turn.m, pitch, slot, m);
    smg_take_slots(a->across, pitch, slot, field);
    smg_take_slots(a->x, pitch, slot, less);
    smg_take_slots(z + SMG_BEFORE, pitch, slot, out);
    smg_lane_cross(v, m, field);
    smg_lane_axpy(v, smg_lane_of(-1), less, 3);
    smg_mean_across(a->turn, m, v);
    smg_lane_axpy(out, -(smg_real)0.5 * a->turn.half * smg_lane_take(a->q + slot), v, 3);
    smg_put_slots(z + SMG_BEFORE, pitch, slot, out);
  }
}

/* Is K shown to be regular? In the memory of the basis of a Krylov space; B: a bound on the norms of a row of the
 * Hessian. */
static int smg_mean_shows(const smg_state *s, smg_besides *known, const smg_turning turn, smg_real B, smg_real *q) {
  const size_t size = (size_t)smg_array_size(&s->c);
  if (7 * size + SMG_WIDEST >= smg_krylov_worksize(SMG_BS * smg_coupled(&s->c))) return 0;
  smg_real *next = smg_line_from(s->work) + 3 * size;
  smg_row_mean a = {s, known, turn, NULL, NULL, NULL, NULL, NULL, q};
  a.turn.inverses = smg_inverses_of(s);
  a.rest = smg_place_slots(&next, size);
  a.x = smg_place_slots(&next, size);
  a.turned = smg_place_slots(&next, size);
  a.across = smg_place_slots(&next, size);
  const smg_real spread = smg_abs(turn.half) * smg_radius(&s->c, 0) * B * smg_mean_scales(&a);
  const smg_krylov mean = {&a, smg_mean_times, (int64_t)size, smg_line_from(s->work)};
  if (!(spread <= SMG_CLEAR)) return 0;
  smg_zero(a.x - SMG_BEFORE, (int64_t)size);
  smg_zero(a.rest - SMG_BEFORE, (int64_t)size);
  smg_mean_fields(&a, a.x, a.rest);
  return smg_krylov_coercive(&mean, spread);
}
#else
static inline int smg_mean_shows(SMG_UNUSED const smg_state *s, SMG_UNUSED smg_besides *known,
                                 SMG_UNUSED const smg_turning turn, SMG_UNUSED smg_real B, SMG_UNUSED smg_real *q) {
  return 0;
}
#endif

#endif
