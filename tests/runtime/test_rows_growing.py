"""Lattices whose bounds hold at the time of a step alone: by rows while they are small, from site to site where they are not, and back."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.run.step.saved import HISTORY
from test_rows import EXCHANGE, lattice
from test_rows_held import PINNED
from test_rows_in_time import by_rows, field

GROWING = EXCHANGE.replace("-0.7*", "-(0.5 + 0.3*t)*")
SPECS = {"growing": lattice("growing", "square(n, 5, open)", 9, "5*n", GROWING + PINNED + field("-0.3*t*normal(1, i)*w[i].z^2")),
         "and back": lattice("growing", "chain(n, periodic)", 33, "n", EXCHANGE.replace("-0.7*", "-0.6*(t - 30)^2*"))}
START = {"growing": 0.0, "and back": 28.0}


def started(name, h=0.4):
    return smidgen.build(SPECS[name]).start("random", h=h, t0=START[name])


@pytest.mark.parametrize("name", SPECS)
def test_steps_are_those_of_the_equation(name):
    """From rows to single sites, and from single sites to rows."""
    assert by_rows(SPECS[name])
    model = started(name)
    w = model.w.copy()
    found = Witness(SPECS[name]).steps(w, START[name], 0.4, 9)[-1]
    assert np.abs(model.steps(9).w - found).max() <= 1e-12


@pytest.mark.parametrize("name", SPECS)
def test_calls_of_any_length_and_restored_states_have_the_same_bits(name):
    """The history begins anew where steps go over from one layout to the other."""
    whole, parts = started(name), started(name)
    whole.steps(9)
    kept = []
    for _ in range(9):
        again = started(name)
        again.restore(parts.save())
        parts.steps(1)
        assert np.array_equal(again.steps(1).save(), parts.save())
        kept.append(parts.save()[HISTORY])
    assert np.array_equal(parts.save(), whole.save()) and 1 in kept[1:]


def test_it_is_said_and_costs_others_nothing():
    assert "site by site" not in generate(SPECS["growing"]).notes["reason"]
    assert "SMG_ROWS_IN_TIME" not in generate(lattice("plain", "chain(n, periodic)", 16, "n", EXCHANGE + field("-0.3*cos(t)*w[i].z")))["plain.c"]


def test_a_call_ends_with_the_first_step_that_fails():
    """In the state that calls of one step each leave."""
    spec = lattice("grown", "square(n, 5, periodic)", 10, "5*n", EXCHANGE.replace("-0.7*", "-0.05*exp(4*t)*"))
    together, alone = (smidgen.build(spec).start("random", h=0.1) for _ in range(2))
    taken = together.advance(40)
    assert 3 < taken < 40
    assert sum(alone.advance(1) for _ in range(40)) == taken
    assert np.array_equal(together.save(), alone.save())


def test_a_step_with_noise_that_fails_where_the_layout_changes_leaves_the_state():
    """w before the noise is kept in an array, which begins elsewhere then; without it all vectors would be 0."""
    bath = '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\nkT = 0.01\n'
    model = smidgen.build(lattice("hot", "square(n, 5, periodic)", 10, "5*n", EXCHANGE.replace("-0.7*", "-0.05*exp(40*t)*") + bath)).start("random", h=0.1).steps(1)
    before, after = model.w.copy(), np.empty_like(model.w)
    assert model.advance(1) == 0
    model._c.state(model._state, after.ctypes.data)
    assert np.array_equal(before, after)
