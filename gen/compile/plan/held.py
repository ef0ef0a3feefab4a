"""Terms with a site that is not there are 0, by factors 0 and 1 that a state keeps (`site_number` of lower/lowering.py)."""
from __future__ import annotations

from dataclasses import replace
from functools import reduce

from ...effects.held import at_site, share
from ...language.expr import Expr, Idx, Num, Op, kind_of, slots_of, walk
from ...language.held import absent
from ...language.spec import Family, Spec, Term, families_of

FINITE = {"+", "-", "*", "neg", "dot", "cross", "triple", "vec", "x", "y", "z", "kept", "uniform", "normal", "sin", "cos", "tanh", "abs", "min", "max", "floor"}


def there(spec: Spec, family: Family) -> Expr:
    """1 where the site Idx("i") of a family is there, 0 where it is not."""
    condition = absent(spec, family.name)
    return Num(1) if condition is None else share(condition, family)


def present(spec: Spec) -> Spec:
    """The spec whose terms are 0 where one of their sites is absent."""
    gone = {f.name: condition for f in spec.families if (condition := absent(spec, f.name)) is not None}
    if not gone:
        return spec
    return replace(spec, effects=tuple(with_factors(e, gone) if isinstance(e, Term) else e for e in spec.effects),
                   observables=tuple(with_factors(o, gone) for o in spec.observables))


def with_factors(t: Term, gone: dict) -> Term:
    """A term with a factor for each of its sites whose family has absent ones."""
    alone = [(slot, family) for family, slot in (*slots_of(t.value), *t.moved) if isinstance(slot, int)]
    sites = dict.fromkeys([*families_of(t.over).items(), *alone])
    factors = [at_site(gone[family], Idx(site) if isinstance(site, str) else Num(site)) for site, family in sites if family in gone]
    return replace(t, value=where(factors, t.value)) if factors else t


def where(factors, value: Expr) -> Expr:
    """The value times the factors; chosen by them where it may have no finite value, as log(0)."""
    factor = reduce(lambda a, b: Op("*", (a, b)), factors)
    if all(is_finite(e) for e in walk(value) if isinstance(e, Op)):
        return Op("*", (factor, value))
    zero = Op("vec", (Num(0),) * 3) if kind_of(value) == "v" else Num(0)
    return Op("if", (Op(">", (factor, Num(0))), value, zero))


def is_finite(e: Op) -> bool:
    """Is it finite wherever its arguments are?"""
    power = e.args[1] if e.op == "^" else None
    return e.op in FINITE or isinstance(power, Num) and isinstance(power.value, int) and power.value > 0
