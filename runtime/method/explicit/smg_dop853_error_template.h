/* smidgen method: how large the error of an internal step of smg_dop853.h is, of one site; a template
 * (smg_template.h). */
#include "smg_vec.h"

/* The square of the error of one site, as part of what is allowed: e5^4/(e5^2 + e3^2/100) of the norms of both; squares
 * that leave the range of numbers are of steps that are far too large or too small. NaN where its new w is no number.
 * */
SMG_INLINE smg_number smg_site_error(const smg_number *y, const smg_number *u, const smg_number *e5,
                                     const smg_number *e3) {
  const smg_number first = smg_dot(e5, e5), both = first + smg_dot(e3, e3) * (smg_real)0.01;
  const smg_number square = smg_select(smg_less(smg_of(0), first), first * (first / both), first);
  const smg_test shows = smg_at_most(both, smg_of(SMG_MAX)); /* else of e5 that does not show beside it, too */
  return smg_select(smg_vec_finite(smg_vec_add(smg_vec_load(y), smg_vec_load(u))),
                    smg_select(shows, square, smg_of(SMG_MAX)), smg_of((smg_real)NAN));
}
