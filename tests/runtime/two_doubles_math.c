/* The same as wide_math.c, where a wide number is the sum of two doubles. */
#define SMG_DOUBLE_DOUBLE
#include "wide_math.c"
