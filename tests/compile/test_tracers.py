"""What an effect over tracers says moves the tracers alone, whichever vectors its formula names; the others move as if it were not there."""
import numpy as np
import pytest
import smidgen

from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.run.record.conserved import with_tracers

SPEC = """[model]
name = "carried"
[space]
q = { sphere = 3 }
s = { sphere = 1 }
a = { sphere = 2, tracer = true }
[effects.own]
over = "pair(i, j) of q"
energy = "-log(2.5 - 2*dot(q[i], q[j]))"
[effects.single]
energy = "0.3*s.x^2"
[effects.carry]
over = "each(i of a, j of q)"
energy = "0.3*dot(a[i], q[j]) + 0.2*q[j].x*a[i].z^2"
"""
OVER = 'over = "each(i of a, j of q)"\nenergy = '
# Effects over tracers whose formulas name none of them: alone, squared, in time, of a vector that stands alone, and joined to one.
OTHERS = {"linear": OVER + '"0.7*q[j].z"', "square": OVER + '"0.7*q[j].z^2 + cos(t)*q[j].x"', "one": 'over = "site(i) of a"\nenergy = "0.5*s.z"',
          "joint": OVER + '"0.4*dot(q[j], s)"'}
START = np.array([[0.36, 0.48, 0.8], [-0.6, 0.0, 0.8], [0.48, -0.8, -0.36], [0.0, 0.6, 0.8], [-0.8, 0.6, 0.0], [0.0, -1.0, 0.0]])
METHODS = ("spherical-midpoint", "classical-midpoint", "gauss-4", "cf4", "isospectral-midpoint", "dop853", "spherical-midpoint-4")


def with_effect(name):
    return smidgen.load_text(f"{SPEC}[effects.{name}]\n{OTHERS[name]}\n")


@pytest.mark.quick
@pytest.mark.parametrize("name", OTHERS)
def test_its_effect_is_in_no_sum_of_the_c_and_in_no_reported_energy(name):
    assert with_tracers(with_effect(name)) == {"carry", name}
    for features in ((), ("extended",), ("tangent",)):
        assert f"effect_{name}_gradient(c" not in generate(with_effect(name), features=features)["carried.c"]


@pytest.mark.parametrize("name", OTHERS)
def test_the_field_is_that_without_it_and_the_energy_the_witness_s(name):
    spec, plain = with_effect(name), Witness(smidgen.load_text(SPEC))
    model, witness = smidgen.build(spec).start(START.copy(), t0=0.3, h=0.05), Witness(spec)
    assert np.allclose(model.field(START, 0.3), plain.field(START, 0.3), rtol=1e-13, atol=1e-14)
    assert np.array_equal(witness.field(START, 0.3), plain.field(START, 0.3))
    assert model.energy(START, 0.3) == pytest.approx(witness.energy(START, 0.3), rel=1e-14)
    assert abs(witness.energy(START, 0.3) - plain.energy(START, 0.3)) > 0.1


@pytest.mark.parametrize("method", [m if m in METHODS[:3] else pytest.param(m, marks=pytest.mark.long) for m in METHODS])
def test_steps_have_the_bits_that_they_have_without_it(method):
    states = [smidgen.build(spec, method=method).start(START.copy(), t0=0.3, h=0.05).steps(5).state()
              for spec in (smidgen.load_text(SPEC), *map(with_effect, ("linear", "joint")))]
    assert all(s.tobytes() == states[0].tobytes() for s in states[1:])
