/* smidgen runtime: sweeps by rows that contract slowly, or not at all, are accelerated (Anderson, J. ACM 12, 1965).
 *
 * A sweep takes midpoints x to g, by f = g - x. Of the changes of f from sweep to sweep an orthonormal basis q is kept,
 * with the changes d of g that belong to them: the next sweep begins with g - sum (f.q) d, on the spheres. After
 * SMG_ANDERSON changes another basis begins. */
#ifndef SMG_ROW_ANDERSON_H
#define SMG_ROW_ANDERSON_H

#include "smg_krylov.h"
#include "smg_row_step.h"

/* the factor of a pass from which on sweeps are slow */
#define SMG_ROW_SLOW (smg_real)0.7

/* x, then e = x - g; e and g of the sweep before; q and d, and how many there are; sweeps since it began. */
typedef struct smg_row_anderson {
  smg_real *x, *e, *g, *q[SMG_ANDERSON], *d[SMG_ANDERSON];
  int known, sweeps;
} smg_row_anderson;

/* Its arrays, from next on. */
static inline void smg_place_anderson(const smg_state *s, smg_real *next, smg_row_anderson *a) {
  const size_t size = (size_t)smg_array_size(&s->c);
  a->x = smg_place_slots(&next, size);
  a->e = smg_place_slots(&next, size);
  a->g = smg_place_slots(&next, size);
  for (int i = 0; i < SMG_ANDERSON; ++i) {
    a->q[i] = smg_place_slots(&next, size);
    a->d[i] = smg_place_slots(&next, size);
  }
}

/* Arrays by slots: to = from; y += by x; the scalar product. */
static inline void smg_rows_copy(const smg_state *s, smg_real *to, const smg_real *from) {
  smg_copy(to - SMG_BEFORE, from - SMG_BEFORE, smg_array_size(&s->c));
}
static inline void smg_rows_add(const smg_state *s, smg_real *y, smg_real by, const smg_real *x) {
  smg_axpy(y - SMG_BEFORE, by, x - SMG_BEFORE, smg_array_size(&s->c));
}
static smg_real smg_rows_dot(const smg_state *s, const smg_real *a, const smg_real *b) {
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  smg_real sum = 0;
  for (int k = 0; k < 3; ++k) sum += smg_krylov_dot(slots, a + k * pitch, b + k * pitch);
  return sum;
}

/* Midpoints as long as their spins. */
static void smg_onto_spheres(const smg_state *s) {
  const smg_inverses inverses = smg_inverses_of(s);
  const int64_t pitch = smg_pitch(&s->c), slots = smg_slots(&s->c);
  for (int64_t slot = 0; slot < slots; slot += SMG_LANES) {
    smg_lanes m[3];
    smg_take_slots(s->row_m, pitch, slot, m);
    smg_lane_stretch_to(smg_inverse_at(inverses, slot), 0, m);
    smg_put_slots(s->row_m, pitch, slot, m);
  }
}

/* One more q and d, from the e of a->x and g in row_m. */
static void smg_extend_basis(const smg_state *s, smg_row_anderson *a) {
  if (a->known == SMG_ANDERSON) a->known = 0;
  smg_real *q = a->q[a->known], *d = a->d[a->known];
  smg_rows_copy(s, q, a->x);
  smg_rows_copy(s, d, s->row_m);
  smg_rows_add(s, q, -1, a->e);
  smg_rows_add(s, d, -1, a->g);
  for (int i = 0; i < a->known; ++i) {
    const smg_real along = smg_rows_dot(s, q, a->q[i]);
    smg_rows_add(s, q, -along, a->q[i]);
    smg_rows_add(s, d, -along, a->d[i]);
  }
  const smg_real length = SMG_MATH(sqrt)(smg_rows_dot(s, q, q));
  if (!(length > 0)) return;
  smg_divide(q - SMG_BEFORE, length, smg_array_size(&s->c));
  smg_divide(d - SMG_BEFORE, length, smg_array_size(&s->c));
  ++a->known;
}

/* The midpoints that the next sweep begins with, in place of those that the last one has left. */
static void smg_accelerate(const smg_state *s, smg_row_anderson *a) {
  if (a->sweeps++ > 0) {
    smg_rows_add(s, a->x, -1, s->row_m);
    if (a->sweeps > 2) smg_extend_basis(s, a);
    smg_rows_copy(s, a->e, a->x);
    smg_rows_copy(s, a->g, s->row_m);
    for (int i = 0; i < a->known; ++i) smg_rows_add(s, s->row_m, -smg_rows_dot(s, a->e, a->q[i]), a->d[i]);
    smg_onto_spheres(s);
  }
  smg_rows_copy(s, a->x, s->row_m);
}

#endif
