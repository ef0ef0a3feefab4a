/* A test program is a filter: numbers (doubles) in, numbers out. */
#ifndef PIPE_H
#define PIPE_H

#include <stdio.h>
#include <stdlib.h>

#include "smidgen.h"

static inline double pipe_number(void) {
  double value;
  if (fread(&value, sizeof value, 1, stdin) != 1) exit(70);
  return value;
}

static inline int64_t pipe_integer(void) { return (int64_t)pipe_number(); }

static inline void pipe_take(int64_t count, smg_real *to) {
  for (int64_t e = 0; e < count; e++) to[e] = (smg_real)pipe_number();
}

static inline void pipe_put(double value) {
  if (fwrite(&value, sizeof value, 1, stdout) != 1) exit(71);
}

static inline void pipe_give(int64_t count, const smg_real *from) {
  for (int64_t e = 0; e < count; e++) pipe_put((double)from[e]);
}

/* Exactly `count` reals, so that the sanitizer sees the first access beyond them. */
static inline smg_real *pipe_room(int64_t count) {
  smg_real *room = (smg_real *)malloc((size_t)(count > 0 ? count : 1) * sizeof *room);
  if (!room) exit(72);
  for (int64_t e = 0; e < count; e++) room[e] = (smg_real)NAN;
  return room;
}

#endif
