r"""Strengths over many decades

For two spins of strengths k_1 and k_2, every step satisfies k_1 (W_1 - w_1) + k_2 (W_2 - w_2) = 0: each increment is -+ h J m_1 x m_2
divided by the strength. The heavy spin may move by less than its last bit, so its increment has to be computed from the state together
with its stored rounding error. The sum of all k_i w_i is not a sufficient criterion, since an error of a light spin would not be visible in it.
"""
import subprocess
import tempfile
from pathlib import Path

import mpmath as mp
import numpy as np

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import SmidgenError
from smidgen.resources import include_flags
from smidgen.check.witness import Witness

from .case import EPS, Row, below, case, near
from .geometry import build, largest, load, turns
from .spins import coupled, turn_of

PAIRS = ((1.0, 1e-12), (-1.0, 1e-12), (1e-12, 1e12), (1e12, -1e-12), (1e-12, -2e-12), (1e6, -1e-6), (1e12, 1e12))

# argv: k, w and h in C's notation. One step; then, of each component, W - w with the carry in extended precision.
DRIVER = r"""
#include "two_spins.c"
#include <stdio.h>
#include <stdlib.h>
int main(int argc, char **argv) {
  static double mem[65536], k[2];
  double w[6];
  two_spins_params p;
  two_spins_model model;
  two_spins_state s;
  if (argc != 10) return 1;
  for (int i = 0; i < 2; ++i) k[i] = strtod(argv[1 + i], 0);
  for (int i = 0; i < 6; ++i) w[i] = strtod(argv[3 + i], 0);
  two_spins_defaults(&p);
  p.k = k;
  if (two_spins_model_init(&model, &p) != SMG_OK || two_spins_memsize(&model) > sizeof mem) return 2;
  if (two_spins_init(&s, &model, mem, w, 0, strtod(argv[9], 0)) != SMG_OK) return 3;
  if (two_spins_step(&s) != SMG_OK) return 4;
  for (int i = 0; i < 6; ++i) printf("%.21Lg ", (long double)s.w[i] - w[i] + s.compensation[i]);
  return 0;
}
"""


def compiled(here: Path) -> Path:
    """The driver, around the generated C."""
    for name, text in {**generate(load("two_spins")), "main.c": DRIVER}.items():
        (here / name).write_text(text)
    subprocess.run(["cc", "-O1", "-std=c11", "-ffp-contract=off", *include_flags(), f"-I{here}", str(here / "main.c"),
                    "-lm", "-o", str(here / "main")], check=True)
    return here / "main"


def increments(driver, k, w, h):
    """W - w with the carry, shape (2, 3), of one step."""
    words = [float(x).hex() for x in (*k, *w.ravel(), h)]
    said = subprocess.run([str(driver), *words], capture_output=True, text=True, check=True).stdout
    return np.array(said.split(), np.longdouble).reshape(2, 3)


def pair_rows(driver):
    """Momentum of the pair and angle of the lighter spin."""
    for k1, k2 in PAIRS:
        h, w, what = 0.3 * min(abs(k1), abs(k2)), coupled(k1, k2, 1.2), f"strengths {k1:g}, {k2:g}"
        moved = increments(driver, (k1, k2), w, h)
        first, second = (np.longdouble(k) * d for k, d in zip((k1, k2), moved))
        yield below(f"{what}: |k1 dW1 + k2 dW2| over |k1 dW1|", largest(first + second) / largest(first), 1e-14)
        light = int(abs(k2) < abs(k1))
        found = abs(turns(w, w + moved.astype(float))[light])
        yield near(f"{what}: angle of the lighter spin", found, turn_of(h, np.sign(k1 * k2), k1, k2, mp.mpf("1.2")), 8 * EPS)


@case("a pair with strengths over 24 decades, both signs")
def pair():
    """|k_1 dW_1 + k_2 dW_2| <= 1e-14 |k_1 dW_1|, carry included, and the light spin where the exact law has it."""
    # broken by: a missing or wrong kappa, a lost carry (the heavy spin would not move at all), a tolerance relative to the heavy spin
    with tempfile.TemporaryDirectory() as place:
        yield from pair_rows(compiled(Path(place)))


@case("25 spins with strengths from 1e-12 to 1e12, both signs")
def cascade():
    """The momentum is conserved to 1e-14 of sum |k_i| over 1000 steps, and every spin agrees with the interpreter."""
    # broken by: a Newton matrix whose pivots drown the light spins, a stop by the residual of the heaviest alone
    k = np.array([10.0**(i - 12) * (-1)**i for i in range(25)])
    model = build("cascade", n=25, k=k.tolist())
    model.start("any", h=0.1 / np.abs(k).max())
    w, whole = model.w.copy(), np.abs(k).sum()
    one = model.step().w.copy()
    exact = Witness(load("cascade"), {"n": 25, "k": k.tolist()}).step(w, 0.0, model.h)
    yield below("one step: largest difference of a spin from the interpreter", largest(one - exact), 8 * EPS)
    yield below("one step: smallest displacement of a spin other than the heaviest", -np.abs(one - w).max(axis=1)[:22].min(), -1e-3)
    model.steps(999)
    yield below("1000 steps: change of the momentum over sum |k_i|", largest(k @ model.w - k @ w) / whole, 1e-14)


@case("strength zero")
def zero():
    """The model is refused at the start."""
    # broken by: 1/kappa = Inf that reaches the state
    try:
        smidgen.build(load("two_spins"), parameters={"k": [1.0, 0.0]}).start("any", h=0.1)
        said = "started"
    except SmidgenError as error:
        said = str(error)
    yield Row("k = (1, 0)", "refused, with the reason", said, "kappa" in said or "strength" in said or "out of range" in said)
