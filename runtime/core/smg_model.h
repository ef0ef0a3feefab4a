/* smidgen runtime: what a method may ask of a model.
 *
 * A model is a handful of static functions; its .c defines them and then includes the header of its method, which knows
 * nothing else of it. Sites are numbered over the whole state, k = 0 .. smg_sites(c) - 1, family by family; vectors are
 * three numbers a site. The equation is w' = (1/kappa) grad C(w) x dH/dw on every site; C = |w|^2/2 on spheres and in
 * R^3.
 *
 *   sizes      smg_sites(c)                       sites
 *              smg_coupled(c), smg_site(c, row)   sites that are solved together, and each of them by its row in
 *                                                 Newton's matrix
 *              smg_row(c, k)                      the row of site k
 *              smg_alone(c, n), smg_tracer(c, k)  the n-th site that is solved alone; does it feel the coupled ones?
 *   a site     smg_kind(c, k)                     SMG_SPHERE, SMG_R3 or SMG_NAMBU
 *              smg_kappa(c, k), smg_h_over_kappa(c, k, h) its strength, and h/kappa
 *              smg_present(c, k)                  1, or 0 where the site is not there: no sum has it
 *              smg_moves(c, k)                    1, or 0 where the site is pinned or absent: it stays, to the bit
 *              smg_radius(c, k)                   of a sphere
 *              smg_normal(c, k, v, n)             n = grad C(v), linear in v
 *   energy     smg_gradient(c, w, g)              g += dH/dw of all sites; what tracers do to others is left out
 *              smg_energy_gradient(c, w, g)       the same without the fields of torques, which are no gradients: where
 *                                                 SMG_TORQUES says so, blocks d2H/dw_i dw_j below need not be symmetric
 *              smg_motion(c, m)                   h (1/kappa) m x dH/dw of one unit sphere alone, by value, where
 *                                                 SMG_HAS_MOTION says so
 *              smg_lane_gradient(c, w, g)         the same of SMG_LANES states at once (smg_lanes.h), where
 *                                                 SMG_HAS_LANES says so
 *              smg_coupled_gradient(c, w, g)      g += dH/dw of the coupled sites, by the terms that couple them
 *              smg_gather(c, at, all, own, g)     g += dH/dw of the site `at` with the vector `own`, the others in
 *                                                 `all`; this and the next are asked of sites that are solved alone or
 *                                                 swept
 *              smg_site_hessian_vector(c, at, all, own, v, y)  y += (d2H/dw_k dw_k) v
 *              smg_hessian_blocks(s)              SMG_BLOCK for every d2H/dw_i dw_j at s->m
 *              smg_hessian_vector(s)              s->hessian_v += d2H/dw2 s->v, of the blocks that join two sites
 *              smg_each(context, visit)                every coupled site, cell by cell
 *              smg_each_coloured(context, visit)       the same colour after colour: sites of one colour do not feel
 *                                                 each other
 *   time       smg_set_step(&c, h), smg_set_time(&c, t)  what depends on h, what on time
 *
 *   parameters smg_sizes(&model, p)               takes them in, and the sizes that they give
 *              smg_check_sizes(model)             SMG_BAD_PARAMETER where a size or an index does not fit
 *              smg_same_sizes(model, other)       have both the same?
 *              smg_prepare(&model)                what they alone decide; 0 where one is not finite
 *              smg_family_end(c, f)               the site after the last of the f-th family
 *   response   smg_response(c, k, r)              r = f, q, F0, Q0: how site k moves in its field (smg_respond.h),
 *                                                 where SMG_RESPONDS says so; SMG_PUSHES: some F0 or Q0 is not 0
 *   noise      smg_diffusion(c, k)                D of site k, the rate at which noise turns it (smg_thermal.h), where
 *                                                 SMG_THERMAL says so
 *   splitting  smg_slope_x(c, k, v), _y, _z       dH/dx of site k at the vector v, where no term joins two sites
 *                                                 (SMG_SEPARATE)
 *              smg_slopes_x(c, w, g), _y, _z      g[k] += dH/dx of site k, for all sites
 *              smg_colours(c), smg_each_of_colour(c, colour, context, visit)  sites of one colour do not feel each
 *                                                 other
 *              smg_pull(c, at, all, g)            g += dH/dw of the site `at`, in which it is linear itself
 *              smg_each_pair(c, all, context, visit), smg_each_pair_back  every bond, with the derivative of its energy
 *                                                 by the scalar product of its ends
 *              smg_bond_classes(c), smg_each_of_class(c, which, all, context, visit)  the same of one class, of which
 *                                                 no two meet; 0 classes where there are none
 *   rows       smg_cells(c, d), smg_shift(sub), smg_rank(sub), smg_place(colour, rank)  where sites stand: smg_rows.h,
 *                                                 where SMG_BY_ROWS says so
 *              smg_offsets(sub, beside)           what stands beside the sites of a place
 *              smg_slot_gradient(c, run, blocks, all, pitch, j, p, sum)  sum += dH/dw of the slots of one vector, in
 *                                                 lanes
 *              smg_changed_slot_gradient(c, run, blocks, all, pitch, j, p, sum)  sum += d2H/dw2 of the points of the
 *                                                 run times the changes `all`, for the tangent map
 *              smg_beside_norm(c, sub, n)         a bound on the norm of the Hessian's block with the n-th of them,
 *                                                 with the site itself for n = -1, where SMG_BESIDE_NORMS says so
 *              smg_rest_field_norm(c, k)          a bound on the norm of dH/dw at site k at w = 0, at all times
 *              smg_row_hessian_norm(c, k)         as smg_hessian_row_norm at all times, where SMG_ROW_HESSIAN says so
 *              smg_site_value(c, n, k)            the n-th of SMG_SITE_VALUES numbers that differ from site to site
 *              smg_row_classes[], smg_lane_bond_slope(c, term, products), smg_slope_bound(c, size)  bonds in classes
 *                                                 (smg_pair_rows.h): which they are; in lanes the derivative of a
 *                                                 bond's energy by the scalar product of its ends; a bound on it where
 *                                                 that is at most `size`
 *   numbers    smg_site_number(c, n, i)           the n-th of SMG_SITE_NUMBERS that the i-th site of a family has
 *   few        smg_few_field(c, all, pitch, i, g), smg_few_norms  dH/dw of the sites in the lanes from i on: smg_few.h,
 *                                                 where SMG_FEW_IN_LANES says so
 *   bound      smg_hessian_row_norm(c, k)                    sum of bounds on the norms of the Hessian blocks in the
 *                                                 row of site k, on a graph in a norm that fits it, where
 *                                                 SMG_CONSTANT_HESSIAN says that it is the same at all states
 *
 * A tracer feels others and acts on none.
 *
 * c: const smg_coefficients *, what depends on h and time, and c->model, the parameters and what depends on them alone,
 * which states share; s: smg_state *; at: smg_lattice_site. */
#ifndef SMG_MODEL_H
#define SMG_MODEL_H

#ifndef SMG_FAMILIES
#include "smg_stub_model.h"
#endif
#include "smg_arrays.h"
#include "smg_defaults.h"
#include "smg_own.h"
#include "smg_site.h"

/* What the model says of itself by macros, 0 where neither it nor smg_defaults.h says anything: SMG_BS unknowns a site
 * of Newton's matrix, SMG_HISTORY increments kept, SMG_FAMILIES, SMG_ORIENTATION of the bracket (1 or -1), SMG_TIMED:
 * H depends on time; SMG_HAS_COUPLED, SMG_HAS_ALONE: sites of both kinds; SMG_ALONE_LINEAR, SMG_ALONE_NEWTON: those
 * whose field does not depend on themselves, and the others; SMG_LEAVES: leaves are kept in s->leaf_value;
 * SMG_COUPLED_NAMBU: some coupled sites are Nambu factors; SMG_COUPLED_LIFTED: the leaf of some moves with w. The
 * matrix: SMG_MATRIX_FREE, or SMG_BAND blocks on either side, SMG_CYCLIC, or SMG_ORDER rows in an elimination order.
 * SMG_SWEPT: sweeps come before Newton; SMG_ROTATION: each turns a spin exactly; SMG_BY_ROWS: by rows of a lattice,
 * with SMG_COLOURS and what else smg_rows.h asks for, SMG_LAW, SMG_ALL_OR_NOTHING: how sites respond beside some that
 * stand still (smg_respond.h), SMG_LAW_BY_SITE: what of that differs from site to site, in arrays from the number
 * SMG_LAW_FIRST on, SMG_RADII: radii differ, 1/r^2 has the number SMG_RADIUS_AT,
 * SMG_ROWS_IN_TIME: bounds are those of the time of a step, SMG_ROW_TURNS: by an explicit method, SMG_ROW_CLASSES:
 * that takes bonds in so many classes, in layers along the direction SMG_LAYERED; SMG_FETCHED_AHEAD: the sites of a
 * graph in an order of their own; SMG_FEW_IN_LANES: few sites, all at once in lanes; SMG_TRIED_SWEEPS of them at most,
 * where the model says it. SMG_COMPOSED: stages of a composition, SMG_STAGES_KEPT: their increments are kept, for the
 * tangent map. SMG_AXES: the components in H, 1, 2, 4; SMG_SEPARATE: no term joins two sites, SMG_ONE_SITE: there is
 * but one. Features: SMG_EXTENDED, SMG_PLAIN_SUMS; SMG_SINGLE_SPHERE: one unit sphere alone, SMG_HAS_MOTION: one of
 * which a method asks the field alone; SMG_FEW: the coupled sites are a few, and their number is known;
 * SMG_FEW_STAGED: of so many sites, or fewer, stages of Gauss collocation are in registers, SMG_ASSUMES_SITES: once
 * smg_assume_sites has said how many there are. */

/* Before a loop over the coupled sites: each of a few gets a copy of its body, in which its family and its formulas are
 * known. */
#if SMG_FEW
#define SMG_UNROLL_FEW SMG_UNROLL
#else
#define SMG_UNROLL_FEW
#endif

enum { SMG_SPHERE, SMG_R3, SMG_NAMBU };

/* A site, and where it stands on a lattice: its place in the cell and the coordinates of the cell. On a graph that is
 * visited in an order (SMG_FETCHED_AHEAD) s0 is a site that is visited soon after. */
typedef struct smg_lattice_site {
  int64_t k, sub, s0, s1, s2, s3;
} smg_lattice_site;

#include "smg_plain.h"
#if SMG_STUB_MODEL
#include "smg_stub_functions.h"
#endif

#if SMG_HAS_COUPLED
/* J += G_i B S_j^T, y = B S_j^T; without a stored matrix also its transpose, by z = B G_j^T: defined by smg_newton.h or
 * smg_matrix_free.h. */
static inline void smg_add_hessian(const smg_state *s, int64_t i, int64_t j, const smg_real *y, const smg_real *z);
#endif

/* A Hessian block B = d2H/dw_i dw_j of one term for Newton's matrix; add_product: the call that adds B `direction` to
 * `product`. */
#define SMG_BLOCK(i, j, add_product)                             \
  do {                                                           \
    smg_real y[3 * SMG_BS] = {0}, z[3 * SMG_BS] = {0};           \
    for (int l = 0; l < SMG_BS; ++l) {                           \
      const smg_real *direction = s->S + 3 * (SMG_BS * (j) + l); \
      smg_real *product = y + 3 * l;                             \
      add_product;                                               \
      if (!SMG_MATRIX_FREE || (i) == (j)) continue;              \
      direction = s->G + 3 * (SMG_BS * (j) + l);                 \
      product = z + 3 * l;                                       \
      add_product;                                               \
    }                                                            \
    smg_add_hessian(s, i, j, y, SMG_MATRIX_FREE ? z : NULL);     \
  } while (0)

#endif
