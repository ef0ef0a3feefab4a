/* What CVODE and ARKODE share: a context that says nothing, a vector over y, the right-hand side. SUNDIALS 7 or newer. */
#ifndef PEER_SUNDIALS_H
#define PEER_SUNDIALS_H
#include "rate.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

typedef struct peer {
  void *model, *mem;
  SUNContext context;
  N_Vector y;
} peer;

static int right_side(sunrealtype t, N_Vector y, N_Vector dydt, void *model) {
  return rate(model, t, N_VGetArrayPointer(y), N_VGetArrayPointer(dydt)) ? 0 : -1;
}

/* The libraries of sundials4py call these to forget functions of Python, of which there are none here. */
#define FORGET(name) \
  __attribute__((weak)) void name(void *table); \
  __attribute__((weak)) void name(void *table) { (void)table; }
FORGET(SUNContextFunctionTable_Destroy)
FORGET(SUNDomEigEstimatorFunctionTable_Destroy)
FORGET(SUNLinearSolverFunctionTable_Destroy)
FORGET(SUNLoggerFunctionTable_Destroy)
FORGET(SUNNonlinearSolverFunctionTable_Destroy)
FORGET(SUNStepperFunctionTable_Destroy)
FORGET(arkode_user_supplied_fn_table_destroy)
FORGET(cvode_user_supplied_fn_table_destroy)
FORGET(mristepinnerstepper_user_supplied_fn_table_destroy)

/* A peer without its integrator. */
static inline peer *begun(void *model) {
  peer *p = (peer *)calloc(1, sizeof *p);
  if (!p) return NULL;
  p->model = model;
  if (SUNContext_Create(SUN_COMM_NULL, &p->context) == 0) {
    SUNContext_ClearErrHandlers(p->context);
    p->y = N_VNew_Serial((sunindextype)numbers(model), p->context);
  }
  if (p->y) memset(N_VGetArrayPointer(p->y), 0, numbers(model) * sizeof(double));
  return p;
}

static inline void ended(peer *p) {
  if (p->y) N_VDestroy(p->y);
  if (p->context) SUNContext_Free(&p->context);
  free(p);
}
#endif
