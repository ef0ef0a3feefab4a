/* w_i' = w_i x (w_{i-1} + w_{i+1}) on a ring; the ends apart, so that the loop between them is plain. */
typedef struct field_numbers {
  char none;
} field_numbers;

ALWAYS void prepared(field_numbers *f, const heisenberg_chain_params *p) {
  (void)p;
  f->none = 0;
}

ALWAYS void at_site(const double *restrict w, double *restrict k, int before, int i, int after) {
  const double *x = w, *y = w + SITES, *z = y + SITES;
  const double gx = x[before] + x[after], gy = y[before] + y[after], gz = z[before] + z[after];
  k[i] = y[i] * gz - z[i] * gy;
  k[SITES + i] = z[i] * gx - x[i] * gz;
  k[2 * SITES + i] = x[i] * gy - y[i] * gx;
}

ALWAYS void field(const field_numbers *f, const double *restrict w, double *restrict k) {
  (void)f;
  at_site(w, k, SITES - 1, 0, 1);
  for (int i = 1; i < SITES - 1; ++i) at_site(w, k, i - 1, i, i + 1);
  at_site(w, k, SITES - 2, SITES - 1, 0);
}
