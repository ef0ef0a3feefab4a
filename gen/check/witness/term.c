/* One term of the energy at all instances of its indices: its value, gradient and Hessian added where they belong. */
#include "interpreter.h"

#include <stdlib.h>

/* Memory for the instances of one term. */
typedef struct work {
  jets j;
  real *spin;
  reads in;
  int64_t variables; /* spins only; time is one more at order 2 */
} work;

static void work_free(work *k) {
  jets_free(&k->j);
  free(k->spin);
}

static int work_new(work *k, const program *p, real t, int order) {
  k->variables = 3 * p->slots;
  k->spin = malloc((size_t)(k->variables + 1) * sizeof(real));
  k->in = (reads){k->spin, t, k->variables, p->data, p->table};
  const int status = jets_new(&k->j, p->length, k->variables + (order > 1), order);
  return k->spin ? status : NO_MEMORY;
}

/* The spins of instance n, then the value (and derivatives) of the term in its last register. */
static int run_instance(work *k, const program *p, int64_t n, const real *w) {
  for (int64_t s = 0; s < p->slots; s++)
    for (int c = 0; c < 3; c++) k->spin[3 * s + c] = w[3 * p->site[n * p->slots + s] + c];
  k->in.data = p->data + n * p->columns;
  return interpret(p, &k->in, &k->j);
}

int term_value(const program *p, real t, const real *w, real *sum) {
  work k;
  int status = work_new(&k, p, t, 0);
  for (int64_t n = 0; n < p->instances && status == OK; n++) {
    status = run_instance(&k, p, n, w);
    *sum += value(&k.j, p->length - 1);
  }
  work_free(&k);
  return status;
}

/* Adds the gradient of one instance to the sites that the term acts on. */
static void scatter_gradient(const work *k, const program *p, int64_t n, real *gradient) {
  const int64_t last = p->length - 1, *site = p->site + n * p->slots;
  if (!k->j.active[last]) return;
  for (int64_t v = 0; v < k->variables; v++)
    if (p->feels[v / 3]) gradient[3 * site[v / 3] + v % 3] += jet(&k->j, last)[1 + v];
}

int term_gradient(const program *p, real t, const real *w, real *gradient) {
  work k;
  int status = work_new(&k, p, t, 1);
  for (int64_t n = 0; n < p->instances && status == OK; n++) {
    status = run_instance(&k, p, n, w);
    scatter_gradient(&k, p, n, gradient);
  }
  work_free(&k);
  return status;
}

int term_values(const program *p, real t, const real *w, const int64_t *moved, int64_t component, real *T) {
  work k;
  int status = work_new(&k, p, t, 0);
  for (int64_t n = 0; n < p->instances && status == OK; n++) {
    status = run_instance(&k, p, n, w);
    T[3 * moved[n] + component] += value(&k.j, p->length - 1);
  }
  work_free(&k);
  return status;
}

int term_slopes(const program *p, real t, const real *w, const int64_t *moved, int64_t component, int64_t rows,
                double *slopes, real *T_dt) {
  work k;
  int status = work_new(&k, p, t, 2);
  for (int64_t n = 0; n < p->instances && status == OK; n++) {
    const int64_t last = p->length - 1, row = 3 * moved[n] + component, *site = p->site + n * p->slots;
    status = run_instance(&k, p, n, w);
    if (!k.j.active[last]) continue;
    for (int64_t v = 0; v < k.variables; v++)
      slopes[row * rows + 3 * site[v / 3] + v % 3] += (double)jet(&k.j, last)[1 + v];
    T_dt[row] += jet(&k.j, last)[1 + k.variables];
  }
  work_free(&k);
  return status;
}

/* second derivative with respect to the local variables u and v */
static real second(const work *k, int64_t last, int64_t u, int64_t v) {
  const int64_t row = u > v ? u : v, column = u > v ? v : u;
  return jet(&k->j, last)[1 + k->j.k + row * (row + 1) / 2 + column];
}

static void scatter_hessian(const work *k, const program *p, int64_t n, real *gradient_dt,
                            block_sink sink, void *to) {
  const int64_t last = p->length - 1, *site = p->site + n * p->slots;
  if (!k->j.active[last]) return;
  for (int64_t a = 0; a < p->slots; a++) {
    if (!p->feels[a]) continue;
    for (int c = 0; c < 3; c++)
      gradient_dt[3 * site[a] + c] += second(k, last, 3 * a + c, k->variables);
    for (int64_t b = 0; b < p->slots; b++) {
      real block[9];
      for (int e = 0; e < 9; e++) block[e] = second(k, last, 3 * a + e / 3, 3 * b + e % 3);
      sink(to, site[a], site[b], block);
    }
  }
}

int term_hessian(const program *p, real t, const real *w, real *gradient, real *gradient_dt,
                 block_sink sink, void *to) {
  work k;
  int status = work_new(&k, p, t, 2);
  for (int64_t n = 0; n < p->instances && status == OK; n++) {
    status = run_instance(&k, p, n, w);
    scatter_gradient(&k, p, n, gradient);
    scatter_hessian(&k, p, n, gradient_dt, sink, to);
  }
  work_free(&k);
  return status;
}
