/* smidgen runtime: the kernels of one site, for editors (smg_stub_functions.h); a template (smg_template.h). */
#include "smg_model.h"
#include "smg_vec.h"

#if SMG_SINGLE_SPHERE
typedef struct smg_slope {
  smg_number e00;
} smg_slope;

smg_vec smg_motion(const smg_coefficients *c, smg_vec m);
smg_vec smg_radial(const smg_coefficients *c, smg_vec m, smg_vec g);
smg_slope smg_derivative(const smg_coefficients *c, smg_vec m, smg_number q);
smg_vec smg_slope_times(smg_slope D, smg_vec v);
smg_number smg_slope_minors(smg_slope D);
smg_vec smg_slope_sums(smg_slope D);
#else
smg_vec smg_motion(const smg_coefficients *c, smg_vec m, smg_number size);
#endif
