"""The intermediate form: trees of integers, loops and kernels, what they say of themselves, and the printers that write them."""
import ast
import re
from pathlib import Path

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from smidgen.compile.assemble.functions import definitions
from smidgen.compile.assemble.model import Model
from smidgen.compile.assemble.parts import PARTS
from smidgen.compile.assemble.plain import PLAIN, macro
from smidgen.compile.emit.print_scalar import Scalar
from smidgen.compile.emit.print_wide import elementary
from smidgen.compile.emit.targets import PRINTERS, printed
from smidgen.compile.lower.code import (Add, Argument, Assign, At, Call, Component, Constant, Element, For, Function, Held, If, Let, Local, Name,
                                        Ordered, Parameter, Real, Return, Scope, Table, Value, Zeros, mentions, needed, refuse, tidy, walk, where, written)
from smidgen.compile.lower.integers import ONE, ZERO, Cell, Field, Given, Index, Size, Whole, compare, modulo, quotient, remainder, times, total, wrapped
from smidgen.compile.lower.trim import trim
from smidgen.compile.plan.plan import choose
from smidgen.methods import DEFAULT
from smidgen.read import load_text
from support.systems import load

pytestmark = pytest.mark.quick
ROOT = Path(__file__).parents[2]
SCALAR = PRINTERS["scalar"]
I, J, N, P = Index("i"), Index("j"), Size("n0"), Given("n")
X, Y = sp.symbols("x y", real=True)


# Integers

@pytest.mark.parametrize("e, text", [
    (3 * I, "3*i"), (1 * I, "i"), (0 * I, "0"), (I - 0, "i"), (I + 0, "i"), (I - I, "0"), (I + I, "2*i"), (I + 2 - 3, "i - 1"),
    (2 + I, "i + 2"), (N - 1, "c->model->n0 - 1"), (3 * (N + I), "3*(c->model->n0 + i)"), (J - (I - 2), "j - i + 2"), (-1 * I, "-i"), (I - 2 * J, "i - 2*j"),
    (2 * (3 * I), "6*i"), (I * J * 2, "2*i*j"), (total(), "0"), (times(), "1"), (N * (I + N * J), "c->model->n0*(i + c->model->n0*j)"),
    (times(I + 1, J + 1), "(i + 1)*(j + 1)"), (-1 * times(I, J + 1), "-i*(j + 1)"), (J - I * (J + 1), "j - i*(j + 1)"), (wrapped(I - 1, N), "smg_wrap(i - 1, c->model->n0)"),
    (modulo(P, 2) + 1, "smg_mod(c->model->p.n, 2) + 1"), (remainder(I, 1), "0"), (quotient(I, 1), "i"), (remainder(I + 1, N), "(i + 1) % c->model->n0"),
    (2 * quotient(I, 2), "2*(i / 2)"), (Cell("edge", (I + 1, ONE)), "edge[i + 1][1]"), (Field("at", "k") - 3, "at.k - 3")])
def test_integers_are_simplified_and_printed(e, text):
    assert SCALAR(e) == text


trees = st.recursive(st.one_of(st.integers(-3, 3).map(Whole), st.sampled_from([I, J, N])),
                     lambda inside: st.tuples(st.sampled_from("+-*"), inside, inside).map(lambda t: {"+": lambda a, b: a + b, "-": lambda a, b: a - b,
                                                                                                     "*": lambda a, b: a * b}[t[0]](t[1], t[2])), max_leaves=12)
AT = {"i": 5, "j": -7, "n0": 11}


def value(e):
    """The number that an expression is, by its nodes."""
    if isinstance(e, Whole):
        return e.value
    if hasattr(e, "terms"):
        return sum(map(value, e.terms))
    if hasattr(e, "factors"):
        product = 1
        for f in e.factors:
            product *= value(f)
        return product
    return AT[e.name]


@settings(max_examples=200, deadline=None, derandomize=True)
@given(trees, trees)
def test_simplified_integers_keep_their_value(a, b):
    """What is printed, too: blanks, signs and brackets say the same as the tree."""
    for e, number in ((a + b, value(a) + value(b)), (a - b, value(a) - value(b)), (a * b, value(a) * value(b))):
        assert value(e) == number == eval(SCALAR(e).replace("c->model->", ""), {}, dict(AT))


def test_equal_integers_are_equal():
    """As keys, too: a size has one name however it was written."""
    assert I + 1 == total(1, I) and hash(I + 1) == hash(total(1, I)) and 2 * N == N * 2 and I + J != I - J


@pytest.mark.parametrize("left, op, right, truth", [(ONE, "<", 1, False), (Whole(3), ">=", 3, True), (Whole(2), "!=", 3, True), (Whole(2), "==", 3, False)])
def test_comparisons_of_numbers_are_decided(left, op, right, truth):
    assert compare(left, op, right) is truth
    assert refuse(truth) == ((Return(Name("SMG_BAD_PARAMETER")),) if truth else ())


def test_a_check_that_cannot_fail_is_none():
    assert refuse(False, False) == () and len(refuse(False, compare(N, "<", 1))) == 1
    assert SCALAR.lines(refuse(compare(N, "<", 1), compare(N, ">", 9))) == ["if (c->model->n0 < 1 || c->model->n0 > 9) return SMG_BAD_PARAMETER;"]


# Statements

def lines(*statements):
    return SCALAR.lines(statements)


def test_scopes_that_keep_nothing_apart_are_dissolved():
    one, other, same = Let("a", I), Let("b", J), Let("a", J)
    assert tidy([Scope((one,)), other]) == (one, other)
    assert tidy([Scope((Scope((one,)),))]) == (one,)
    assert tidy([Scope((one,)), Scope((same,))]) == (Scope((one,)), Scope((same,)))


def test_a_scope_stays_where_a_deeper_name_would_be_hidden():
    """-Wshadow: the loop declares what the scope does."""
    loop = For("a", ZERO, N, (Call("f", (Index("a"),)),))
    assert tidy([Scope((Let("a", I),)), loop]) == (Scope((Let("a", I),)), loop)


def test_loops_and_tests():
    body = (Call("f", (At(Name("w"), 3 * I), At(Name("g"), ZERO, True))),)
    assert lines(For("i", ZERO, N, body)) == ["for (int64_t i = 0; i < c->model->n0; ++i) f(w + 3*i, g);"]
    assert lines(For("j", ZERO, N, (For("i", ZERO, N, body),))) == ["for (int64_t j = 0; j < c->model->n0; ++j)", "  for (int64_t i = 0; i < c->model->n0; ++i) f(w + 3*i, g);"]
    assert lines(For("i", ZERO, N, (*body, *body))) == ["for (int64_t i = 0; i < c->model->n0; ++i) {", "  f(w + 3*i, g);", "  f(w + 3*i, g);", "}"]
    assert lines(For("i", J, N, (), step=2))[0] == "for (int64_t i = j; i < c->model->n0; i += 2) {"
    assert lines(where([compare(I, "<", N), compare(I, "<", N)], body))[0] == "if (i < c->model->n0) {"
    assert lines(where([True], body)) == ["{", "  f(w + 3*i, g);", "}"]
    assert lines(If((compare(I, "==", ZERO),), (Return(ONE),))) == ["if (i == 0) return 1;"]


@pytest.mark.parametrize("expr, text", [(2 * X, "+= 2.0*x;"), (-2 * X, "-= 2.0*x;"), (sp.Float(-1.5), "-= 1.5;"), (X - Y, "+= x - y;"), (-X, "-= x;")])
def test_minus_signs_of_additions(expr, text):
    assert lines(Add(Component("g0", 1), Real(expr, {"x": Local("x"), "y": Local("y")}))) == [f"g0[1] {text}"]


def test_what_is_ordered_keeps_its_brackets():
    a, b, c = map(Name, "abc")
    assert SCALAR(Ordered("-", a, Ordered("-", b, c))) == "a - (b - c)"
    assert SCALAR(Ordered("-", Ordered("-", a, b), c)) == "a - b - c"
    assert SCALAR(Ordered("*", Ordered("+", a, b), c)) == "(a + b)*c"
    assert SCALAR(Ordered("/", a, Ordered("*", b, c))) == "a / (b*c)"


def test_names_numbers_arrays_and_tables():
    assert lines(Zeros("o1", 3), Let("i", Index("s0")), Assign(Element("n", 2), Element("v", 2))) == [
        "smg_real o1[3] = {0, 0, 0};", "const int64_t i = s0;", "n[2] = v[2];"]
    assert printed(Table("edge", "int64_t", ((0, 1), (1, 2)), columns=2)) == "static const int64_t edge[][2] = {{0, 1}, {1, 2}};"
    assert printed(Table("weight", "double", (1, 0.1))) == "static const double weight[] = {1.0, 0.1};"


# Leaves and targets

LEAVES = {"a": Component("v0", 2), "b": Parameter("ga", I), "c": Constant(-0.5), "d": Held("k3", "wide"), "e": Local("x0"), "f": Local("weight_J", exact=True), "g": I}
SHOWN = {"model": ["v0[2]", "model->p.ga[i]", "-0.5", "wide->k3", "x0", "weight_J", "(smg_real)i"],
         "scalar": ["v0[2]", "c->model->p.ga[i]", "-0.5", "wide->k3", "x0", "weight_J", "(smg_real)i"],
         "value": ["v0.z", "c->model->p.ga[i]", "-0.5", "wide->k3", "x0", "weight_J", "(smg_real)i"],
         "lanes": ["v0[2]", "c->model->p.ga[i]", "-0.5", "wide->k3", "x0", "weight_J", "(smg_real)i"],
         "lanes by value": ["v0.z", "c->model->p.ga[i]", "smg_lane_of(-0.5)", "wide->k3", "smg_lane_of(x0)", "smg_lane_of(weight_J)", "smg_lane_of((smg_real)i)"],
         "wide": ["smg_wide_load(v0, 2)", "smg_wide_of(c->model->p.ga[i])", "smg_wide_of(-0.5)", "wide->k3", "x0", "smg_wide_of(weight_J)", "smg_wide_of((smg_real)i)"]}


@pytest.mark.parametrize("target", PRINTERS)
def test_leaves_of_every_target(target):
    assert [PRINTERS[target](Real(sp.Symbol(name), LEAVES)) for name in LEAVES] == SHOWN[target]


def test_a_negative_constant_is_bracketed_in_a_product():
    """`x - -0.5` would be read, `--0.5` would not."""
    assert SCALAR(Real(-sp.Symbol("c"), LEAVES)) == "-(-0.5)"


FORCE = Function("void", "force", (Argument("const smg_coefficients *", "c"), Argument("int64_t", "i"), Argument("const smg_real *", "v0"), Argument("smg_real *", "g0")),
                 (Value("x0", Real(X * Y, {"x": Component("v0", 0), "y": Held("k0", "c")})), Add(Component("g0", 0), Real(-X, {"x": Local("x0")}))))


def test_one_function_in_every_target():
    """The tree says nothing of the arithmetic; a further target is one class."""
    class Lanes(Scalar):
        real = "lanes"

        def do_add(self, s):
            return [f"{self(s.target)} = lanes_add({self(s.target)}, {self(s.value)});"]

    assert [printer.define(FORCE).splitlines()[1:] for printer in (SCALAR, PRINTERS["wide"], Lanes())] == [
        ["  (void)i;", "  const smg_real x0 = v0[0]*c->k0;", "  g0[0] -= x0;", "}"],
        ["  (void)i;", "  const smg_wide x0 = smg_wide_mul(smg_wide_load(v0, 0), c->k0);", "  smg_wide_into(g0, 0, smg_wide_neg(x0));", "}"],
        ["  (void)i;", "  const lanes x0 = v0[0]*c->k0;", "  g0[0] = lanes_add(g0[0], -x0);", "}"]]


def test_which_function_is_needed_and_what_it_mentions():
    caller = Function("void", "caller", (), (Call("force", (Name("c"), I, Name("v"), At(Name("g"), 3 * I, True))),))
    assert mentions(*FORCE.body) == {"c", "v0", "x0", "g0"} and mentions(caller) == {"force", "c", "i", "v", "g"}
    assert needed([FORCE, caller], {"caller"}) == [FORCE, caller] and needed([FORCE, caller], {"other"}) == []


@pytest.mark.parametrize("expr, takes", [(X * Y, False), (sp.sqrt(X), False), (X ** -3, False), (X ** sp.Rational(3, 2), False), (sp.exp(X), True),
                                         (1 / sp.sin(X), True), (X ** sp.Float(0.3), True), (X ** sp.Rational(-1, 3), True), (X ** 12, True)])
def test_elementary_functions_are_seen_in_the_data(expr, takes):
    """What the header of elementary functions is included for, as the printer will call them."""
    node = Value("x0", Real(expr, {"x": Local("x"), "y": Local("y")}))
    calls = PRINTERS["wide"].lines([node])[0]
    assert elementary([node]) is takes is any(f"smg_wide_{name}(" in calls for name in ("exp", "sin", "pow"))


# Whole models

BY_SITE = """
[model]
name = "logs"
[space]
w = { sphere = 1600 }
[effects.all]
over = "bond(i, j) of square(40, 40, periodic)"
energy = "log(0.1 + dot(w[i], w[j])^2)/w[i].z"
[starts.a]
random = 1
"""


def functions(name, **how):
    spec = load_text(BY_SITE) if name == "by site" else load(name)
    return {f.name: f for f in definitions(Model(spec, choose(spec, DEFAULT, "auto"), **how))[0] if isinstance(f, Function)}


def loops_of(f):
    return [node for node in walk(f) if isinstance(node, For)]


def test_who_writes():
    """A sum over bonds writes at both ends; of one site alone it writes there; sweeps go over colours, then over cells."""
    chain = functions("heisenberg_chain")
    assert written(chain["smg_gradient"]) == {At(Name("g"), 3 * I, True), At(Name("g"), 3 * J, True)}
    assert written(functions("by site")["smg_gather"]) == {At(Name("g"), ZERO, True)}
    assert written(chain["effect_exchange_gradient"]) == {Component(f"g{k}", a) for k in range(2) for a in range(3)}
    assert [loop.over for loop in loops_of(chain["smg_gradient"])] == ["cells"]
    assert {loop.over for loop in loops_of(functions("by site")["smg_each_coloured"])} == {"cells", "colours"}
    assert loops_of(functions("point_vortices")["smg_gradient"])[0].over == "pairs"


def test_what_a_kernel_reads():
    names = mentions(functions("free_rigid_body")["effect_rotation_gradient"])
    assert names == {"c", "v0", "g0"}


def test_targets_of_a_single_sphere():
    found = functions("free_rigid_body", features=("extended",))
    assert {f.target for f in found.values()} == {"scalar", "model", "value", "wide"}
    assert found["smg_motion"].target == "value" and found["wide_effect_rotation_gradient"].target == "wide"


@pytest.mark.parametrize("features", [(), ("extended", "tangent")])
@pytest.mark.parametrize("name", ["heisenberg_chain", "product", "vortex_tracers", "honeycomb"])
def test_nothing_is_kept_that_nothing_mentions(name, features):
    """And each follows what it mentions: the C needs no declarations before."""
    spec = load(name)
    found, _ = definitions(Model(spec, choose(spec, DEFAULT, "auto"), features))
    place = {d.name: k for k, d in enumerate(found)}
    assert len(place) == len(found)
    assert all(place.get(other, -1) < k for k, d in enumerate(found) for other in mentions(d) if other != d.name and not isinstance(d, Table))


# The rule: what is printed stays as it is

PRINTED = ("replace", "sub", "split", "removeprefix", "removesuffix", "findall", "search", "match", "startswith")
TEXTS = {"amalgamate.py", "includes.py", "memory.py", "text.py"}      # headers of the runtime as they are, members of structs, texts of users in comments
SPARED = {"solo.py": {"replace"}, "by_site.py": {"replace"}, "indices.py": {"startswith"}}      # of sympy; of an index's name in a spec


@pytest.mark.parametrize("path", sorted((ROOT / "gen/compile").glob("[aelp]*/*.py")), ids=lambda p: f"{p.parent.name}/{p.name}")
def test_no_text_is_edited_or_searched(path):
    """Neither `re` nor the methods of strings that look into a text; `dataclasses.replace` and sympy's are no such."""
    tree = ast.parse(path.read_text())
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    called = {node.func.attr for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)}
    if path.name not in TEXTS:
        assert "re" not in imported
        assert called & set(PRINTED) <= SPARED.get(path.name, set())


SHELL = ("assemble/model.py", "assemble/functions.py", "assemble/buffers.py", "emit/settings.py", "emit/emit.py", "emit/interface.py")
KNOWN = {("emit/settings.py", "wide")}      # whose functions of extended precision the printer of them knows


def test_the_shell_of_a_model_knows_no_part_by_its_name():
    """Neither its attribute of a model nor its name as a word; the templates include its files by the slots that it fills."""
    names = {part.name for part in PARTS}
    for path in SHELL:
        tree = ast.parse((ROOT / "gen/compile" / path).read_text())
        said = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in ("model", "self")}
        said |= {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
        assert {(path, name) for name in said & names} <= KNOWN
    for name in ("model.h.j2", "model.c.j2", "abi.c.j2", "interface.c.j2"):
        assert not set(re.findall(r"{%-? *(?:if|for \w+ in) (\w+)", (ROOT / "templates" / name).read_text())) & names


def test_plain_functions_are_those_of_the_header():
    """smg_plain.h defines just what the generator leaves out, each under the macro that a model defines in its place."""
    text = (ROOT / "runtime/core/smg_plain.h").read_text()
    guarded = {name: " ".join(body.split()) for name, body in re.findall(r"^#if !(SMG_OWN_\w+)\n.*?\{\s(.*?)\s\}\n#endif$", text, re.MULTILINE | re.DOTALL)}
    assert guarded.keys() == {macro(name) for name in PLAIN}
    for name, body in PLAIN.items():
        statements = " ".join(PRINTERS["scalar"].lines(body)).replace("1.0", "1").replace("0.0", "0")
        assert re.sub(r"\(void\)\w+[;,] ?|\(smg_real\)", "", guarded[macro(name)]) == statements


def test_the_middle_prints_nothing():
    """No braces, arrows or semicolons of C before `emit`, where the printers are."""
    for path in sorted([*(ROOT / "gen/compile/lower").glob("*.py"), *(ROOT / "gen/compile/assemble").glob("*.py")]):
        tree = ast.parse(path.read_text())
        documents = {ast.get_docstring(node, clean=False) for node in ast.walk(tree) if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))}
        texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)} - documents
        assert not [text for text in texts if any(mark in text for mark in (";", "{", "}", "->"))], path.name


def test_functions_that_differ_in_the_last_digit_stay():
    """A text of sympy has fifteen digits, a double seventeen."""
    def scaled(name, x):
        return Function("smg_real", name, (Argument("const smg_real *", "v0"),), (Return(Real(x * X, {"x": Component("v0", 0)})),), inlined="usual")
    functions = [scaled("a", sp.Float(0.3)), scaled("b", sp.Float(0.1 + 0.2)), scaled("c", sp.Float(0.3))]
    body = tuple(Assign(Name(f"y{k}"), Call(f.name, (Name("w"),))) for k, f in enumerate(functions))
    kept, (calls,) = trim(functions, [body])
    assert [f.name for f in kept] == ["a", "b"] and [one.value.function for one in calls] == ["a", "b", "a"]
