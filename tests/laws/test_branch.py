"""The branch check: a second solution of the step equation is refused.

Two equal vortices at half-angle a about an axis turn by theta in a step h,
    sin(theta) = h kappa / (4 pi sin(a) tan(a)),
which has the solutions theta (connected to h = 0) and pi - theta (not). Both satisfy the step
equation to round-off, so nothing but the branch tells them apart. With two far-apart pairs, both
on their wrong branch, the determinant of the Newton matrix is positive again.
"""
import subprocess
from math import asin, cos, pi, sin, tan

import pytest

from smidgen.compile.emit.emit import generate
from smidgen.read import load_text
from smidgen.resources import include_flags

VORTICES = """
[model]
name = "pairs"
[space]
w = {{ sphere = {n} }}
[effects.interaction]
over = "pair(i, j) of w"
energy = "-log(2 - 2*dot(w[i], w[j]))/(4*pi)"
[starts.any]
random = 1
"""

# Puts midpoints where a guess has them and asks the solver itself, from inside the model's file.
DRIVER = """
#include "pairs.c"
#include <stdio.h>
#include <string.h>
int main(void) {{
  static double mem[100000];
  double w[] = {{{w}}}, guess[] = {{{guess}}};
  pairs_params p; pairs_model model; pairs_state s;
  pairs_defaults(&p);
  if (pairs_model_init(&model, &p) != SMG_OK || pairs_init(&s, &model, mem, w, 0, {h}) != SMG_OK) return 2;
  smg_set_time(&s.c, 0);
  memcpy(s.mbar, guess, sizeof guess);
#if SMG_MATRIX_FREE
  SMG_PRODUCTS_LEFT(&s) = SMG_KRYLOV_A_STEP;
#endif
  const int status = smg_newton(&s, {h});
  double moved = 0;
  for (int k = 0; k < (int)(sizeof w / sizeof *w); ++k) moved = fmax(moved, fabs(s.w[k] - w[k]) + fabs(s.compensation[k]));
  printf("%d %.3e %.17g", status, (double)s.report.residual, moved);
  printf(" %d", (int)pairs_step(&s));
  for (int k = 0; k < (int)(sizeof w / sizeof *w); ++k) printf(" %.17g", s.w[k]);
  return 0;
}}
"""


def turned(a, angle):
    """A pair about the z axis, each vortex at colatitude a, turned by -angle (clockwise)."""
    return [[sin(a) * cos(angle), -sin(a) * sin(angle), cos(a)],
            [-sin(a) * cos(angle), sin(a) * sin(angle), cos(a)]]


def below(points):
    """The same pair at the south pole: turned by pi about the x axis."""
    return [[x, -y, -z] for x, y, z in points]


def ask(folder_of_test, pairs, a, h, wrong, solver="auto"):
    """Solve from the midpoints of the right or the wrong solution -> (status, residual, moved, status of step, W)."""
    theta = asin(h / (4 * pi * sin(a) * tan(a)))
    angle = pi - theta if wrong else theta
    start, end = turned(a, 0), turned(a, angle)
    middle = [[(x + y) / 2 for x, y in zip(p, q)] for p, q in zip(start, end)]
    if pairs == 2:
        start, middle = start + below(start), middle + below(middle)
    text = DRIVER.format(w=", ".join(repr(x) for p in start for x in p), h=repr(h),
                         guess=", ".join(repr(x) for p in middle for x in p))
    files = generate(load_text(VORTICES.format(n=2 * pairs)), solver=solver)
    for name, content in {**files, "main.c": text}.items():
        (folder_of_test / name).write_text(content)
    program = folder_of_test / "program"
    subprocess.run(["gcc", "-O1", "-std=c11", "-ffp-contract=off", *include_flags(), f"-I{folder_of_test}",
                    str(folder_of_test / "main.c"), "-lm", "-o", str(program)], check=True)
    words = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.split()
    return int(words[0]), float(words[1]), float(words[2]), int(words[3]), [float(x) for x in words[4:]]


@pytest.mark.parametrize("pairs, solver", [(1, "auto"), (2, "rotation"), *(
    pytest.param(pairs, solver, marks=pytest.mark.long) for pairs, solver in ((1, "rotation"), (1, "plain"), (2, "auto"), (2, "plain")))])
def test_second_solution_is_refused(tmp_path, pairs, solver):
    a, h = 0.15, 0.15
    right = ask(tmp_path, pairs, a, h, wrong=False, solver=solver)
    wrong = ask(tmp_path, pairs, a, h, wrong=True, solver=solver)
    assert right[0] == 0 and wrong[0] == 3          # SMG_OK, SMG_WRONG_BRANCH
    assert wrong[1] < 1e-14                         # it does solve the step equation
    assert wrong[2] == 0                            # and the state is as it was


@pytest.mark.quick
@pytest.mark.parametrize("part", [pytest.param(0.3, marks=pytest.mark.long), pytest.param(0.9, marks=pytest.mark.long), 0.999])
def test_right_branch_up_to_the_fold(tmp_path, part):
    """The step turns the pair by the exact angle, also just before the fold sin(theta) = 1."""
    a = 0.15
    h = part * 4 * pi * sin(a) * tan(a)
    _, _, _, status, w = ask(tmp_path, 1, a, h, wrong=False)
    expected = [x for p in turned(a, asin(part)) for x in p]
    assert status == 0
    error = max(abs(x - y) for x, y in zip(w, expected))
    assert error < 1e-14 / (1 - part) ** 0.5        # the angle's condition at the fold


@pytest.mark.quick
def test_beyond_the_fold_there_is_no_step(tmp_path):
    a = 0.15
    fold = 4 * pi * sin(a) * tan(a)
    theta = asin(0.999)
    start = turned(a, 0)
    text = DRIVER.format(w=", ".join(repr(x) for p in start for x in p), h=repr(1.01 * fold),
                         guess=", ".join(repr(x) for p in turned(a, theta / 2) for x in p))
    for name, content in {**generate(load_text(VORTICES.format(n=2))), "main.c": text}.items():
        (tmp_path / name).write_text(content)
    subprocess.run(["gcc", "-O1", "-std=c11", *include_flags(), f"-I{tmp_path}", str(tmp_path / "main.c"),
                    "-lm", "-o", str(tmp_path / "program")], check=True)
    words = subprocess.run([str(tmp_path / "program")], capture_output=True, text=True, check=True).stdout.split()
    assert int(words[3]) == 2                       # SMG_NO_SOLUTION
    assert [float(x) for x in words[4:]] == [x for p in start for x in p]
