/* Members of an ensemble in lanes, the same one by one, and a body by hand: ns a body and step, by turns, the least of ROUNDS.
 * argv: h. MODEL, SOURCE: of a body; BY_HAND: it is the free body with moments 1, 2, 4. */
#include SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define JOINED(a, b) a##b
#define NAMED(model, word) JOINED(model, word)
#define F(word) NAMED(MODEL, word)

enum { MEMBERS = 1000, STEPS = 1000, ROUNDS = 5 };
static double start[3 * MEMBERS];

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* By hand: every spin by a fixed point without compensation or a check of the branch, to a change of an ulp, from the polynomial of
 * degree DEGREE through the last increments. */
typedef double hand __attribute__((vector_size(64)));
enum { HAND = 8, DEGREE = 11, GROUPS = MEMBERS / HAND };
typedef struct hand_body {
  hand w[3], u[3 * (DEGREE + 1)];
} hand_body;
static hand_body body[GROUPS];

static void hand_step(hand_body *b, const double *weight, const double *k, int newest) {
  hand p[3] = {{0}};
  for (int j = DEGREE; j >= 0; --j)
    for (int i = 0; i < 3; ++i) p[i] += weight[j] * b->u[3 * ((newest + j) % (DEGREE + 1)) + i];
  for (int sweep = 0; sweep < 50; ++sweep) {
    const hand x = 2 * b->w[0] + p[0], y = 2 * b->w[1] + p[1], z = 2 * b->w[2] + p[2], q = 1 / (x * x + y * y + z * z);
    const hand u[3] = {k[0] * q * (y * z), k[1] * q * (z * x), k[2] * q * (x * y)};
    const hand a = u[0] - p[0], c = u[1] - p[1], d = u[2] - p[2], change = a * a + c * c + d * d;
    int left = 0;
    for (int l = 0; l < HAND; ++l) left |= change[l] > 4e-32;
    for (int i = 0; i < 3; ++i) p[i] = u[i];
    if (!left) break;
  }
  for (int i = 0; i < 3; ++i) {
    b->u[3 * ((newest + DEGREE) % (DEGREE + 1)) + i] = p[i];
    b->w[i] += p[i];
  }
}

static double by_hand(double h) {
  const double k[3] = {h * (1. / 4 - 1. / 2), h * (1 - 1. / 4), h * (1. / 2 - 1)};
  double weight[DEGREE + 1], binomial = 1;
  for (int j = 0; j <= DEGREE; ++j) {
    binomial = binomial * (DEGREE + 1 - j) / (j + 1);
    weight[j] = j % 2 ? -binomial : binomial;
  }
  memset(body, 0, sizeof body);
  for (int n = 0; n < MEMBERS; ++n)
    for (int i = 0; i < 3; ++i) body[n / HAND].w[i][n % HAND] = start[3 * n + i];
  const double t = now(), none[DEGREE + 1] = {0};
  for (int g = 0; g < GROUPS; ++g)
    for (int n = 0; n < STEPS; ++n) hand_step(body + g, n > DEGREE ? weight : none, k, (STEPS * (DEGREE + 1) - n) % (DEGREE + 1));
  return now() - t;
}

static double one_by_one(smg_state *s, const smg_model *model, char *mem, size_t size, double h) {
  for (int n = 0; n < MEMBERS; ++n) (void)smg_begin_state(s + n, model, mem + size * (size_t)n, start + 3 * n, 0, h);
  const double t = now();
  for (int n = 0; n < MEMBERS; ++n) (void)F(_steps)(s + n, STEPS);
  return now() - t;
}

static double in_lanes(smg_ensemble *e, const smg_model *model, void *mem, double h) {
  (void)F(_ensemble_init)(e, model, 0, MEMBERS, mem, start, 0, h);
  const double t = now();
  (void)F(_ensemble_steps)(e, 0, MEMBERS, STEPS);
  return now() - t;
}

static void spread_starts(void) {
  srand(1);
  for (int n = 0; n < MEMBERS; ++n) {
    double *w = start + 3 * n, size = 0;
    for (int i = 0; i < 3; ++i) w[i] = rand() / (RAND_MAX + 1.0) - 0.5, size += w[i] * w[i];
    for (int i = 0; i < 3; ++i) w[i] /= sqrt(size);
  }
}

/* How many states differ in a bit. */
static int differing(const smg_state *s, const smg_ensemble *e, const smg_model *model) {
  const size_t size = F(_savesize)(model);
  double *a = malloc(size * sizeof *a), *b = malloc(size * sizeof *b);
  int found = 0;
  for (int n = 0; n < MEMBERS; ++n) {
    F(_save)(s + n, a);
    F(_save)(e->member + n, b);
    found += memcmp(a, b, size * sizeof *a) != 0;
  }
  free(a);
  free(b);
  return found;
}

int main(int argc, char **argv) {
  const double h = argc > 1 ? atof(argv[1]) : 0.1;
  smg_params p;
  smg_model model;
  smg_ensemble e;
  F(_defaults)(&p);
  (void)F(_model_init)(&model, &p);
  spread_starts();
  const size_t size = smg_whole_lines(F(_memsize)(&model));
  smg_state *s = malloc(sizeof *s * MEMBERS);
  char *mem = aligned_alloc(64, size * MEMBERS);
  void *all = aligned_alloc(64, smg_whole_lines(F(_ensemble_memsize)(&model, 0, MEMBERS)));
  double least[3] = {1e9, 1e9, 1e9};
  for (int r = 0; r < ROUNDS; ++r) {
    const double t[3] = {in_lanes(&e, &model, all, h), one_by_one(s, &model, mem, size, h), BY_HAND ? by_hand(h) : 0};
    for (int k = 0; k < 3; ++k)
      if (t[k] < least[k]) least[k] = t[k];
  }
  for (int k = 0; k < 3; ++k) printf("%.2f ", least[k] / MEMBERS / STEPS * 1e9);
  printf("%d %d\n", SMG_LANES, differing(s, &e, &model));
  return 0;
}
