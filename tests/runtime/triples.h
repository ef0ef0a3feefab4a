/* A test program whose numbers travel as three doubles each, so that none is lost in quad. After smidgen.h. */
#ifndef TRIPLES_H
#define TRIPLES_H

#include <stdio.h>
#include <stdlib.h>

static inline smg_real triple_number(void) {
  double part[3] = {0, 0, 0};
  if (fread(part, sizeof part, 1, stdin) != 1) exit(70);
  return (smg_real)part[0] + (smg_real)part[1] + (smg_real)part[2];
}

static inline void triple_put(smg_real x) {
  double part[3];
  for (int k = 0; k < 3; ++k) {
    part[k] = (double)x;
    x -= (smg_real)part[k];
  }
  if (fwrite(part, sizeof part, 1, stdout) != 1) exit(71);
}

#endif
