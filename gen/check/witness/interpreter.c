/* The operations of interpreter.h, one function each. */
#include "interpreter.h"

#include <math.h>

/* a^b: (a^b)_a = b a^(b-1), (a^b)_b = a^b log a; log a only where b varies */
static void power(jets *j, int64_t r, const instruction *i) {
  const real a = value(j, i->a), b = value(j, i->b), f = powl(a, b);
  const real fa = b == 0 ? 0 : b * powl(a, b - 1);
  const real faa = b == 0 || b == 1 ? 0 : b * (b - 1) * powl(a, b - 2);
  if (!j->active[i->b]) {
    jet_unary(j, r, i->a, f, fa, faa);
    return;
  }
  const real l = logl(a);
  jet_binary(j, r, i->a, i->b, f,
             (real[5]){fa, f * l, faa, powl(a, b - 1) * (1 + b * l), f * l * l});
}

static void divide(jets *j, int64_t r, const instruction *i) {
  const real a = value(j, i->a), b = value(j, i->b), f = a / b;
  jet_binary(j, r, i->a, i->b, f,
             (real[5]){1 / b, -f / b, 0, -1 / (b * b), 2 * f / (b * b)});
}

static void angle(jets *j, int64_t r, const instruction *i) {
  const real y = value(j, i->a), x = value(j, i->b), s = x * x + y * y;
  const real fyy = -2 * x * y / (s * s), fyx = (y * y - x * x) / (s * s);
  jet_binary(j, r, i->a, i->b, atan2l(y, x), (real[5]){x / s, -y / s, fyy, fyx, -fyy});
}

static void binary(jets *j, int64_t r, const instruction *i) {
  const real a = value(j, i->a), b = value(j, i->b);
  switch (i->op) {
    case OP_ADD: jet_binary(j, r, i->a, i->b, a + b, (real[5]){1, 1, 0, 0, 0}); break;
    case OP_SUBTRACT: jet_binary(j, r, i->a, i->b, a - b, (real[5]){1, -1, 0, 0, 0}); break;
    case OP_MULTIPLY: jet_binary(j, r, i->a, i->b, a * b, (real[5]){b, a, 0, 1, 0}); break;
    case OP_DIVIDE: divide(j, r, i); break;
    case OP_POWER: power(j, r, i); break;
    default: angle(j, r, i); break; /* OP_ATAN2 */
  }
}

static void root(jets *j, int64_t r, int64_t a, real x) {
  const real f = sqrtl(x);
  jet_unary(j, r, a, f, 1 / (2 * f), -1 / (4 * f * x));
}

static void tangent(jets *j, int64_t r, int64_t a, real x) {
  const real f = tanl(x), fa = 1 + f * f;
  jet_unary(j, r, a, f, fa, 2 * f * fa);
}

/* asin: f' = (1-x^2)^(-1/2), f'' = x f'^3; acos: the negative */
static void arc(jets *j, int64_t r, int64_t a, real x, real f, real sign) {
  const real fa = 1 / sqrtl((1 - x) * (1 + x));
  jet_unary(j, r, a, f, sign * fa, sign * x * fa * fa * fa);
}

static void arc_tangent(jets *j, int64_t r, int64_t a, real x) {
  const real fa = 1 / (1 + x * x);
  jet_unary(j, r, a, atanl(x), fa, -2 * x * fa * fa);
}

static void hyperbolic_tangent(jets *j, int64_t r, int64_t a, real x) {
  const real f = tanhl(x), fa = 1 - f * f;
  jet_unary(j, r, a, f, fa, -2 * f * fa);
}

static void unary(jets *j, int64_t r, const instruction *i) {
  const real x = value(j, i->a);
  const int64_t a = i->a;
  switch (i->op) {
    case OP_NEGATE: jet_unary(j, r, a, -x, -1, 0); break;
    case OP_SQRT: root(j, r, a, x); break;
    case OP_EXP: jet_unary(j, r, a, expl(x), expl(x), expl(x)); break;
    case OP_LOG: jet_unary(j, r, a, logl(x), 1 / x, -1 / (x * x)); break;
    case OP_SIN: jet_unary(j, r, a, sinl(x), cosl(x), -sinl(x)); break;
    case OP_COS: jet_unary(j, r, a, cosl(x), -sinl(x), -cosl(x)); break;
    case OP_TAN: tangent(j, r, a, x); break;
    case OP_ASIN: arc(j, r, a, x, asinl(x), 1); break;
    case OP_ACOS: arc(j, r, a, x, acosl(x), -1); break;
    case OP_ATAN: arc_tangent(j, r, a, x); break;
    case OP_SINH: jet_unary(j, r, a, sinhl(x), coshl(x), sinhl(x)); break;
    case OP_COSH: jet_unary(j, r, a, coshl(x), sinhl(x), coshl(x)); break;
    case OP_TANH: hyperbolic_tangent(j, r, a, x); break;
    case OP_FLOOR: jet_constant(j, r, floorl(x)); break;
    default: jet_constant(j, r, (double)x); break; /* OP_DOUBLE */
  }
}

static void truth(jets *j, int64_t r, const instruction *i) {
  const real a = value(j, i->a), b = value(j, i->b);
  int holds;
  switch (i->op) {
    case OP_LESS: holds = a < b; break;
    case OP_LESS_EQUAL: holds = a <= b; break;
    case OP_GREATER: holds = a > b; break;
    case OP_GREATER_EQUAL: holds = a >= b; break;
    case OP_EQUAL: holds = a == b; break;
    case OP_NOT_EQUAL: holds = a != b; break;
    case OP_AND: holds = a != 0 && b != 0; break;
    case OP_OR: holds = a != 0 || b != 0; break;
    default: holds = a == 0; break; /* OP_NOT */
  }
  jet_constant(j, r, holds);
}

/* entry of an array: b is its first position in the table, c its number of entries */
static int element(jets *j, int64_t r, const instruction *i, const double *table) {
  const real index = value(j, i->a);
  if (!(index >= 0 && index < i->c && index == floorl(index))) return BAD_ELEMENT;
  jet_constant(j, r, table[i->b + (int64_t)index]);
  return OK;
}

static void time_now(jets *j, int64_t r, const reads *in) {
  if (j->order > 1) jet_variable(j, r, in->t, in->time_variable);
  else jet_constant(j, r, in->t);
}

static int execute(const instruction *i, int64_t r, const reads *in, jets *j) {
  switch (i->op) {
    case OP_CONSTANT: jet_constant(j, r, i->number); break;
    case OP_TIME: time_now(j, r, in); break;
    case OP_COLUMN: jet_constant(j, r, in->data[i->a]); break;
    case OP_SPIN: jet_variable(j, r, in->spin[3 * i->a + i->b], 3 * i->a + i->b); break;
    case OP_ELEMENT: return element(j, r, i, in->table);
    case OP_IF: jet_copy(j, r, value(j, i->a) != 0 ? i->b : i->c); break;
    case OP_ADD: case OP_SUBTRACT: case OP_MULTIPLY: case OP_DIVIDE: case OP_POWER:
    case OP_ATAN2: binary(j, r, i); break;
    case OP_LESS: case OP_LESS_EQUAL: case OP_GREATER: case OP_GREATER_EQUAL: case OP_EQUAL:
    case OP_NOT_EQUAL: case OP_AND: case OP_OR: case OP_NOT: truth(j, r, i); break;
    default: unary(j, r, i); break;
  }
  return OK;
}

int interpret(const program *p, const reads *in, jets *j) {
  int status = OK;
  for (int64_t r = 0; r < p->length && status == OK; r++)
    status = execute(&p->code[r], r, in, j);
  return status;
}
