"""What a run needs of its spec is evaluated once."""
import collections
import sys

import numpy as np
import pytest
import smidgen
from smidgen.compile import select
from smidgen.compile.plan import plan
from smidgen.errors import UsageError
from smidgen.run.step import evaluated
from smidgen.run.step.evaluated import Evaluated
from smidgen.run.step.prepared import prepare

FILM = """
[model]
name = "film"
[parameters]
n = { default = 4, meaning = "cells along a side" }
J = { default = 1.0, meaning = "coupling" }
B = { default = [0.5, 0.25], size = "2", meaning = "fields" }
[space]
w = { sphere = "n*n" }
[effects.exchange]
over = "bond(i, j) of square(n, n, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.field]
over = "site(i)"
energy = "-B[0]*w[i].z"
[starts.any]
w = { random = 1 }
[runs.demo]
start = "any"
h = "0.1*J"
steps = 8
output = { every = 2 }
set = { J = 2.0 }
"""


@pytest.fixture
def calls(monkeypatch):
    """How often parameter values, places, scenes and plans have been made, by name."""
    found = collections.Counter()

    def counted(function, places):
        def one(*given, **more):
            found[function.__name__] += 1
            return function(*given, **more)
        for place in places:
            for name in [name for name, value in vars(place).items() if value is function]:
                monkeypatch.setattr(place, name, one)
    everywhere = [m for name, m in sys.modules.items() if name.startswith("smidgen")]
    for function in (evaluated.parameter_values, select.select, plan.choose):
        counted(function, everywhere)
    counted(evaluated.integer, [evaluated])     # sizes: of the array and of the family
    return found


@pytest.mark.parametrize("more", [{}, {"substeps": True}, {"estimate": True}, {"what": ["states", "energy", "momentum", "casimirs", "magnetisation"]}])
def test_a_run_evaluates_its_spec_once(calls, more):
    """Where the library is made and where it is there. It was 22 to 28 evaluations of the parameters, 10 to 13 of the sizes."""
    spec = smidgen.load_text(FILM)
    for _ in range(2):
        calls.clear()
        smidgen.run(spec, **more)
        assert calls == {"parameter_values": 1, "select": 1, "choose": 1, "integer": 2}


def test_a_run_that_goes_on_and_an_ensemble_do_too(calls, tmp_path):
    spec = smidgen.load_text(FILM)
    smidgen.run(spec, out=tmp_path / "a.npz", checkpoint=2)
    calls.clear()
    smidgen.ensemble(spec, start=np.tile(smidgen.build(spec).start("any", h=0.1).w, (3, 1, 1)), steps=2)
    assert calls["select"] == calls["choose"] == 2 and calls["parameter_values"] == 2      # of `build`, and of `ensemble`


def test_numbers_are_evaluated_when_they_are_asked_for_and_kept():
    numbers = Evaluated(smidgen.load_text(FILM), {"n": 3})
    assert numbers.places == {"w": (0, 9)} and numbers.places is numbers.places
    assert numbers.kappas is numbers.kappas and numbers.radii.tolist() == [1.0] * 9 and numbers.casimir_matrices.shape == (9, 3, 3)
    with pytest.raises(ValueError, match="read-only"):
        numbers.kappas[0] = 2


def test_a_scene_has_the_numbers_of_its_spec():
    spec = smidgen.load_text(FILM)
    one = prepare(spec, "spherical-midpoint", ["exchange"], {"n": 5, "J": 3.0})
    assert one.numbers.parameters == {"n": 5, "J": 3.0} and one.numbers.spec is one.scene and one.numbers.places == {"w": (0, 25)}
    assert one.with_parameters({"J": 4.0}).numbers.parameters == {"n": 5, "J": 4.0} and one.numbers.parameters["J"] == 3.0
    with pytest.raises(UsageError, match="no parameter"):
        one.with_parameters({"K": 1.0})


def test_an_ensemble_takes_the_values_that_its_run_sets():
    """As a run does: bits of each member are those that it has alone."""
    spec = smidgen.load_text(FILM)
    alone = smidgen.run(spec, "demo", what=["states"]).final
    assert smidgen.ensemble(spec, run="demo").w.tobytes() == alone[None].tobytes()
