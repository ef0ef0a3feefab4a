/* smidgen runtime: what rounding does to the formula of the field. Where its terms cancel, as in log(2 - 2 w.w) of two
 * vortices, h X(m) is off by far more than the ulps of its products, and no iteration leaves less: sites d apart lose
 * the part eps/d^2 of their field. Rounding moves products of components by an ulp or so, which is what the same
 * relative change of the components does. So the field is probed at points whose components are changed by SMG_PROBE
 * ulps each, up and down. Where the two do not do opposite things, the formula jumps, or has less than three digits
 * left, and its round-off is not known. */
#ifndef SMG_NOISE_H
#define SMG_NOISE_H

#if SMG_HAS_COUPLED
#include "smg_coupled.h"
#endif
#include "smg_midpoint.h"
#include "smg_tolerances.h"

/* The factor of the component b, which goes down where the bits `down` have it. */
SMG_INLINE smg_real smg_probe_factor(unsigned down, int64_t b) {
  return 1 + (down >> b & 1 ? -1 : 1) * SMG_PROBE * SMG_EPS;
}

/* x = the components of m, changed. */
SMG_INLINE void smg_probe(unsigned down, const smg_real *m, smg_real *x) {
  for (int b = 0; b < 3; ++b) x[b] = m[b] * smg_probe_factor(down, b);
}

/* Takes in a site whose h X is u, and `up` and `down` at the changed components: how far it moves, and how much of that
 * is not odd. */
static inline void smg_probe_take(smg_real *odd, smg_real *even, const smg_real *up, const smg_real *down,
                                  const smg_real *u) {
  for (int b = 0; b < 3; ++b) {
    *odd = smg_max(*odd, 0.5 * smg_abs(up[b] - down[b]));
    *even = smg_max(*even, smg_abs(up[b] + down[b] - 2 * u[b]));
  }
}

/* What a change of an ulp does; 0 where that is not known. */
static inline smg_real smg_probed_noise(smg_real odd, smg_real even) { return even <= 0.5 * odd ? odd / SMG_PROBE : 0; }

#if SMG_ALONE_NEWTON
/* h X of a site alone at the components of m, changed. */
SMG_RARE static void smg_probe_site(const smg_state *s, smg_real h, int64_t k, const smg_real *m, unsigned down,
                                    smg_real *u) {
  smg_real x[3], g[3] = {0, 0, 0};
  smg_probe(down, m, x);
  smg_gather(&s->c, smg_at(k), s->m, x, g);
  smg_increment(&s->c, k, h, x, g, u);
}

/* How far u = h X(m) of a site alone moves, at most, when each component of m does by an ulp of its own. */
SMG_COLD SMG_RARE static smg_real smg_site_noise(const smg_state *s, smg_real h, int64_t k, const smg_real *m,
                                                 const smg_real *u) {
  smg_real odd = 0, even = 0;
  for (unsigned down = 0; down < 4; ++down) { /* the other four are their opposites */
    smg_real one[3], other[3];
    smg_probe_site(s, h, k, m, down, one);
    smg_probe_site(s, h, k, m, 7 - down, other);
    smg_probe_take(&odd, &even, one, other, u);
  }
  return smg_probed_noise(odd, even);
}
#endif

#if SMG_HAS_COUPLED
#define SMG_PROBES 8

/* Which components of site k go down: those of the bits 0 to 3 as of a site alone; of every second probe, with half of
 * the sites the other way round, for terms in which changes of like sign cancel. */
static inline unsigned smg_probe_signs(int64_t k, unsigned probe) {
  const unsigned turned = (unsigned)((uint64_t)k * UINT64_C(0x9E3779B97F4A7C15) >> (60 + probe % 4)) & 1;
  return probe % 4 ^ (probe >= 4 && turned ? 7 : 0);
}

/* u = h X at the components of m = P(mbar), changed; `back`: by the opposite. */
SMG_RARE static void smg_probe_all(smg_state *s, smg_real h, unsigned probe, int back, smg_real *u) {
  smg_project_all(s);
  for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
    const int64_t k = smg_site(&s->c, row);
    smg_probe(smg_probe_signs(k, probe) ^ (back ? 7 : 0), s->m + 3 * k, s->m + 3 * k);
  }
  smg_coupled_gradient(&s->c, s->m, s->g);
  smg_increments(s, h, u);
}

/* noise: of every site how far its h X moves, at most, when each component of all midpoints does by an ulp of its own.
 * u: h X at P(s->mbar), where all is evaluated again at the end. up, even: room for 3 numbers a site and for one. */
SMG_COLD SMG_RARE static void smg_noise_of_all(smg_state *s, smg_real h, const smg_real *u, smg_real *up,
                                               smg_real *even, smg_real *noise) {
  const int64_t n = smg_sites(&s->c);
  smg_zero(noise, n);
  smg_zero(even, n);
  for (unsigned probe = 0; probe < SMG_PROBES; ++probe) {
    smg_probe_all(s, h, probe, 0, up);
    smg_probe_all(s, h, probe, 1, s->u);
    for (int64_t row = 0; row < smg_coupled(&s->c); ++row) {
      const int64_t k = smg_site(&s->c, row);
      smg_probe_take(noise + k, even + k, up + 3 * k, s->u + 3 * k, u + 3 * k);
    }
  }
  for (int64_t k = 0; k < n; ++k) noise[k] = smg_probed_noise(noise[k], even[k]);
  (void)smg_evaluate(s, h);
}
#endif

#endif
