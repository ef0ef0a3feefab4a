/* Four vortices in vectors: w_i' = sum_j s gamma_j w_i x w_j/(2 - 2 w_i.w_j), s = 1/(2 pi), where j = i + 1, i + 2 and i + 3. The
 * pairs of i + 3 are those of i + 1 from their other end, so two divisions of vectors do for all. */
#if SITES != 4
#error "of four vortices"
#endif
typedef double row __attribute__((vector_size(32), aligned(8), may_alias));

typedef struct field_numbers {
  double strength[4];
} field_numbers;

ALWAYS void prepared(field_numbers *f, const point_vortices_params *p) {
  for (int i = 0; i < 4; ++i) f->strength[i] = p->gamma[i] * 0.15915494309189535;
}

ALWAYS row next(row a) { return __builtin_shufflevector(a, a, 1, 2, 3, 0); }
ALWAYS row opposite(row a) { return __builtin_shufflevector(a, a, 2, 3, 0, 1); }
ALWAYS row before(row a) { return __builtin_shufflevector(a, a, 3, 0, 1, 2); }

ALWAYS void field(const field_numbers *f, const double *w, double *k) {
  const row x = *(const row *)w, y = *(const row *)(w + 4), z = *(const row *)(w + 8), s = *(const row *)f->strength;
  const row x1 = next(x), y1 = next(y), z1 = next(z), x2 = opposite(x), y2 = opposite(y), z2 = opposite(z);
  const row x3 = before(x), y3 = before(y), z3 = before(z);
  const row near = 1 / (2 - 2 * (x * x1 + y * y1 + z * z1)), far = 1 / (2 - 2 * (x * x2 + y * y2 + z * z2));
  const row a = near * next(s), b = far * opposite(s), c = before(near) * before(s);
  const row gx = a * x1 + b * x2 + c * x3, gy = a * y1 + b * y2 + c * y3, gz = a * z1 + b * z2 + c * z3;
  *(row *)k = y * gz - z * gy;
  *(row *)(k + 4) = z * gx - x * gz;
  *(row *)(k + 8) = x * gy - y * gx;
}
