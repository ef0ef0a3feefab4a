/* SUNDIALS CVODE (by CVODES, which holds all of it): Adams with fixed-point iteration, BDF with Newton and a dense matrix by
 * differences, which are its own defaults. */
#include "sundials.h"

#include <cvodes/cvodes.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

/* What belongs to the integrator; peer comes first. */
typedef struct multistep {
  peer *p;
  SUNNonlinearSolver iteration;
  SUNMatrix matrix;
  SUNLinearSolver linear;
} multistep;

static int with_adams(multistep *m) {
  m->iteration = SUNNonlinSol_FixedPoint(m->p->y, 0, m->p->context);
  return m->iteration ? CVodeSetNonlinearSolver(m->p->mem, m->iteration) : -1;
}

static int with_bdf(multistep *m) {
  const sunindextype n = N_VGetLength_Serial(m->p->y);
  m->matrix = SUNDenseMatrix(n, n, m->p->context);
  m->linear = m->matrix ? SUNLinSol_Dense(m->p->y, m->matrix, m->p->context) : NULL;
  return m->linear ? CVodeSetLinearSolver(m->p->mem, m->linear, m->matrix) : -1;
}

static int prepared(multistep *m, int adams, double tol, double first) {
  void *mem = m->p->mem;
  if (!mem || CVodeInit(mem, right_side, 0, m->p->y) || CVodeSStolerances(mem, tol, tol)) return 0;
  if (CVodeSetUserData(mem, m->p->model) || CVodeSetMaxNumSteps(mem, MOST_STEPS)) return 0;
  CVodeSetMaxHnilWarns(mem, -1);
  (void)first; /* it finds its own first step */
  return (adams ? with_adams(m) : with_bdf(m)) == 0;
}

void *peer_new(void *model, int kind, double tol, double first) {
  multistep *m = (multistep *)calloc(1, sizeof *m);
  if (!m) return NULL;
  m->p = begun(model);
  if (m->p && m->p->y) {
    m->p->mem = CVodeCreate(kind == 0 ? CV_ADAMS : CV_BDF, m->p->context);
    if (prepared(m, kind == 0, tol, first)) return m;
  }
  peer_free(m);
  return NULL;
}

int64_t peer_run(void *at, double t0, double *y, const double *times, int64_t count, double *out) {
  const peer *p = ((multistep *)at)->p;
  const size_t bytes = numbers(p->model) * sizeof *y;
  double *now = N_VGetArrayPointer(p->y), t = t0;
  long steps = 0;
  memcpy(now, y, bytes);
  if (CVodeReInit(p->mem, t0, p->y)) return -1;
  for (int64_t k = 0; k < count; ++k) {
    if (CVode(p->mem, times[k], p->y, &t, CV_NORMAL) < 0 || CVodeGetNumSteps(p->mem, &steps) || steps > MOST_STEPS) return -1;
    memcpy(out + (size_t)k * numbers(p->model), now, bytes);
  }
  memcpy(y, now, bytes);
  return (int64_t)steps;
}

void peer_free(void *at) {
  multistep *m = (multistep *)at;
  if (!m) return;
  if (m->p && m->p->mem) CVodeFree(&m->p->mem);
  if (m->iteration) SUNNonlinSolFree(m->iteration);
  if (m->linear) SUNLinSolFree(m->linear);
  if (m->matrix) SUNMatDestroy(m->matrix);
  if (m->p) ended(m->p);
  free(m);
}
