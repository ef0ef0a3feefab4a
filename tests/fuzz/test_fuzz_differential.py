"""Whole random Hamiltonians: generated C against the witness (docs/fuzzing.md)."""
import random
import re

import numpy as np
import pytest
import smidgen
from fuzz import differential
from fuzz.differential import Mismatch, check
from support.random_specs import random_spec

FEW = (7, 13, 23, 42)       # 7 and 13: a family behind one whose count is a parameter did not compile


@pytest.mark.parametrize("seed", FEW)
def test_generated_c_agrees_with_the_witness(seed):
    check(*random_spec(random.Random(seed)), seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 130))
def test_more_of_them_agree(seed):
    check(*random_spec(random.Random(seed)), seed)


def test_a_spin_nearly_along_a_strong_field_is_where_the_step_equation_has_it():
    """Errors of single steps at |h b| > 1, in units of 2^-53: what keeps |w| to round-off moves no spin by more."""
    found, dice = [], np.random.default_rng(121)
    pair = differential.Pair(*random_spec(random.Random(121)), dice)
    for _ in range(100):
        w, t = differential.random_state(pair.spec, pair.values, dice), float(dice.uniform(0, 3))
        h = pair.step_size(w, t)
        pair.model.start(w.copy(), t0=t, h=h)
        found.append(np.abs(pair.model.step().w - pair.witness.steps(w, t, h, 1)[1]).max() * 2**53)
    assert np.median(found) < 2.5 and max(found) < 30


ONE = """[model]
name = "one"
[space]
w = { sphere = 2 }
[effects.pair]
energy = "0.7*dot(w[0], w[1]) + 0.4*w[0].z^2 + cos(t)*w[1].x"
"""


@pytest.mark.parametrize("old, new", [("0.7", "0.70000000000001"), ("cos(t)", "cos(1.00000000001*t)"), ("w[1].x", "w[1].y"), ("+ 0.4", "- 0.4")])
def test_a_small_fault_is_seen(monkeypatch, old, new):
    """A witness of a slightly different energy: the comparison says no. The faults are 1e-14 to 1."""
    real = differential.Witness
    monkeypatch.setattr(differential, "Witness", lambda spec, values: real(smidgen.load_text(ONE.replace(old, new)), values))
    with pytest.raises(Mismatch):
        check(ONE, {}, 1)


def test_the_same_without_the_fault():
    assert check(ONE, {}, 1).model.count == differential.STEPS


def test_random_specs_use_the_language():
    """A hundred of them: all kinds of spaces, index families and most functions occur."""
    texts = "\n".join(random_spec(random.Random(seed))[0] for seed in range(100))
    wanted = ["sphere =", "r3 =", "nambu =", "tracer", "kappa", "radius", "site(", "pair(", "bond(", "edge(", "each(", "t + ", "if(",
              "orientation = -1", "triple(", "atan2(", "floor(", "mod(", "gamma[", "fixed"]
    assert [word for word in wanted if not re.search(re.escape(word), texts)] == []
