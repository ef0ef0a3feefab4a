"""Rows of `verify` for torques: only turns that leave them unchanged, too, are looked at."""
import numpy as np
import pytest

import smidgen
from smidgen.check.verify.case import Case
from smidgen.check.verify.equivariant import equivariant
from smidgen.check.verify.integrals import integrals, known_integrals
from smidgen.check.verify.row import NO, YES
from smidgen.check.verify.subject import Emitted
from smidgen.check.verify.symplectic import given_up
from smidgen.run.settings import settle

pytestmark = pytest.mark.quick
SPEC = """
[model]
name = "current"
[space]
w = {{ sphere = 4 }}
[effects.exchange]
over = "bond(i, j) of chain(4, periodic)"
energy = "-0.4*dot(w[i], w[j]) - 0.1*w[i].z^2"
[effects.current]
over = "site(i) of w"
torque = "0.3*cross(w[i], cross(w[i], vec({along})))"
[starts.random]
random = 2
[runs.demo]
start = "random"
h = 0.1
steps = 20
"""


def rows(along: str) -> tuple:
    spec = smidgen.load_text(SPEC.format(along=along))
    case = Case(spec, settle(spec), 2, tier=1000)
    subject, known = Emitted(smidgen.build(spec), smidgen.build(spec, real="long double")), known_integrals(case)
    case.find_states(subject)
    return equivariant(case, subject, known.actions)[0], integrals(case, subject, known)[0], given_up(case.scene)


def test_a_turn_that_the_torque_does_not_share_is_left_out():
    turn, momentum, why = rows("0, 1, 0")
    assert turn.verdict not in (YES, NO) and "and the torques" in turn.note
    assert momentum.verdict not in (YES, NO) and "torques" in momentum.note and "torques" in why


def test_one_that_it_shares_is_looked_at():
    turn, momentum, _ = rows("0, 0, 1")
    assert turn.verdict == YES and turn.note.endswith("1)") and "(0, 0, " in turn.note
    assert momentum.verdict not in (YES, NO)


def test_a_hot_scene_with_a_torque_has_no_boltzmann_distribution():
    text = SPEC.format(along="0, 1, 0").replace("[starts", '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\nkT = 0.2\n[starts')
    hot, calm = (" ".join(smidgen.explain(smidgen.load_text(text), effects=effects).words()) for effects in (None, ["exchange", "bath"]))
    assert "exp(-H/kT) is not stationary" in hot and "A step of -h is still the inverse of a step of h with the noise left out" in hot
    assert "is stationary up to" in calm and np.all([word not in calm for word in ("orques act", "not stationary")])
