/* smidgen runtime: the step of a large lattice in one go through memory, or a few (temporal blocking by wavefronts).
 *
 * One colour after the other passes through all of the memory, a dozen times a step. So the slots of every colour are
 * cut into the same blocks, and the stages of a step take turns: its beginning (the increments of the step before are
 * added to w, midpoints predicted), its passes, and its end. Sites feel others at most R slots from their own place in
 * the colour, which is x blocks, rounded up. So a stage takes block b once the one before it has done those up to b +
 * x, and what stages still need of each other's blocks stays in the cache. Around a ring the k-th stage begins with
 * block k x, later than the one before it, which so has done its first blocks too.
 *
 * Threads share the stages: with x + 1 in place of x, none of them needs what another one does at the same time. Where
 * there are not two stages for each, they share colours.
 *
 * All sites read what they would one colour after the other, and have the same bits. Changes are looked at after all
 * passes: as many as one of the last steps took. Where fewer would have done, the step begins anew without wavefronts;
 * where they do not do, others follow. */
#ifndef SMG_ROW_WAVE_H
#define SMG_ROW_WAVE_H

#include "smg_row_commit.h"
#include "smg_row_sweep.h"

#ifndef SMG_WAVE_BLOCK
/* slots of a block, at least: 1024 take as long on 100^3 spins, 256 and 4096 some 5 % longer */
#define SMG_WAVE_BLOCK 2048
#endif
#ifndef SMG_WAVE_FROM
/* bytes of all arrays: beside a cache of 32 MiB, 40^3 spins (10 MB) take a tenth longer in wavefronts, 64^3 (42 MB)
 * gain nothing, 80^3 (82 MB) take a quarter less */
#define SMG_WAVE_FROM 60000000
#endif
#ifndef SMG_WAVE_HELD
/* bytes that the stages of a wavefront need of each other, at most: half of such a cache; with 64 MB 160^3 spins take
 * 1.4 times as long */
#define SMG_WAVE_HELD 16000000
#endif
#define SMG_WAVE_PASSES 48
#define SMG_WAVE_STAGES 4 /* of a wavefront, at least */

/* Passes and blocks of a step, its stages in each wavefront; x; how many blocks later a stage begins than the one
 * before it; how colours are passed, how far that moves midpoints, and the largest squares of residuals. */
typedef struct smg_row_wave {
  int64_t passes, blocks, stages, lag, later;
  smg_row_pass pass[SMG_WAVE_PASSES];
  smg_row_motion motion[SMG_WAVE_PASSES];
  smg_lanes residual;
} smg_row_wave;

/* |d| around a colour. */
SMG_INLINE int64_t smg_apart(int64_t slots, int64_t d) {
  const int64_t there = smg_left(d, slots);
  return there < slots - there ? there : slots - there;
}

/* R, once rows of every kind are known. */
static int64_t smg_row_reach(const smg_coefficients *c, const smg_besides *known) {
  const int64_t slots = smg_colour_slots(c);
  int64_t most = 1;
  for (int64_t k = 0; k < SMG_KNOWN * SMG_BESIDES; ++k) {
    const smg_beside *b = &known->rows[k / SMG_BESIDES][k % SMG_BESIDES];
    if (!known->known[k / SMG_BESIDES] || !b->there) continue;
    const int64_t start = smg_apart(slots, b->start), around = smg_apart(slots, b->around);
    if (start > most) most = start;
    if (around > most) most = around;
  }
  return most;
}

/* Bytes of all arrays, and those that a stage needs of the one before it: w, m and u of lag + 1 blocks. */
static inline int64_t smg_wave_all(const smg_coefficients *c) { return 20 * (int64_t)sizeof(smg_real) * smg_slots(c); }
static inline int64_t smg_wave_held(const smg_row_wave *wave) {
  return (wave->lag + 1) * SMG_WAVE_BLOCK * SMG_COLOURS * 9 * (int64_t)sizeof(smg_real);
}

/* As few wavefronts as the cache has room for, and as do not spend half of their time at the ends of the lattice. */
static int64_t smg_wave_stages(const smg_row_wave *wave) {
  const int64_t fit = SMG_WAVE_HELD / smg_wave_held(wave), ends = wave->blocks / (2 * wave->lag),
                most = fit < ends ? fit : ends;
  if (most < SMG_WAVE_STAGES) return 0;
  const int64_t waves = (wave->passes + 2 + most - 1) / most;
  return (wave->passes + 2 + waves - 1) / waves;
}

/* Does the next step go so? With how many passes, and which blocks? */
static int smg_wave_pays(const smg_state *s, smg_row_wave *wave) {
  const int64_t slots = smg_colour_slots(&s->c), vectors = slots / SMG_WIDEST;
  wave->passes = SMG_OF_STAGE(s, row_fewest);
  wave->blocks = slots / SMG_WAVE_BLOCK;
  if (wave->passes < SMG_COLOURS || wave->passes > SMG_WAVE_PASSES || wave->blocks == 0 ||
      smg_wave_all(&s->c) < SMG_WAVE_FROM)
    return 0;
  if (SMG_SHARED_BY_RANKS || smg_colours_meet(&s->c) || s->row_beside) return 0;
  const int64_t block = vectors / wave->blocks * SMG_WIDEST;
  wave->lag = (s->row_reach + block - 1) / block + (s->row_team > 1);
  wave->later = SMG_RINGS > 0 || SMG_RANKS > 1 ? wave->lag : 0;
  wave->stages = smg_wave_stages(wave);
  return wave->stages > 0 && (s->row_team == 1 || wave->stages >= 2 * s->row_team);
}

/* The passes: the last one finds increments too. */
static void smg_plan_wave(const smg_state *s, smg_row_wave *wave) {
  smg_row_sweeping sweep;
  smg_begin_sweeping(&sweep);
  for (; sweep.passes < wave->passes; ++sweep.passes) {
    smg_row_pass *pass = wave->pass + sweep.passes;
    *pass = smg_next_pass(s, &sweep);
    pass->small |= pass->way == SMG_FROM_BEFORE && sweep.passes >= SMG_OF_STAGE(s, row_near);
    pass->last = pass->watched && s->row_alone && sweep.passes + 1 == wave->passes && sweep.passes >= SMG_COLOURS;
    wave->motion[sweep.passes] = smg_at_rest();
  }
  wave->residual = smg_at_rest().residual;
}

/* The slots of a block of a colour. */
static inline smg_share smg_block_slots(const smg_coefficients *c, const smg_row_wave *wave, int64_t colour,
                                        int64_t block) {
  return smg_part_of(smg_colours_from(c, colour, 1), block, wave->blocks);
}

/* The beginning of a block of all colours. */
static void smg_begin_block(const smg_state *s, const smg_row_wave *wave, const smg_row_going *go, int64_t block) {
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) {
    const smg_share part = smg_block_slots(&s->c, wave, colour, block);
    if (s->row_due) smg_go_on(*go, part);
    if (colour == 0) smg_begin_first_colour(s, part);
  }
}

/* Its end: the increments that are not known. */
static void smg_end_block(const smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_wave *wave,
                          int64_t block) {
  const smg_row_pass *last = wave->pass + wave->passes - 1;
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    if (!last->last || colour != last->colour)
      smg_end_part(s, known, *turn, colour, smg_block_slots(&s->c, wave, colour, block), &wave->residual);
}

/* The k-th stage of a step, in one block. */
static void smg_take_block(const smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_wave *wave,
                           const smg_row_going *go, int64_t k, int64_t block) {
  if (k == 0) smg_begin_block(s, wave, go, block);
  else if (k > wave->passes) smg_end_block(s, known, turn, wave, block);
  else {
    const smg_row_pass pass = wave->pass[k - 1];
    smg_turn_some_slots(s, known, turn, pass, smg_block_slots(&s->c, wave, pass.colour, block), wave->motion + k - 1);
  }
}

/* Some stages of it, each in its order of blocks. */
static void smg_run_wave(const smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_wave *wave,
                         int64_t first, int64_t stages) {
  const smg_row_going go = smg_going_of(s, s->degree);
  const int64_t times = wave->blocks + (stages - 1) * (wave->lag + wave->later);
  SMG_TEAM(s->row_team) {
    for (int64_t time = 0; time < times; ++time) {
      SMG_TURNS_OF_TEAM
      for (int64_t k = 0; k < stages; ++k) {
        const int64_t at = time - k * wave->lag, from = k * wave->later;
        if (at >= from && at < from + wave->blocks)
          smg_take_block(s, known, turn, wave, &go, first + k, at % wave->blocks);
      }
    }
  }
}

/* Have the passes shown what they would have one by one, without being more than that? */
static int smg_judge_wave(const smg_state *s, const smg_row_wave *wave, smg_row_sweeping *sweep) {
  for (int64_t k = 0; k < wave->passes; ++k) {
    smg_row_pass pass = smg_next_pass(s, sweep);
    if (smg_rows_settled(s, sweep) || (pass.small && !wave->pass[k].small)) return 0;
    pass.last = wave->pass[k].last;
    smg_take_pass(s, pass, wave->motion + k, sweep);
  }
  return 1;
}

/* All of them. */
static void smg_run_waves(const smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_wave *wave) {
  const int64_t all = wave->passes + 2;
  for (int64_t k = 0; k < all; k += wave->stages)
    smg_run_wave(s, known, turn, wave, k, k + wave->stages < all ? wave->stages : all - k);
}

/* The passes of a step in wavefronts, and whether they have settled; sweep->residual is then that of all colours. */
static int smg_sweep_in_wave(smg_state *s, smg_besides *known, const smg_turning *turn, smg_row_wave *wave,
                             smg_row_sweeping *sweep) {
  smg_plan_wave(s, wave);
  smg_run_waves(s, known, turn, wave);
  s->row_due = 0;
  if (!smg_judge_wave(s, wave, sweep)) { /* anew */
    smg_begin_sweeping(sweep);
    smg_predict_rows(s);
    smg_begin_first_colour(s, smg_colours_from(&s->c, 0, 1));
    return 0;
  }
  if (!smg_rows_settled(s, sweep)) return 0;
  smg_take(&sweep->residual, smg_lane_largest(wave->residual));
  return 1;
}

/* What is to know for the wavefronts of the next step: passes that one of the last two took, and from which on small
 * components may be looked at. */
static void smg_expect_passes(smg_state *s, const smg_besides *known, const smg_row_sweeping *sweep) {
  if (s->row_reach == 0 && !SMG_SHARED_BY_RANKS) s->row_reach = smg_row_reach(&s->c, known);
  const int64_t before = SMG_OF_STAGE(s, row_passes);
  SMG_OF_STAGE(s, row_fewest) = before < sweep->passes && before > 0 ? before : sweep->passes;
  SMG_OF_STAGE(s, row_passes) = sweep->passes;
  SMG_OF_STAGE(s, row_near) = sweep->near;
}

#endif
