/* smidgen runtime: outputs in blocks, for callers without types. Included by <model>_abi.c alone, whose functions it
 * calls by SMG_ABI(word); SMG_COLUMNS is the number of values of an output. */
#ifndef SMG_OUTPUTS_H
#define SMG_OUTPUTS_H

#include <stdlib.h>

#include "smidgen.h"
#ifndef SMG_ABI
#include "smg_stub_abi.h"
#endif

/* Room for `rows` outputs: t of each, states (3 numbers a site; NULL: not asked for), values, Casimirs (one a site).
 * near: pairs of sites (from, to) whose midpoints are looked at; nearest: the smallest |w + W|^2/(4 |W|^2) so far;
 * where: its site and its step. */
typedef struct smg_outputs {
  double *t;
  smg_real *states, *values, *casimirs;
  const int64_t *near;
  int64_t pairs;
  double *nearest;
  int64_t *where;
} smg_outputs;

/* The sites from..to of a step from w to W: is one of them nearer to a centre? */
static void smg_look_near(const smg_outputs *o, const smg_real *w, const smg_real *W, int64_t from, int64_t to,
                          int64_t step) {
  for (int64_t k = 3 * from; k < 3 * to; k += 3) {
    const smg_real x = w[k] + W[k], y = w[k + 1] + W[k + 1], z = w[k + 2] + W[k + 2];
    const smg_real size = W[k] * W[k] + W[k + 1] * W[k + 1] + W[k + 2] * W[k + 2];
    const double rho = (double)((x * x + y * y + z * z) / (4 * size));
    if (!(rho < *o->nearest)) continue;
    *o->nearest = rho;
    o->where[0] = k / 3;
    o->where[1] = step;
  }
}

static void smg_put_row(void *s, const smg_outputs *o, int64_t row) {
  const int64_t n = SMG_ABI(sites)(s);
  o->t[row] = SMG_ABI(time)(s);
  if (o->states) SMG_ABI(state)(s, o->states + 3 * n * row);
  SMG_ABI(values)(s, o->values + SMG_COLUMNS * row);
  SMG_ABI(casimirs)(s, o->casimirs + n * row);
}

/* `count` steps; the last one is looked at. w: scratch of 6 numbers a site, NULL where nothing is to be looked at. */
static int smg_steps_to_row(void *s, const smg_outputs *o, smg_real *w, int64_t count) {
  int64_t done;
  int status = count > 1 ? SMG_ABI(steps)(s, count - 1, &done) : 0;
  if (status || count < 1) return status;
  if (!w) return SMG_ABI(steps)(s, 1, &done);
  smg_real *W = w + 3 * SMG_ABI(sites)(s);
  SMG_ABI(state)(s, w);
  if ((status = SMG_ABI(steps)(s, 1, &done)) != 0) return status;
  SMG_ABI(state)(s, W);
  for (int64_t k = 0; k < o->pairs; ++k) smg_look_near(o, w, W, o->near[2 * k], o->near[2 * k + 1], SMG_ABI(count)(s));
  return 0;
}

/* Up to `rows` outputs, the first after `first` steps, each later one after `every` more. *done: how many; returns the
 * status of the last step, -1 without memory. */
static int smg_put_outputs(void *s, int64_t first, int64_t every, int64_t rows, const smg_outputs *o, int64_t *done) {
  smg_real *w = o->pairs > 0 ? (smg_real *)malloc(6 * (size_t)SMG_ABI(sites)(s) * sizeof *w) : NULL;
  int status = o->pairs > 0 && !w ? -1 : 0;
  for (*done = 0; *done < rows && !status; *done += !status) {
    status = smg_steps_to_row(s, o, w, *done > 0 ? every : first);
    if (!status) smg_put_row(s, o, *done);
  }
  free(w);
  return status;
}

#endif
