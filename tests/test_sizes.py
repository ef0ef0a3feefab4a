"""Sizes are values at run time: each is computed, checked, and no other size is another program."""
import re
from itertools import cycle

import pytest
from support.strict import run_sanitized

from smidgen.build import write_files
from smidgen.emit import generate
from smidgen.features import FEATURES
from smidgen.read import load_text

SPEC = """
[model]
name = "sized"
[space]
w = {{ sphere = "n", kappa = "{kappa}" }}
v = {{ sphere = "m" }}
[parameters]
n = 4
m = 3
gamma = {{ default = 1.0, size = "{size}" }}
delta = {{ default = 0.5, size = "{other}" }}
[effects.field]
over = "site(i) of w"
energy = "{energy}"
[effects.chain]
over = "bond(i, j) of chain(m, open) on v"
energy = "dot(v[i], v[j])"
[observables.seen]
over = "site(i) of v"
value = "delta[i]*v[i].x"
"""
USES = {"kappa": ("gamma[i] + 1", "w[i].z^2"), "energy": ("1", "gamma[i]*w[i].z^2"), "nothing": ("1", "w[i].z^2")}
LENGTHS = ("n", "2*n", "n + m", "n*m", "3*n - m", "m*m", "5")


def sized(size="2*n", use="kappa", other="n*m + 1"):
    kappa, energy = USES[use]
    return SPEC.format(size=size, kappa=kappa, energy=energy, other=other)


@pytest.mark.quick
@pytest.mark.parametrize("size, use, features", [*((size, use, ()) for size, use in zip(LENGTHS, cycle(USES))),
                                                 *(("2*n", use, tuple(FEATURES)) for use in USES)])
def test_every_coefficient_that_is_read_is_computed(size, use, features):
    """Sizes n0, n1, .. in `_sizes`, values k0, k1, .. in `_prepare` or `_clock`; none is declared in vain."""
    files = generate(load_text(sized(size, use)), features=features)
    read = set(re.findall(r"(?:c|wide)->([nk]\d+)", files["sized.c"]))
    computed = set(re.findall(r"(?:k|wide)->([nk]\d+) = ", files["sized.c"]))
    declared = set(re.findall(r"(?:int64_t|smg_real|smg_wide) ([nk]\d+);", files["sized.h"]))
    assert read <= computed == declared


MAIN = """
#include "sized.h"
#include <stdlib.h>
/* A check in memory that was used before, with arrays of exactly their sizes; a bad entry, the last one, is seen. */
int main(void) {
  for (int64_t n = 3; n < 6; ++n) {
    sized_params p;
    sized_defaults(&p);
    p.n = n;
    double *gamma = (double *)malloc((size_t)(2 * n) * sizeof(double)), *delta = (double *)malloc((size_t)(3 * n + 1) * sizeof(double));
    for (int64_t k = 0; k < 2 * n; ++k) gamma[k] = 1;
    for (int64_t k = 0; k < 3 * n + 1; ++k) delta[k] = 1;
    p.gamma = gamma;
    p.delta = delta;
    if (sized_check(&p) != SMG_OK) return 1;
    delta[3 * n] = (double)NAN;
    if (sized_check(&p) != SMG_NOT_FINITE) return 2;
    free(gamma);
    free(delta);
  }
  return 0;
}
"""


def test_arrays_are_checked_over_their_own_sizes(tmp_path):
    files = generate(load_text(sized()))
    write_files({**files, "main.c": MAIN}, tmp_path)
    status, said = run_sanitized(tmp_path, ["sized.c", "main.c"])
    assert status == 0, said[:3000]
