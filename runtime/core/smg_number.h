/* smidgen runtime: which numbers a text is about that serves scalars and lanes. Such a header has no guard: with
 * SMG_IN_LANES it defines smg_lane_dot and the like over smg_lanes, else smg_dot over smg_real. */
#undef SMG_NUMBER
#undef SMG_OF
#ifdef SMG_IN_LANES
#define SMG_NUMBER smg_lanes
#define SMG_OF(name) smg_lane_##name
#else
#define SMG_NUMBER smg_real
#define SMG_OF(name) smg_##name
#endif
