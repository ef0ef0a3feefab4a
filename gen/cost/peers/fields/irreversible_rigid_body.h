/* w' = w x g, g_k = (w_k + (3 sigma/2) w_k^2)/I_k, in vectors of four with one idle. */
#define NUMBERS 4
typedef double row __attribute__((vector_size(32), aligned(8), may_alias));

typedef struct field_numbers {
  double linear[4], square[4];
} field_numbers;

ALWAYS void prepared(field_numbers *f, const irreversible_rigid_body_params *p) {
  const double I[3] = {p->I1, p->I2, p->I3};
  f->linear[3] = f->square[3] = 0;
  for (int c = 0; c < 3; ++c) f->linear[c] = 1 / I[c], f->square[c] = 1.5 * p->sigma / I[c];
}

ALWAYS row yzx(row a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }

ALWAYS void field(const field_numbers *f, const double *w, double *k) {
  const row a = *(const row *)w, g = a * (*(const row *)f->linear + *(const row *)f->square * a);
  /* a x g, its components turned by one: z, x, y */
  const row zxy = a * yzx(g) - g * yzx(a);
  *(row *)k = yzx(zxy);
}
