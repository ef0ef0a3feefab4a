"""How sites move in the gradient g = dH/dw where they do more than precess (runtime/core/smg_respond.h): F = f g + F0, Q = q g + Q0."""
from __future__ import annotations

from ..derive.derivatives import scalar
from ..lower.code import Argument, Assign, Element
from ..lower.lowering import Kernel, index_names
from ...language.expr import Num
from ...effects.motion import Response
from .families import SITE, by_family
from .part import Part


def formulas(response: Response) -> tuple:
    """f, q and the components of F0 and Q0."""
    return (response.f, response.q, *response.F0, *response.Q0)


def indexed(response: Response) -> bool:
    """Does it differ from site to site?"""
    return any(index_names(e) for e in formulas(response))


def response_functions(model) -> list:
    """smg_response(c, k, r): r = f, q, F0, Q0 of site k."""
    arguments = (*SITE, Argument("smg_real *", "r"))
    return [by_family("void", "smg_response", arguments, lambda f: stored(model.responding[f.name]), model.families, wanted=True)]


def response_kernels(model, low) -> dict:
    """Family -> the kernel of its eight numbers; of families that only precess too, where others do more."""
    if not model.responses:
        return {}
    return {f.name: response_kernel(low, model.responses.get(f.name, Response())) for f in model.families}


def response_kernel(low, response: Response) -> Kernel:
    values, leaves = zip(*map(scalar, formulas(response)))
    return low.kernel(values, {name: node for some in leaves for name, node in some.items()})


def stored(kernel: Kernel) -> tuple:
    return (*kernel.values, *(Assign(Element("r", a), value) for a, value in enumerate(kernel.results)))


class Responses(Part):
    """Sites that do more than precess: the kernels of their families."""
    name = "responding"

    def made(self, model, low):
        return response_kernels(model, low) or None

    def functions(self, model):
        return response_functions(model)

    def settings(self, model):
        pushed = any(x != Num(0) for law in model.responses.values() for x in (*law.F0, *law.Q0))
        return {"SMG_RESPONDS": 1, **({"SMG_PUSHES": 1} if pushed else {})}
