"""Derivatives of any legal formula: within bounded work, without complex numbers, as an independent hand finds them."""
import math
import random

import numpy as np
import pytest
import smidgen
import sympy as sp
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from smidgen.language import limits
from smidgen.compile.derive.derivatives import NoRealValue, derive
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, SpecError, UsageError
from smidgen.language.expr import Op, walk
from smidgen.read import load_text
from smidgen.read.work import derivatives
from smidgen.check.witness import Witness

COPIES = 30         # nodes of all derivatives by parts for each operation that the limit counts
WHOLE = 50_000      # nodes of those of a formula that stays whole
STEP = 1e-4         # of differences
AT = np.array([[0.36, 0.48, 0.8], [-0.6, 0.0, 0.8], [0.48, -0.8, -0.36]])


def spec_of(energy, more="", sites=1):
    return load_text(f'[model]\nname = "m"\n[parameters]\na = 0.7\nz = {{ default = 0.0, fixed = true }}\n'
                     f'minus = {{ default = -1.0, fixed = true }}\nB = {{ default = [0.3, -0.5, 0.8], vector = true }}\n{more}'
                     f'[space]\nw = {{ sphere = {sites} }}\n[effects.e]\nenergy = "{energy}"\n')


# Numbers of a derivation, without C

NUMBERS = {"a": 0.7, "z": 0.0, "minus": -1.0, "t": 0.3}


def real(function):
    """The function as C has it: NaN or an infinity, no exception."""
    def call(*x):
        with np.errstate(all="ignore"):
            return float(function(*map(np.float64, x)))
    return call


OWN = {name: real(f) for name, f in {
    "absolute": np.abs, "signum": np.sign, "sign": np.sign, "floor_": np.floor, "lesser": np.fmin, "greater": np.fmax, "power": np.power,
    "chosen": lambda c, a, b: a if c else b,
    "plus": np.add, "minus": np.subtract, "times": np.multiply, "over": np.divide, "negative": np.negative,
    "sqrt": np.sqrt, "log": np.log, "exp": np.exp, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "atan2": np.arctan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh}.items()}


def numbers(derived):
    """w -> (value, gradient, Hessian) in double precision, the parts one after the other."""
    size = 3 * len(derived.slots)
    hessian = sp.zeros(size, size)
    for (k, l), block in derived.hessian.items():
        hessian[3 * k:3 * k + 3, 3 * l:3 * l + 3] = block
    everything = [derived.value, *(x for row in derived.gradient for x in row), *hessian]
    leaves = [sp.Symbol(name, real=True) for name in derived.leaves]
    given = [[0.3, -0.5, 0.8][node.index.value] if name.startswith("a.B") else NUMBERS[name.removeprefix("p.")]
             for name, node in derived.leaves.items()]
    call = sp.lambdify([*(x for v in derived.vectors for x in v), *leaves], everything, modules=[OWN, "math"], dummify=True,
                       cse=lambda all_: (list(derived.parts.items()), all_))

    def at(w):
        try:
            found = np.array(call(*map(np.float64, w.ravel()), *given), float)
        except (ArithmeticError, ValueError, TypeError):
            found = np.full(len(everything), math.nan)
        return found[0], found[1:1 + size].reshape(-1, 3), found[1 + size:].reshape(size, size)
    return at


def nodes(derived):
    """Nodes of all that is written out, each name one."""
    roots = [derived.value, *derived.parts.values(), *(x for row in derived.gradient for x in row),
             *(x for block in derived.hessian.values() for x in block)]
    return sum(1 for root in roots for _ in sp.preorder_traversal(sp.sympify(root)))


def check(energy, more="", sites=1, at=AT):
    """Derived in bounded work, and right; or refused, and then without a value anywhere."""
    try:
        spec = spec_of(energy, more, sites)
    except SpecError:
        return
    witness = Witness(spec)
    try:
        derived = derive(spec.effects[0])
    except NoRealValue as error:
        assert "`e`" in str(error) and not any(finite(witness, at[k:k + sites]) for k in range(4 - sites))
        return
    whole = [derived.value, *derived.parts.values(), *(x for row in derived.gradient for x in row), *derived.hessian.values()]
    assert not any(sp.sympify(e).has(sp.I, sp.re, sp.im, sp.arg, sp.Derivative, sp.Subs) for e in whole)
    assert nodes(derived) <= COPIES * derivatives(spec.effects[0].value) + (0 if derived.parts else WHOLE)
    ours = numbers(derived)
    for k in range(4 - sites):
        compare(derived, ours, witness, at[k:k + sites])


def finite(witness, w):
    try:
        return math.isfinite(witness.energy(w)) and bool(np.all(np.isfinite(witness.field(w))))
    except RunError:
        return False


def compare(derived, at, witness, w):
    """The gradient is the interpreter's, and both Hessian and gradient are differences, where these settle."""
    if not finite(witness, w):
        return
    value, gradient, hessian = at(w[[slot for _, slot in derived.slots]])
    if not np.all(np.isfinite(gradient)) and holds(derived.term.value, {"min", "max"}):
        return              # min(1, NaN) is 1 in C, and which slope it has is open
    theirs = np.array([witness.field(w)[slot] for _, slot in derived.slots]).reshape(gradient.shape)
    scale = max(1.0, np.abs(theirs).max(initial=0.0))
    assert value == pytest.approx(witness.energy(w), rel=1e-9, abs=1e-9)
    assert np.allclose(gradient, theirs, rtol=1e-7, atol=1e-9 * scale)
    for x in range(3 * len(w)):
        near, far = (slope(witness, w, x, h) for h in (STEP, 2 * STEP))
        if near is None or far is None or not np.allclose(near, far, rtol=1e-5, atol=1e-6 * scale):
            continue
        ours = np.append(gradient.ravel()[x], hessian[:, x]) if derived.slots == tuple(("w", k) for k in range(len(w))) else None
        assert ours is None or np.allclose(ours, near, rtol=1e-3, atol=1e-4 * max(scale, np.abs(near).max()))


def holds(e, operations) -> bool:
    return any(isinstance(node, Op) and node.op in operations for node in walk(e))


def slope(witness, w, x, h):
    """Central differences along component x: of the energy, then of the field."""
    out = []
    for sign in (1, -1):
        v = w.copy()
        v.flat[x] += sign * h
        if not finite(witness, v):
            return None
        out.append(np.append(witness.energy(v), witness.field(v)))
    return (out[0] - out[1]) / (2 * h)


# What sympy takes a complex, an infinite or a long way for

HOSTILE = [
    "sqrt(-w.x^2)", "(-w.x^2)^0.5", "(w.x^2)^0.5", "(w.x^2)^1.5", "((-2)*w.x)^0.3", "sqrt(-1 - w.x^2)", "a^0.5*sqrt(-a^2)*w.x",
    "sqrt(-(a + 1)^2)*w.x", "sqrt(-(sqrt(a) + w.x)^2)", "sqrt(minus*w.x^2)*w.y", "w.x/z", "log(minus)*w.x", "(-1)^w.x", "(-1)^floor(w.x)*w.y",
    "minus^w.x", "(-w.x)^(1/3)", "sqrt(-exp(w.x)*w.y)", "if(w.x > 5, sqrt(-w.x^2), w.y)", "(0*w.x)^-1", "(1 - 1)^w.x", "1/(w.x - w.x)",
    "log(w.x - w.x)", "atan2(w.y*0, w.x*0)*w.x", "atan2(-w.x^2, 0)", "atan2(w.x, w.y)^2", "asin(w.x^2 + 3)", "asin(w.x)*acos(w.y)",
    "mod(w.x, 0)", "mod(w.x, w.y)^2", "floor(3*w.x)*w.y^2", "abs(w.x)^3", "abs(abs(w.x) - 1)^1.5", "(-abs(w.x))^1.5", "norm(w)^0.3",
    "norm(0*w)", "norm(w - w)*w.x", "w.x^64", "(w.x + w.y + 1)^64", "((w.x + 2)^0.5)^64", "tan(w.x)^-64", "w.x^-0.5", "(w.x*w.y)^w.z",
    "min(w.x, max(w.y, w.z))^2", "if(w.x < 0.1, if(w.y < 0, w.x^2, w.y^3), floor(w.y) + mod(w.z, 0.3)^2)",
    "1/(2 + (3 + dot(w + B, w)^2)^2)", "1/(2 + (3 + (1 + dot(w + B, w)^2)^2)^2)^3"]
NESTED = [
    "1/(2 + " * 20 + "w.x*w.y" + ")" * 20, "sin(w.x + " * 20 + "w.y" + ")" * 20, "(1.5 + w.z + " * 12 + "w.x" + ")^0.7" * 12,
    "(w.x + 0.1*" * 12 + "w.y" + ")^2" * 12, "cross(w, cross(B, " * 6 + "w" + "))" * 6 + ".x", "sqrt(1 + w.x*" * 15 + "w.y" + ")" * 15,
    "if(w.x < 2, w.y + 0.5*" * 12 + "w.z^2" + ", 1)" * 12, "max(w.x, -0.9*" * 12 + "w.y" + ")" * 12, "atan2(w.x, 2 + " * 10 + "w.y" + ")" * 10]


SHORT = {"sqrt(-w.x^2)", "(w.x^2)^0.5", "w.x/z", "atan2(w.y*0, w.x*0)*w.x", "(-1)^w.x", "sqrt(-(sqrt(a) + w.x)^2)", "1/(2 + (3 + dot(w + B, w)^2)^2)"}


def long_but(energies, short):
    return [pytest.param(e, marks=pytest.mark.quick if e in short else pytest.mark.long) for e in energies]


@pytest.mark.parametrize("energy", long_but(HOSTILE, SHORT))
def test_what_sympy_has_no_real_way_for(energy):
    check(energy)


@pytest.mark.parametrize("energy", long_but(NESTED, NESTED[-1:]))
def test_nested_formulas_are_derived_by_parts(energy):
    assert derive(spec_of(energy).effects[0]).parts
    check(energy)


@pytest.mark.parametrize("energy", long_but(HOSTILE, SHORT))
def test_every_hostile_formula_is_written_as_c(energy):
    try:
        files = generate(spec_of(energy))
    except UsageError as error:
        assert "finite real value" in str(error)
    else:
        assert "zoo" not in files["m.c"] and "nan;" not in files["m.c"]


# The same in C

MANY = {"once": NESTED[0], "sines": NESTED[1], "rest": "sin(a + " * 9 + "w.x*w.y*t" + ")" * 9 + " + w.z*" + "cos(a + " * 9 + "B.x" + ")" * 9}


def test_parts_are_the_same_in_c():
    """Energies, field and a step: early parts are kept with the coefficients, the others are statements."""
    effects = "".join(f'[effects.{name}]\nenergy = "{e}"\n' for name, e in MANY.items())
    spec = spec_of("0.1*w.z", effects)
    witness, model, w = Witness(spec), smidgen.build(spec, features=["extended"]), AT[:1]
    begun = model.start(w.copy(), t0=0.3, h=0.05)
    assert np.allclose(begun.field(w, 0.3), witness.field(w, 0.3), rtol=1e-13, atol=1e-14)
    assert begun.energy(w, 0.3) == pytest.approx(witness.energy(w, 0.3), rel=1e-14)
    assert np.abs(begun.step().state() - witness.step(w, 0.3, 0.05)).max() < 1e-14


@pytest.mark.quick
def test_the_deepest_formula_that_is_allowed_and_an_observable_without_derivatives():
    """A hundred functions inside each other: no recursion ends, and an observable is never differentiated."""
    def inside(depth):
        return "[formulas]\nf0 = 'w.x'\n" + "".join(f"f{k + 1} = 'sin(w.y*f{k})'\n" for k in range(depth))
    deep, seen = spec_of("f38", inside(38)), spec_of("w.z", inside(38) + "[observables.o]\nvalue = 'f38'\n")
    found, value = derive(deep.effects[0]), derive(seen.observables[0], with_derivatives=False)
    assert nodes(found) <= COPIES * derivatives(deep.effects[0].value)
    assert value.gradient == () and value.hessian == {} and nodes(value) <= 5 * 150
    compare(found, numbers(found), Witness(deep), AT[:1])


# Any formula

@st.composite
def formulas(draw, depth=4):
    """Legal text: components, numbers and parameters, joined by whatever is hard."""
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        return draw(st.sampled_from(["w.x", "w.y", "w.z", "w[1].x", "w[1].z", "a", "z", "minus", "2", "0.5", "-3", "dot(w[1], w)", "norm(w - B)"])
                    ).replace("w.", "w[0].").replace("w)", "w[0])").replace("w -", "w[0] -")
    inside = [draw(formulas(depth=draw(st.integers(0, depth - 1)))) for _ in range(3)]
    form = draw(st.sampled_from([
        "({0} + {1})", "({0} - {1})", "({0})*({1})", "({0})/({1})", "1/(2 + ({0})^2)", "1/({0})", "({0})^2", "({0})^-3", "({0})^0.5", "({0})^1.5",
        "({0})^-0.7", "(({0})^2)^0.5", "({0})^({1})", "({0})^31", "sqrt({0})", "sqrt(-({0})^2)", "log({0})", "log(-({0}))", "asin({0})", "acos({0})",
        "exp({0})", "sin({0})", "tan({0})", "atan2({0}, {1})", "abs({0})", "floor({0})", "mod({0}, {1})", "min({0}, {1})", "max({0}, {1})",
        "if({0} < {1}, {2}, {1})", "if({0} == {1} or not {2} > 0, {2}, 1)", "cross(w[0], vec({0}, {1}, {2})).x", "-({0})"]))
    return form.format(*inside)


@pytest.mark.long
@settings(max_examples=80, deadline=None, derandomize=True, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(energy=formulas())
def test_any_formula_is_derived_or_refused(energy):
    check(energy + " + 0*w[1].x + w[0].y", sites=2)


# Branches inside branches: conditions that sympy's own pieces rewrite for ever

OFF_EDGES = np.array([[0.3571, 0.4841, 0.7988], [-0.6031, 0.0917, 0.7924], [0.4779, -0.8013, -0.3599]])     # no abs(w.y) at 0

ENDLESS = ["min(w.y + 0.04*w.z, w.z - 0.3*w.x)", "max(0.7*w.x - 0.04*w.z, w.z - 0.3*w.x)*w.y",
           "if(w.y + 0.04*w.z <= w.z - 0.3*w.x, w.x^2, w.y)", "min(abs(w.x - 0.3*w.y), max(w.z, if(w.x < 0.2*w.z, w.y, w.x*w.z)))"]


def branches(draw, depth):
    """Text of random branches over lines with coefficients of two digits."""
    if depth == 0:
        return " + ".join(f"{draw.choice((-1, 1))*draw.randint(1, 99)/100}*w.{axis}" for axis in draw.sample("xyz", draw.randint(1, 3)))
    a, b, c, d = (branches(draw, draw.randrange(depth)) for _ in range(4))
    test = draw.choice(["{0} < {1}", "{0} <= {1}", "{0} > {1} and {1} < {2}", "{0} >= {1} or {1} > 0.3*a", "not {0} < {1}"]).format(a, b, c)
    return draw.choice([f"min({a}, {b})", f"max({a}, {b})", f"if({test}, {c}, {d})", f"abs({a})", f"({a})*({b})", f"({a})^2 + ({b})", f"mod({a}, 0.37)"])


@pytest.mark.quick
@pytest.mark.parametrize("energy", ENDLESS)
def test_branches_are_differentiated_one_by_one(energy):
    check(energy)


@pytest.mark.parametrize("seed", [pytest.param(s, marks=pytest.mark.long if s else pytest.mark.quick) for s in range(10)])
def test_random_branches_are_those_of_the_witness(seed):
    draw = random.Random(seed)
    for _ in range(25):
        check(branches(draw, 3) + " + 0.1*w.x", at=OFF_EDGES)


def test_branches_are_the_same_in_c():
    """Scalar text, lanes and extended precision."""
    draw = random.Random(1)
    effects = "".join(f'[effects.e{k}]\nenergy = "{e}"\n' for k, e in enumerate([*ENDLESS, *(branches(draw, 3) for _ in range(12))]))
    spec = spec_of("0.1*w.z", effects)
    witness, first = Witness(spec), OFF_EDGES[:1] / np.linalg.norm(OFF_EDGES[0])
    for method, features in (("spherical-midpoint", ["extended"]), ("gauss-4", [])):
        begun = smidgen.build(spec, method=method, features=features).start(first.copy(), t0=0.3, h=1e-3)
        for w in OFF_EDGES:
            assert np.allclose(begun.field(w[None], 0.3), witness.field(w[None], 0.3), rtol=1e-12, atol=1e-13)
        assert np.abs(begun.step().state() - witness.step(first, 0.3, 1e-3, method)).max() < 1e-14


# The bound

def chain(count):
    return "*".join(["w.x"] * count)


@pytest.mark.quick
def test_the_limit_of_work_at_its_edge(monkeypatch):
    count = derivatives(spec_of(chain(9)).effects[0].value)
    assert count == 8 * (1 + 3 + 6)
    for limit, energy in ((count, chain(9)), (count - 1, chain(9)), (count, chain(10))):
        monkeypatch.setattr(limits, "DERIVATIVES", limit)
        if (limit, energy) == (count, chain(9)):
            spec_of(energy)
            continue
        with pytest.raises(SpecError, match="E311.*derivatives of `e`") as error:
            spec_of(energy)
        assert "several effects" in str(error.value)


@pytest.mark.quick
@pytest.mark.parametrize("energy, count", [
    ("w.x + w.y + w.z", 2 * 4), ("dot(w, B)", 5 * 10), ("cross(w, B).x", 9 * 10), ("a*a + 2", 1 + 1), ("sin(w.x)*a", 2 * 10),
    ("dot(w + B, 2*w)", 3 * 4 + 3 * 10 + 5 * 10)])
def test_what_is_counted(energy, count):
    assert derivatives(spec_of(energy).effects[0].value) == count


@pytest.mark.quick
def test_the_largest_formula_that_is_allowed_is_refused_where_it_joins_many_vectors():
    """4000 operations and operands of eight vectors: refused when read, before any derivative."""
    lines = "[formulas]\ng = '" + "*".join(f"dot(w[{k % 8}], w[{(k + 1) % 8}])" for k in range(60)) + "'\nh = 'g + 1/(1 + g*g)'\n"
    with pytest.raises(SpecError, match="E311"):
        spec_of("h*h + sin(h)", lines, sites=8)


@pytest.mark.parametrize("real", ["double", "long double"])
def test_remainders_of_whole_numbers_are_exact(real):
    """49*(1/49) < 1 in double, 3*(1/3) < 1 in extended precision."""
    spec = smidgen.load_text('[model]\nname = "rests"\n[space]\nw = { sphere = 200 }\n[effects.e]\nover = "site(i) of w"\n'
                             'energy = "(mod(i, 3) + 10*mod(i, 49) + 1000*mod(2*i, 7) + 10000*floor(i/11))*w[i].z"\n')
    w = np.tile([0.0, 0.0, 1.0], (200, 1))
    field = smidgen.build(spec, real=real).start(w, h=0.1).field()[:, 2]
    i = np.arange(200)
    assert np.array_equal(field, i % 3 + 10 * (i % 49) + 1000 * (2 * i % 7) + 10000 * (i // 11))


@pytest.mark.parametrize("real", ["double", "long double"])
def test_jumps_are_where_they_are_in_double_precision(real):
    """0.7*10 is 7 in double precision, and less in extended precision."""
    spec = smidgen.load_text('[model]\nname = "sides"\n[space]\nw = { sphere = 200 }\n[effects.e]\nover = "site(i) of w"\n'
                             'energy = "(floor(0.7*i) + 1000*if(0.7*i - 7 < 0, 1, 0) + 2000*abs(0.7*i - 7))*w[i].z"\n')
    w = np.tile([0.0, 0.0, 1.0], (200, 1))
    field = smidgen.build(spec, real=real).start(w, h=0.1).field()[:, 2]
    i = np.arange(200)
    np.testing.assert_allclose(np.asarray(field, float), np.floor(0.7 * i) + 1000 * (0.7 * i - 7 < 0) + 2000 * np.abs(0.7 * i - 7), atol=1e-9)


def test_thirds_have_all_digits_of_a_long_double():
    spec = smidgen.load_text('[model]\nname = "thirds"\n[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "w.x/3 + w.z/7"\n')
    model = smidgen.build(spec, real="long double").start(np.array([[0.6, 0, 0.8]]), h=0.1)
    x, _, z = model.w[0]
    assert abs(model.energy() - (x / 3 + z / 7)) <= np.finfo(np.longdouble).eps
    assert np.array_equal(model.field()[0], [np.longdouble(1) / 3, 0, np.longdouble(1) / 7])


@pytest.mark.quick
def test_what_branches_give_is_a_real_number():
    """A comparison with an `if` in it is rewritten by sympy, which refuses what may be complex."""
    text = """[model]
name = "branched"
[space]
w = { sphere = 2 }
[parameters]
q = 0.7
D = { default = [0.2, 0.7, -0.4], vector = true }
[effects.e]
over = "site(i) of w"
energy = "min(dot(w[i] + D, w[i]), if(w[i].z < -0.6, mod(t, q), cos(t)) - dot(w[i], D))"
"""
    assert generate(smidgen.load_text(text), features=("tangent",))
