"""Units and dimensions that do not fit: each is refused where it stands, with its cause and what to write instead."""
import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from smidgen.errors import SpecError, UsageError
from smidgen.language.codes import CONFLICT, DIMENSION, LIMIT, MEASURE, MISSING, NUMBER, SYNTAX, TYPE, UNIT
from smidgen.read import load_text
from smidgen.read.given import Bare
from smidgen.run.step.evaluated import parameter_values
from smidgen.run.step.start import initial_state

pytestmark = pytest.mark.quick

FILM = """
[model]
name = "film"

[units]
energy = "meV"
field = "T"
time = "ps"
length = "nm"

[space]
w = { sphere = "n*n", moment = "m" }
v = { r3 = 1 }

[parameters]
n = 4
m = "1.72 mu_B"
J = { default = 5.7, unit = "meV" }
K = "0.4 meV"
B = "2 T"
T = "300 K"
tau = "5 ps"
g = { default = ["1 meV", "2 meV"], size = 2 }

[formulas]
"pulse(s)" = "exp(-(s/tau)^2)"

[effects.exchange]
over = "bond(i, j) of square(n, n, periodic) on w"
energy = "-J*dot(w[i], w[j])"

[effects.axis]
over = "site(i) of w"
energy = "-K*w[i].z^2 - m*B*pulse(t - 1 ps)*w[i].x"

[effects.body]
energy = "dot(v, v)/(2 meV ps^2)"

[effects.bath]
over = "site(i) of w"
damping = 0.1
kT = "T"

[effects.drive]
over = "site(i) of w"
torque = "cross(w[i], vec(0, 0, 0.02 rad/ps))"

[effects.edge]
over = "site(i) of w"
pinned = "i < 2"

[observables.M]
over = "site(i) of w"
value = "m*w[i].z"
unit = "mu_B"

[starts.up.w]
theta = "30 deg"
phi = 0

[starts.up.v]
vectors = [["1 meV ps", 0, 0]]

[runs.demo]
start = "up"
h = "1 fs"
time = "10 fs"
output = { period = "2 fs", what = ["M"] }
averages = { what = ["M"], after = "2 fs" }
set = { J = "6 meV" }
"""

WRONG = [   # in place of, what is written, the code, what the caret points at, part of the cause
    ('energy = "meV"', 'energy = "ps"', DIMENSION, '"ps"', "cannot be the unit of an energy"),
    ('energy = "meV"', 'energy = "mev"', UNIT, "mev", "there is no unit `mev`"),
    ('energy = "meV"\n', "", MISSING, "units", "does not determine a unit of energy"),
    ('energy = "meV"', "energy = 3", TYPE, "3", "must be a string"),
    ('energy = "meV"', 'energy = "0 meV"', NUMBER, "0", "a unit must be positive"),
    ('energy = "meV"', 'dimensionless = true\nenergy = "meV"', CONFLICT, '"meV"', "`dimensionless` means that there are none"),
    ('field = "T"', 'field = "A/m"', DIMENSION, '"A/m"', "cannot be the unit of a field"),
    ('moment = "m"', 'moment = "J"', DIMENSION, '"J"', "`moment` must be a moment, but this is an energy"),
    (', moment = "m"', "", MEASURE, '{ sphere = "n*n" }', "has no strength"),
    ('moment = "m"', 'kappa = "1 meV"', DIMENSION, '"1 meV"', "kappa is an angular momentum"),
    ('moment = "m"', "kappa = [1, 2]", DIMENSION, "[1, 2]", "this is a number without a unit"),
    ('moment = "m"', 'moment = "m", kappa = "1 hbar"', CONFLICT, '"m"', "a moment and a kappa"),
    ('m = "1.72 mu_B"', "m = 1.72", MEASURE, '"m"', "`moment` must be a moment, but this has no unit"),
    ('unit = "meV" }', 'unit = "exchange" }', UNIT, "exchange", "there is no unit"),
    ('"0.4 meV"', '"0.4 mV"', DIMENSION, "m*B*pulse(t - 1 ps)*w[i].x", "combines"),
    ("-K*w[i].z^2", "-0.4meV*w[i].z^2", SYNTAX, "meV", "neither a number nor a name"),
    ('"0.4 meV"', '"meV"', SYNTAX, "meV", "a number is missing"),
    ('"0.4 meV"', '"1e200 meV"', NUMBER, "1e200", "in absolute value"),
    ('"1 meV", "2 meV"', '"1 meV", "2 T"', DIMENSION, '"2 T"', "is a field where an energy is needed"),
    ('"1 meV", "2 meV"', '"1 meV", 2', DIMENSION, "2", "a number without a unit where an energy"),
    ('"-J*dot', '"-dot', MEASURE, "-dot(w[i], w[j])", "`energy` must be an energy, but this has no unit"),
    ('"-J*dot', '"-J*B*dot', DIMENSION, "-J*B*dot(w[i], w[j])", "this is energy field"),
    ("-K*w[i].z^2", "-K*w[i].z^2 + tau", DIMENSION, "tau", "combines an energy and a time"),
    ("t - 1 ps", "t - 1", DIMENSION, "1", "combines a time and a number without a unit"),
    ("(s/tau)^2", "s^2", DIMENSION, "-s^2", "the argument of `exp` is time^2"),
    ("w[i].z^2", "w[i].z^tau", DIMENSION, "tau", "an exponent is a time"),
    ("-K*w[i].z^2", "-K*max(w[i].z, B)", DIMENSION, "B", "`max` combines"),
    ("-K*w[i].z^2", "-if(t < 2, K, K)", DIMENSION, "2", "`<` combines a time"),
    ("-K*w[i].z^2", "-if(t < tau, K, 0.5)", DIMENSION, "0.5", "the branches of `if`"),
    ("-K*w[i].z^2", "-K*dot(w[i], vec(0, 1, B))", DIMENSION, "B", "`vec` combines"),
    ("-K*w[i].z^2", "-K^1.37*sin(t)", DIMENSION, "t", "the argument of `sin` is a time"),
    ("-K*w[i].z^2", "-K^i", DIMENSION, "i", "an exponent that is not constant"),
    ("-K*w[i].z^2", "-2 T*w[i].z^2", DIMENSION, "m*B", "combines"),
    ("-K*w[i].z^2", "-K*mod(t, 3)", DIMENSION, "3", "`mod` combines"),
    ("-K*w[i].z^2", "-2 Kk*w[i].z^2", UNIT, "Kk", "there is no unit `Kk`"),
    ("-K*w[i].z^2", "-2 meV^99", LIMIT, "99", "the exponent of a unit"),
    ('"dot(v, v)/(2 meV ps^2)"', '"dot(v, v)/2"', DIMENSION, "dot(v, v)/2", "`energy` must be an energy"),
    ("damping = 0.1", 'damping = "0.1 meV"', MEASURE, '"0.1 meV"', "a damping must be a number without a unit"),
    ('kT = "T"', 'kT = "B"', DIMENSION, '"B"', "a temperature must be an energy"),
    ("0.02 rad/ps", "0.02", MEASURE, "cross(w[i], vec(0, 0, 0.02))", "which is added to w'"),
    ("0.02 rad/ps", "0.02 rad/tau^2", DIMENSION, None, "a torque"),
    ('"i < 2"', '"i < B"', DIMENSION, "B", "`<` combines"),
    ('unit = "mu_B"', 'unit = "meV"', DIMENSION, '"meV"', "the unit of `M`"),
    ('theta = "30 deg"', 'unit = "ps"\ntheta = 30', DIMENSION, '"ps"', "cannot be the unit of an angle"),
    ('theta = "30 deg"', 'unit = "deg"\ntheta = "30 + i"', MEASURE, '"30 + i"', "`unit` is that of numbers"),
    ('"30 deg"', '"30 ps"', MEASURE, '"30 ps"', "a start must be a number without a unit"),
    ('"1 meV ps", 0, 0', "1, 0, 0", DIMENSION, "1", "where an angular momentum is needed"),
    ('vectors = [["1 meV ps", 0, 0]]', "random = 1", MEASURE, "1", "gives `v` the length 1"),
    ('h = "1 fs"', "h = 0.001", MEASURE, "0.001", "a step must be a time, but this has no unit"),
    ('h = "1 fs"', 'h = "1 meV"', DIMENSION, '"1 meV"', "a step must be a time, but this is an energy"),
    ('time = "10 fs"', 'time = "10 nm"', DIMENSION, '"10 nm"', "a duration must be a time, but this is a length"),
    ('period = "2 fs"', "period = 2", MEASURE, "2", "a period of outputs must be a time"),
    ('after = "2 fs"', "after = 2", MEASURE, "2", "the time of the first sample must be a time"),
    ('J = "6 meV"', "J = 6", DIMENSION, "6", "where an energy is needed"),
]


def spec_with(old: str, new: str) -> str:
    assert FILM.count(old) >= 1, old
    return FILM.replace(old, new, 1)


def test_the_film_is_right():
    spec = load_text(FILM)
    assert spec.units and {p.name: p.unit for p in spec.parameters}["m"] == "meV/T"
    assert {o.name: o.unit for o in spec.observables} == {"M": "mu_B"} and len(WRONG) >= 30


@pytest.mark.parametrize("angles", ["theta = 30\nphi = 0", "theta = %s\nphi = %s" % ([30] * 16, [0] * 16)])
def test_angles_have_the_unit_of_their_start(angles):
    spec = load_text(spec_with('theta = "30 deg"\nphi = 0', f'unit = "deg"\n{angles}'))
    assert initial_state(spec, "up")[0] == pytest.approx([0.5, 0, 0.75 ** 0.5], abs=1e-15)


def test_a_number_for_an_angle_in_degrees_has_a_unit():
    """30 is 30 deg where it is declared: nowhere else does a bare number mean radians."""
    text = spec_with("n = 4\n", 'n = 4\nangle = { default = 30, unit = "deg" }\nturns = { default = 0.5, unit = "rad" }\n').replace("-K*w[i].z^2", "-K*w[i].z^2*cos(angle + turns)")
    spec = load_text(text)
    assert {p.name: (p.default, p.unit) for p in spec.parameters}["angle"] == (pytest.approx(math.pi / 6, abs=1e-15), "rad")
    assert parameter_values(spec, {"angle": "60 deg", "turns": Bare(2)})["angle"] == pytest.approx(math.pi / 3, abs=1e-15)
    with pytest.raises(UsageError, match="`angle` is in rad, but 60.0 has no unit"):
        parameter_values(spec, {"angle": Bare(60)})
    assert dict(load_text(text.replace('J = "6 meV"', 'angle = "60 deg", turns = 2')).runs[0].parameters)["angle"] == pytest.approx(math.pi / 3, abs=1e-15)
    with pytest.raises(SpecError, match="`angle` is in rad, but this number has no unit"):
        load_text(text.replace('J = "6 meV"', "angle = 60"))


def test_components_have_the_unit_of_their_start():
    spec = load_text(spec_with('vectors = [["1 meV ps", 0, 0]]', 'x = 2\ny = 0\nz = "1 meV ps"\nunit = "eV ps"'))
    assert initial_state(spec, "up")[-1].tolist() == [2000, 0, 1]


@pytest.mark.parametrize("old, new, code, at, cause", WRONG, ids=[f"{k}-{new.split(' = ')[-1][:24]}" for k, (_, new, *_) in enumerate(WRONG)])
def test_what_does_not_fit_is_refused(old, new, code, at, cause):
    text = spec_with(old, new)
    with pytest.raises(SpecError) as caught:
        load_text(text, "film.toml")
    one = caught.value.diagnostics[0]
    lines = text.split("\n")
    assert one.code == code and cause in one.cause and one.hint and one.file == "film.toml"
    assert lines[one.line - 1] == one.text
    here = one.text[one.column - 1:one.column - 1 + one.length].strip('"')
    assert at is None or here.startswith(at.strip('"'))


WORDS = ("w[i]", "w[i].z", "J", "K", "B", "T", "m", "t", "pi", "2", "0", "0.5", "1 meV", "2 T", "3 ps^2", "4 kg m", "1 K", "rad", "meV", "ps", "s^-1", "+", "-", "*", "/", "^", "(", ")", ",", "dot(",
         "vec(", "if(", "<", "exp(", "sqrt(", "max(", "norm(", "9" * 20, "1e200 J", "pulse(", "T^", "[", "]", "g[0]", ".x", " m", " mu_B", "1 m^99", "\u00b5T")


@settings(max_examples=120, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=14), st.booleans())
def test_any_formula_is_read_or_refused(words, spaced):
    """Never another exception than SpecError, and never an energy of another dimension."""
    text = FILM.replace("-K*w[i].z^2 - m*B*pulse(t - 1 ps)*w[i].x", (" " if spaced else "").join(words))
    try:
        spec = load_text(text)
    except SpecError as error:
        assert all(one.cause and one.hint for one in error.diagnostics)
    else:
        assert spec.units


@settings(max_examples=120, deadline=None)
@given(st.text(alphabet="0123456789.eE+-*/^ ()mVTKspJku_Bga\u00b5\\", max_size=40))
def test_any_value_is_read_or_refused(value):
    text = FILM.replace('"0.4 meV"', json.dumps(value))
    try:
        assert isinstance({p.name: p for p in load_text(text).parameters}["K"].default, (int, float))
    except SpecError as error:
        assert all(one.cause and one.hint for one in error.diagnostics)


def test_without_units_nothing_has_a_unit():
    """A number followed by a name stays the error that it was."""
    plain = '[model]\nname = "m"\n[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "2 meV*w.z"\n'
    with pytest.raises(SpecError) as caught:
        load_text(plain)
    assert "a product is written with `*`" in caught.value.diagnostics[0].hint and "[units]" in caught.value.diagnostics[0].hint
    with pytest.raises(SpecError) as caught:
        load_text(plain.replace("2 meV", "2").replace("sphere = 1", 'sphere = 1, moment = 1'))
    assert caught.value.diagnostics[0].code == MEASURE


def test_dimensionless_is_what_is_said_without_units():
    plain = '[model]\nname = "m"\n[space]\nw = { sphere = 1 }\n[parameters]\nJ = { default = 1.0, unit = "of exchange" }\n[effects.e]\nenergy = "J*w.z"\n'
    assert load_text(plain).units is None and load_text(plain + "[units]\ndimensionless = true\n").units is None
    assert load_text(plain + "[units]\n").parameters == load_text(plain).parameters
