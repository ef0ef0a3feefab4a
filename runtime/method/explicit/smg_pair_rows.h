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

#include "smg_explicit_step.h"
#include "smg_pair_state.h"

/* What the model says of a class, in a row of its table smg_row_classes: colour and rank of the rows where its bonds
 * begin; which of what is beside them is their other end; whether direction 0 is a ring for them; layers from end to
 * end; which term. */
enum { SMG_CLASS_COLOUR, SMG_CLASS_RANK, SMG_CLASS_BESIDE, SMG_CLASS_RING, SMG_CLASS_AWAY, SMG_CLASS_TERM };

/* What its turns work with: w and what it has lost; h/(2 kappa^2). */
typedef struct smg_pair_turning {
  smg_turned all;
  smg_real half;
} smg_pair_turning;

SMG_INLINE void smg_select_spins(smg_lane_mask test, const smg_lane_spins *b, smg_lane_spins *a) {
  smg_lane_choose(a->w, test, a->w, b->w, 3);
  smg_lane_choose(a->lost, test, a->lost, b->lost, 3);
}

/* In the lanes of a test alone: the others keep what stands there. */
SMG_INLINE void smg_put_some_spins(const smg_pair_turning *turn, int64_t slot, smg_lane_mask test,
                                   const smg_lane_spins *a) {
  smg_lane_spins here, those = *a;
  smg_take_spins(turn->all, slot, &here);
  smg_select_spins(test, &here, &those);
  smg_put_spins(turn->all, slot, &those);
}

/* smg_turn_pair. */
SMG_INLINE void smg_turn_bonds_in_lanes(const smg_coefficients *c, const smg_pair_turning *turn, int64_t term,
                                        smg_lane_spins *v, smg_lane_spins *w) {
  const smg_real kappa = smg_kappa(c, 0);
  const smg_lanes a = turn->half * smg_lane_bond_slope(c, term, smg_lane_dot(v->w, w->w));
  (void)smg_lane_turn_both(a, kappa, kappa, v->w, v->lost, w->w, w->lost);
}

/* The same where some lanes are no bond: beyond the run, of empty slots, with another end beyond an open one or around
 * a ring. */
static void smg_turn_some(const smg_coefficients *c, const smg_pair_turning *turn, const int64_t *which,
                          const smg_run *run, int64_t j, int64_t p) {
  const smg_beside *b = run->b + which[SMG_CLASS_BESIDE];
  const int64_t slot = run->start + j, in = run->to - j;
  const smg_lane_mask sites = smg_lane_below(in) & (smg_lane_mask)(smg_lane_places(run, p) < (smg_real)run->sites);
  const int inside = smg_all_within(b, p, in < SMG_LANES ? in : SMG_LANES), around = which[SMG_CLASS_RING] && !inside;
  smg_lane_mask within = sites;
  smg_lane_spins v, w, far, before;
  if (!inside) within &= smg_lanes_within(run, b, p);
  smg_take_spins(turn->all, slot, &v);
  smg_take_spins(turn->all, slot + b->start, &w);
  if (around) {
    smg_take_spins(turn->all, slot + b->around, &far);
    smg_select_spins(within, &far, &w);
  }
  before = v;
  smg_turn_bonds_in_lanes(c, turn, which[SMG_CLASS_TERM], &v, &w);
  smg_select_spins(around ? sites : within, &before, &v);
  smg_put_spins(turn->all, slot, &v);
  smg_put_some_spins(turn, slot + b->start, within, &w);
  if (around) smg_put_some_spins(turn, slot + b->around, sites & smg_lane_not(within), &w);
}

/* The bonds of a class that begin in a run of rows. */
static void smg_turn_run(const smg_coefficients *c, const smg_pair_turning turn, const int64_t *which,
                         const smg_run *run) {
  const smg_beside *b = run->b + which[SMG_CLASS_BESIDE];
  const int64_t term = which[SMG_CLASS_TERM], start = run->start, to = run->to, full = run->sites == run->length;
  for (int64_t j = 0, p = 0; j < to; j += SMG_LANES, p = smg_next_place(p, run->length)) {
    if (to - j < SMG_LANES || !(full || p + SMG_LANES <= run->sites) || !smg_all_within(b, p, SMG_LANES)) {
      smg_turn_some(c, &turn, which, run, j, p);
      continue;
    }
    smg_lane_spins v, w;
    smg_take_spins(turn.all, start + j, &v);
    smg_take_spins(turn.all, start + b->start + j, &w);
    smg_turn_bonds_in_lanes(c, &turn, term, &v, &w);
    smg_put_spins(turn.all, start + j, &v);
    smg_put_spins(turn.all, start + b->start + j, &w);
  }
}

/* Layers, and rows of one that a place has. */
static inline int64_t smg_layers(const smg_coefficients *c) { return SMG_LAYERED > 0 ? smg_cells(c, SMG_LAYERED) : 1; }
static inline int64_t smg_layer_rows(const smg_coefficients *c) { return smg_rows(c) / SMG_RANKS / smg_layers(c); }

/* Those that begin in a layer. */
static void smg_turn_layer(const smg_coefficients *c, smg_besides *known, const smg_pair_turning turn,
                           const int64_t *which, int64_t layer) {
  const int64_t length = smg_row_length(c);
  int64_t rows = smg_layer_rows(c);
  smg_lattice_row at = smg_row_of(c, which[SMG_CLASS_COLOUR], (which[SMG_CLASS_RANK] * smg_layers(c) + layer) * rows);
  while (rows > 0) {
    const int64_t alike = smg_run_of_rows(c, &at, length);
    const smg_run run = {at.start,     at.sub, at.sites, length, 0, alike * length, smg_besides_of(c, &at, known),
                         known->place, NULL,   NULL};
    if (run.b[which[SMG_CLASS_BESIDE]].there) smg_turn_run(c, turn, which, &run);
    smg_after_rows(c, length, alike, &at);
    rows -= alike;
  }
}

/* smg_restore_length of some slots. */
static void smg_restore_slots(const smg_turned all, smg_real inverse, int64_t slot, int64_t end) {
  for (; slot < end; slot += SMG_LANES) {
    smg_lane_spins v;
    smg_take_spins(all, slot, &v);
    smg_lane_axpy(v.lost, smg_lane_first(end - slot, smg_lane_way_back(inverse, v.w)), v.w, 3);
    smg_put_slots(all.lost, all.pitch, slot, v.lost);
  }
}
static void smg_restore_layer(const smg_state *s, const smg_turned all, int64_t layer) {
  const int64_t rows = smg_layer_rows(&s->c), length = smg_row_length(&s->c);
  const smg_real inverse = smg_inverse_square(&s->c);
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (int64_t rank = 0; rank < SMG_RANKS; ++rank) {
      const int64_t first = colour * smg_colour_slots(&s->c) + (rank * smg_layers(&s->c) + layer) * rows * length;
      smg_restore_slots(all, inverse, first, first + rows * length);
    }
}

/* The classes of a stage, there and back, after which lengths are restored: how many layers each goes behind the first,
 * and with which it begins. */
#define SMG_TURNED (2 * SMG_ROW_CLASSES - 1)
typedef struct smg_layer_order {
  int64_t lag[SMG_TURNED + 1], first[SMG_TURNED + 1];
} smg_layer_order;

static inline void smg_order_layers(smg_layer_order *order) {
  int64_t behind = 0, later = 0; /* the largest of lag - min(0, o), and of first + max(0, o) */
  for (int64_t k = 0; k <= SMG_TURNED; ++k) {
    const int64_t away = k < SMG_TURNED ? smg_row_classes[smg_there_and_back(k, SMG_ROW_CLASSES)][SMG_CLASS_AWAY] : 0;
    order->lag[k] = behind + (away > 0 ? away : 0);
    order->first[k] = later + (away < 0 ? -away : 0);
    behind = order->lag[k] + (away < 0 ? -away : 0);
    later = order->first[k] + (away > 0 ? away : 0);
  }
}

/* One layer of the k-th turn of a stage of the size h; after all of them, lengths. */
static void smg_turn_in_order(const smg_state *s, smg_besides *known, int64_t k, smg_real h, int64_t layer) {
  const smg_pair_turning turn = {smg_turned_of(s), smg_pair_half(s, smg_turn_h(k, SMG_ROW_CLASSES, h))};
  if (k == SMG_TURNED) {
    smg_restore_layer(s, turn.all, layer);
    return;
  }
  smg_turn_layer(&s->c, known, turn, smg_row_classes[smg_there_and_back(k, SMG_ROW_CLASSES)], layer);
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
