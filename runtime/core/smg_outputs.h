/* smidgen runtime: outputs in blocks, for callers without types. Included by <model>_abi.c alone, whose functions it
 * calls by SMG_ABI(word); SMG_COLUMNS is the number of values of an output. */
#ifndef SMG_OUTPUTS_H
#define SMG_OUTPUTS_H

#include <stdlib.h>

#include "smidgen.h"
#ifndef SMG_ABI
#include "smg_stub_abi.h"
#endif

/* Room for `rows` outputs: t of each, states (3 numbers a site), values, of which those that are asked for are found,
 * Casimirs (one a site); states and Casimirs NULL: not asked for. near: pairs of sites (from, to) whose midpoints are
 * looked at; nearest: the smallest |w + W|^2/(4 |W|^2) so far; where: its site and its step. */
typedef struct smg_outputs {
  double *t;
  smg_real *states, *values, *casimirs;
  const unsigned char *asked;
  const int64_t *near;
  int64_t pairs;
  double *nearest;
  int64_t *where;
} smg_outputs;

/* |W|^2 and |w + W|^2 of one site. */
static inline smg_real smg_square(const smg_real *W) { return W[0] * W[0] + W[1] * W[1] + W[2] * W[2]; }
static inline smg_real smg_square_of_sum(const smg_real *w, const smg_real *W) {
  const smg_real sum[3] = {w[0] + W[0], w[1] + W[1], w[2] + W[2]};
  return smg_square(sum);
}

#define SMG_LOOKED 256 /* sites that are looked at together: hardly ever is there one to be looked at alone */

/* The sites from..to of a step from w to W: is one of them nearer to a centre? */
static void smg_look_near(const smg_outputs *o, const smg_real *w, const smg_real *W, int64_t from, int64_t to,
                          int64_t step) {
  for (int64_t end, k = from; k < to; k = end) {
    const smg_real limit = 4 * (smg_real)*o->nearest;
    int nearer = 0;
    end = to - k < SMG_LOOKED ? to : k + SMG_LOOKED;
    for (int64_t j = k; j < end; ++j) nearer |= smg_square_of_sum(w + 3 * j, W + 3 * j) < limit * smg_square(W + 3 * j);
    for (; nearer && k < end; ++k) {
      const double rho = (double)(smg_square_of_sum(w + 3 * k, W + 3 * k) / (4 * smg_square(W + 3 * k)));
      if (!(rho < *o->nearest)) continue;
      *o->nearest = rho;
      o->where[0] = k;
      o->where[1] = step;
    }
  }
}

static void smg_put_row(void *s, const smg_outputs *o, int64_t row) {
  const int64_t n = SMG_ABI(sites)(s);
  o->t[row] = SMG_ABI(time)(s);
  if (o->states) SMG_ABI(state)(s, o->states + 3 * n * row);
  SMG_ABI(values)(s, o->asked, o->values + SMG_COLUMNS * row);
  if (o->casimirs) SMG_ABI(casimirs)(s, o->casimirs + n * row);
}

/* `count` steps; the last one is looked at. w: scratch of 3 numbers a site, NULL where nothing is to be looked at. */
static int smg_steps_to_row(void *s, const smg_outputs *o, smg_real *w, int64_t count) {
  int64_t done;
  int status = count > 1 ? SMG_ABI(steps)(s, count - 1, &done) : 0;
  if (status || count < 1) return status;
  if (!w) return SMG_ABI(steps)(s, 1, &done);
  SMG_ABI(state)(s, w);
  if ((status = SMG_ABI(steps)(s, 1, &done)) != 0) return status;
  for (int64_t k = 0; k < o->pairs; ++k)
    smg_look_near(o, w, SMG_ABI(w)(s), o->near[2 * k], o->near[2 * k + 1], SMG_ABI(count)(s));
  return 0;
}

/* Up to `rows` outputs, the first after `first` steps, each later one after `every` more. *done: how many; returns the
 * status of the last step, -1 without memory. */
static int smg_put_outputs(void *s, int64_t first, int64_t every, int64_t rows, const smg_outputs *o, int64_t *done) {
  smg_real *w = o->pairs > 0 ? (smg_real *)malloc(3 * (size_t)SMG_ABI(sites)(s) * sizeof *w) : NULL;
  int status = o->pairs > 0 && !w ? -1 : 0;
  for (*done = 0; *done < rows && !status; *done += !status) {
    status = smg_steps_to_row(s, o, w, *done > 0 ? every : first);
    if (!status) smg_put_row(s, o, *done);
  }
  free(w);
  return status;
}

#endif
