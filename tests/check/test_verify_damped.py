"""The row `round-off` of damped spins that have come to rest, where every step rounds in the same way."""
import numpy as np
import pytest
import smidgen
from smidgen.check.verify.case import EPS, Case
from smidgen.check.verify.integrals import known_integrals
from smidgen.check.verify.round_off import round_off
from smidgen.check.verify.row import NO, YES
from smidgen.check.verify.subject import Emitted
from smidgen.run.settings import settle

SPEC = """
[model]
name = "at_rest"
[space]
w = { sphere = 36 }
[effects.exchange]
over = "bond(i, j) of square(6, 6, periodic)"
energy = "-0.4*dot(w[i], w[j])"
[effects.damping]
over = "site(i) of w"
damping = "0.5"
[starts.random]
random = 2
[runs.rest]
start = "random"
h = 0.1
steps = 1000
"""


class Drifting:
    """Spins whose length grows by a part of an ulp in every step."""

    def __init__(self, subject, ulps):
        self.subject, self.ulps = subject, ulps

    def run(self, starts, t, h, counts):
        return self.subject.run(starts, t, h, counts) * (1 + self.ulps * EPS * np.array(counts).reshape(-1, 1, 1, 1))


@pytest.fixture(scope="module")
def looked():
    spec = smidgen.load_text(SPEC)
    case = Case(spec, settle(spec), 2, tier=10_000)
    double, extended = (smidgen.build(spec, real=real, effects=None) for real in ("double", "long double"))
    return case, Emitted(double, extended)


def row(case, subject):
    found, _ = round_off(case, subject, known_integrals(case))
    print(found)
    return found


def test_rounding_at_rest_has_no_exponent(looked):
    found = row(*looked)
    assert found.verdict == YES and "at rest" in found.note


def test_a_drift_at_rest_is_seen(looked):
    case, subject = looked
    assert row(case, Drifting(subject, 0.05)).verdict == NO
