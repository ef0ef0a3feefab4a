/* smidgen runtime: the functions of <model>_abi.c that smg_outputs.h calls, for editors (smg_stub_model.h). */
#ifndef SMG_STUB_ABI_H
#define SMG_STUB_ABI_H

#include "smidgen.h"

#define SMG_ABI(word) stub_abi_##word
#define SMG_COLUMNS 1

int64_t stub_abi_sites(void *s);
int64_t stub_abi_count(void *s);
double stub_abi_time(void *s);
void stub_abi_state(void *s, smg_real *w);
void stub_abi_values(void *s, const unsigned char *asked, smg_real *out);
const smg_real *stub_abi_w(void *s);
void stub_abi_casimirs(void *s, smg_real *out);
int stub_abi_steps(void *s, int64_t count, int64_t *done);

#endif
