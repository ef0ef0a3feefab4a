/* w' = f(t, w) for integrators that ask for it: the generated right-hand side, inlined where they call it. The model is that of an
 * explicit method, with h = 1; its text is included here, so that nothing stands between the integrator and the field.
 *
 * MODEL_SOURCE, ABI_SOURCE: files of the model; MODEL: the type of <name>_abi.
 * Every integrator here offers the same three functions:
 *     peer_new    memory for tolerance `tol`, absolute and relative; NULL without it
 *     peer_run    from y at t0 through `count` times; y afterwards, and a row of `out` for each; its steps, or -1
 *     peer_free
 * and over them peer_seconds and peer_rate. */
#ifndef RATE_H
#define RATE_H
#define _POSIX_C_SOURCE 199309L
#include MODEL_SOURCE
#ifndef SMG_HAS_MOTION
#define SMG_HAS_MOTION 0
#endif
#include ABI_SOURCE

#include <string.h>
#include <time.h>

static inline int rate(void *model, double t, const double *y, double *out) {
  smg_coefficients *c = &((MODEL *)model)->s.c;
#if SMG_TIMED
  smg_set_time(c, t);
#else
  (void)t;
#endif
  smg_right_side(c, 1, y, out);
  return out[0] - out[0] == 0;
}

#define MOST_STEPS 3000000 /* of a run, or about so: one that needs more gives up */

static inline size_t numbers(void *model) { return (size_t)(3 * smg_sites(&((MODEL *)model)->s.c)); }

void *peer_new(void *model, int kind, double tol, double first);
int64_t peer_run(void *p, double t0, double *y, const double *times, int64_t count, double *out);
void peer_free(void *p);
void peer_rate(void *model, double t, const double *y, double *out);

void peer_rate(void *model, double t, const double *y, double *out) { rate(model, t, y, out); }

/* Of this thread: what others on the machine do counts for little. */
static inline double clock_now(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Seconds of one run from `start` at 0 to t, the mean of `repeats`; y and out: room for a state each. */
double peer_seconds(void *p, void *model, const double *start, double t, int repeats, double *y, double *out);
double peer_seconds(void *p, void *model, const double *start, double t, int repeats, double *y, double *out) {
  const double began = clock_now();
  for (int k = 0; k < repeats; ++k) {
    memcpy(y, start, numbers(model) * sizeof *y);
    peer_run(p, 0, y, &t, 1, out);
  }
  return (clock_now() - began) / repeats;
}

#endif
