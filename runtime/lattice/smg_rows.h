/* smidgen runtime: the sites of a lattice in rows, for vectors of lanes.
 *
 * Sites of one colour do not feel each other unless that takes many colours (gen/compile/plan/colouring.py): a colour
 * is (weights . cell + shift of the place) mod SMG_COLOURS. Along direction 0 a row of the lattice holds every
 * SMG_ROW_STEP-th site of a colour, s0 = first + SMG_ROW_STEP j: every SMG_COLOURS-th, or all where the place in the
 * cell alone decides. An array holds three times smg_pitch numbers, all x, all y, all z, each in slots: colour after
 * colour, row after row, j after j. Rows have one length; where one has a site less, or is rounded up, its last slots
 * stay empty. So the neighbours of a row of sites lie in a row of slots, and lanes are loaded as they stand, and at the
 * ends of a row from two places.
 *
 * In a plane, rows that begin alike follow each other: s1 = 0, SMG_ROW_STEP, .., then 1, SMG_ROW_STEP + 1, .. Their
 * neighbours do so too, at the same distance in slots but for s1 near an end. So such rows are one run of slots, and
 * vectors go across from one to the next: rows need not be longer than a vector. Where the lattice is one large plane
 * of long rows, they follow each other as they lie, and feel the next ones alone (smg_row_wave.h). Small lattices stand
 * in blocks instead, one in each lane (smg_row_blocks.h). The order of the slots is the same for all SMG_LANES. */
#ifndef SMG_ROWS_H
#define SMG_ROWS_H

#include "smg_model.h"
#include "smg_slots.h"

#include <string.h>

/* numbers before the first slot and after the last that vectors reach into (colouring.py) */
#define SMG_BEFORE 8
#define SMG_AFTER 16
#define SMG_LONG_ROW 64 /* slots from which a row takes whole vectors: at most an eighth stays empty */
#ifndef SMG_LARGE_PLANE
#define SMG_LARGE_PLANE 375000 /* slots of all colours; 60 MB of arrays */
#endif
/* Slots that a sweep works on at a time: fields, spins and midpoints of 256 are 18 KB; four stages of 64 spins 24
 * KB. */
#if SMG_ROW_STAGES
#define SMG_PIECE 64
#else
#define SMG_PIECE 256
#endif
#define SMG_PIECE_ROOM (SMG_PIECE + SMG_BEFORE)

/* What the model says: cells of a direction (1 of those beyond); the shift of a place, its number among the SMG_RANKS
 * places of its colour in a row, and the place of that number. */
static inline int64_t smg_cells(const smg_coefficients *c, int d);
static inline int64_t smg_shift(int64_t sub);
static inline int64_t smg_rank(int64_t sub);
static inline int64_t smg_place(int64_t colour, int64_t rank);

/* Families stand one after the other, each with so many places of every cell: the number of the site at a place of a
 * cell, and the place of a site. */
#define SMG_HOME_PLACES (SMG_PLACES / SMG_FAMILIES)
SMG_INLINE int64_t smg_numbered_site(const smg_coefficients *c, int64_t cell, int64_t sub) {
  return SMG_FAMILIES > 1
             ? (sub / SMG_HOME_PLACES * (smg_sites(c) / SMG_PLACES) + cell) * SMG_HOME_PLACES + sub % SMG_HOME_PLACES
             : cell * SMG_PLACES + sub;
}
static inline int64_t smg_place_of_site(const smg_coefficients *c, int64_t site) {
  return (SMG_FAMILIES > 1 ? site / (smg_sites(c) / SMG_FAMILIES) * SMG_HOME_PLACES : 0) + site % SMG_HOME_PLACES;
}

/* One row: its colour, place and cells; s0 of its first site, how many there are, and the slot of the first; kind: that
 * of all rows with these s2 and s3. */
typedef struct smg_lattice_row {
  int64_t colour, rank, sub, s1, s2, s3, first, sites, start, kind;
} smg_lattice_row;

/* a/n rounded down and what is left, for |a| < 2^40 n and a known n > 0. */
SMG_INLINE int64_t smg_down(int64_t a, int64_t n) {
  return (int64_t)((uint64_t)(a + n * ((int64_t)1 << 40)) / (uint64_t)n) - ((int64_t)1 << 40);
}
SMG_INLINE int64_t smg_left(int64_t a, int64_t n) {
  return (int64_t)((uint64_t)(a + n * ((int64_t)1 << 40)) % (uint64_t)n);
}

SMG_INLINE int64_t smg_colour_of(int64_t sub, int64_t s0, int64_t s1, int64_t s2, int64_t s3) {
  return smg_left(SMG_WEIGHT_0 * s0 + SMG_WEIGHT_1 * s1 + SMG_WEIGHT_2 * s2 + SMG_WEIGHT_3 * s3 + smg_shift(sub),
                  SMG_COLOURS);
}

static inline int64_t smg_weight_of(int d) {
  const int64_t weights[4] = {SMG_WEIGHT_0, SMG_WEIGHT_1, SMG_WEIGHT_2, SMG_WEIGHT_3};
  return weights[d];
}

/* Slots of a row, rows of a colour, slots of a colour, and of all. Long rows and colours begin where a vector does. */
static inline int64_t smg_row_length(const smg_coefficients *c) {
  const int64_t n = (smg_cells(c, 0) + SMG_ROW_STEP - 1) / SMG_ROW_STEP;
  return n < SMG_LONG_ROW ? n : smg_whole_vectors(n);
}
static inline int64_t smg_rows(const smg_coefficients *c) {
  return SMG_RANKS * smg_cells(c, 1) * smg_cells(c, 2) * smg_cells(c, 3);
}
static inline int64_t smg_colour_slots(const smg_coefficients *c) {
  return smg_whole_vectors(smg_rows(c) * smg_row_length(c));
}
static inline int64_t smg_slots(const smg_coefficients *c) { return SMG_COLOURS * smg_colour_slots(c); }

/* slots of a colour that are worth a thread: some 8 microseconds of work; a team takes 1 to 2 to begin and end */
#ifndef SMG_SHARE
#define SMG_SHARE 1024
#endif

/* Some slots: from <= slot < to. */
typedef struct smg_share {
  int64_t from, to;
} smg_share;

/* Numbers from x to y of an array, and numbers of an array. */
static inline int64_t smg_pitch(const smg_coefficients *c) { return smg_slots(c) + SMG_BEFORE + SMG_AFTER; }
static inline int64_t smg_array_size(const smg_coefficients *c) { return 3 * smg_pitch(c); }

/* Do sites of one colour feel each other across the seam of a ring that is no multiple of the colours? Anywhere? Then
 * those of one piece turn at once, and use the newest midpoints of all others. */
SMG_INLINE int smg_meet_along(const smg_coefficients *c, int d) {
  return (SMG_RINGS >> d & 1) && smg_weight_of(d) * smg_cells(c, d) % SMG_COLOURS > 0;
}
static inline int smg_colours_meet(const smg_coefficients *c) {
  return SMG_COLOURS_MEET || smg_meet_along(c, 0) || smg_meet_along(c, 1) || smg_meet_along(c, 2) ||
         smg_meet_along(c, 3);
}

/* From a row of a plane to the next one in memory; at the end of the plane another q begins. */
SMG_INLINE int64_t smg_plane_step(const smg_coefficients *c, int64_t length) {
  return smg_cells(c, 2) * smg_cells(c, 3) == 1 && length >= SMG_LONG_ROW &&
                 SMG_COLOURS * smg_rows(c) * length >= SMG_LARGE_PLANE && !smg_colours_meet(c)
             ? 1
             : SMG_ROW_STEP;
}

/* Rows of a plane in the q-th turn, and the place of a row among all of its plane. */
SMG_INLINE int64_t smg_rows_like(const smg_coefficients *c, int64_t step, int64_t q) {
  return (smg_cells(c, 1) - q + step - 1) / step;
}
static inline int64_t smg_place_in_plane(const smg_coefficients *c, int64_t s1) {
  const int64_t step = smg_plane_step(c, smg_row_length(c)), q = s1 % step, longer = smg_cells(c, 1) % step;
  return q * (smg_cells(c, 1) / step) + (q < longer ? q : longer) + s1 / step;
}

/* The first slot of a row in its colour, and in all. */
static inline int64_t smg_row_slot(const smg_coefficients *c, int64_t rank, int64_t s1, int64_t s2, int64_t s3) {
  const int64_t plane = (rank * smg_cells(c, 3) + s3) * smg_cells(c, 2) + s2;
  return (plane * smg_cells(c, 1) + smg_place_in_plane(c, s1)) * smg_row_length(c);
}
static inline int64_t smg_row_start(const smg_coefficients *c, int64_t colour, int64_t sub, int64_t s1, int64_t s2,
                                    int64_t s3) {
  return colour * smg_colour_slots(c) + smg_row_slot(c, smg_rank(sub), s1, s2, s3);
}

/* Kinds of rows: what stands beside one depends, along a direction, on its cell alone where that is within SMG_REACH_d
 * of an end, and else not; and on how it begins, and among which rows of its plane it stands. */
#define SMG_KINDS(reach) (2 * (reach) + 1)
/* of rows in their plane: near its ends each, the others by s1 mod SMG_ROW_STEP */
#define SMG_ROW_KINDS (2 * SMG_REACH_1 + SMG_ROW_STEP)
#define SMG_KNOWN \
  (SMG_COLOURS * SMG_RANKS * SMG_KINDS(SMG_REACH_3) * SMG_KINDS(SMG_REACH_2) * SMG_ROW_KINDS * SMG_ROW_STEP)
/* up to so many, times the neighbours of a site, their table is on the stack: 16 KB; else in the memory of the state */
#define SMG_AT_HAND 400
#define SMG_MANY_KINDS (SMG_KNOWN * SMG_BESIDES > SMG_AT_HAND)
#if SMG_MANY_KINDS
#define SMG_KINDS_OF(s) ((s)->row_kinds)
#else
#define SMG_KINDS_OF(s) NULL
#endif
SMG_INLINE int64_t smg_kind_of_cell(int64_t s, int64_t n, int64_t reach) {
  return s < reach ? s : s < n - reach ? reach : s - n + SMG_KINDS(reach);
}

SMG_INLINE int64_t smg_kind_of_row(int64_t s1, int64_t n) {
  return s1 < SMG_REACH_1 ? s1 : s1 < n - SMG_REACH_1 ? SMG_REACH_1 + s1 % SMG_ROW_STEP : s1 - n + SMG_ROW_KINDS;
}

SMG_INLINE int64_t smg_sites_from(const smg_coefficients *c, int64_t first) {
  return smg_down(smg_cells(c, 0) - first + SMG_ROW_STEP - 1, SMG_ROW_STEP);
}

/* What follows from the place of a row: weights . cell + shift = colour. SMG_TURN_0 undoes the weight of s0. */
static inline void smg_row_place(const smg_coefficients *c, smg_lattice_row *at) {
  at->sub = smg_place(at->colour, at->rank);
  at->first = smg_left(SMG_TURN_0 * (at->colour - smg_colour_of(at->sub, 0, at->s1, at->s2, at->s3)), SMG_ROW_STEP);
  at->sites = smg_sites_from(c, at->first);
  at->kind = (at->colour * SMG_RANKS + at->rank) * SMG_KINDS(SMG_REACH_3) +
             smg_kind_of_cell(at->s3, smg_cells(c, 3), SMG_REACH_3);
  at->kind = at->kind * SMG_KINDS(SMG_REACH_2) + smg_kind_of_cell(at->s2, smg_cells(c, 2), SMG_REACH_2);
}

/* The row-th of a colour. */
static inline smg_lattice_row smg_row_of(const smg_coefficients *c, int64_t colour, int64_t row) {
  const int64_t above = row / smg_cells(c, 1), over = above / smg_cells(c, 2), length = smg_row_length(c),
                step = smg_plane_step(c, length);
  smg_lattice_row at = {colour, over / smg_cells(c, 3), 0, 0, 0, 0, 0, 0, 0, 0};
  int64_t among = row - above * smg_cells(c, 1);
  while (among >= smg_rows_like(c, step, at.s1)) among -= smg_rows_like(c, step, at.s1++);
  at.s1 += step * among;
  at.s2 = above - over * smg_cells(c, 2);
  at.s3 = over - at.rank * smg_cells(c, 3);
  at.start = colour * smg_colour_slots(c) + row * length;
  smg_row_place(c, &at);
  return at;
}

/* The cells after all of direction 1; then the place. */
static inline void smg_next_plane(const smg_coefficients *c, smg_lattice_row *at) {
  at->s1 = 0;
  if (++at->s2 == smg_cells(c, 2)) {
    at->s2 = 0;
    if (++at->s3 == smg_cells(c, 3)) {
      at->s3 = 0;
      if (++at->rank == SMG_RANKS) return;
    }
  }
  smg_row_place(c, at);
}

/* The next row of the colour, which begins where this one ends; after the last one, that has the rank SMG_RANKS. */
SMG_INLINE void smg_next_row(const smg_coefficients *c, int64_t length, smg_lattice_row *at) {
  const int64_t step = smg_plane_step(c, length), turn = at->s1 % step;
  at->start += length;
  at->s1 += step;
  if (at->s1 < smg_cells(c, 1)) {
    if (step == SMG_ROW_STEP) return;
  } else if (turn + 1 < step && turn + 1 < smg_cells(c, 1)) at->s1 = turn + 1;
  else {
    smg_next_plane(c, at);
    return;
  }
  at->first = smg_left(at->first - SMG_TURN_0 * SMG_WEIGHT_1, SMG_ROW_STEP);
  at->sites = smg_sites_from(c, at->first);
}

/* How many rows from this one on are one run: begin alike, with all that is beside them at the same distances. */
SMG_INLINE int64_t smg_run_of_rows(const smg_coefficients *c, const smg_lattice_row *at, int64_t length) {
  const int64_t end = smg_cells(c, 1) - SMG_REACH_1;
  return at->s1 >= SMG_REACH_1 && at->s1 < end && smg_plane_step(c, length) == SMG_ROW_STEP
             ? (end - at->s1 + SMG_ROW_STEP - 1) / SMG_ROW_STEP
             : 1;
}

/* The row after some of a run. */
SMG_INLINE void smg_after_rows(const smg_coefficients *c, int64_t length, int64_t rows, smg_lattice_row *at) {
  at->s1 += SMG_ROW_STEP * (rows - 1); /* 0 where each row is a run */
  at->start += length * (rows - 1);
  smg_next_row(c, length, at);
}

/* The sites beside those of a row, at one distance: that beside the j-th stands `start` slots after its first, and j
 * more, for from <= j < to, SMG_EVERYWHERE where that is all of them; the others, beyond the ends of the row, stand
 * `around`, and j more, after it where direction 0 is a ring. there: do the other directions not end before? */
typedef struct smg_beside {
  int64_t start, around, from, to, there;
} smg_beside;

#define SMG_EVERYWHERE INT64_MAX

/* In blocks: how many slots what is beside lane 0 of a vector stands from that, SMG_BESIDES of them; where it is not
 * lane 0 of a vector, all of them and SMG_SOME_TURNED; and which lane each takes where lane 0 takes the t-th. */
#if defined(__GNUC__)
typedef int32_t smg_slot_beside __attribute__((may_alias));
#else
typedef int32_t smg_slot_beside;
#endif
#define SMG_SOME_TURNED (1 << 27)
typedef struct smg_lane_order {
  SMG_LINES int64_t of[SMG_WIDEST];
} smg_lane_order;

/* Some slots of a run of rows, those from <= j < to: the slot where j = 0; the place of all, and how many sites each
 * row has; slots of a row; what stands beside all of them; of short rows, the places of slots in their rows; numbers of
 * sites; where changes begin, for the tangent map; beside, order: of a run of blocks. */
typedef struct smg_run {
  int64_t start, sub, sites, length, from, to;
  const smg_beside *b;
  const smg_real *place;
#if SMG_SITE_VALUES
  const smg_real *values;
#endif
#if SMG_TANGENT
  const smg_real *points;
#endif
  const smg_slot_beside *beside;
  const smg_lane_order *order;
} smg_run;

/* The cell s + offset, on a ring around it; 0 where there is none. */
static inline int smg_step_to(int64_t *s, int64_t offset, int64_t n, int ring) {
  *s += ring ? offset % n : offset; /* one end of a bond may be farther from another than the ring is long */
  if (ring) *s = smg_wrap(*s, n);
  return *s >= 0 && *s < n;
}

/* The slot of the site x of the row of a place and cells, as if it went on beyond its ends. */
static inline int64_t smg_slot_beyond(const smg_coefficients *c, int64_t sub, int64_t x, const int64_t *s) {
  return smg_row_start(c, smg_colour_of(sub, x, s[0], s[1], s[2]), sub, s[0], s[1], s[2]) + smg_down(x, SMG_ROW_STEP);
}

/* Sites at one distance from those of a place: their place, and by how much their cell is away; bit d of ring says
 * whether direction d closes. */
typedef struct smg_offset {
  int64_t sub, cell[4];
  int ring;
} smg_offset;

/* All that is beside the sites of a place, SMG_BESIDES at most: as the model says. */
static inline int64_t smg_offsets(int64_t sub, smg_offset *beside);

/* The number of the site that is the n-th beside one, -1 beyond an open end. */
static inline int64_t smg_site_beside(const smg_coefficients *c, int64_t site, int64_t n) {
  smg_offset all[SMG_BESIDES];
  int64_t cell = site / SMG_HOME_PLACES, found = 0, size = 1;
  if (n >= smg_offsets(smg_place_of_site(c, site), all)) return -1;
  for (int d = 0; d < 4; ++d) {
    const int64_t cells = smg_cells(c, d), to = cell % cells + all[n].cell[d];
    if (!(all[n].ring >> d & 1) && (to < 0 || to >= cells)) return -1;
    found += size * ((to % cells + cells) % cells);
    size *= cells;
    cell /= cells;
  }
  return smg_numbered_site(c, found, all[n].sub);
}

/* What stands there beside a row. */
static inline smg_beside smg_beside_row(const smg_coefficients *c, const smg_lattice_row *at, const smg_offset *o) {
  const int ring = o->ring;
  const int64_t n = smg_cells(c, 0), along = ring & 1 ? o->cell[0] % n : o->cell[0], x = at->first + along,
                sub = o->sub, before = -smg_down(x, SMG_ROW_STEP), inside = -smg_down(x - n, SMG_ROW_STEP);
  int64_t s[3] = {at->s1, at->s2, at->s3};
  smg_beside b = {0, 0, 0, before > 0 ? smg_row_length(c) : SMG_EVERYWHERE, 1};
  b.there = smg_step_to(s, o->cell[1], smg_cells(c, 1), ring >> 1 & 1) &
            smg_step_to(s + 1, o->cell[2], smg_cells(c, 2), ring >> 2 & 1) &
            smg_step_to(s + 2, o->cell[3], smg_cells(c, 3), ring >> 3 & 1);
  if (!b.there) return b;
  b.start = smg_slot_beyond(c, sub, x, s) - at->start;
  b.around = smg_slot_beyond(c, sub, along < 0 ? x + n : x - n, s) - at->start;
  if (before > 0) b.from = before < at->sites ? before : at->sites;
  if (inside < at->sites) b.to = inside > 0 ? inside : 0;
  return b;
}

#if SMG_SITE_VALUES
/* The n-th numbers of the sites from the j-th on of a run. */
SMG_INLINE smg_lanes smg_take_value(const smg_run *run, int64_t n, int64_t pitch, int64_t j) {
  return smg_lane_take(run->values + n * pitch + run->start + j);
}
#endif

/* The places of lanes in their rows, of which the first is the p-th: from memory, or of long rows, where vectors stay
 * within one. */
SMG_INLINE smg_lanes smg_lane_places(const smg_run *run, int64_t p) {
  static const smg_real number[SMG_WIDEST] = {0, 1, 2, 3, 4, 5, 6, 7};
  if (run->length < SMG_LONG_ROW) return smg_lane_take(run->place + p);
  return (smg_real)p + smg_lane_take(number);
}
SMG_INLINE int64_t smg_next_place(int64_t p, int64_t length) {
  for (p += SMG_LANES; p >= length;) p -= length;
  return p;
}

/* Do the neighbours of all `in` lanes stand within the row? Those of which do? */
SMG_INLINE int smg_all_within(const smg_beside *b, int64_t p, int64_t in) {
  return b->to == SMG_EVERYWHERE || (p >= b->from && p + in <= b->to);
}
SMG_INLINE smg_lane_mask smg_lanes_within(const smg_run *run, const smg_beside *b, int64_t p) {
  const smg_lanes at = smg_lane_places(run, p);
  return (smg_lane_mask)(at >= (smg_real)b->from) & (smg_lane_mask)(at < (smg_real)b->to);
}

/* A vector whose lanes are turned by t. */
SMG_INLINE void smg_take_turned(const smg_real *all, int64_t pitch, const int64_t *order, smg_lanes *v) {
#if SMG_LANES == SMG_WIDEST && SMG_LANES > 1 && !defined(__clang__)
  const smg_lane_mask from = *(const smg_lane_mask *)order;
  for (int k = 0; k < 3; ++k) v[k] = __builtin_shuffle(smg_lane_load(all + k * pitch), from);
#else
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < SMG_LANES; ++l) smg_lane_set(v + k, l, all[k * pitch + order[l]]);
#endif
}

/* How sites find what is beside them: by rows; in blocks; in blocks from vectors that all stand as they are. */
enum smg_standing { SMG_IN_ROWS, SMG_IN_BLOCKS, SMG_STRAIGHT_ON };
/* Of a vector of a run of blocks. */
SMG_INLINE const smg_slot_beside *smg_beside_of(const smg_run *run, int64_t j) {
  return run->beside + (uint64_t)(run->start + j) / SMG_WIDEST * SMG_BESIDES;
}
SMG_INLINE int smg_standing_of(const smg_run *run, int blocks, int64_t j) {
  return !blocks ? SMG_IN_ROWS : *smg_beside_of(run, j) < SMG_SOME_TURNED / 2 ? SMG_STRAIGHT_ON : SMG_IN_BLOCKS;
}

/* The n-th vectors beside the slots from the j-th on of a run of blocks. */
SMG_INLINE void smg_take_in_blocks(const smg_run *run, int blocks, int n, const smg_real *all, int64_t pitch, int64_t j,
                                   smg_lanes *v) {
  const int64_t slot = run->start + j, beside = smg_beside_of(run, j)[n], to = slot + beside - SMG_SOME_TURNED;
  const int64_t t = (uint64_t)beside % SMG_WIDEST, lane = (uint64_t)slot % SMG_WIDEST;
  if (blocks == SMG_STRAIGHT_ON) smg_take_slots(all + slot, pitch, beside, v);
  else if (t == 0) smg_take_slots(all, pitch, to, v);
  else smg_take_turned(all + (to - t - lane), pitch, run->order[t].of + lane, v);
}

/* Those beside the sites from the j-th on of a run, the p-th of its row. around: may they stand around a ring, beyond
 * the ends of the row? That is read for sites of the run alone: that far beyond it there may be no memory. */
SMG_INLINE void smg_take_beside(const smg_run *run, int blocks, int n, int around, int64_t p, const smg_real *all,
                                int64_t pitch, int64_t j, smg_lanes *v) {
  if (blocks) {
    smg_take_in_blocks(run, blocks, n, all, pitch, j, v);
    return;
  }
  const smg_beside *b = run->b + n;
  smg_take_slots(all, pitch, run->start + b->start + j, v);
  if (!around || smg_all_within(b, p, run->to - j < SMG_LANES ? run->to - j : SMG_LANES)) return;
  const smg_lane_mask within = smg_lanes_within(run, b, p);
  smg_lanes far[3];
  smg_take_slots(all, pitch, run->start + b->around + j, far);
  smg_lane_choose(v, within, v, far, 3);
}

/* Of open ends: g as it was, in the lanes whose neighbour is beyond. */
SMG_INLINE void smg_only_within(const smg_run *run, int n, int64_t p, const smg_lanes *before, smg_lanes *g) {
  const smg_beside *b = run->b + n;
  if (smg_all_within(b, p, SMG_LANES)) return;
  const smg_lane_mask within = smg_lanes_within(run, b, p);
  smg_lane_choose(g, within, g, before, 3);
}

/* Of rows that are not full: g = 0 in the lanes of empty slots. */
SMG_INLINE void smg_only_sites(const smg_run *run, int64_t p, smg_lanes *g) {
  if (p + SMG_LANES <= run->sites || run->sites == run->length) return;
  const smg_lane_mask sites = (smg_lane_mask)(smg_lane_places(run, p) < (smg_real)run->sites);
  for (int k = 0; k < 3; ++k) g[k] = smg_lane_select(sites, g[k], smg_lane_of(0));
}

/* How many rows lie between the first and the last of a plane, where these are two and meet across a seam. */
static inline int64_t smg_rows_between(const smg_coefficients *c) {
  return smg_meet_along(c, 1) && smg_cells(c, 1) > 1 ? smg_place_in_plane(c, smg_cells(c, 1) - 1) : SMG_PIECE;
}

/* Slots of a piece, so that the next one begins where a vector does: as many whole rows as fit, or SMG_PIECE. Where the
 * first and the last row of a plane meet across a seam, a plane, of which the first piece has the rows before the last:
 * so these two are not in one piece, and feel each other as sites of two colours do. */
static inline int64_t smg_piece_room(const smg_coefficients *c) {
  const int64_t length = smg_row_length(c), plane = smg_cells(c, 1) * length, apart = smg_rows_between(c) * length;
  if (apart < SMG_PIECE) return plane <= SMG_PIECE ? plane : apart;
  for (int64_t n = SMG_PIECE / length; n > 0; --n)
    if (n * length % SMG_WIDEST == 0) return n * length;
  return SMG_PIECE;
}

/* Numbers of the memory that the table of all kinds takes. */
static inline int64_t smg_kinds_size(void) {
  return (int64_t)((SMG_KNOWN * SMG_BESIDES * sizeof(smg_beside) + sizeof(smg_real) - 1) / sizeof(smg_real));
}

/* What stands beside rows of every kind, from memory; and the places of the slots of short rows, so many that vectors
 * may begin at each of them. */
typedef struct smg_besides {
#if SMG_MANY_KINDS
  smg_beside (*rows)[SMG_BESIDES];
#else
  smg_beside rows[SMG_KNOWN][SMG_BESIDES];
#endif
  int known[SMG_KNOWN];
  smg_real place[SMG_LONG_ROW + SMG_WIDEST];
  int64_t room, begin; /* slots of a piece, and of the first one of a colour */
  smg_lattice_row first[SMG_COLOURS];
#if SMG_SITE_VALUES
  const smg_real *values; /* of sites, by slots */
#endif
#if SMG_TANGENT
  const smg_real *points; /* where changes begin, by slots */
#endif
  const smg_slot_beside *beside; /* of blocks; else NULL */
  smg_lane_order order[SMG_WIDEST];
} smg_besides;

/* kinds: where their table is, of many. */
static inline void smg_forget_besides(const smg_coefficients *c, SMG_UNUSED void *kinds, smg_besides *all) {
  const int64_t length = smg_row_length(c);
#if SMG_MANY_KINDS
  all->rows = (smg_beside(*)[SMG_BESIDES])kinds;
#endif
  memset(all->known, 0, sizeof all->known);
  for (int64_t k = 0; k < SMG_LONG_ROW + SMG_WIDEST; ++k) all->place[k] = (smg_real)(k % length);
  all->room = smg_piece_room(c);
  all->begin = smg_rows_between(c) * length < SMG_PIECE ? smg_rows_between(c) * length : all->room;
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) all->first[colour] = smg_row_of(c, colour, 0);
  all->beside = NULL;
}

static void smg_look_beside(const smg_coefficients *c, const smg_lattice_row *at, smg_beside *b) {
  smg_offset beside[SMG_BESIDES];
  const int64_t found = smg_offsets(at->sub, beside);
  for (int64_t k = 0; k < found; ++k) b[k] = smg_beside_row(c, at, beside + k);
  for (int64_t k = found; k < SMG_BESIDES; ++k) b[k].there = 0;
}

SMG_INLINE const smg_beside *smg_besides_of(const smg_coefficients *c, const smg_lattice_row *at, smg_besides *all) {
  const int64_t kind = (at->kind * SMG_ROW_KINDS + smg_kind_of_row(at->s1, smg_cells(c, 1))) * SMG_ROW_STEP + at->first;
  if (!all->known[kind]) {
    smg_look_beside(c, at, all->rows[kind]);
    all->known[kind] = 1; /* threads find all of them known */
  }
  return all->rows[kind];
}

#endif
