/* Runs the code of a term on jets: one function per operation, each with f and its
 * derivatives by the textbook. The numbering of the operations is that of program.py. */
#ifndef INTERPRETER_H
#define INTERPRETER_H

#include "jet.h"

enum operation {
  OP_CONSTANT, OP_TIME, OP_COLUMN, OP_SPIN, OP_ELEMENT,
  OP_ADD, OP_SUBTRACT, OP_NEGATE, OP_MULTIPLY, OP_DIVIDE, OP_POWER,
  OP_SQRT, OP_EXP, OP_LOG, OP_SIN, OP_COS, OP_TAN, OP_ASIN, OP_ACOS, OP_ATAN,
  OP_SINH, OP_COSH, OP_TANH, OP_FLOOR, OP_ATAN2, OP_IF,
  OP_LESS, OP_LESS_EQUAL, OP_GREATER, OP_GREATER_EQUAL, OP_EQUAL, OP_NOT_EQUAL,
  OP_AND, OP_OR, OP_NOT, OP_DOUBLE
};

/* Where the code reads: spins are the local variables 0 .. 3*slots-1, time is the next. */
typedef struct reads {
  const real *spin;   /* 3 x slots */
  real t;
  int64_t time_variable;
  const double *data, *table;
} reads;

int interpret(const program *p, const reads *in, jets *j);

#endif
