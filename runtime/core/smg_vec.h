/* smidgen runtime: smg_vec, three numbers by value. */
#ifndef SMG_VEC_H
#define SMG_VEC_H

#include "smg_vec_template.h"

#endif
