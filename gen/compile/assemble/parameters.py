"""What parameters, and what time alone decide: sizes, their checks, hoisted values."""
from __future__ import annotations

from itertools import combinations

from ...language import limits
from ...language.spec import Graph, Lattice, families_of
from ..lower.code import Argument, Assign, Either, For, Function, If, Member, Name, Not, Ordered, Parameter, Return, Unary, Variable, refuse
from ..lower.integers import ONE, ZERO, Index, Pointed, compare, times
from ..lower.lowering import CLOCK, PREPARE, STRIDE
from .bounds import Bounds

C = Argument("smg_coefficients *", "c")
MODEL = Argument("smg_model *", "model")
KEPT = Argument("const smg_model *", "model")


def parameter_functions(model) -> list:
    """smg_sizes, smg_check_sizes, smg_same_sizes and smg_prepare of the model; smg_set_step and smg_set_time of coefficients."""
    sizes = [Assign(Member("model", name), size) for name, size in model.coefficients.sizes]
    start = (Assign(Member("model", "p"), Unary("*", Name("p"))),)
    checks = dict.fromkeys([*checks_of(model), *Bounds(model.low, lambda f: model.by_name[f].count).checks(model.spec)])
    return [Function("void", "smg_sizes", (MODEL, Argument("const smg_params *", "p")), (*start, *sizes), target="model", wanted=True),
            Function("smg_status", "smg_check_sizes", (KEPT,), (*together(checks), Return(Name("SMG_OK"))), target="model", wanted=True),
            Function("int", "smg_same_sizes", (KEPT, Argument("const smg_model *", "other")), same_sizes(model), target="model", wanted=True),
            Function("int", "smg_prepare", (MODEL,), prepared(model), target="model", wanted=True),
            set_to(model, "step", "h", STRIDE), set_to(model, "time", "t", CLOCK)]


def together(checks):
    """Refusals that follow each other as one, of a few tests."""
    tests: list = []
    for one in checks:
        more = one.tests[0].tests if isinstance(one, If) and isinstance(one.tests[0], Either) else one.tests if isinstance(one, If) else ()
        plain = isinstance(one, If) and len(one.tests) == 1 and one.body == refuse(True)
        if tests and not (plain and len(tests) + len(more) <= 4):
            yield from refuse(*tests)
            tests = []
        if plain:
            tests += more
        else:
            yield one
    yield from refuse(*tests)


def set_to(model, what: str, name: str, level: int) -> Function:
    """smg_set_step or smg_set_time: h or t, and the coefficients that depend on it."""
    return Function("void", f"smg_set_{what}", (C, Argument("smg_real", name)), (Assign(Member("c", name), Name(name)), *stored(model, level)), wanted=True)


def stored(model, level: int, holder: str = "c") -> list:
    return [Assign(Member(holder, name), value) for name, value in model.coefficients.at(level)]


def same_sizes(model) -> tuple:
    """Have two models the same sizes?"""
    names = [name for name, _ in model.coefficients.sizes]
    if len(names) == 1:
        return (Return(compare(Pointed("model", names[0]), "==", Pointed("other", names[0]))),)
    differ = tuple(compare(Pointed("model", name), "!=", Pointed("other", name)) for name in names)
    return (Return(Not(Either(differ)) if differ else ONE),)


def run_time(spec) -> list:
    """The parameters that are no part of the program."""
    return [p for p in spec.parameters if not p.fixed]


def prepared(model) -> tuple:
    """Once per model: hoisted values of the parameters; 0 when a parameter is not finite."""
    tests = []
    for p in run_time(model.spec):
        if p.kind == "real":
            tests.append(stays_finite(Parameter(p.name)))
        elif p.kind == "array":
            tests.append(For("i", ZERO, model.low.size(p.size), (stays_finite(Parameter(p.name, Index("i"))),), over="entries"))
    values = stored(model, PREPARE, "model")
    if not tests:
        return (*values, Return(ONE))
    return (Variable("int", "finite", ONE), *tests, *values, Return(Name("finite")))


def stays_finite(x) -> Assign:
    """x - x is 0 for a number, and NaN for what is none."""
    return Assign(Name("finite"), Ordered("==", Ordered("-", x, x), ZERO), "&=")


# Checks: sizes that must hold for the loops, the solver and the arrays

def checks_of(model) -> list:
    found = [check for f in model.families for check in outside(f.count, 1)]
    sizes = [model.low.size(p.size) for p in run_time(model.spec) if p.kind == "array"]
    found += [check for n in sizes for check in outside(n, 1)]
    for t in (*model.fields, *model.observables):
        found += [check for f, k in t.slots if isinstance(k, int) for check in refuse(compare(model.by_name[f].count, "<=", k))]
        if isinstance(t.over, Lattice):
            found += lattice_checks(model, t)
        if isinstance(t.over, Graph):
            found += graph_checks(model, t)
    if model.plan.solver == "band":
        found += refuse(compare(model.rows, "<", 2 * model.plan.band + 1))
    if model.plan.solver == "sparse":
        found += refuse(compare(model.rows, "!=", model.plan.pattern.size))
    return found


def outside(size, least: int) -> tuple:
    """The check of a size; beyond `limits.SITES` the products of sizes could overflow."""
    return refuse(compare(size, "<", least), compare(size, ">", limits.SITES))


def lattice_checks(model, t) -> list:
    sizes = [model.low.size(s) for s in t.over.size]
    found = []
    for d, n in enumerate(sizes):
        far = max(abs(offset[d]) for bond in t.over.bonds for _, offset in bond)
        found += outside(n, max(1, far, numbered_reach(t.over, d)))
        if model.method.splitting == "sublattices" and t.over.family and t.over.periodic[d]:      # no site is bound to itself
            reach = [[offset[d] for _, offset in bond] for bond in t.over.bonds]
            found += outside(n, 1 + max(max(r) - min(r) for r in reach))
    ends = [combinations(zip(families_of(t.over).values(), bond), 2) for bond in t.over.bonds]
    found += [check for pairs in ends for (f, a), (g, b) in pairs if f == g for check in closed_upon_itself(t.over, sizes, a, b)]
    product = times(*sizes, t.over.sites)
    for f in families_in(t):
        count = model.by_name[f].count
        found += refuse(compare(count, "!=", product)) if count != product else ()
    return found


def numbered_reach(over: Lattice, d: int) -> int:
    """What bonds with numbers span along an open direction: each of them has a number of cells in which it is."""
    if not over.number or over.periodic[d]:
        return 0
    return max(max(0, *reach) - min(0, *reach) for reach in ([offset[d] for _, offset in bond] for bond in over.bonds))


def closed_upon_itself(over: Lattice, sizes, a, b) -> tuple:
    """The check that two ends (sub, offset) of a bond, of one family, are two sites: no way between them leads around every ring that it goes along."""
    away = [abs(x - y) for x, y in zip(a[1], b[1])]
    if a[0] != b[0] or any(d and not ring for d, ring in zip(away, over.periodic)):
        return ()
    tests = [[compare(n, "==", q) for q in range(1, d + 1) if d % q == 0] for n, d in zip(sizes, away) if d]
    open_ = [tuple(test for test in around if test is not False) for around in tests if True not in around]
    if not all(open_):
        return ()
    return (If(tuple(Either(around) if len(around) > 1 else around[0] for around in open_), refuse(True)),) if open_ else refuse(True)


def graph_checks(model, t) -> list:
    """Every family that an edge meets has the sites that the graph names."""
    return [check for f in families_in(t) for check in refuse(compare(model.by_name[f].count, "<=", t.over.highest))]


def families_in(t) -> dict:
    """Of its vectors, and those that its bonds join: their numbers may be places in arrays."""
    return dict.fromkeys([*(f for f, _ in t.slots), *families_of(t.over).values()])
