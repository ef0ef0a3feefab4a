"""Responses that differ from site to site, on lattices by rows: those of their eight numbers that do stand in arrays by slots, behind the factors of gradients."""
from __future__ import annotations

from ...effects.motion import Response
from ...language.expr import Num
from ..lower.code import Argument, Assign, Call, Element, Function, Let, Name, Return, Variable
from ..lower.integers import Index
from ..lower.lowering import index_names
from .families import SITE
from .response import formulas, indexed, stored

RESPONSE = (*SITE, Argument("smg_real *", "r"))
SIZE = 8        # SMG_RESPONSE_SIZE
PUSH = range(2, SIZE)


def pushes(law: Response) -> bool:
    """Does it move sites where there is no field?"""
    return any(x != Num(0) for x in (*law.F0, *law.Q0))


def differing(model, laws: dict) -> tuple:
    """Which of f, q, F0, Q0 differ from site to site, of the laws of those that move: with those that do not, where these are told apart by nothing else."""
    all_laws = [laws.get(f.name, Response()) for f in model.families]
    if not laws or not (unlike(all_laws) or any(indexed(law) or model.moving and pushes(law) for law in all_laws)):
        return ()
    return tuple(n for n in range(SIZE) if varies(model, n))


def unlike(laws) -> bool:
    return any(formulas(law) != formulas(laws[0]) for law in laws)


def varies(model, n: int) -> bool:
    """Does that number, which is not 0, differ from site to site, or from family to family?"""
    found = [formulas(model.responses.get(f.name, Response()))[n] for f in model.families]
    some = [e for e, f in zip(found, model.families) if not model.responding[f.name].results[n].is_number(0)]
    return any(index_names(e) for e in some) or bool(some) and any(e != found[0] for e in found)


def law_functions(found) -> list:
    """smg_law(c, k, r): smg_response of sites that move; or, where the strength of sites is a factor of their gradients, with that factor in F0 and Q0."""
    if found.law:
        return [Function("void", "smg_law", RESPONSE, stored(found.law), wanted=True)]
    return [Function("void", "smg_law", RESPONSE, rated_law(), wanted=True)] if rates_law(found) else []


def rates_law(found) -> bool:
    return found.rated and any(n in PUSH for n in found.differing)


def rated_law() -> tuple:
    rate = Let("rate", Call("smg_rate", (Name("c"), Index("k"))), "const smg_real")
    return (Call("smg_response", (Name("c"), Index("k"), Name("r"))), rate, *(Assign(Element("r", n), Name("rate"), "*=") for n in PUSH))


def law_values(found) -> list:
    """The statements that return each of those numbers."""
    call = Call("smg_law" if rates_law(found) else "smg_response", (Name("c"), Index("site"), Name("r")))
    return [(Variable("smg_real", f"r[{SIZE}]"), call, Return(Element("r", n))) for n in found.differing]


def law_settings(found, first: int) -> dict:
    """first: the number of the first of them."""
    if found.differing:
        bits = sum(1 << n for n in found.differing)
        return {"SMG_LAW_BY_SITE": bits, "SMG_LAW_FIRST": first, **({"SMG_LAW": 1} if rates_law(found) else {})}
    return {"SMG_LAW" if found.law else "SMG_ALL_OR_NOTHING": 1} if found.held else {}
