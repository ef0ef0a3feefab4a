"""The dimension of every operation, seen by the unit of an observable; what follows of the vectors of each kind of factor."""
import re

import pytest

from smidgen.errors import SpecError
from smidgen.language.evaluate import evaluate
from smidgen.language.expr import SIGNATURES
from smidgen.read import load_text

pytestmark = pytest.mark.quick

HEAD = """
[model]
name = "m"

[units]
energy = "meV"
time = "ps"
field = "T"
length = "nm"

[parameters]
K = "0.4 meV"
J = "2 meV"
B = { default = [0, "1 T", "2 T"], vector = true }
x = "3 nm"
a = { default = 0.5, size = 4 }
k = 2
m = "1 mu_B"
"""
SPEC = HEAD + """
[space]
w = { sphere = 2, kappa = "1 hbar" }
v = { r3 = 1 }

[formulas]
"twice(q)" = "2*q"

[effects.e]
energy = "-K*w[0].z"

[effects.u]
energy = "dot(v, v)/(2 meV ps^2)"

[observables.o]
value = "{}"
"""

FOUND = [("K", "meV"), ("-K", "meV"), ("K + J", "meV"), ("K - 0", "meV"), ("K*J", "meV^2"), ("K/J", "1"), ("K^2", "meV^2"), ("K^(1/2)", "meV^(1/2)"), ("K^-1", "1/meV"), ("sqrt(K*J)", "meV"), ("sqrt(K)", "meV^(1/2)"),
         ("dot(B, w[0])", "T"), ("norm(B)", "T"), ("cross(B, B).x", "T^2"), ("triple(B, w[0], v)", "meV ps T"), ("vec(K, J, 0).y", "meV"), ("B.z", "T"), ("abs(K)", "meV"), ("min(K, J)", "meV"), ("max(0, J)", "meV"),
         ("mod(t, 2 ps)", "ps"), ("atan2(K, J)", "1"), ("if(t < 2 ps, K, J)", "meV"), ("floor(K/J)", "1"), ("exp(-t/(2 ps))", "1"), ("sin(pi*k)", "1"), ("cos(30 deg)", "1"), ("x^3*K", "meV nm^3"),
         ("t", "ps"), ("0.2 rad/ps", "1/ps"), ("2 nm/ps", "nm/ps"), ("1/t", "1/ps"), ("a[2]*K", "meV"), ("v.x", "meV ps"), ("dot(v, v)", "meV^2 ps^2"), ("w[1].x", "1"), ("twice(J)", "meV"), ("2 gamma*B.z", "1/ps"),
         ("1 hbar/t", "meV"), ("dot(m*B, w[0])", "meV"), ("m", "meV/T"), ("1 mu_B", "meV/T"), ("orthonormal_harmonics(a, w[0])", "1"), ("uniform(3, k)*K", "meV"), ("log(K/J) + tan(0) + acos(0.1)", "1"),
         ("if(K < J and not t > 1 ps or K == J, x, 2 nm)", "nm"), ("1 K", "meV"), ("300 K/K", "1"), ("1 k_B*K", "meV"), ("0", "1"), ("0*K", "1"), ("3 km", "nm")]


@pytest.mark.parametrize("formula, unit", FOUND, ids=[formula for formula, _ in FOUND])
def test_dimension(formula, unit):
    observable, = load_text(SPEC.replace("{}", formula)).observables
    assert observable.unit == unit


def test_all_operations_are_in_the_table():
    """But for the hyperbolic functions and the like, which are one entry of the rule."""
    said = " ".join(formula for formula, _ in FOUND)
    alike = {"sinh", "cosh", "tanh", "asin", "atan", "neg", "kept", "normal", "<=", ">=", "!="}
    assert [op for op in SIGNATURES if op not in alike and op not in said] == []


@pytest.mark.parametrize("function", ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "floor", "1 + ", "2^"])
def test_numbers_without_a_unit(function):
    with pytest.raises(SpecError, match="E321"):
        load_text(SPEC.replace("{}", f"{function}(K)"))


@pytest.mark.parametrize("value, number", [("K", 0.0004), ("1 T*m", 5.7883817982e-5), ("300 K", 0.025851999786)])
def test_an_observable_is_told_in_its_unit(value, number):
    text = SPEC.replace('value = "{}"', f'value = "{value}"\nunit = "eV"')
    observable, = load_text(text).observables
    values = {"K": 0.4, "m": 0.05788381798194}
    assert observable.unit == "eV" and float(evaluate(observable.value, values)) == pytest.approx(number, rel=1e-10)
    with pytest.raises(SpecError, match="the unit of `o`"):
        load_text(text.replace('"eV"', '"nm"'))


SPACES = [  # the family, its dimension by the unit of w.x, a fault, what is said of it
    ('w = { sphere = 1, moment = "1.72 mu_B" }', "1", 'moment = "1.72 mu_B"', 'moment = "1 nm"', "`moment` must be a moment"),
    ('w = { sphere = 1, kappa = "0.5 hbar" }', "1", "0.5 hbar", "0.5", "kappa is an angular momentum"),
    ('w = { sphere = 1, radius = "2 meV ps" }', "meV ps", "2 meV ps", "2 nm", "has no strength"),
    ('w = { sphere = 1, radius = "2 mu_B", kappa = "1 T ps" }', "meV/T", "1 T ps", "1 T", "kappa is"),
    ("w = { sphere = 1, fixed = true }", "1", "fixed = true", "fixed = false", "has no strength"),
    ("w = { r3 = 1 }", "meV ps", None, None, None),
    ('w = { r3 = 1, kappa = "2 hbar" }', "1", None, None, None),
    ('w = { nambu = 1, C = "(w.x^2 - w.y^2)/2" }', "meV ps", "w.y^2", "2 T*w.y^2", "combines"),
    ('w = { nambu = 1, C = "(w.x^2 - w.y^2)/2", kappa = "1 nm" }', "meV ps/nm", None, None, None),
    ('w = { nambu = 1, C = "(2 T)*w.x*w.y" }', "meV ps T", None, None, None),
]


@pytest.mark.parametrize("family, unit, old, new, said", SPACES, ids=[family for family, *_ in SPACES])
def test_vectors(family, unit, old, new, said):
    text = HEAD + f'[space]\n{family}\n[effects.e]\nenergy = "K*t/(1 ps)"\n[observables.o]\nvalue = "w.x"\n'
    assert load_text(text).observables[0].unit == unit
    if old:
        with pytest.raises(SpecError, match=re.escape(said)):
            load_text(text.replace(old, new))


@pytest.mark.parametrize("damping, code", [('"2/(1 meV ps)"', None), ("2", "E322"), ('"2 nm"', "E321")])
def test_damping_in_r3_has_the_unit_of_an_inverse_vector(damping, code):
    text = HEAD + f'[space]\nw = {{ r3 = 1 }}\n[effects.e]\nenergy = "dot(w, w)/(2 meV ps^2)"\n[effects.d]\nover = "site(i) of w"\ndamping = {damping}\n'
    if code is None:
        assert load_text(text).units
    else:
        with pytest.raises(SpecError, match=code):
            load_text(text)


PLACES = HEAD + """
[lattices.film]
name = "square"
size = [4, 3]
constant = "0.27 nm"
boundary = "open"

[space]
w = { sphere = "film", moment = "m" }

[effects.exchange]
over = "bond(i, j) of film.first"
energy = "-J*dot(w[i], w[j])*norm(r(i, j))/(0.27 nm)"

[effects.pulse]
over = "site(i) of w"
energy = "-m*B.z*exp(-norm(r(i))^2/x^2)*w[i].x"

[effects.edge]
over = "site(i) of w"
pinned = "r(i).y < 0.1 nm"

[observables.length]
over = "bond(i, j) of film.first"
value = "norm(r(i, j))"
"""


@pytest.mark.parametrize("old, new, said", [("/(0.27 nm)", "", "`energy` must be an energy"), ("^2/x^2)", ")", "the argument of `exp` is a length"), ("0.1 nm", "0.1", "`<` combines a length"),
                                            ('"0.27 nm"', "0.27", "combines a number without a unit and a length"), ('"0.27 nm"', '"0.27 ps"', "a lattice constant")])
def test_places_have_a_length(old, new, said):
    assert load_text(PLACES).observables[0].unit == "nm"
    with pytest.raises(SpecError, match=re.escape(said)):
        load_text(PLACES.replace(old, new, 1))
