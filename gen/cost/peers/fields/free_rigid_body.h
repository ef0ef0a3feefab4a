/* w' = w x I^-1 w */
typedef struct field_numbers {
  double d[3];
} field_numbers;

ALWAYS void prepared(field_numbers *f, const free_rigid_body_params *p) {
  f->d[0] = 1 / p->I3 - 1 / p->I2, f->d[1] = 1 / p->I1 - 1 / p->I3, f->d[2] = 1 / p->I2 - 1 / p->I1;
}

ALWAYS void field(const field_numbers *f, const double *w, double *k) {
  k[0] = f->d[0] * (w[1] * w[2]);
  k[1] = f->d[1] * (w[2] * w[0]);
  k[2] = f->d[2] * (w[0] * w[1]);
}
