/* smidgen method: an internal step of smg_dop853.h, where its equations are, and the control of its size; a template
 * (smg_template.h), of which smg_lane_dop853.h makes several states in lanes.
 *
 * Who includes it gives, before, what smg_dop853_stages_template.h asks for. */
#include "smg_dop853_control.h"
#include "smg_dop853_estimates.h"
#include "smg_dop853_stages_template.h"

/* An output step under way. Sizes are parts of h. */
typedef struct smg_pace {
  /* what is done; the internal step that is tried, and where it ends; the next one if nothing cuts it short */
  smg_number done, size, end, natural;
  /* of the error of the try, as part of what is allowed; the largest of all that were accepted */
  smg_number square, largest;
  smg_number per_allowed;     /* 1/(tolerance scale); 0: all w are 0, and nothing moves */
  smg_count tries, accepted;  /* of the output step */
  smg_test refused, hopeless; /* was the last try refused, and is no smaller one left? */
} smg_pace;

/* u = sum_i b_i k_i, e5 = r sum_i (b_i - b5_i) k_i, and e3 alike. */
SMG_INLINE void smg_combine_slopes(const smg_number *k, int64_t n, smg_number r, smg_number *SMG_RESTRICT u,
                                   smg_number *SMG_RESTRICT e5, smg_number *SMG_RESTRICT e3) {
  for (int64_t q = 0; q < n; ++q) {
    u[q] = smg_weighted(smg_dop853_b, SMG_STAGES_USED, k + q, n);
    e5[q] = r * smg_weighted(smg_dop853_e5, SMG_STAGES_USED, k + q, n);
    e3[q] = r * smg_weighted(smg_dop853_e3, SMG_STAGES_USED, k + q, n);
  }
}

#include "smg_dop853_error_template.h"

/* ---- its end ---- */
/* y + carry := y + carry + u at one component, where the test holds. */
SMG_INLINE void smg_add_where(smg_test test, smg_number *y, smg_number *carry, smg_number u) {
  smg_number sum = *y, lost = *carry;
  smg_add_compensated(&sum, &lost, u);
  *y = smg_select(test, sum, *y);
  *carry = smg_select(test, lost, *carry);
}

/* The increment u is taken where it is good, with its rounding error carried along. */
SMG_INLINE void smg_take_increment(smg_trial *f, smg_test good) {
  smg_number *y = smg_vector(f, SMG_Y), *carry = smg_vector(f, SMG_Y_COMPENSATION);
  const int64_t n = smg_width(f);
  for (int64_t q = 0; q < n; ++q) {
#if SMG_PLAIN_SUMS
    (void)carry;
    y[q] = smg_select(good, y[q] + f->u[q], y[q]);
#else
    smg_add_where(good, y + q, carry + q, f->u[q]);
#endif
  }
}

/* A round of Newton's method of one site back to its leaf, n = grad C(y): y + a n, 2 a |n|^2 = leaf - 2 C(y), where it
 * is off. Returns where it was. */
SMG_INLINE smg_test smg_towards_leaf(smg_test off, smg_number leaf, const smg_number *n, smg_number *y,
                                     smg_number *carry) {
  const smg_number gap = leaf - (smg_dot(n, y) + 2 * smg_dot(n, carry)), square = smg_dot(n, n),
                   size = smg_abs(n[0] * y[0]) + smg_abs(n[1] * y[1]) + smg_abs(n[2] * y[2]), part = gap / (2 * square);
  off = off SMG_AND smg_less(smg_of(0), square) SMG_AND smg_not(smg_at_most(smg_abs(gap), SMG_EPS * size));
  for (int b = 0; b < 3; ++b) smg_add_where(off, y + b, carry + b, part * n[b]);
  return off;
}

/* ---- control of the size ---- */
/* Where the next internal step ends: exactly at 1 when it comes near, and half way when two steps will do. Its size is
 * the difference as rounded, so that the sizes of all add up to 1. */
SMG_INLINE void smg_next_try(smg_pace *pace) {
  const smg_number left = 1 - pace->done, part = smg_smaller(pace->natural, left / 2);
  const smg_test whole = smg_all(SMG_FIXED_STEP) SMG_OR smg_at_most(left, pace->natural * (smg_real)1.01);
  pace->end = smg_select(whole, smg_of(1), pace->done + part);
  pace->size = pace->end - pace->done;
  pace->tries += 1;
}

/* x^(-1/16), from the bits of x > 0: those of a number are nearly its logarithm (smg_lane_rough_inverse_root()), off by
 * at most 3.3 %, which the part SMG_SAFETY makes up for; of numbers other than doubles by roots. */
SMG_INLINE smg_number smg_sixteenth(smg_number x) {
#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD)
  return 1 / smg_sqrt(smg_sqrt(smg_sqrt(smg_sqrt(x))));
#else
  return smg_of_bits(SMG_SIXTEENTH, x, 4);
#endif
}

/* The error of a step of size p goes as p^8: the factor at which it meets the tolerance, within its limits, `most`
 * where the error vanishes and SMG_SHRINK where it is no number. */
SMG_INLINE smg_number smg_step_factor(smg_number square, smg_number most) {
  return smg_smaller(most, smg_larger(SMG_SAFETY * smg_sixteenth(square), smg_of(SMG_SHRINK)));
}

/* Where is the try good? Elsewhere it is refused: again from the same place, with a smaller size, as long as that is
 * one. A size that the end of h cut short says little of the natural one when its error vanishes. */
SMG_INLINE smg_test smg_judge(smg_pace *pace) {
  const smg_test good = smg_at_most(pace->square, smg_of(SMG_FIXED_STEP ? SMG_MAX : 1));
  const smg_number most = smg_select(pace->refused, smg_of(1), smg_of(SMG_GROWTH)),
                   factor = smg_step_factor(pace->square, most), next = pace->size * factor;
  const smg_test stays = good SMG_AND smg_at_most(smg_of(SMG_GROWTH), factor) SMG_AND smg_at_most(next, pace->natural);
  pace->natural = smg_select(stays, pace->natural, next);
  pace->largest = smg_select(good, smg_larger(pace->square, pace->largest), pace->largest);
  pace->done = smg_select(good, pace->end, pace->done);
  pace->accepted = smg_counted(pace->accepted, good);
  pace->refused = smg_not(good);
  pace->hopeless =
      pace->refused SMG_AND(smg_all(SMG_FIXED_STEP) SMG_OR smg_less(pace->natural, smg_of(SMG_LEAST_PART)));
  return good;
}

/* Is the output step given up, before its end? Too many tries, or more of this size are to be expected. */
SMG_INLINE smg_test smg_gives_up(const smg_pace *pace) {
  const smg_test due = (smg_test)((pace->tries & (SMG_LOOK_AHEAD - 1)) == 0),
                 up = pace->hopeless SMG_OR(smg_test)(pace->tries >= SMG_MOST_TRIES);
  if (!smg_any(due)) return up;
  const smg_number may = pace->natural * smg_number_of(SMG_MOST_TRIES - pace->tries);
  return up SMG_OR(due SMG_AND smg_less(may, 1 - pace->done));
}
