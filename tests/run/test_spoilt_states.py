"""A saved state of which an integer is spoilt: it is refused, or it is one that steps could have left."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from smidgen.run.step.saved import DEGREE, HISTORY
from smidgen.run.step.status import Status
from support.strict import CALLS
from support.systems import begin, model, tiers
from test_set_state import LAYOUTS, spec_of, start_of


def accepted(one, saved, changes) -> bool:
    """Is a saved state with these numbers in it taken? Where it is not, the state stays."""
    before, wrong = one.save(), saved.copy()
    for place, value in changes.items():
        wrong[place] = value
    try:
        one.restore(wrong)
    except smidgen.RunError as refused:
        assert refused.status == Status.BAD_PARAMETER
        np.testing.assert_array_equal(one.save(), before)
        return False
    return True


@pytest.mark.quick
@pytest.mark.parametrize("name, method, most", [("free_rigid_body", "spherical-midpoint", 8), ("free_rigid_body", "spherical-midpoint-6", 3), ("two_bodies", "spherical-midpoint-4", 3),
                                                ("two_bodies", "spherical-midpoint", 6), ("two_bodies", "gauss-4", None), ("free_rigid_body", "dop853", None), ("two_bodies", "cf4", None)])
def test_a_saved_degree_is_one_that_the_predictor_has(name, method, most):
    """`most`: with the whole history; with a part of it, no more than that serves. None: there is no predictor, and the degree stays."""
    case = begin(name)
    one = model(case, method).start(case.w.copy(), h=case.h).steps(20)
    saved = one.save()

    def taken(history):
        return [degree for degree in range(-2, 13) if accepted(one, saved, {HISTORY: history, DEGREE: degree})]
    assert taken(int(saved[HISTORY])) == ([saved[DEGREE]] if most is None else list(range(most + 1)))
    for history in range(1, int(saved[HISTORY])):
        assert taken(history) == list(range(taken(history)[-1] + 1)) and taken(history)[-1] < history


# Restored with numbers of its head spoilt at random it is refused, or goes on, the same twice; the program reports how many were taken.
SPOILT = """
#include "{M}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t seed = 1;
static uint32_t drawn(uint32_t below) {{ return (seed = seed * 1664525u + 1013904223u) / 65536 % below; }}

static const double absurd[] = {{0.5, -1, -2, 7, 8, 9, 10, 12, 255, 256, -255, -256, 1e9, -1e9, 2147483647.0, 2147483648.0, 4294967295.0, 9.3e18, -9.3e18, 1e300}};

int main(void) {{
  {M}_params p;
  {M}_model model;
  {M}_state s;
  {M}_defaults(&p);
  if ({M}_model_init(&model, &p) != SMG_OK) return 1;
  const size_t n = 3 * (size_t){M}_sites(&model), size = {M}_savesize(&model);
  smg_real *w = malloc(n * sizeof *w), *one = malloc(size * sizeof *one), *wrong = malloc(size * sizeof *one), *end = malloc(size * sizeof *one), *again = malloc(size * sizeof *one);
  void *mem = malloc({M}_memsize(&model));
  int taken = 0;
  if (fread(w, sizeof *w, n, stdin) != n || {M}_init(&s, &model, mem, w, 0, {h}) != SMG_OK || {M}_steps(&s, {steps}) != SMG_OK) return 1;
  {M}_save(&s, one);
  for (int k = 0; k < 400; ++k) {{
    memcpy(wrong, one, size * sizeof *one);
    for (uint32_t c = 0; c <= drawn(2); ++c) wrong[4 + drawn(5)] = drawn(2) ? (smg_real)absurd[drawn(sizeof absurd / sizeof *absurd)] : (smg_real)drawn(16) - 2;
    if ({M}_restore(&s, wrong) != SMG_OK) continue;
    ++taken;
    const smg_status status = {M}_steps(&s, 2);
    {M}_save(&s, end);
    if ({M}_restore(&s, wrong) != SMG_OK || {M}_steps(&s, 2) != status) return 2;
    {M}_save(&s, again);
    if (memcmp(end, again, size * sizeof *end)) return 3;
  }}
  printf("%d\\n", taken);
  free(w), free(one), free(wrong), free(end), free(again), free(mem);
  return 0;
}}
"""


@pytest.mark.parametrize("name", tiers(LAYOUTS, (), ("single sphere composed", "composed", "ring by rows")))
def test_spoilt_integers_are_refused_or_harmless(tmp_path, name):
    """Four hundred times, under sanitizers."""
    one, method, h = LAYOUTS[name]
    spec = spec_of(one)
    for file, text in generate(spec, method=method).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(SPOILT.format(M=spec.name, h=h, steps=20))
    flags = ["-Wno-psabi", "-std=c11", "-O0", CALLS, "-ffp-contract=off", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
    subprocess.run(["gcc", *flags, *include_flags(), "-I.", "main.c", f"{spec.name}.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    w = np.ascontiguousarray(start_of(spec), float)
    said = subprocess.run(["./main"], cwd=tmp_path, input=w.tobytes(), capture_output=True)
    assert said.returncode == 0, (said.returncode, said.stderr.decode()[-2000:])
    assert 0 < int(said.stdout) < 400
