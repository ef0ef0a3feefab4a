"""Explicit splittings: which of them a Hamiltonian allows, found in the formulas; what stands in the way of the others.

Axes: H = A(all x) + B(all y) + C(all z), so no second derivative joins two components.
"""
from __future__ import annotations

import sympy as sp

from ...errors import UsageError
from ...language.spec import Spec
from ...methods import METHODS, Method
from ..derive.derivatives import Derived, derive
from ..derive.parts import expanded

AXES = "xyz"
LONGEST = 80        # characters of a term that is quoted


def require_splitting(spec: Spec, method: Method) -> None:
    """Raises UsageError where the Hamiltonian does not allow the splitting of the method."""
    found = obstacle(spec, method)
    if found is not None:
        raise UsageError(f"method {method.name} {ASKED[method.splitting]}, but {found}")


def obstacle(spec: Spec, method: Method) -> str | None:
    """What stands in the way, in words: a factor of the space, or the first effect that does; None where nothing does."""
    for f in spec.families:
        if f.kind not in method.spaces:
            return f"'{f.name}' is a Nambu factor, on which the parts of H make no rotations"
    found = ((e.name, OBSTACLES[method.splitting](derive(e))) for e in spec.effects)
    return next((f"effect '{name}' {why}" for name, why in found if why), None)


def splittings(spec: Spec) -> dict:
    """Method -> what stands in its way, None where nothing does."""
    return {m.name: obstacle(spec, m) for m in METHODS.values() if m.splitting and m.stages == 1}


# Axes

def mixing(d: Derived) -> str | None:
    """Two components that the term joins: a second derivative by both that is not zero."""
    for (k, l), block in d.hessian.items():
        for a in range(3):
            for b in range(3):
                if a != b and expanded(block[a, b]) != 0:
                    return f"joins {component(d, k, a)} and {component(d, l, b)}" + quoted(d, d.vectors[k][a], d.vectors[l][b])
    return None


def component(d: Derived, slot: int, axis: int) -> str:
    family, site = d.slots[slot]
    return f"{family}[{site}].{AXES[axis]}"


def quoted(d: Derived, x, y) -> str:
    """` in the term ..`: the first summand with both symbols, where the formula is whole and it is short."""
    if d.parts:
        return ""
    for term in sp.Add.make_args(expanded(d.value)):
        if {x, y} <= term.free_symbols:
            text = written(d, term)
            return f" in the term {text}" if len(text) <= LONGEST else ""
    return ""


def written(d: Derived, e) -> str:
    """An expression as formulas of a spec are written."""
    names = {v: component(d, k, a) for k, row in enumerate(d.vectors) for a, v in enumerate(row)}
    names |= {s: s.name.replace("p.", "").replace("i.", "").replace("e.", "").replace("a.", "") for s in e.free_symbols if s not in names}
    return sp.sstr(e.xreplace({s: sp.Symbol(name) for s, name in names.items()})).replace("**", "^")


ASKED = {"axes": "is for a sum of functions of single components, each of x, of y or of z alone"}
OBSTACLES = {"axes": mixing}
