"""A hand-written model behind the C interface, for tests that need no compiler.

n unit spins turn about z at the rate J; the step after number `fail` (when positive) fails
with `status`, at site 1, whatever the state.
"""
SPEC = """
[model]
name = "toy"
title = "Toy"
[space]
w = { sphere = "n" }
[parameters]
n = { default = 3 }
J = { default = 1.0 }
fail = { default = 0 }
status = { default = 2 }
shift = { default = [0.0, 0.0], size = 2 }
[effects.field]
over = "site(i) of w"
energy = "J * w[i].z + 0*(fail + status + shift[0] + shift[1]) * w[i].z"
[effects.extra]
over = "site(i) of w"
energy = "0.5 * w[i].x"
[observables.mz]
over = "site(i) of w"
value = "w[i].z / n"
[starts.ring]
x = "cos(2*pi*i/n)*0.6"
y = "sin(2*pi*i/n)*0.6"
z = "0.8"
[starts.any]
random = 7
[runs.demo]
start = "ring"
h = 0.125
steps = 20
effects = ["field"]
output = { every = 5, what = ["states", "energy", "momentum", "casimirs", "mz"] }
[runs.turns]
start = "any"
h = "2*pi/20"
time = "6*pi"
effects = ["field"]
output = { period = "2*pi", what = ["states"] }
"""

HEADER = "/* toy */\n#include \"smidgen.h\"\n"
SOURCE = r"""
#include "toy.h"
#include <stdlib.h>
#include <string.h>
typedef struct { int64_t n, fail, status, count; double j, t0, h, shift; int last; smg_real *w; } toy;

void *toy_abi_new(const double *p, const double *const *arrays, const smg_real *w, double t0,
                  double h, int *status) {
  toy *s = calloc(1, sizeof *s);
  *status = p[0] < 1 || p[1] == 0 ? SMG_BAD_PARAMETER : SMG_OK;
  s->n = (int64_t)p[0]; s->j = p[1]; s->fail = (int64_t)p[2]; s->status = (int64_t)p[3];
  s->shift = arrays[0][0]; s->t0 = t0; s->h = h;
  s->w = malloc((size_t)s->n * 3 * sizeof *s->w);
  memcpy(s->w, w, (size_t)s->n * 3 * sizeof *s->w);
  if (*status) { free(s->w); free(s); return NULL; }
  return s;
}
int toy_abi_set_parameters(void *v, const double *p, const double *const *arrays) { (void)v; (void)p; (void)arrays; return SMG_BAD_PARAMETER; }
int toy_abi_set_tolerance(void *v, double tolerance) { (void)v; (void)tolerance; return SMG_OK; }
int toy_abi_steps(void *v, int64_t count, int64_t *done) {
  toy *s = v;
  smg_real c = SMG_MATH(cos)((smg_real)(s->j * s->h)), d = SMG_MATH(sin)((smg_real)(s->j * s->h));
  for (*done = 0; *done < count; ++*done, ++s->count) {
    s->last = s->fail > 0 && s->count == s->fail ? (int)s->status : 0;
    if (s->last) return s->last;
    for (int64_t i = 0; i < s->n; i++) {
      smg_real *w = s->w + 3 * i, x = w[0], y = w[1];
      w[0] = c * x + d * y;
      w[1] = c * y - d * x;
    }
  }
  return 0;
}
int toy_abi_take(void *v, smg_real *w) { toy *s = v; memcpy(s->w, w, (size_t)s->n * 3 * sizeof *w); return 0; }
int toy_abi_go(void *v, smg_real *w, int64_t count, int64_t *done) {
  toy *s = v;
  toy_abi_take(v, w);
  const int status = toy_abi_steps(v, count, done);
  memcpy(w, s->w, (size_t)s->n * 3 * sizeof *w);
  return status;
}
int64_t toy_abi_savesize(void *v) { return 10 + 3 * ((toy *)v)->n; }
void toy_abi_save(void *v, smg_real *out) {      /* the head of runtime/core/smg_saved.h, then w */
  toy *s = v;
  const smg_real head[10] = {(smg_real)(10 + 3 * s->n), (smg_real)(10 + 3 * s->n), (smg_real)s->t0, (smg_real)s->h,
                             (smg_real)(s->count / 4294967296), (smg_real)(s->count % 4294967296)};
  memcpy(out, head, sizeof head);
  memcpy(out + 10, s->w, (size_t)s->n * 3 * sizeof *s->w);
}
int toy_abi_restore(void *v, const smg_real *in) {
  toy *s = v;
  if (in[0] != (smg_real)(10 + 3 * s->n)) return SMG_BAD_PARAMETER;
  s->t0 = (double)in[2]; s->h = (double)in[3];
  s->count = (int64_t)in[4] * 4294967296 + (int64_t)in[5];
  memcpy(s->w, in + 10, (size_t)s->n * 3 * sizeof *s->w);
  return SMG_OK;
}
double toy_abi_time(void *v) { toy *s = v; return s->t0 + (double)s->count * s->h; }
int64_t toy_abi_sites(void *v) { return ((toy *)v)->n; }
void toy_abi_state(void *v, smg_real *w) { toy *s = v; memcpy(w, s->w, (size_t)s->n * 3 * sizeof *w); }
const smg_real *toy_abi_w(void *v) { return ((toy *)v)->w; }
void toy_abi_values(void *v, const unsigned char *asked, smg_real *out) {
  toy *s = v;
  (void)asked;
  smg_real m[3] = {0, 0, 0};
  for (int64_t i = 0; i < 3 * s->n; i++) m[i % 3] += s->w[i];
  out[0] = out[1] = s->j * m[2];
  memcpy(out + 2, m, sizeof m);
  out[5] = m[2] / (smg_real)s->n;
}
void toy_abi_casimirs(void *v, smg_real *out) {
  toy *s = v;
  for (int64_t i = 0; i < s->n; i++)
    out[i] = s->w[3*i]*s->w[3*i] + s->w[3*i+1]*s->w[3*i+1] + s->w[3*i+2]*s->w[3*i+2];
}
void toy_abi_report(void *v, int *iterations, double *residual, int64_t *site, int64_t *partner, double *reached) {
  toy *s = v;
  *iterations = 4; *residual = s->last ? 0.25 : 1e-17; *site = s->last ? 1 : -1;
  *partner = -1; *reached = 0;
}
void toy_abi_field(void *v, double t, const smg_real *w, smg_real *b) {
  toy *s = v; (void)t; (void)w;
  for (int64_t i = 0; i < 3 * s->n; i++) b[i] = i % 3 == 2 ? s->j : s->shift;
}
void toy_abi_energy(void *v, double t, const smg_real *w, smg_real *e) {
  toy *s = v; (void)t;
  *e = 0;
  for (int64_t i = 0; i < s->n; i++) *e += s->j * w[3*i+2];
}
int64_t toy_abi_count(void *v) { return ((toy *)v)->count; }
#define SMG_ABI(word) toy_abi_##word
#define SMG_COLUMNS 6
#include "smg_outputs.h"
int toy_abi_outputs(void *v, int64_t first, int64_t every, int64_t rows, const void *out, int64_t *done) {
  return smg_put_outputs(v, first, every, rows, out, done);
}
void toy_abi_free(void *v) { free(((toy *)v)->w); free(v); }
"""


def generate(spec, method, solver, features):
    """In place of `smidgen.compile.emit.emit.generate`."""
    return {"toy.h": HEADER, "toy_abi.c": SOURCE}, {"solver": "exact"}
