/* smidgen runtime: the increments of a lattice by rows, from settled midpoints, and what the equation of the step
 * leaves. */
#ifndef SMG_ROW_END_H
#define SMG_ROW_END_H

#include "smg_row_piece.h"
#include "smg_row_spin.h"
#include "smg_row_state.h"
#include "smg_lane_respond.h"

/* What a sweep works with, at hand in registers: spins, midpoints and, once it is known of which colour, increments by
 * slots; h/(2 kappa), 1/radius^2, the size below which a component is small, |g|^2 = 1/(36 half^2) from which an
 * increment is made to keep the length of its spin. */
typedef struct smg_turning {
  const smg_real *w, *compensation;
  smg_real *m, *u;
  int64_t pitch, u_pitch;
  smg_inverses inverses;
  smg_real half, small, weakest, relax;
  int weak, flat, stretched; /* are fields so weak that midpoints are near spins? may 1 - |g|^2 be small? are there such
                                increments? */
  smg_told told;
#if SMG_SITE_VALUES
  const smg_real *values; /* of sites, by slots */
#endif
} smg_turning;

/* The response of the sites in the slots of one vector. */
SMG_INLINE smg_told smg_told_at(const smg_turning turn, SMG_UNUSED int64_t slot) {
#if SMG_LAW_BY_SITE
  return smg_told_of_slots(turn.told, turn.values + slot, turn.pitch);
#else
  return turn.told;
#endif
}

/* Squares of vectors in the slots of one vector, those of small spheres as if they were as large as the largest one. */
SMG_INLINE smg_lanes smg_as_large(smg_real largest, smg_inverse inverse, smg_lanes square) {
  return SMG_RADII ? (smg_lanes)(largest * largest * inverse * square) : square;
}
SMG_INLINE smg_lanes smg_turned_as_large(const smg_turning turn, int64_t slot, smg_lanes square) {
  return smg_as_large(turn.small / SMG_SMALL_PART, smg_inverse_at(turn.inverses, slot), square);
}

static inline smg_turning smg_turning_of(const smg_state *s, smg_real h) {
  const smg_real half = (smg_real)0.5 * smg_h_over_kappa(&s->c, 0, h);
  smg_turning turn = {
    s->row_w,
    s->row_compensation,
    s->row_m,
    NULL,
    smg_pitch(&s->c),
    0,
    smg_inverses_of(s),
    half,
    SMG_SMALL_PART * smg_at_all_sites(&s->c, smg_radius),
    s->row_stretched ? 1 / (36 * half * half) : SMG_MAX,
    1,
    s->row_weak,
    s->row_flat,
    s->row_stretched,
    smg_told_of(&s->c, 0),
#if SMG_SITE_VALUES
    s->row_values,
#endif
  };
  return turn;
}

/* Where the increments of a colour are. */
SMG_INLINE void smg_increments_into(const smg_state *s, int64_t colour, smg_turning *turn) {
  const int kept = colour >= SMG_FIRST_KEPT(&s->c);
  turn->u = kept ? s->row_late - SMG_KEPT_FROM(&s->c) : s->row_u;
  turn->u_pitch = kept ? SMG_LATE_PITCH(&s->c) : SMG_FIRST_PITCH(&s->c);
}

/* u = h X(m) of the slots of one vector, `in` of them sites, whose gradient is g; the largest square of the residual w
 * + u/2 - rho m, rho = 1 where midpoints are no projections. */
SMG_INLINE void smg_end_slots(const smg_turning turn, int64_t slot, int64_t in, const smg_lanes *m, const smg_lanes *g,
                              smg_lanes *most) {
  smg_lanes w[3], u[3], e[3], room[3];
  smg_take_slots(turn.w, turn.pitch, slot, w);
  const smg_inverse inverse = smg_inverse_at(turn.inverses, slot);
  const smg_told told = smg_told_at(turn, slot);
  const smg_lanes *R = smg_lane_respond(&told, m, g, room);
  smg_lane_cross(u, m, R); /* the rate last: pairs of spins turn each other by exactly opposite amounts */
  smg_lane_scale(u, smg_lane_of(2 * turn.half), 3);
  if (turn.stretched) {
    smg_lanes lost[3];
    smg_take_slots(turn.compensation, turn.pitch, slot, lost);
    smg_lane_stretch(w, lost, R, inverse, turn.weakest, u);
  }
  smg_lane_waxpy(e, smg_lane_of((smg_real)0.5), u, w, 3);
  if (SMG_ONTO_LEAF) smg_lane_axpy(e, -(inverse * smg_lane_dot(w, m)), m, 3);
  else smg_lane_axpy(e, smg_lane_of(-1), m, 3);
  smg_first_lanes(in, u); /* of what is no site of the piece 0, in empty slots to stay */
  *most = smg_lane_max(*most, smg_lane_first(in, smg_turned_as_large(turn, slot, smg_lane_dot(e, e))));
  smg_put_slots(turn.u, turn.u_pitch, slot, u);
}

/* The same of all vectors that end. */
typedef struct smg_ending {
  smg_turning turn;
  smg_lanes most;
} smg_ending;

SMG_INLINE void smg_end_vector(void *context, int64_t slot, int64_t in, smg_lanes *g) {
  smg_ending *end = (smg_ending *)context;
  smg_lanes m[3];
  smg_take_slots(end->turn.m, end->turn.pitch, slot, m);
  smg_end_slots(end->turn, slot, in, m, g, &end->most);
}

/* The increments of some slots of a colour, and the largest square of their residual. */
static void smg_end_part(const smg_state *s, smg_besides *known, smg_turning turn, int64_t colour, smg_share part,
                         smg_lanes *most) {
  turn.inverses = smg_inverses_of(s);
  smg_increments_into(s, colour, &turn);
  smg_ending end = {turn, *most};
  smg_each_vector(&s->c, known, s->row_m, colour, part, &end, smg_end_vector);
  *most = end.most;
}

#endif
