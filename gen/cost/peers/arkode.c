/* SUNDIALS ARKODE: its explicit Runge-Kutta method of order 8. Outputs are ends of steps: its interpolation is of low order. */
#include "sundials.h"

#include <arkode/arkode.h>
#include <arkode/arkode_erkstep.h>

#define ORDER 8

static int prepared(peer *p, double tol) {
  if (!p->mem || ARKodeSetOrder(p->mem, ORDER) || ARKodeSStolerances(p->mem, tol, tol)) return 0;
  ARKodeSetMaxHnilWarns(p->mem, -1);
  return ARKodeSetUserData(p->mem, p->model) == 0 && ARKodeSetMaxNumSteps(p->mem, MOST_STEPS) == 0;
}

void *peer_new(void *model, int kind, double tol, double first) {
  peer *p = begun(model);
  (void)kind;
  (void)first; /* it finds its own first step */
  if (!p) return NULL;
  if (p->y) {
    p->mem = ERKStepCreate(right_side, 0, p->y, p->context);
    if (prepared(p, tol)) return p;
  }
  peer_free(p);
  return NULL;
}

int64_t peer_run(void *at, double t0, double *y, const double *times, int64_t count, double *out) {
  const peer *p = (const peer *)at;
  const size_t bytes = numbers(p->model) * sizeof *y;
  double *now = N_VGetArrayPointer(p->y), t = t0;
  long steps = 0;
  memcpy(now, y, bytes);
  if (ERKStepReInit(p->mem, right_side, t0, p->y)) return -1;
  for (int64_t k = 0; k < count; ++k) {
    if (ARKodeSetStopTime(p->mem, times[k]) || ARKodeEvolve(p->mem, times[k], p->y, &t, ARK_NORMAL) < 0) return -1;
    if (ARKodeGetNumSteps(p->mem, &steps) || steps > MOST_STEPS) return -1;
    memcpy(out + (size_t)k * numbers(p->model), now, bytes);
  }
  memcpy(y, now, bytes);
  return (int64_t)steps;
}

void peer_free(void *at) {
  peer *p = (peer *)at;
  if (!p) return;
  if (p->mem) ARKodeFree(&p->mem);
  ended(p);
}
