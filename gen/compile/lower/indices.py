"""Indices of a spec as the C has them (`language.c_names`), and an index that runs over one site is 0."""
from __future__ import annotations

from dataclasses import replace

from ...language.c_names import index_in_c
from ...language.counts import constant_integer, runtime_names
from ...language.expr import Elem, Idx, Num, Op, Spin
from ...language.spec import Each, Family, Graph, Lattice, Once, Pairs, Sites, Spec, families_of


def rename(e):
    """The expression with safe index names."""
    if isinstance(e, Idx):
        return replace(e, name=index_in_c(e.name))
    if isinstance(e, Spin):
        return Spin(e.family, index_in_c(e.slot) if isinstance(e.slot, str) else e.slot)
    if isinstance(e, Op):
        return Op(e.op, tuple(rename(a) for a in e.args))
    return Elem(e.name, rename(e.index)) if isinstance(e, Elem) else e


def rename_over(over):
    if isinstance(over, Sites):
        return replace(over, index=index_in_c(over.index))
    if isinstance(over, (Pairs, Graph)):
        return replace(over, first=index_in_c(over.first), second=index_in_c(over.second))
    if isinstance(over, Lattice):
        return replace(over, indices=tuple(map(index_in_c, over.indices)), number=over.number and index_in_c(over.number))
    if isinstance(over, Each):
        return replace(over, indices=tuple(map(index_in_c, over.indices)))
    assert isinstance(over, Once)
    return over


def safe_indices(spec: Spec) -> Spec:
    """The same spec; only the index names inside its effects and observables may differ."""
    return replace(spec, effects=tuple(e.mapped(rename_over, rename) for e in spec.effects),
                   observables=tuple(o.mapped(rename_over, rename) for o in spec.observables))


def at_zero(e, names):
    """The expression with 0 in place of the indices `names`; vectors keep theirs."""
    if isinstance(e, Idx) and e.name in names:
        return Num(0)
    if isinstance(e, Op):
        return Op(e.op, tuple(at_zero(a, names) for a in e.args))
    return Elem(e.name, at_zero(e.index, names)) if isinstance(e, Elem) else e


def one_site(spec: Spec) -> Spec:
    """The same spec without the numbers of sites that are alone in their family: they are 0."""
    parameters = {p.name: p for p in spec.parameters}
    alone = {f.name for f in spec.families
             if not runtime_names(f.count, parameters) and constant_integer(f.count, parameters) == 1}

    def family(f: Family) -> Family:
        return replace(f, kappa=at_zero(f.kappa, "i"), radius=f.radius and at_zero(f.radius, "i")) if f.name in alone else f

    def term(e):
        none = {i for i, f in families_of(e.over).items() if f in alone}
        return e.mapped(lambda over: over, lambda formula: at_zero(formula, none))

    return replace(spec, families=tuple(map(family, spec.families)), effects=tuple(map(term, spec.effects)), observables=tuple(map(term, spec.observables)))
