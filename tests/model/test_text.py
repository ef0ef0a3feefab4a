"""Expressions of sympy as formulas: what they say is what the reader of specs understands."""
import math

import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from smidgen.language.evaluate import evaluate
from smidgen.language.spec import Parameter
from smidgen.model.text import formula
from smidgen.read import given as read

pytestmark = pytest.mark.quick
a, b, c = sympy.symbols("a b c", real=True)
VALUES = {"a": 0.7, "b": -1.3, "c": 2.1}
EXACT = {sympy.Symbol(name, real=True): sympy.Rational(str(v)) for name, v in VALUES.items()}
PARAMETERS = tuple(Parameter(name, "real", value) for name, value in VALUES.items())


def value(text: str) -> float:
    return float(evaluate(read.formula(text, "test", PARAMETERS), VALUES))


@pytest.mark.parametrize("expression, text", [
    (a - b, "a - b"), (-a, "-a"), (-(a + b)*c, "c*(-a - b)"), (a/b, "a/b"), (a/(b*c), "a/b/c"), (a**-2, "1/a^2"), (sympy.sqrt(a + c), "sqrt(a + c)"),
    (sympy.Rational(2, 3)*a, "2*a/3"), (a**sympy.Rational(3, 2), "a^(3/2)"), ((a + b)**2, "(a + b)^2"), (a**(c**b), "a^(c^b)"), ((a**2)**b, "abs(a)^(2*b)"), ((1 + a)**2*(a - b)**3/(2 - a), "(a + 1)^2*(a - b)^3/(2 - a)"), (-(a**2), "-a^2"),
    ((-a)**3, "-a^3"), (2.5*a, "2.5*a"), (-0.5 + a, "a - 0.5"), (sympy.pi*a, "pi*a"), (sympy.exp(1), "exp(1)"), (sympy.exp(-a), "exp(-a)"), (sympy.Abs(a), "abs(a)"),
    (sympy.Mod(a, b), "mod(a, b)"), (sympy.atan2(a, b), "atan2(a, b)"), (sympy.Max(a, b, c), None), (sympy.sign(a), "if(a > 0, 1, if(a < 0, -1, 0))"),
    (sympy.Piecewise((a, a > b), (b, sympy.And(a < 1, b < 2)), (c, True)), None), (sympy.Integer(-3), "-3"), (1e-300*a, "1e-300*a"), ("a*w[i].z", "a*w[i].z"),
    (a/sympy.Integer(10)**18, "a/1e+18"), (sympy.Integer(2)**53*a, "9007199254740992*a"), (sympy.Rational(10**20, 3)*a, "1e+20*a/3")])
def test_texts(expression, text):
    said = formula(expression)
    assert text is None or said == text
    if not isinstance(expression, str):
        assert math.isclose(value(said), float(sympy.N(sympy.sympify(expression).subs(EXACT), 30)), rel_tol=1e-14)


LEAVES = st.sampled_from([a, b, c, sympy.Integer(2), sympy.Integer(-3), sympy.Rational(1, 3), sympy.Float(0.25), sympy.pi])


def joined(parts):
    pairs = st.tuples(parts, parts)
    return st.one_of(
        pairs.map(lambda p: p[0] + p[1]), pairs.map(lambda p: p[0] - p[1]), pairs.map(lambda p: p[0]*p[1]), pairs.map(lambda p: p[0]/(1 + p[1]**2)),
        parts.map(lambda p: p**2), parts.map(lambda p: p**-3), parts.map(lambda p: sympy.sqrt(1 + p**2)), parts.map(sympy.sin), parts.map(sympy.atan),
        parts.map(sympy.Abs), parts.map(lambda p: -p), pairs.map(lambda p: sympy.Max(*p)), pairs.map(lambda p: sympy.Piecewise((p[0], p[1] > 0), (p[1], True))))


def in_doubles(expression) -> float:
    """The value by arithmetic of doubles, as sympy writes it: far from the exact one where rounding is magnified."""
    try:
        return float(sympy.lambdify((a, b, c), expression, "math")(*VALUES.values()))
    except (ArithmeticError, ValueError, TypeError):
        return math.nan


@settings(max_examples=150, deadline=None)
@given(st.recursive(LEAVES, joined, max_leaves=8))
def test_a_formula_has_the_value_of_the_expression(expression):
    assume(not expression.has(sympy.zoo, sympy.oo, -sympy.oo, sympy.nan, sympy.AccumBounds))    # of 1/0, and what comes of it
    exact = complex(sympy.N(expression.subs(EXACT), 30))
    assume(not exact.imag and 1e-100 < abs(exact.real) < 1e100 and math.isclose(in_doubles(expression), exact.real, rel_tol=1e-11))
    assert math.isclose(value(formula(expression)), exact.real, rel_tol=1e-8)
