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
#endif
