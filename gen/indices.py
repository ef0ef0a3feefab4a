"""Index names of a spec that would hide names of the generated C get an underscore."""
from __future__ import annotations

from dataclasses import replace

from .expr import Elem, Idx, Op, Spin
from .spec import Each, Graph, Lattice, Once, Pairs, Sites, Spec, Term

C_NAMES = {"c", "d", "e", "g", "h", "k", "m", "p", "r", "s", "t", "u", "v", "w", "x", "y", "l", "q", "b",
           "n", "all", "own", "out", "row", "site", "sub", "sum", "lost", "body", "column", "block",
           "hessian", "state", "int", "for", "if", "do"}


def safe(name: str) -> str:
    taken = name in C_NAMES or (name[:1] in "bcgnorsuvxk" and name[1:].isdigit()) or name.startswith("spare")
    return name + "_" if taken else name


def rename(e):
    """The expression with safe index names."""
    if isinstance(e, Idx):
        return Idx(safe(e.name))
    if isinstance(e, Spin):
        return Spin(e.family, safe(e.slot) if isinstance(e.slot, str) else e.slot)
    if isinstance(e, Op):
        return Op(e.op, tuple(rename(a) for a in e.args))
    return Elem(e.name, rename(e.index)) if isinstance(e, Elem) else e


def rename_over(over):
    if isinstance(over, Sites):
        return replace(over, index=safe(over.index))
    if isinstance(over, (Pairs, Graph)):
        return replace(over, first=safe(over.first), second=safe(over.second))
    if isinstance(over, (Each, Lattice)):
        return replace(over, indices=tuple(safe(i) for i in over.indices))
    assert isinstance(over, Once)
    return over


def rename_term(term: Term) -> Term:
    return replace(term, over=rename_over(term.over), value=rename(term.value))


def safe_indices(spec: Spec) -> Spec:
    """The same spec; only the index names inside its effects and observables may differ."""
    return replace(spec, effects=tuple(map(rename_term, spec.effects)),
                   observables=tuple(map(rename_term, spec.observables)))
