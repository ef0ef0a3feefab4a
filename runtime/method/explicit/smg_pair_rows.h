/* smidgen method: the steps of pair rotations (smg_pair_rotations.h) by rows of a lattice, sites in the lanes of
 * vectors, with the bits of those from bond to bond. The bonds of a class begin in rows of one colour and place; their
 * other ends stand beside them.
 *
 * A class after the other would pass through all of the memory. So the lattice is cut into layers, the cells of equal
 * s_d in the slowest direction d, and layers of several classes take turns. With o_k the layers from the first ends of
 * class k up to the second, a bond of k in layer x meets one of a later class l in layer y only if
 *
 *     y + min(0, o_l) - max(0, o_k) <= x <= y + max(0, o_l) - min(0, o_k).
 *
 * So class l goes by so many layers, its lag, behind those before it, and on a ring begins so many layers later, that x
 * comes first. */
#ifndef SMG_PAIR_ROWS_H
#define SMG_PAIR_ROWS_H

#include "smg_pair_state.h"
#include "smg_rows.h"
#include "smg_row_spin.h"

/* A class, as the model has it: colour and rank of the rows where its bonds begin; which of what is beside them is
 * their other end; whether direction 0 is a ring for them; layers from end to end; which term. */
typedef struct smg_row_class {
  int64_t colour, rank, beside, ring, away, term;
} smg_row_class;

static inline smg_row_class smg_row_class_of(int64_t k) {
  const int64_t *has = smg_row_classes[k];
  const smg_row_class all = {has[0], has[1], has[2], has[3], has[4], has[5]};
  return all;
}

/* What its turns work with: w and what it has lost, by slots; h/(2 kappa^2). */
typedef struct smg_pair_turning {
  smg_real *w, *lost;
  int64_t pitch;
  smg_real half;
} smg_pair_turning;

/* Some spins: w, and what they have lost. */
typedef struct smg_lane_spins {
  smg_lanes w[3], lost[3];
} smg_lane_spins;

SMG_INLINE void smg_take_spins(const smg_pair_turning *turn, int64_t slot, smg_lane_spins *a) {
  smg_take_slots(turn->w, turn->pitch, slot, a->w);
  smg_take_slots(turn->lost, turn->pitch, slot, a->lost);
}
SMG_INLINE void smg_put_spins(const smg_pair_turning *turn, int64_t slot, const smg_lane_spins *a) {
  smg_put_slots(turn->w, turn->pitch, slot, a->w);
  smg_put_slots(turn->lost, turn->pitch, slot, a->lost);
}
SMG_INLINE void smg_select_spins(smg_lane_mask test, const smg_lane_spins *b, smg_lane_spins *a) {
  for (int k = 0; k < 3; ++k) {
    a->w[k] = smg_lane_select(test, a->w[k], b->w[k]);
    a->lost[k] = smg_lane_select(test, a->lost[k], b->lost[k]);
  }
}

/* In the lanes of a test alone: the others keep what stands there. */
SMG_INLINE void smg_put_some_spins(const smg_pair_turning *turn, int64_t slot, smg_lane_mask test,
                                   const smg_lane_spins *a) {
  smg_lane_spins here, those = *a;
  smg_take_spins(turn, slot, &here);
  smg_select_spins(test, &here, &those);
  smg_put_spins(turn, slot, &those);
}

/* smg_turn_pair. */
SMG_INLINE void smg_turn_bonds_in_lanes(const smg_coefficients *c, const smg_pair_turning *turn, int64_t term,
                                        smg_lane_spins *v, smg_lane_spins *w) {
  const smg_real kappa = smg_kappa(c, 0);
  smg_lanes g[3], p[3], pg[3];
  const smg_lanes a = turn->half * smg_lane_bond_slope(c, term, smg_lane_dot(v->w, w->w));
  for (int b = 0; b < 3; ++b) g[b] = a * (kappa * v->w[b] + kappa * w->w[b]);
  const smg_lanes scale = 2 / (1 + smg_lane_dot(g, g)) * a;
  smg_lane_cross(p, v->w, w->w);
  smg_lane_cross(pg, p, g);
  for (int b = 0; b < 3; ++b) {
    const smg_lanes moved = kappa * (scale * (p[b] + pg[b]));
    smg_lane_add_compensated(v->w + b, v->lost + b, moved);
    smg_lane_add_compensated(w->w + b, w->lost + b, -moved);
  }
}

/* The same where some lanes are no bond: beyond the run, of empty slots, with another end beyond an open one or around
 * a ring. */
static void smg_turn_some(const smg_coefficients *c, const smg_pair_turning *turn, const smg_row_class *all,
                          const smg_run *run, int64_t j, int64_t p) {
  const smg_beside *b = run->b + all->beside;
  const int64_t slot = run->start + j, in = run->to - j;
  const smg_lane_mask sites = smg_lane_below(in) & (smg_lane_mask)(smg_lane_places(run, p) < (smg_real)run->sites);
  const int inside = smg_all_within(b, p, in < SMG_LANES ? in : SMG_LANES), around = all->ring && !inside;
  smg_lane_mask within = sites;
  smg_lane_spins v, w, far, before;
  if (!inside) within &= smg_lanes_within(run, b, p);
  smg_take_spins(turn, slot, &v);
  smg_take_spins(turn, slot + b->start, &w);
  if (around) {
    smg_take_spins(turn, slot + b->around, &far);
    smg_select_spins(within, &far, &w);
  }
  before = v;
  smg_turn_bonds_in_lanes(c, turn, all->term, &v, &w);
  smg_select_spins(around ? sites : within, &before, &v);
  smg_put_spins(turn, slot, &v);
  smg_put_some_spins(turn, slot + b->start, within, &w);
  if (around) smg_put_some_spins(turn, slot + b->around, sites & smg_lane_not(within), &w);
}

/* The bonds of a class that begin in a run of rows. */
static void smg_turn_run(const smg_coefficients *c, const smg_pair_turning turn, const smg_row_class *all,
                         const smg_run *run) {
  const smg_beside *b = run->b + all->beside;
  const int64_t term = all->term, start = run->start, to = run->to, full = run->sites == run->length;
  for (int64_t j = 0, p = 0; j < to; j += SMG_LANES, p = smg_next_place(p, run->length)) {
    if (to - j < SMG_LANES || !(full || p + SMG_LANES <= run->sites) || !smg_all_within(b, p, SMG_LANES)) {
      smg_turn_some(c, &turn, all, run, j, p);
      continue;
    }
    smg_lane_spins v, w;
    smg_take_spins(&turn, start + j, &v);
    smg_take_spins(&turn, start + b->start + j, &w);
    smg_turn_bonds_in_lanes(c, &turn, term, &v, &w);
    smg_put_spins(&turn, start + j, &v);
    smg_put_spins(&turn, start + b->start + j, &w);
  }
}

/* Layers, and rows of one that a place has. */
static inline int64_t smg_layers(const smg_coefficients *c) { return SMG_LAYERED > 0 ? smg_cells(c, SMG_LAYERED) : 1; }
static inline int64_t smg_layer_rows(const smg_coefficients *c) { return smg_rows(c) / SMG_RANKS / smg_layers(c); }

/* Those that begin in a layer. */
static void smg_turn_layer(const smg_coefficients *c, smg_besides *known, const smg_pair_turning turn,
                           const smg_row_class *all, int64_t layer) {
  const int64_t length = smg_row_length(c);
  int64_t rows = smg_layer_rows(c);
  smg_lattice_row at = smg_row_of(c, all->colour, (all->rank * smg_layers(c) + layer) * rows);
  while (rows > 0) {
    const int64_t alike = smg_run_of_rows(c, &at, length);
    const smg_run run = {at.start,     at.sub, at.sites, length, 0, alike * length, smg_besides_of(c, &at, known),
                         known->place, NULL,   NULL};
    if (run.b[all->beside].there) smg_turn_run(c, turn, all, &run);
    smg_after_rows(c, length, alike, &at);
    rows -= alike;
  }
}

/* smg_restore_length of some slots. */
static void smg_restore_slots(const smg_pair_turning turn, smg_real inverse, int64_t slot, int64_t end) {
  const smg_lanes none = {0};
  for (; slot < end; slot += SMG_LANES) {
    smg_lane_spins v;
    smg_take_spins(&turn, slot, &v);
    smg_lanes back = (smg_real)0.5 * SMG_RESTORED * (1 - inverse * smg_lane_dot(v.w, v.w));
    if (end - slot < SMG_LANES) back = smg_lane_select(smg_lane_below(end - slot), back, none);
    for (int k = 0; k < 3; ++k) v.lost[k] += back * v.w[k];
    smg_put_slots(turn.lost, turn.pitch, slot, v.lost);
  }
}
static void smg_restore_layer(const smg_state *s, const smg_pair_turning turn, int64_t layer) {
  const int64_t rows = smg_layer_rows(&s->c), length = smg_row_length(&s->c);
  const smg_real inverse = smg_row_inverse(s);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (int64_t rank = 0; rank < SMG_RANKS; ++rank) {
      const int64_t first = colour * smg_colour_slots(&s->c) + (rank * smg_layers(&s->c) + layer) * rows * length;
      smg_restore_slots(turn, inverse, first, first + rows * length);
    }
}

/* The classes of a stage, there and back, after which lengths are restored: how many layers each goes behind the first,
 * and with which it begins. */
#define SMG_TURNED (2 * SMG_ROW_CLASSES - 1)
typedef struct smg_layer_order {
  int64_t lag[SMG_TURNED + 1], first[SMG_TURNED + 1];
} smg_layer_order;

static inline int64_t smg_class_of_turn(int64_t k) { return k < SMG_ROW_CLASSES ? k : SMG_TURNED - 1 - k; }

static inline void smg_order_layers(smg_layer_order *order) {
  int64_t behind = 0, later = 0; /* the largest of lag - min(0, o), and of first + max(0, o) */
  for (int64_t k = 0; k <= SMG_TURNED; ++k) {
    const int64_t away = k < SMG_TURNED ? smg_row_class_of(smg_class_of_turn(k)).away : 0;
    order->lag[k] = behind + (away > 0 ? away : 0);
    order->first[k] = later + (away < 0 ? -away : 0);
    behind = order->lag[k] + (away < 0 ? -away : 0);
    later = order->first[k] + (away > 0 ? away : 0);
  }
}

/* One layer of the k-th turn of a stage of the size h; after all of them, lengths. */
static void smg_turn_in_order(const smg_state *s, smg_besides *known, int64_t k, smg_real h, int64_t layer) {
  const smg_pair_turning turn = {s->row_w, s->row_compensation, smg_pitch(&s->c),
                                 smg_pair_half(s, k == SMG_ROW_CLASSES - 1 ? h : (smg_real)0.5 * h)};
  if (k == SMG_TURNED) {
    smg_restore_layer(s, turn, layer);
    return;
  }
  const smg_row_class all = smg_row_class_of(smg_class_of_turn(k));
  smg_turn_layer(&s->c, known, turn, &all, layer);
}

/* smg_stage; at the end of a step, lengths as well. */
static void smg_row_stage(const smg_state *s, smg_besides *known, const smg_turn_stage part) {
  const int64_t layers = smg_layers(&s->c), turns = SMG_TURNED + (part.end != 0);
  smg_layer_order order;
  smg_order_layers(&order);
  for (int64_t at = 0; at < layers + order.lag[turns - 1] + order.first[turns - 1]; ++at)
    for (int64_t k = 0; k < turns; ++k) {
      const int64_t layer = at - order.lag[k];
      if (layer >= order.first[k] && layer < order.first[k] + layers)
        smg_turn_in_order(s, known, k, part.h, layer % layers);
    }
}

#include "smg_turn_steps.h"

#endif
