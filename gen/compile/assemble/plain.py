"""What a model need not say: functions of one family of unit spheres with kappa = 1, all solved together, stand in
runtime/core/smg_plain.h. A model whose own version differs defines it, and SMG_OWN_<NAME>.
"""
from __future__ import annotations

import sympy as sp

from ..lower.code import Assign, Call, Element, Function, Member, Name, Real, Return
from ..lower.integers import ONE, ZERO, Index

ONE_REAL, ZERO_REAL = Real(sp.Integer(1)), Real(sp.Integer(0))
PLAIN = {
    "smg_prepare": (Return(ONE),),
    "smg_set_step": (Assign(Member("c", "h"), Name("h")),),
    "smg_set_time": (Assign(Member("c", "t"), Name("t")),),
    "smg_coupled": (Return(Call("smg_sites", (Name("c"),))),),
    "smg_family_end": (Return(Call("smg_sites", (Name("c"),))),),
    "smg_site": (Return(Index("row")),),
    "smg_row": (Return(Index("k")),),
    "smg_tracer": (Return(ZERO),),
    "smg_kind": (Return(Name("SMG_SPHERE")),),
    "smg_kappa": (Return(ONE_REAL),),
    "smg_h_over_kappa": (Return(Name("h")),),
    "smg_radius": (Return(ONE_REAL),),
    "smg_present": (Return(ONE_REAL),),
    "smg_moves": (Return(ONE_REAL),),
    "smg_normal": tuple(Assign(Element("n", a), Element("v", a)) for a in range(3)),
    "smg_coupled_gradient": (Call("smg_gradient", (Name("c"), Name("w"), Name("g"))),),
    "smg_shift": (Return(ZERO),),
    "smg_rank": (Return(ZERO),),
    "smg_place": (Return(Index("rank")),),
    "smg_rest_field_norm": (Return(ZERO_REAL),),
}


def is_plain(definition) -> bool:
    """Is it a function that smg_plain.h has?"""
    return isinstance(definition, Function) and PLAIN.get(definition.name) == definition.body


def own_settings(definitions) -> list:
    """(macro, 1) of each function that smg_plain.h has otherwise."""
    return [(macro(d.name), 1) for d in definitions if isinstance(d, Function) and d.name in PLAIN and not is_plain(d)]


def macro(name: str) -> str:
    """SMG_OWN_KAPPA of smg_kappa."""
    return f"SMG_OWN_{name[len('smg_'):].upper()}"
