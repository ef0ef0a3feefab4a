/* smidgen runtime: what a response r = f, q, F0, Q0 makes of a gradient (smg_respond.h); a template (smg_template.h).
 * */
#if SMG_RESPONDS
/* F and Q. */
SMG_INLINE void smg_told_parts(const smg_told_number *r, const smg_number *g, smg_number *F, smg_number *Q) {
  for (int b = 0; b < 3; ++b) {
    F[b] = r[0] * g[b] + r[SMG_RESPONSE_F0 + b];
    Q[b] = r[1] * g[b] + r[SMG_RESPONSE_Q0 + b];
  }
}

/* R = F + m x Q, in `room`. */
SMG_INLINE const smg_number *smg_told_respond(const smg_told_number *r, const smg_number *m, const smg_number *g,
                                              smg_number *room) {
  smg_number F[3], Q[3];
  smg_told_parts(r, g, F, Q);
  smg_cross(room, m, Q);
  smg_axpy(room, smg_of(1), F, 3);
  return room;
}

/* The change f y + q m x y of R, y that of g, in `room`. */
SMG_INLINE const smg_number *smg_told_change(const smg_told_number *r, const smg_number *m, const smg_number *y,
                                             smg_number *room) {
  smg_cross(room, m, y);
  for (int b = 0; b < 3; ++b) room[b] = r[1] * room[b] + r[0] * y[b];
  return room;
}

/* turned += m x (d x Q), the change of m x R with m in R by d. */
SMG_INLINE void smg_told_turn(const smg_told_number *r, const smg_number *m, const smg_number *g, const smg_number *d,
                              smg_number *turned) {
  smg_number F[3], Q[3], x[3], y[3];
  smg_told_parts(r, g, F, Q);
  smg_cross(x, d, Q);
  smg_cross(y, m, x);
  smg_axpy(turned, smg_of(1), y, 3);
}
#endif
