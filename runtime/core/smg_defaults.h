/* smidgen runtime: what C itself reads of the macros of smg_model.h, where a model does not say it. The others are read
 * by #if alone, and are 0 there. gen/compile/emit/settings.py reads this file: generated C says what differs. */
#ifndef SMG_DEFAULTS_H
#define SMG_DEFAULTS_H

/* ---- the bracket, and Newton ------------------------------------------------------------- */
#ifndef SMG_ORIENTATION
#define SMG_ORIENTATION 1
#endif
#ifndef SMG_HAS_COUPLED
#define SMG_HAS_COUPLED 0
#endif
#ifndef SMG_ALONE_IN_LANES
#define SMG_ALONE_IN_LANES 0
#endif
#ifndef SMG_HAS_ALONE
#define SMG_HAS_ALONE 0
#endif
#ifndef SMG_COUPLED_NAMBU
#define SMG_COUPLED_NAMBU 0
#endif
#ifndef SMG_SWEPT
#define SMG_SWEPT 0
#endif
#ifndef SMG_CONSTANT_HESSIAN
#define SMG_CONSTANT_HESSIAN 0
#endif
#ifndef SMG_TORQUES
#define SMG_TORQUES 0
#endif
#ifndef SMG_PUSHES
#define SMG_PUSHES 0
#endif
#ifndef SMG_MATRIX_FREE
#define SMG_MATRIX_FREE 0
#endif
#ifndef SMG_CYCLIC
#define SMG_CYCLIC 0
#endif

/* ---- rows: weights of the colouring, and how many cells away neighbours stand, by direction */
#ifndef SMG_LAYERED
#define SMG_LAYERED 0
#endif
#ifndef SMG_TANGENT
#define SMG_TANGENT 0
#endif
#ifndef SMG_PLACES
#define SMG_PLACES 1
#endif
#ifndef SMG_RANKS
#define SMG_RANKS 1
#endif
#ifndef SMG_COLOURS_MEET
#define SMG_COLOURS_MEET 0
#endif
#ifndef SMG_TURN_0
#define SMG_TURN_0 0
#endif
#ifndef SMG_RINGS
#define SMG_RINGS 0
#endif
#ifndef SMG_BLOCKS
#define SMG_BLOCKS 0
#endif
#ifndef SMG_OWN_FIELD
#define SMG_OWN_FIELD 0
#endif
#ifndef SMG_LAW_BY_SITE
#define SMG_LAW_BY_SITE 0
#endif
#ifndef SMG_LAW_FIRST
#define SMG_LAW_FIRST 0
#endif
#ifndef SMG_ROWS_IN_TIME
#define SMG_ROWS_IN_TIME 0
#endif
#ifndef SMG_RADII
#define SMG_RADII 0
#endif
#ifndef SMG_RADIUS_AT
#define SMG_RADIUS_AT 0
#endif
#ifndef SMG_BESIDE_NORMS
#define SMG_BESIDE_NORMS 0
#endif
#ifndef SMG_SITE_VALUES
#define SMG_SITE_VALUES 0
#endif
#ifndef SMG_SLOWEST
#define SMG_SLOWEST 0
#endif
#ifndef SMG_PARTS_REACH
#define SMG_PARTS_REACH 0
#endif
#ifndef SMG_REACH_1
#define SMG_REACH_1 0
#endif
#ifndef SMG_REACH_2
#define SMG_REACH_2 0
#endif
#ifndef SMG_REACH_3
#define SMG_REACH_3 0
#endif
#ifndef SMG_WEIGHT_0
#define SMG_WEIGHT_0 0
#endif
#ifndef SMG_WEIGHT_1
#define SMG_WEIGHT_1 0
#endif
#ifndef SMG_WEIGHT_2
#define SMG_WEIGHT_2 0
#endif
#ifndef SMG_WEIGHT_3
#define SMG_WEIGHT_3 0
#endif
/* A library is compiled in two units side by side: steps of all sites (smg_step.h) in the second; rows, few sites in
 * lanes and the interface in the first; energies and observables in the second where there are rows. A program has all
 * in one: SMG_UNIT is 0. */
#if SMG_UNIT
#define SMG_LINKED __attribute__((visibility("hidden")))
#else
#define SMG_LINKED static
#endif

#endif
