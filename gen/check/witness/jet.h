/* Second-order jets: a value, its gradient and its Hessian in k local variables.
 *
 * Forward mode: every rule is the chain rule for f(a) or f(a, b). The Hessian is stored as
 * its lower triangle, row by row. `order` 0, 1 or 2 says how much is computed. */
#ifndef JET_H
#define JET_H

#include "witness.h"

typedef struct jets {
  int64_t k;      /* variables */
  int order;      /* 0 value, 1 and gradient, 2 and Hessian */
  int64_t stride; /* numbers of one jet */
  real *at;       /* register r starts at at + r*stride */
  uint8_t *active; /* 1 when a register depends on the variables */
} jets;

int jets_new(jets *j, int64_t registers, int64_t variables, int order);
void jets_free(jets *j);

static inline real *jet(const jets *j, int64_t r) { return j->at + r * j->stride; }
static inline real value(const jets *j, int64_t r) { return *jet(j, r); }

void jet_constant(jets *j, int64_t r, real v);
void jet_variable(jets *j, int64_t r, real v, int64_t which);
void jet_copy(jets *j, int64_t r, int64_t a);
void jet_unary(jets *j, int64_t r, int64_t a, real f, real fa, real faa);
/* d holds f_a, f_b, f_aa, f_ab, f_bb */
void jet_binary(jets *j, int64_t r, int64_t a, int64_t b, real f, const real d[5]);

#endif
