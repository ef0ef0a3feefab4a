/* smidgen runtime: a model for editors, and for a header that is compiled alone: no generated file comes before it.
 *
 * Types and macros that headers ask for, and no meaning: smg_model.h includes this where SMG_FAMILIES is not defined,
 * which every generated file defines; the functions of a model follow in smg_stub_functions.h. */
#ifndef SMG_STUB_MODEL_H
#define SMG_STUB_MODEL_H

#include "smidgen.h"

#define SMG_STUB_MODEL 1
#define SMG_PUBLIC(word) stub_##word
#define SMG_FAMILIES 1
#define SMG_HAS_LANES 1
#define SMG_MOST_LANES 8
#define SMG_STAGES 2
#define SMG_COLOURS 2
#define SMG_ROW_STEP 2
#define SMG_TURN_0 1
#define SMG_RINGS 1
#define SMG_BLOCKS 1
#define SMG_BESIDES 2
#define SMG_WEIGHT_0 1
#define SMG_BAND 1
#define SMG_CYCLIC 1
#define SMG_AXES 7
#define SMG_CONSTANT_HESSIAN 1

/* What methods ask of a model, and what they say of themselves, by the header that is compiled. */
#if defined(SMG_AXIS_SPLITTING_H) || defined(SMG_ANGLES_H) || defined(SMG_CF4_H) || defined(SMG_DEPONDT_MERTENS_H) || \
    defined(SMG_HEUN_H) || defined(SMG_PAIR_ROTATIONS_H) || defined(SMG_SUBLATTICE_ROTATIONS_H) ||                    \
    defined(SMG_EXPLICIT_H) || defined(SMG_EXPLICIT_STEP_H) || defined(SMG_GAUSS_SITE_H)
#define SMG_HISTORY 1
#ifndef SMG_ANGLES
#define SMG_ANGLES 2
#endif
#elif defined(SMG_ONE_STAGE_H) || defined(SMG_GEODESIC_MIDPOINT_H) || defined(SMG_ISOSPECTRAL_MIDPOINT_H) || \
    defined(SMG_EXPONENTIAL_MIDPOINT_H) || defined(SMG_RATTLE_H) || defined(SMG_SLOPES_H)
#define SMG_HISTORY 3
#undef SMG_HAS_LANES
#define SMG_HAS_LANES 0
#ifdef SMG_SLOPES_H
#define SMG_SLOPES 3
#endif
#elif !defined(SMG_DOP853_H) && !defined(SMG_EXTRAPOLATION_H)
#define SMG_HISTORY 7
#if !defined(SMG_SPHERE_HISTORY_H) && !defined(SMG_SINGLE_SPHERE_H) && !defined(SMG_LANE_NEWTON_H)
#define SMG_NO_DEGREE -1
#endif
#endif
#if !defined(SMG_AXIS_SPLITTING_H) && !defined(SMG_CLASSICAL_MIDPOINT_H) && !defined(SMG_DOP853_H) &&      \
    !defined(SMG_EXPONENTIAL_MIDPOINT_H) && !defined(SMG_EXTRAPOLATION_H) && !defined(SMG_GAUSS_SITE_H) && \
    !defined(SMG_ISOSPECTRAL_MIDPOINT_H) && !defined(SMG_PAIR_ROTATIONS_H) && !defined(SMG_RATTLE_H) &&    \
    !defined(SMG_SUBLATTICE_ROTATIONS_H)
#define SMG_ONTO_LEAF 1
#endif
#ifndef SMG_CLASSICAL_MIDPOINT_H
#define SMG_BS 2
#endif
#if defined(SMG_GAUSS_SLOTS_H) || defined(SMG_GAUSS_SWEEP_H) || defined(SMG_GAUSS_ROWS_H) || defined(SMG_GAUSS_SHIFT_H)
#define SMG_ROW_STAGES 1
#endif
#ifdef SMG_MATRIX_FREE_H
#define SMG_MATRIX_FREE 1
#endif
#ifdef SMG_MATRIX_SPARSE_H
#define SMG_ORDER 2
static const int32_t smg_block_rows[2] = {0}, smg_rows[3] = {0}, smg_columns[4] = {0}, smg_diagonal[2] = {0};
#endif
#if defined(SMG_PAIR_ROWS_H) || defined(SMG_PAIR_STATE_H)
#define SMG_ROW_CLASSES 2
static const int64_t smg_row_classes[SMG_ROW_CLASSES][6] = {{0}};
#endif
#if defined(SMG_ROW_SWEEP_H) || defined(SMG_ROW_WAVE_H) || defined(SMG_ROW_STEP_H) || defined(SMG_ROW_BEYOND_H)
#define SMG_BY_ROWS 1
#define SMG_TANGENT 1
#endif
#if defined(SMG_LEVELS_H) || defined(SMG_STAGE_PREDICTOR_H) || defined(SMG_COMPOSITION_H) || \
    defined(SMG_COMPOSED_TANGENT_H) || defined(SMG_LANE_COMPOSITION_H)
#define SMG_COMPOSED 5
static const smg_real smg_gamma[5] = {0}, smg_inverse_gamma[5] = {0};
static const double smg_stage_weights[5][4][8] = {{{0}}};
#endif
#if defined(SMG_SPHERE_HISTORY_H) || defined(SMG_SINGLE_SPHERE_H) || defined(SMG_LANE_NEWTON_H)
#define SMG_SINGLE_SPHERE 1
#else
#define SMG_HAS_COUPLED 1
#define SMG_HAS_ALONE 1
#endif

typedef struct smg_params {
  int64_t n;
} smg_params;

typedef struct smg_model {
  smg_params p;
  int64_t n0;
  uint64_t version;
  smg_status status;
} smg_model;

typedef struct smg_coefficients {
  const smg_model *model;
  smg_real t, h;
} smg_coefficients;

typedef struct smg_wide_coefficients {
  smg_real t;
} smg_wide_coefficients;

typedef struct smg_lane_coefficients {
  smg_real t;
} smg_lane_coefficients;

typedef struct smg_state {
  smg_coefficients c;
  smg_wide_coefficients wide;
  uint64_t version;
  double t0, h;
  int64_t count, begun;
  int history, degree, newton_steps, row, stage;
  smg_real older[4], *past[7], *spare[7];
#if SMG_SINGLE_SPHERE
  smg_real *rows;
#else
  int rows;
#endif
  int row_team, row_strong, row_flat, row_weak, row_stretched, row_alone, row_due, row_kept;
  int64_t row_passes, row_fewest, row_from, row_near, row_reach;
  int32_t *row_beside;
  void *row_kinds, *row_known;
  smg_real row_bound, *row_w, *row_compensation, *row_m, *row_u, *row_late, *row_beyond, *row_w_before;
  smg_real *row_compensation_before, *row_u_before;
  smg_real *w, *compensation, *u, *m, *mbar, *g, *r, *s, *G, *S, *x, *A, *work, *curve, *sums, *mean, *v, *hessian_v;
  smg_real *product, *few, *misses, *prepared, *before, *increments, *leaf_value, *points, *slopes, *inverse, *stages;
  smg_real *tableau, *row_spins, *turns, *past_slopes, *low, *wide_m, *wide_g, *wide_v, *wide_d, *wide_e, *wide_s,
      *wide_y;
  uint64_t seed;
  uint32_t member;
  int64_t halved;
  smg_real *unturned, tolerance, scale;
  smg_report report;
} smg_state;

typedef struct smg_ensemble {
  smg_state *member;
  int64_t members, failed, own;
  smg_status status;
} smg_ensemble;

#endif
