"""Torques in closed form on lattices by rows: they turn no empty slot, so that neither calls nor restored states are told apart by what stands there."""
import numpy as np
import pytest

import smidgen
from test_rows_in_time import by_rows

SPEC = """
[model]
name = "current"
[space]
w = {{ sphere = {count} }}
[effects.exchange]
over = "bond(i, j) of {over}"
energy = "-0.7*dot(w[i], w[j]) - 0.1*w[i].x"
[effects.bath]
over = "site(i) of w"
damping = 0.05
[effects.current]
over = "site(i) of w"
torque = "0.3*cross(w[i], vec(0.6, 0.8, 0)) + 0.2*cross(w[i], cross(w[i], vec(0, 1, 0.1)))"
[starts.random]
random = 4
"""
PLACES = {"odd square": ("square(5, 5, open)", 25), "odd chain": ("chain(25, open)", 25), "odd ring": ("chain(33, periodic)", 33), "even square": ("square(6, 6, periodic)", 36)}


def started(place: str, h: float):
    over, count = PLACES[place]
    spec = smidgen.load_text(SPEC.format(over=over, count=count))
    assert by_rows(spec)
    return smidgen.build(spec).start("random", h=h)


@pytest.mark.quick
@pytest.mark.parametrize("h", (0.02, 0.12), ids=("weak", "strong"))
@pytest.mark.parametrize("place", PLACES)
def test_calls_of_any_length_and_restored_states_have_the_same_bits(place, h):
    whole, parts, again = (started(place, h) for _ in range(3))
    whole.steps(300)
    for _ in range(42):
        parts.steps(7)
    again.restore(parts.save())
    for one in (parts, again):
        one.steps(6)
        assert np.array_equal(one.w, whole.w)


def test_a_long_run_of_a_lattice_with_empty_slots():
    model = started("odd square", 0.12)
    for _ in range(60):
        model.steps(1000)
    assert np.abs(np.linalg.norm(model.w, axis=1) - 1).max() < 1e-13
