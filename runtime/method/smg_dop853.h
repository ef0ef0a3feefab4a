/* smidgen method: Dormand and Prince of order 8, explicit, with error estimates of orders 5 and 3 and control of its own steps.
 *
 * w' = f(t, w) = (1/kappa) grad C(w) x dH/dw. Twelve stages give one internal step of the size p, with y = w at its start:
 *     k_i = f(t + c_i p, y + p sum_(j<i) a_ij k_j),   y + p sum_i b_i k_i,
 * and two linear combinations of them estimate its error. smg_step takes one output step, t0 + n h to t0 + (n + 1) h, by as many
 * internal ones as the tolerance asks; the last ends exactly there. It is no symplectic method: energy and leaves drift.
 *
 * Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 (method), II.10 (estimates) and II.6 (dense
 * output); the coefficients are the published ones, of 30 digits. They meet the order conditions to 3e-29, those of the dense
 * output to 3e-28: that is what a quadruple build can have.
 *
 * What a build may choose:
 *     SMG_TOLERANCE   error of an internal step, as part of s->scale, the largest component: 1e-12, long double 1e-15, quad 1e-26
 *     SMG_PROJECT     1: after every internal step each site goes back to its leaf, along grad C; default 0
 *     SMG_FIXED_STEP  1: h itself is the only internal step, whatever its error; default 0
 * Arrays: s->w, s->compensation, s->u (3 a site) and s->stages, which has 45 numbers a site and 4 more. */
#ifndef SMG_DOP853_H
#define SMG_DOP853_H

#include "smg_leaf.h"

#define SMG_ONTO_LEAF 0
#define SMG_NO_DEGREE -1 /* there is no predictor */

#ifndef SMG_HISTORY
#define SMG_HISTORY 0 /* increments of steps before: none are kept */
#endif
#ifndef SMG_PROJECT
#define SMG_PROJECT 0
#endif
#ifndef SMG_FIXED_STEP
#define SMG_FIXED_STEP 0
#endif
#ifndef SMG_TOLERANCE
#if defined(SMG_LONG_DOUBLE)
#define SMG_TOLERANCE 1e-15
#elif defined(SMG_QUAD)
#define SMG_TOLERANCE 1e-26
#else
#define SMG_TOLERANCE 1e-12
#endif
#endif

#define SMG_GROWTH 6 /* how much larger the next internal step may be, */
#define SMG_SHRINK ((smg_real)1 / 3) /* and how much smaller */
#define SMG_SAFETY (smg_real)0.9 /* of the size at which the estimate would just be the tolerance */
#define SMG_LEAST_PART (smg_real)1e-12 /* of h, the smallest internal step */
#define SMG_MOST_TRIES 100000 /* internal steps of one output step, with those refused */
#define SMG_LEAF_ROUNDS 4 /* of Newton's method onto the leaf */

/* s->stages: fifteen vectors of 3 numbers a site, then four numbers. The places of k_2 .. k_5, which neither the increment nor
 * the estimates need, serve k_13 .. k_16 of the dense output: "in order of places" is 1, 13, 14, 15, 16, 6, 7, .., 12. */
enum { SMG_STAGES_USED = 12, SMG_Y = 12, SMG_Y_COMPENSATION, SMG_Y_BEFORE, SMG_STAGE_VECTORS };

/* The four numbers: the size of the last internal step that nothing cut short (0: none yet); where the last internal step began
 * and its size (0: there is none to interpolate); are k_13 .. k_16 there? Sizes are parts of h. */
enum { SMG_NATURAL, SMG_LAST_FROM, SMG_LAST_SIZE, SMG_EXTRA_READY, SMG_KEPT };

static inline smg_real *smg_vector(const smg_state *s, int i) { return s->stages + i * (3 * smg_sites(&s->c)); }
static inline smg_real *smg_kept(const smg_state *s) { return smg_vector(s, SMG_STAGE_VECTORS); }

/* ---- the history: one number, the natural size --------------------------------------------------------------------------- */
static inline void smg_blank_history(smg_state *s) { s->degree = SMG_NO_DEGREE; }

/* Numbers of the history. */
static inline size_t smg_history_size(const smg_coefficients *c) {
  (void)c;
  return 1;
}

static inline void smg_save_history(const smg_state *s, smg_real *out) { out[0] = smg_kept(s)[SMG_NATURAL]; }

static inline void smg_restore_history(smg_state *s, const smg_real *in) {
  smg_kept(s)[SMG_NATURAL] = in[0];
  smg_kept(s)[SMG_LAST_SIZE] = 0;
}

#include "smg_state.h"

/* ---- the coefficients ---------------------------------------------------------------------------------------------------- */
/* A number of 30 digits as the double next to it and the rest; double itself has no use for the rest. */
#if defined(SMG_LONG_DOUBLE) || defined(SMG_QUAD)
#define SMG_PAIR(high, low) ((smg_real)(high) + (smg_real)(low))
#else
#define SMG_PAIR(high, low) (high)
#endif

/* c_1 .. c_16 */
static const smg_real smg_dop853_c[16] = {
    0, SMG_PAIR(0.05260015195876773, 2.2355514829149388e-18), SMG_PAIR(0.0789002279381516, -3.58556667953482e-18),
    SMG_PAIR(0.1183503419072274, -5.37835001930203e-18), SMG_PAIR(0.2816496580927726, 1.0929465142427812e-17),
    SMG_PAIR(0.3333333333333333, 1.850371707708561e-17), 0.25, SMG_PAIR(0.3076923076923077, -1.7080354225002717e-17),
    SMG_PAIR(0.6512820512820513, -1.7649699365835873e-17), SMG_PAIR(0.6, 2.2204460492503132e-17),
    SMG_PAIR(0.8571428571428571, 4.7580986769648707e-17), 1.0, 1.0, SMG_PAIR(0.1, -5.551115123125783e-18),
    SMG_PAIR(0.2, -1.1102230246251566e-17), SMG_PAIR(0.7777777777777778, -1.2335811384723739e-17)};

/* a_ij, j < i */
static const smg_real smg_dop853_a[12][11] = {
    {0},
    {SMG_PAIR(0.05260015195876773, 2.2355514829149388e-18)},
    {SMG_PAIR(0.0197250569845379, -8.96391669883705e-19), SMG_PAIR(0.0591751709536137, -2.689175009651115e-18)},
    {SMG_PAIR(0.02958758547680685, -1.3445875048255075e-18), 0, SMG_PAIR(0.08876275643042054, 2.905131389430606e-18)},
    {SMG_PAIR(0.2413651341592667, -6.624152203916624e-18), 0, SMG_PAIR(-0.8845494793282861, 7.016246096573124e-18),
     SMG_PAIR(0.924834003261792, 1.0537371249772312e-17)},
    {SMG_PAIR(0.037037037037037035, 2.055968564120623e-18), 0, 0, SMG_PAIR(0.17082860872947386, 8.175883949864783e-18),
     SMG_PAIR(0.12546768756682242, 8.271864563100202e-18)},
    {0.037109375, 0, 0, SMG_PAIR(0.17025221101954405, -8.139510062367305e-18), SMG_PAIR(0.06021653898045596, 1.2006161584603762e-18),
     -0.017578125},
    {SMG_PAIR(0.03709200011850479, 3.4253328451425882e-18), 0, 0, SMG_PAIR(0.17038392571223998, 1.2967148331612122e-17),
     SMG_PAIR(0.10726203044637328, 4.772385209399161e-18), SMG_PAIR(-0.015319437748624402, 2.8475137341766893e-19),
     SMG_PAIR(0.008273789163814023, -3.660555130834814e-19)},
    {SMG_PAIR(0.6241109587160757, 2.492689915630562e-17), 0, 0, SMG_PAIR(-3.3608926294469414, 1.5456576283941173e-16),
     SMG_PAIR(-0.868219346841726, -3.718582587865727e-17), SMG_PAIR(27.59209969944671, -1.2881343059163701e-15),
     SMG_PAIR(20.154067550477894, -4.800642775601694e-16), SMG_PAIR(-43.48988418106996, 1.9413089553812176e-15)},
    {SMG_PAIR(0.47766253643826434, 2.5724262912655348e-17), 0, 0, SMG_PAIR(-2.4881146199716677, 7.616377660551361e-17),
     SMG_PAIR(-0.590290826836843, -2.1870450269554425e-17), SMG_PAIR(21.230051448181193, 1.1824507909843185e-15),
     SMG_PAIR(15.279233632882423, 1.6175344620758999e-16), SMG_PAIR(-33.28821096898486, 3.9439004961642045e-16),
     SMG_PAIR(-0.020331201708508627, 7.661055475764465e-19)},
    {SMG_PAIR(-0.9371424300859873, -2.660163817828355e-17), 0, 0, SMG_PAIR(5.186372428844064, -8.942575540409293e-17),
     SMG_PAIR(1.0914373489967295, 7.207295585396141e-17), SMG_PAIR(-8.149787010746927, 6.712606849485736e-16),
     SMG_PAIR(-18.52006565999696, -7.798463984469516e-16), SMG_PAIR(22.739487099350505, -8.796132218075033e-16),
     SMG_PAIR(2.4936055526796523, 5.2481978128364214e-17), SMG_PAIR(-3.0467644718982196, 1.3907396197551354e-16)},
    {SMG_PAIR(2.273310147516538, 1.7007512072370059e-16), 0, 0, SMG_PAIR(-10.53449546673725, -7.40073388060864e-16),
     SMG_PAIR(-2.0008720582248625, -2.823131109979535e-17), SMG_PAIR(-17.9589318631188, 3.8189608367611925e-16),
     SMG_PAIR(27.94888452941996, 1.1856623515433554e-16), SMG_PAIR(-2.8589982771350235, -1.7007630722635992e-16),
     SMG_PAIR(-8.87285693353063, -2.2457366408213776e-16), SMG_PAIR(12.360567175794303, -1.3158566470097505e-16),
     SMG_PAIR(0.6433927460157636, -4.213091915914117e-17)}};

/* b_i of order 8 */
static const smg_real smg_dop853_b[12] = {
    SMG_PAIR(0.054293734116568765, -2.564525917607828e-18), 0, 0, 0, 0, SMG_PAIR(4.450312892752409, -2.737092775581909e-16),
    SMG_PAIR(1.8915178993145003, 6.581122499260484e-17), SMG_PAIR(-5.801203960010585, 1.3317442893008373e-16),
    SMG_PAIR(0.3111643669578199, -1.0104455449341739e-17), SMG_PAIR(-0.1521609496625161, 8.776696451848075e-18),
    SMG_PAIR(0.20136540080403034, 6.12257216002761e-18), SMG_PAIR(0.04471061572777259, 3.1043973515105385e-18)};

/* b_i less those of order 5 */
static const smg_real smg_dop853_e5[12] = {
    SMG_PAIR(0.01312004499419488, 6.877543760801164e-19), 0, 0, 0, 0, SMG_PAIR(-1.2251564463762044, -8.518996614610585e-17),
    SMG_PAIR(-0.4957589496572502, 1.150330848872384e-17), SMG_PAIR(1.6643771824549864, 8.89823354515909e-17),
    SMG_PAIR(-0.35032884874997366, -1.693296289744891e-17), SMG_PAIR(0.3341791187130175, 3.4127098833665863e-18),
    SMG_PAIR(0.08192320648511571, 2.5584664710400534e-18), SMG_PAIR(-0.022355307863886294, -1.5521986757531191e-18)};

/* b_i less those of order 3 */
static const smg_real smg_dop853_e3[12] = {
    SMG_PAIR(-0.18980075407240762, 7.925770378062754e-18), 0, 0, 0, 0, SMG_PAIR(4.450312892752409, -2.737092775581909e-16),
    SMG_PAIR(1.8915178993145003, 6.581122499260484e-17), SMG_PAIR(-5.801203960010585, 1.3317442893008373e-16),
    SMG_PAIR(-0.42268232132379197, 2.2627811149171965e-18), SMG_PAIR(-0.1521609496625161, 8.776696451848075e-18),
    SMG_PAIR(0.20136540080403034, 6.12257216002761e-18), SMG_PAIR(0.022651792198360825, 1.0635462033025066e-18)};

/* a_14,j .. a_16,j in order of places; those of k_13 are the b_j */
static const smg_real smg_dop853_extra[3][12] = {
    {SMG_PAIR(0.056167502283047954, -1.88644555359609e-18), SMG_PAIR(-0.008298, -1.794120407794253e-19), 0, 0, 0, 0,
     SMG_PAIR(0.25350021021662483, -2.1693122810297358e-17), SMG_PAIR(-0.2462390374708025, 1.2121494224161007e-17),
     SMG_PAIR(-0.12419142326381637, 6.293125460594507e-18), SMG_PAIR(0.15329179827876568, 1.3218335854066822e-17),
     SMG_PAIR(0.00820105229563469, -7.959644410071743e-19), SMG_PAIR(0.007567897660545699, 3.8130025355849374e-19)},
    {SMG_PAIR(0.03183464816350214, -1.9866654610511737e-18), SMG_PAIR(-0.00034046500868740456, -4.8166271401306394e-21),
     SMG_PAIR(0.1413124436746325, 1.7199776914665478e-18), 0, 0, SMG_PAIR(0.028300909672366776, -4.0327406802622954e-19),
     SMG_PAIR(0.053541988307438566, 1.2699877652684217e-18), SMG_PAIR(-0.05492374857139099, 3.015077888147616e-18), 0, 0,
     SMG_PAIR(-0.00010834732869724932, -1.6268392119904694e-21), SMG_PAIR(0.0003825710908356584, 2.070642294190223e-20)},
    {SMG_PAIR(-0.42889630158379194, 1.5618605757625628e-17), SMG_PAIR(-0.0013990241651590145, -1.0435935893777387e-19),
     SMG_PAIR(2.9475147891527724, -9.080327027287263e-17), SMG_PAIR(-9.15095847217987, -4.3692612746328837e-16), 0,
     SMG_PAIR(-4.697621415361164, 1.1142707166495955e-16), SMG_PAIR(7.683421196062599, -5.92973577603934e-17),
     SMG_PAIR(4.06898981839711, -1.8994109982627546e-16), SMG_PAIR(0.3567271874552811, 1.7527083212753864e-17)}};

/* Dense output: four rows of corrections, in order of places */
static const smg_real smg_dop853_d[4][12] = {
    {SMG_PAIR(-8.428938276109013, 6.07001772311276e-16), SMG_PAIR(-0.08899033645133331, -3.5435308668958646e-18),
     SMG_PAIR(18.148505520854727, 6.873877271126774e-16), SMG_PAIR(-9.194632392478356, 5.533128061827524e-16),
     SMG_PAIR(-4.436036387594894, -3.6232834900443103e-16), SMG_PAIR(0.5667149535193777, 4.085083132246998e-17),
     SMG_PAIR(-3.0689499459498917, -1.3480870726737455e-17), SMG_PAIR(2.38466765651207, -8.217286869152e-17),
     SMG_PAIR(2.117034582445028, 2.086504301138e-16), SMG_PAIR(-0.871391583777973, -3.1344855853238036e-18),
     SMG_PAIR(2.2404374302607883, -6.705197588280659e-17), SMG_PAIR(0.6315787787694688, 4.4331899416815995e-17)},
    {SMG_PAIR(10.427508642579134, 2.5756180718540317e-16), SMG_PAIR(15.697238121770845, -6.572034421526076e-16),
     SMG_PAIR(-31.139403219565178, 5.273923982966446e-16), SMG_PAIR(-9.35292435884448, 8.712970565344274e-16),
     SMG_PAIR(35.81684148639408, 1.2580947935545244e-15), SMG_PAIR(242.28349177525817, 1.2619950687919397e-14),
     SMG_PAIR(165.20045171727028, -1.3399247147160801e-15), SMG_PAIR(-374.5467547226902, -7.145990220191793e-15),
     SMG_PAIR(-22.113666853125306, -2.5837691116326833e-16), SMG_PAIR(7.733432668472264, -1.000846077165442e-17),
     SMG_PAIR(-30.674084731089398, -5.89065475830282e-16), SMG_PAIR(-9.332130526430229, 6.835214192289661e-16)},
    {SMG_PAIR(19.985053242002433, 8.826808429334292e-16), SMG_PAIR(-2.778205752353508, -2.110530566458063e-16),
     SMG_PAIR(-60.19669523126412, 1.8248028942949262e-15), SMG_PAIR(84.32040550667716, -5.929910464094051e-16),
     SMG_PAIR(11.99229113618279, 2.6278928135977475e-17), SMG_PAIR(-387.0373087493518, 1.4528391673698836e-14),
     SMG_PAIR(-189.17813819516758, 8.06767469151173e-15), SMG_PAIR(527.8081592054236, 1.3720495297384635e-14),
     SMG_PAIR(-11.57390253995963, -7.608570167042261e-16), SMG_PAIR(6.8812326946963, -2.6131419487549096e-16),
     SMG_PAIR(-1.0006050966910838, -6.736550672641282e-17), SMG_PAIR(0.7777137798053443, 3.572781834715124e-17)},
    {SMG_PAIR(-25.69393346270375, 1.3333738395969295e-15), SMG_PAIR(-43.53345659001114, -2.325046131602548e-15),
     SMG_PAIR(96.32455395918828, 4.052941400678487e-15), SMG_PAIR(-39.17726167561544, 1.4295794480996634e-15),
     SMG_PAIR(-149.72683625798564, 1.2853156972603791e-14), SMG_PAIR(-154.18974869023643, -5.9211399582358015e-15),
     SMG_PAIR(-231.5293791760455, -5.608383362985495e-16), SMG_PAIR(357.6391179106141, 5.737366523638755e-15),
     SMG_PAIR(93.40532418362432, -5.988439273072516e-15), SMG_PAIR(-37.45832313645163, -9.054105230765388e-16),
     SMG_PAIR(104.0996495089623, -6.184417850693204e-16), SMG_PAIR(29.8402934266605, 1.5710388591321508e-15)}};

/* ---- one internal step --------------------------------------------------------------------------------------------------- */
/* out = sum_j a_j k_j, j < count, block after block of components, each of which stays in the cache. */
static inline void smg_sum_stages(const smg_state *s, const smg_real *a, int count, smg_real *out) {
  const int64_t n = 3 * smg_sites(&s->c), block = 256;
  for (int64_t from = 0; from < n; from += block) {
    const int64_t to = from + block < n ? from + block : n;
    for (int64_t q = from; q < to; ++q) out[q] = 0;
    for (int j = 0; j < count; ++j) {
      const smg_real *k = smg_vector(s, j), weight = a[j];
      if (weight == 0) continue;
      for (int64_t q = from; q < to; ++q) out[q] += weight * k[q];
    }
  }
}

/* What depends on time, at the part `part` of the step that s->count tells. */
static inline void smg_set_time_at(smg_coefficients *c, const smg_state *s, smg_real part) {
#if SMG_TIMED
  smg_set_time(c, smg_time_at(s, part));
#else
  (void)c;
  (void)s;
  (void)part;
#endif
}

/* k = (1/kappa) grad C(w) x dH/dw of every site. */
static inline void smg_right_side(const smg_coefficients *c, const smg_real *w, smg_real *k) {
  const int64_t sites = smg_sites(c);
  for (int64_t q = 0; q < 3 * sites; ++q) k[q] = 0;
  smg_gradient(c, w, k);
  for (int64_t i = 0; i < sites; ++i) {
    const smg_real kappa = smg_kappa(c, i);
    smg_real n[3], f[3];
    smg_normal(c, i, w + 3 * i, n);
    smg_cross(f, n, k + 3 * i);
    for (int b = 0; b < 3; ++b) k[3 * i + b] = f[b] / kappa;
  }
}

/* k_2 .. k_12 of the internal step from the part `from` of h, of the size `size`; h with the sign of the bracket. */
static inline void smg_later_stages(smg_state *s, smg_real from, smg_real size) {
  const int64_t n = 3 * smg_sites(&s->c);
  const smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION), p = smg_signed_h(s->h) * size;
  for (int i = 1; i < SMG_STAGES_USED; ++i) {
    smg_sum_stages(s, smg_dop853_a[i], i, s->u);
    for (int64_t q = 0; q < n; ++q) s->u[q] = y[q] + (compensation[q] + p * s->u[q]);
    smg_set_time_at(&s->c, s, from + smg_dop853_c[i] * size);
    smg_right_side(&s->c, s->u, smg_vector(s, i));
  }
}

/* The error of site k, in units of w: |p| e5^2/sqrt(e5^2 + e3^2/100), e5 = |sum_i (b_i - b5_i) k_i|, e3 alike; k_2 .. k_5 are in
 * neither. NaN where the new w of the site is no number. */
static inline smg_real smg_site_error(const smg_state *s, int64_t k, smg_real p) {
  const smg_real *y = smg_vector(s, SMG_Y) + 3 * k, *u = s->u + 3 * k;
  smg_real e5[3] = {0}, e3[3] = {0}, end[3];
  for (int b = 0; b < 3; ++b) end[b] = y[b] + u[b];
  if (!(smg_largest(end) <= SMG_MAX)) return (smg_real)NAN;
  for (int i = 0; i < SMG_STAGES_USED; i += i == 0 ? 5 : 1) {
    const smg_real *v = smg_vector(s, i) + 3 * k;
    for (int b = 0; b < 3; ++b) {
      e5[b] += smg_dop853_e5[i] * v[b];
      e3[b] += smg_dop853_e3[i] * v[b];
    }
  }
  const smg_real first = smg_norm(e5), both[3] = {first, smg_norm(e3) / 10, 0};
  return first > 0 ? smg_abs(p) * first * (first / smg_norm(both)) : first;
}

/* An output step under way. Sizes are parts of h. */
typedef struct smg_pace {
  smg_real done, size, natural; /* what is done; the internal step that is tried; the next one if nothing cuts it short */
  smg_real error, largest;      /* of the try, as part of the tolerance; of all that were accepted, in units of w */
  int64_t worst;                /* the site of that error */
  int tries, accepted, refused; /* refused: was the last try? */
} smg_pace;

/* u = p sum_i b_i k_i, and its error: the largest of all sites. */
static inline void smg_estimate(smg_state *s, smg_pace *pace) {
  const int64_t sites = smg_sites(&s->c);
  const smg_real p = smg_signed_h(s->h) * pace->size, allowed = s->tolerance * s->scale;
  smg_real most = 0;
  smg_sum_stages(s, smg_dop853_b, SMG_STAGES_USED, s->u);
  for (int64_t q = 0; q < 3 * sites; ++q) s->u[q] *= p;
  for (int64_t k = 0; k < sites && most == most; ++k) {
    const smg_real error = smg_site_error(s, k, p);
    if (error <= most) continue;
    most = error; /* NaN comes in and stays */
    pace->worst = k;
  }
  pace->error = most > 0 ? most / allowed : most; /* nothing moves: 0, also where all w are 0 */
}

#if SMG_PROJECT
/* v.grad C(v) at v = w + compensation, which is |v|^2, or 2 C(v); n = grad C(w). */
static inline smg_real smg_twice_casimir(const smg_coefficients *c, int64_t k, const smg_real *w, const smg_real *compensation, smg_real *n) {
  smg_normal(c, k, w, n);
  return smg_dot(n, w) + 2 * smg_dot(n, compensation);
}

/* y of site k back on the leaf of the start of the output step: y + a n, n = grad C(y), 2 a |n|^2 = 2 C - 2 C(y), repeated. */
static inline void smg_back_on_leaf(const smg_state *s, int64_t k, smg_real *y, smg_real *compensation) {
  smg_real n[3], leaf;
  if (smg_kind(&s->c, k) == SMG_SPHERE) leaf = smg_radius(&s->c, k) * smg_radius(&s->c, k);
  else leaf = smg_twice_casimir(&s->c, k, s->w + 3 * k, s->compensation + 3 * k, n);
  for (int round = 0; round < SMG_LEAF_ROUNDS; ++round) {
    const smg_real off = leaf - smg_twice_casimir(&s->c, k, y, compensation, n), square = smg_dot(n, n);
    if (!(square > 0) || smg_abs(off) <= SMG_EPS * smg_norm(n) * smg_norm(y)) return;
    for (int b = 0; b < 3; ++b) smg_add_compensated(&y[b], &compensation[b], off / (2 * square) * n[b]);
  }
}
#endif

/* The increment u is taken: y + u with its rounding error carried along, and back on the leaves. */
static inline void smg_take(smg_state *s) {
  smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION), *before = smg_vector(s, SMG_Y_BEFORE);
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) {
    before[q] = y[q];
#if SMG_PLAIN_SUMS
    y[q] += s->u[q];
#else
    smg_add_compensated(&y[q], &compensation[q], s->u[q]);
#endif
  }
#if SMG_PROJECT
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) smg_back_on_leaf(s, k, y + 3 * k, compensation + 3 * k);
#endif
  (void)compensation;
}

/* ---- control of the size ------------------------------------------------------------------------------------------------- */
/* x^(1/8) */
static inline smg_real smg_eighth_root(smg_real x) { return SMG_MATH(sqrt)(SMG_MATH(sqrt)(SMG_MATH(sqrt)(x))); }

/* The error of a step of size p goes as p^8: the factor at which it meets the tolerance, within its limits. */
static inline smg_real smg_factor(smg_real error) {
  if (!(error > 0)) return SMG_GROWTH;
  return smg_min(SMG_GROWTH, smg_max(SMG_SHRINK, SMG_SAFETY / smg_eighth_root(error)));
}

/* k_1, at the start of an internal step. */
static inline smg_status smg_first_stage(smg_state *s, smg_pace *pace) {
  const smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION), *k = smg_vector(s, 0);
  const int64_t n = 3 * smg_sites(&s->c);
  for (int64_t q = 0; q < n; ++q) s->u[q] = y[q] + compensation[q];
  smg_set_time_at(&s->c, s, pace->done);
  smg_right_side(&s->c, s->u, smg_vector(s, 0));
  for (int64_t q = 0; q < n; ++q) {
    if (smg_abs(k[q]) <= SMG_MAX) continue;
    pace->worst = q / 3;
    return SMG_NOT_FINITE;
  }
  return SMG_OK;
}

/* The very first size, where k_1 alone would move w by the eighth root of the tolerance; the control soon finds a better one. */
static inline smg_real smg_first_size(const smg_state *s) {
  const smg_real *k = smg_vector(s, 0);
  smg_real most = 0;
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) most = smg_max(most, smg_abs(k[q]));
  const smg_real moves = most * smg_abs((smg_real)s->h), may = smg_eighth_root(s->tolerance) * s->scale;
  return moves > may ? may / moves : 1;
}

/* Where the next internal step ends: exactly at 1 when it comes near, and half way when two steps will do. Its size is the
 * difference as rounded, so that the sizes of all add up to 1. */
static inline smg_real smg_next_end(smg_pace *pace) {
  const smg_real left = 1 - pace->done;
  smg_real end = pace->done + smg_min(pace->natural, left / 2);
  if (SMG_FIXED_STEP || left <= pace->natural * (smg_real)1.01) end = 1;
  else if (left > 2 * pace->natural) end = pace->done + pace->natural;
  pace->size = end - pace->done;
  return end;
}

/* The step is good. A size that the end of h cut short says little of the natural one when its error vanishes. */
static inline void smg_accept(smg_state *s, smg_pace *pace, smg_real end) {
  const smg_real factor = pace->refused ? smg_min(1, smg_factor(pace->error)) : smg_factor(pace->error);
  smg_take(s);
  pace->largest = smg_max(pace->largest, pace->error * s->tolerance * s->scale);
  if (factor < SMG_GROWTH || pace->size * factor > pace->natural) pace->natural = pace->size * factor;
  smg_kept(s)[SMG_LAST_FROM] = pace->done;
  pace->done = end;
  pace->refused = 0;
  ++pace->accepted;
}

/* It is not: again from the same place, with a smaller size, as long as that is one. */
static inline smg_status smg_refuse(smg_pace *pace) {
  const int finite = pace->error - pace->error == 0;
  pace->natural = pace->size * (finite ? smg_factor(pace->error) : SMG_SHRINK);
  pace->refused = 1;
  if (!SMG_FIXED_STEP && pace->natural >= SMG_LEAST_PART) return SMG_OK;
  return finite ? SMG_NO_CONVERGENCE : SMG_NOT_FINITE;
}

/* ---- an output step ------------------------------------------------------------------------------------------------------ */
/* All internal steps, in the scratch arrays. */
static smg_status smg_integrate(smg_state *s, smg_pace *pace) {
  smg_status status = smg_first_stage(s, pace);
  pace->natural = smg_max(SMG_LEAST_PART, pace->natural > 0 ? pace->natural : smg_first_size(s));
  while (status == SMG_OK && pace->done < 1) {
    if (++pace->tries > SMG_MOST_TRIES) return SMG_NO_CONVERGENCE;
    const smg_real end = smg_next_end(pace);
    smg_later_stages(s, pace->done, pace->size);
    smg_estimate(s, pace);
    if (SMG_FIXED_STEP ? pace->error - pace->error == 0 : pace->error <= 1) {
      smg_accept(s, pace, end);
      if (end < 1) status = smg_first_stage(s, pace);
    } else status = smg_refuse(pace);
  }
  return status;
}

/* The state after the step. */
static void smg_commit(smg_state *s, const smg_pace *pace) {
  const smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION);
  for (int64_t k = 0; k < smg_sites(&s->c); ++k) {
    for (int64_t q = 3 * k; q < 3 * k + 3; ++q) {
      s->w[q] = y[q];
      s->compensation[q] = compensation[q];
    }
    if (smg_kind(&s->c, k) == SMG_NAMBU) s->scale = smg_max(s->scale, smg_largest(y + 3 * k)); /* open leaves: orbits grow */
  }
  smg_kept(s)[SMG_NATURAL] = pace->natural;
  smg_kept(s)[SMG_LAST_SIZE] = pace->size;
  ++s->count;
}

static smg_status smg_step(smg_state *s) {
  smg_real *y = smg_vector(s, SMG_Y), *compensation = smg_vector(s, SMG_Y_COMPENSATION), *kept = smg_kept(s);
  smg_pace pace = {0, 0, kept[SMG_NATURAL], 0, 0, -1, 0, 0, 0};
  for (int64_t q = 0; q < 3 * smg_sites(&s->c); ++q) {
    y[q] = s->w[q];
    compensation[q] = s->compensation[q];
  }
  kept[SMG_LAST_SIZE] = kept[SMG_EXTRA_READY] = 0;
  s->report.partner = -1;
  s->report.status = smg_integrate(s, &pace);
  s->report.site = s->report.status == SMG_OK ? -1 : pace.worst;
  s->report.iterations = pace.accepted;
  s->report.residual = pace.largest;
  s->report.reached = s->report.status == SMG_OK ? 0 : pace.done; /* where it could go no further */
  if (s->report.status == SMG_OK) smg_commit(s, &pace);
  return s->report.status;
}

#include "smg_steps.h"

/* ---- dense output -------------------------------------------------------------------------------------------------------- */
/* The part of h that the last internal step took; 0 before a step, after a failed one and after a restart. */
static inline smg_real smg_dense_part(const smg_state *s) { return smg_kept(s)[SMG_LAST_SIZE]; }

/* k_13 = f at the end, k_14 .. k_16, in the places of k_2 .. k_5. The step is counted already: its parts of h are less 1. */
static inline void smg_extra_stages(const smg_state *s) {
  const smg_real *before = smg_vector(s, SMG_Y_BEFORE), *kept = smg_kept(s), p = smg_signed_h(s->h) * kept[SMG_LAST_SIZE];
  smg_coefficients c = s->c;
  smg_set_time_at(&c, s, 0);
  smg_right_side(&c, s->w, smg_vector(s, 1));
  for (int i = 0; i < 3; ++i) {
    smg_sum_stages(s, smg_dop853_extra[i], SMG_STAGES_USED, s->u);
    for (int64_t q = 0; q < 3 * smg_sites(&c); ++q) s->u[q] = before[q] + p * s->u[q];
    smg_set_time_at(&c, s, kept[SMG_LAST_FROM] + smg_dop853_c[13 + i] * kept[SMG_LAST_SIZE] - 1);
    smg_right_side(&c, s->u, smg_vector(s, 2 + i));
  }
}

/* w at the part theta of the last internal step, to order 7: with r = 1 - theta the cubic through both ends and their slopes,
 *     y + theta^2 (3 - 2 theta) (w - y) + p theta r (r k_1 - theta k_13),
 * and p (theta r)^2 sum_i (d_1i + theta d_2i + theta r d_3i + theta^2 r d_4i) k_i. Where there is no such step it is w itself. */
static inline void smg_dense(const smg_state *s, smg_real theta, smg_real *w) {
  const int64_t n = 3 * smg_sites(&s->c);
  const smg_real *y = smg_vector(s, SMG_Y_BEFORE), r = 1 - theta, p = smg_signed_h(s->h) * smg_dense_part(s);
  const smg_real end = theta * theta * (3 - 2 * theta), bump = theta * r * (theta * r);
  smg_real a[SMG_STAGES_USED];
  if (!(smg_dense_part(s) > 0)) {
    for (int64_t q = 0; q < n; ++q) w[q] = s->w[q];
    return;
  }
  if (smg_kept(s)[SMG_EXTRA_READY] == 0) smg_extra_stages(s);
  smg_kept(s)[SMG_EXTRA_READY] = 1;
  for (int i = 0; i < SMG_STAGES_USED; ++i)
    a[i] = bump * (smg_dop853_d[0][i] + theta * (smg_dop853_d[1][i] + r * (smg_dop853_d[2][i] + theta * smg_dop853_d[3][i])));
  a[0] += theta * r * r;
  a[1] -= theta * theta * r;
  smg_sum_stages(s, a, SMG_STAGES_USED, w);
  for (int64_t q = 0; q < n; ++q) w[q] = y[q] + (end * (s->w[q] - y[q]) + p * w[q]);
}

#endif
