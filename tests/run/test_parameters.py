"""Parameters changed between steps: every layout goes on as from a start with the new ones; a model is shared, and no state writes to it."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, UsageError
from smidgen.resources import include_flags
from smidgen.run.step.saved import COUNT_HIGH, COUNT_LOW, HISTORY, T0
from smidgen.run.step.substeps import substep
from support.strict import WARNINGS
from support.systems import tiers
from test_set_state import LATE, LAYOUTS, SOME, bits, spec_of, start_of

DAMPING = '\n[effects.damping]\nover = "site(i) of w"\ndamping = "a"\n'
WAVE = '[effects.wave]\nover = "site(i) of w"\nenergy = "J*cos(i - t)*w[i].x"\n'
WARM = DAMPING + 'kT = "T"\n'
PARAMETERS = '\n[parameters]\nn = {n}\nJ = 1.0\na = 0.1\nT = 0.2\n'
RING = ('[model]\nname = "{name}"\n[space]\nw = {{ sphere = "n" }}\n' + PARAMETERS + '[effects.exchange]\nover = "bond(i, j) of chain(n, periodic)"\n'
        'energy = "-J*dot(w[i], w[j])"\n[starts.some]\nw = {{ random = 1 }}\n')
BODY = ('[model]\nname = "{name}"\n[space]\nw = {{ sphere = "n" }}\n' + PARAMETERS + '[effects.shape]\nover = "site(i) of w"\nenergy = "J*w[i].x^2 + 2*J*w[i].y^2"\n'
        '[starts.some]\nw = {{ random = 1 }}\n')


def spec_with(text, name, n, more=""):
    return smidgen.load_text(text.format(name=name, n=n) + more)


# more of them: what only precesses stands in LAYOUTS
MORE = {
    "ring by rows": (spec_with(RING, "ring", 33), "spherical-midpoint", 0.1), "ring in blocks": (spec_with(RING, "blocks", 64), "spherical-midpoint", 0.1),
    "rows by site, in time": (spec_with(RING, "sited", 32, WAVE), "spherical-midpoint", 0.1), "gauss by rows": (spec_with(RING, "stages", 32), "gauss-6", 0.1),
    "sublattices by rows": (spec_with(RING, "turned", 32), "sublattice-rotations", 0.1), "pairs by rows": (spec_with(RING, "paired", 32), "pair-rotations", 0.1),
    "sublattices composed": (spec_with(RING, "composed", 32), "sublattice-rotations-4", 0.1), "pairs": (spec_with(RING, "pentagon", 5), "pair-rotations", 0.1),
    "sweeps, then Newton": (spec_with(RING, "newton", 17), "spherical-midpoint", 0.7),
    "damped single sphere": (spec_with(BODY, "damped_body", 1, DAMPING), "spherical-midpoint", 0.2),
    "damped ring": (spec_with(RING, "damped_ring", 32, DAMPING), "spherical-midpoint", 0.1),
    "damped few": (spec_with(RING, "damped_few", 6, DAMPING), "spherical-midpoint", 0.1),
    "warm single sphere": (spec_with(BODY, "warm_body", 1, WARM), "spherical-midpoint", 0.2),
    "warm ring": (spec_with(RING, "warm_ring", 32, WARM), "spherical-midpoint", 0.1),
    "warm ring in stages": (spec_with(RING, "warm_gauss", 6, WARM), "gauss-4", 0.1),
}
FIXED = [key for key, (spec, *_) in LAYOUTS.items() if not any(p.kind == "real" or p.kind == "array" for p in spec_of(spec).parameters if not p.fixed)]
ALL = {**{key: one for key, one in LAYOUTS.items() if key not in FIXED}, **MORE}


def free(model) -> list:
    """The parameters of a model that may be changed between steps: those that are no integers and are not compiled in, and are no radius."""
    return [p.name for p in model.scene.parameters if p.kind != "int" and not p.fixed]


def changed(model, factor=1.0625) -> dict:
    return {name: np.multiply(factor, model.parameters[name]) for name in free(model)}


def at(model, place):
    """Where `place`, another's saved state, is in time, by a saved state of this one that has no history."""
    now = model.save()
    now[[T0, COUNT_HIGH, COUNT_LOW]] = place[[T0, COUNT_HIGH, COUNT_LOW]]
    return model.restore(now)


def started(key, values=None, w=None, **build):
    spec, method, h = ALL[key]
    spec = spec_of(spec)
    return smidgen.build(spec, method=method, parameters=values, **build).start(start_of(spec) if w is None else w, h=h)


@pytest.mark.parametrize("key", [pytest.param(key, marks=pytest.mark.quick) if key in SOME or key in MORE else
                                 pytest.param(key, marks=pytest.mark.long) if key in LATE else key for key in ALL])
def test_steps_go_on_as_from_a_start_with_the_new_parameters(key):
    """All bits: w, what it has lost, the history, at every later step; of a state that was saved in between, too."""
    one = started(key).steps(11)
    new = changed(one)
    one.set_parameters(new)
    saved, w = one.save(), one.w.copy()
    other = at(started(key, new, w.copy()), saved)
    assert saved[HISTORY] == -1 and one.energy(w) == other.energy(w) and bits(one.field(w)) == bits(other.field(w))
    third = started(key, new).steps(3).restore(saved)
    for count in (1, 2, 9):
        assert bits(one.steps(count).save()) == bits(other.steps(count).save()) == bits(third.steps(count).save())
    assert bits(one.w) != bits(started(key, w=w.copy()).steps(12).w)


@pytest.mark.quick
@pytest.mark.parametrize("build", [{"real": "long double"}, {"features": ("extended",)}, {"features": ("plain-sums",)}])
@pytest.mark.parametrize("key", ["few in lanes", "single sphere"])
def test_in_other_precisions(key, build):
    one = started(key, **build).steps(11)
    new = changed(one)
    one.set_parameters(new)
    other = at(started(key, new, one.w.copy(), **build), one.save())
    assert bits(one.steps(5).w) == bits(other.steps(5).w)


@pytest.mark.quick
def test_from_rows_to_other_ways_and_back():
    """A coupling beyond which a ring no longer goes by rows, and the old one again."""
    spec, turn = spec_with(RING, "between", 32), np.arange(32.0)
    w = np.stack([0.4*np.cos(turn), 0.4*np.sin(turn), np.full(32, np.sqrt(1 - 0.16))], axis=-1)
    one, weak, strong = (smidgen.build(spec, parameters={"J": J}).start(w.copy(), h=0.2) for J in (1.0, 1.0, 12.0))
    one.steps(4).set_parameters({"J": 12.0})
    strong.start(one.w.copy(), h=0.2)
    assert bits(one.steps(3).w) == bits(strong.steps(3).w)
    one.set_parameters({"J": 1.0})
    weak.start(one.w.copy(), h=0.2)
    assert bits(one.steps(4).w) == bits(weak.steps(4).w)


@pytest.mark.quick
def test_a_control_torque():
    """A field that is on for a while: the motion before and after it is without it, and energy is that of the parameters that there are."""
    spec = smidgen.load_text('[model]\nname = "pulsed"\n[space]\nw = { sphere = 1 }\n[parameters]\nB = 0.0\n[effects.field]\nenergy = "B*w.z"\n')
    one = smidgen.build(spec).start([[1.0, 0, 0]], h=0.125)
    assert bits(one.steps(8).w) == bits(np.array([[1.0, 0, 0]])) and one.energy([[0, 0, 1.0]]) == 0
    one.set_parameters({"B": 2.0})
    assert one.energy([[0, 0, 1.0]]) == 2 and one.parameters["B"] == 2 and one.t == 1
    angle = 2 * np.arcsin(0.125) * 8        # of the spherical midpoint method, exactly
    one.steps(8)
    assert np.abs(one.w[0] - [np.cos(angle), -np.sin(angle), 0]).max() < 1e-14
    w = one.set_parameters({"B": 0.0}).w.copy()
    assert bits(one.steps(8).w) == bits(w) and one.t == 3


DAMPED = """[model]
name = "damped"
orientation = %d
[space]
w = { %s, kappa = %s }
[parameters]
alpha = { default = [0.1, 0.2], size = 2 }
[effects.field]
over = "site(i) of w"
energy = "w[i].z + w[i].x^2"
[effects.drag]
over = "site(i) of w"
damping = "alpha[i]"
%s
[starts.some]
w = { random = 1 }
"""


@pytest.mark.quick
@pytest.mark.parametrize("orientation, space, kappa, more", [(1, "sphere = 2", "1", 'form = "ll"'), (-1, "r3 = 2", "-2", ""), (1, "sphere = 2", "-1", 'kT = "0.3"')])
def test_c_refuses_a_negative_damping(orientation, space, kappa, more):
    """At any site, at the start and later: energy would rise. kT = -0.3 is refused, too, with the diffusion that it gives."""
    spec = smidgen.load_text(DAMPED % (orientation, space, kappa, more))
    one = smidgen.build(spec).start(h=0.1).steps(3)
    w = one.w.copy()
    with pytest.raises(RunError, match="bad parameter"):
        one.set_parameters({"alpha": [0.1, -1e-9]})
    one.set_parameters({"alpha": [0.0, 0.3]}).steps(1)
    assert not np.array_equal(one.w, w)
    with pytest.raises(smidgen.SmidgenError):
        smidgen.build(spec, parameters={"alpha": [-0.1, 0.1]}).start(h=0.1)


@pytest.mark.quick
def test_what_is_refused_changes_nothing():
    spec = smidgen.load_text('[model]\nname = "refusing"\n[space]\nw = { sphere = "n", kappa = "k^3", radius = "r" }\n[parameters]\nn = 4\nk = 1.0\nr = 1.0\n'
                             'J = 1.0\nF = { default = 2.0, fixed = true }\n[effects.exchange]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-F*J*dot(w[i], w[j])"\n'
                             '[starts.some]\nw = { random = 1 }\n')
    one, other = (smidgen.build(spec).start(h=0.1).steps(5) for _ in range(2))
    saved = one.save()
    for values, said in (({"n": 5}, "n"), ({"F": 3.0}, "F"), ({"K": 1.0}, "no parameter"), ({"J": np.nan}, "finite"), ({"J": [1, 2]}, "one number")):
        with pytest.raises(UsageError, match=said):
            one.set_parameters(values)
    for values in ({"r": 2.0}, {"r": 0.0}, {"r": -1.0}, {"k": 0.0}, {"k": 1e120}):
        with pytest.raises(RunError, match="parameter"):
            one.set_parameters(values)
    assert one.parameters["r"] == 1 and one.parameters["k"] == 1 and bits(one.save()) == bits(saved)
    assert bits(one.steps(7).save()) == bits(other.steps(7).save())


@pytest.mark.quick
def test_one_site_at_least_is_there():
    spec = smidgen.load_text(RING.format(name="emptied", n=4) + '[effects.holes]\nover = "site(i) of w"\nabsent = "i < a"\n')
    one, other = (smidgen.build(spec).start(h=0.1).steps(3) for _ in range(2))
    with pytest.raises(RunError, match="parameter"):
        one.set_parameters({"a": 4.0})
    assert bits(one.steps(3).save()) == bits(other.steps(3).save())


@pytest.mark.quick
def test_where_the_new_leaf_cannot_be():
    """C(w) = 0 of a Nambu factor: the step says so, and the state waits for other parameters."""
    spec = smidgen.load_text('[model]\nname = "cone"\n[space]\nw = { nambu = 1, C = "(w.x^2 + w.y^2 + c*w.z^2)/2" }\n[parameters]\nc = 1.0\n'
                             '[effects.shape]\nenergy = "w.x^2 + 2*w.y^2"\n')
    one = smidgen.build(spec).start([[0.6, 0.0, 0.6]], h=0.1)
    w = one.w.copy()
    one.set_parameters({"c": -1.0})
    with pytest.raises(RunError, match="leaf"):
        one.step()
    assert bits(one.w) == bits(w) and one.count == 0
    assert bits(one.set_parameters({"c": 2.0}).steps(3).w) == bits(smidgen.build(spec, parameters={"c": 2.0}).start(w, h=0.1).steps(3).w)


@pytest.mark.quick
def test_the_tangent_map_is_that_of_a_step():
    """There is none of the step before, once the parameters are others."""
    spec = smidgen.load("free_rigid_body")
    one = smidgen.build(spec, features=("tangent",)).start(h=0.1).steps(3)
    v = np.array([[0.0, 1.0, 0.0]])
    one.set_parameters({"I1": 1.5})
    with pytest.raises(RunError):
        one.tangent(v.copy())
    other = smidgen.build(spec, parameters={"I1": 1.5}, features=("tangent",)).start(one.w.copy(), h=0.1)
    assert bits(one.push_forward(v.copy(), 3)) == bits(other.push_forward(v.copy(), 3))


@pytest.mark.quick
def test_substeps_know_them():
    """A saved place with another h forgets history; that parameters are others it does not."""
    spec = spec_with(RING, "substeps", 6)
    one, other = (smidgen.build(spec).start(h=0.1).steps(3) for _ in range(2))
    one.set_parameters({"J": 2.0})
    other.set_parameters({"J": 2.0})
    assert substep(one) == 1 and bits(one.w) == bits(smidgen.build(spec, parameters={"J": 2.0}).start(other.w.copy(), h=0.05).steps(2).w)
