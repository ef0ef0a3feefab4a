/* Who takes part: functions of one prefix, NAME. */
#ifndef CONTENDER_H
#define CONTENDER_H

#include <stdint.h>

#define JOINED(a, b) a##_##b
#define JOIN(a, b) JOINED(a, b)
#define FUNCTION(what) JOIN(NAME, what)
#define DECLARED(name)                                                              \
  void name##_start(void *state, const double *w, double h, double tolerance);      \
  int name##_steps(void *state, int64_t n);                                         \
  const double *name##_position(const void *state);
DECLARED(hand)
DECLARED(hand_carry)
DECLARED(generated)
DECLARED(generated_plain)

#endif
