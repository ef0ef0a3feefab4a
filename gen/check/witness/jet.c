/* Memory of jets (jet.h). */
#include "jet.h"

#include <stdlib.h>
#include <string.h>

static int64_t numbers(int64_t k, int order) {
  return 1 + (order > 0 ? k : 0) + (order > 1 ? k * (k + 1) / 2 : 0);
}

int jets_new(jets *j, int64_t registers, int64_t variables, int order) {
  j->k = variables;
  j->order = order;
  j->stride = numbers(variables, order);
  j->at = calloc((size_t)(registers * j->stride), sizeof(real));
  j->active = calloc((size_t)registers, 1);
  return j->at && j->active ? OK : NO_MEMORY;
}

void jets_free(jets *j) {
  free(j->at);
  free(j->active);
}

static void clear(jets *j, int64_t r) {
  memset(jet(j, r) + 1, 0, (size_t)(j->stride - 1) * sizeof(real));
}

void jet_constant(jets *j, int64_t r, real v) {
  *jet(j, r) = v;
  if (j->active[r]) clear(j, r);
  j->active[r] = 0;
}

void jet_variable(jets *j, int64_t r, real v, int64_t which) {
  jet_constant(j, r, v);
  if (j->order == 0) return;
  jet(j, r)[1 + which] = 1;
  j->active[r] = 1;
}

void jet_copy(jets *j, int64_t r, int64_t a) {
  memcpy(jet(j, r), jet(j, a), (size_t)j->stride * sizeof(real));
  j->active[r] = j->active[a];
}

/* f(a)_p = f_a a_p,   f(a)_pq = f_a a_pq + f_aa a_p a_q */
void jet_unary(jets *j, int64_t r, int64_t a, real f, real fa, real faa) {
  if (!j->active[a]) {
    jet_constant(j, r, f);
    return;
  }
  real *u = jet(j, r), *da = jet(j, a) + 1, *haa = da + j->k, *h = u + 1 + j->k;
  *u = f;
  j->active[r] = 1;
  for (int64_t p = 0; p < j->k; p++) u[1 + p] = fa * da[p];
  if (j->order < 2) return;
  for (int64_t p = 0; p < j->k; p++)
    for (int64_t q = 0; q <= p; q++) *h++ = fa * *haa++ + faa * da[p] * da[q];
}

/* f(a,b)_pq = f_a a_pq + f_b b_pq + f_aa a_p a_q + f_ab (a_p b_q + b_p a_q) + f_bb b_p b_q */
static void both(jets *j, int64_t r, int64_t a, int64_t b, const real d[5]) {
  real *u = jet(j, r) + 1, *da = jet(j, a) + 1, *db = jet(j, b) + 1;
  for (int64_t p = 0; p < j->k; p++) u[p] = d[0] * da[p] + d[1] * db[p];
  if (j->order < 2) return;
  real *h = u + j->k, *haa = da + j->k, *hbb = db + j->k;
  for (int64_t p = 0; p < j->k; p++) {
    const real left = d[2] * da[p] + d[3] * db[p], right = d[3] * da[p] + d[4] * db[p];
    for (int64_t q = 0; q <= p; q++)
      *h++ = d[0] * *haa++ + d[1] * *hbb++ + left * da[q] + right * db[q];
  }
}

void jet_binary(jets *j, int64_t r, int64_t a, int64_t b, real f, const real d[5]) {
  if (!j->active[b]) {
    jet_unary(j, r, a, f, d[0], d[2]);
  } else if (!j->active[a]) {
    jet_unary(j, r, b, f, d[1], d[4]);
  } else {
    *jet(j, r) = f;
    j->active[r] = 1;
    both(j, r, a, b, d);
  }
}
