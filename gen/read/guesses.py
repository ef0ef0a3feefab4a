"""What was probably meant by a name that nothing declares, or by a token that does not fit."""
from __future__ import annotations

import re

from .names import FUNCTIONS
from .problems import nearest
from .scope import Scope, is_single

SELDOM = {"ln": "the natural logarithm is `log`", "cosine": "write `cos`", "sine": "write `sin`", "tangent": "write `tan`", "cosinus": "write `cos`", "sinus": "write `sin`", "tangens": "write `tan`",
          "square": "write `a^2`",
          "arctan": "write `atan`",
          "arcsin": "write `asin`", "arccos": "write `acos`", "arctan2": "write `atan2`",
          "length": "write `norm`", "pow": "write `a^b`", "fabs": "write `abs`",
          "sum": "sums are written with `over`", "sgn": "write `if(x < 0, -1, 1)`",
          "sign": "write `if(x < 0, -1, 1)`", "heaviside": "write `if(x < 0, 0, 1)`",
          "where": "write `if(condition, a, b)`"}
GLUED = re.compile(r"(.+?)_?([xyz]|[i-n]|\d+)\Z", re.ASCII)


def meant(name: str, scope: Scope, index: bool = False) -> str:
    """The hint for the undeclared `name`; index: it stands as the index of a vector."""
    if name in SELDOM:
        return SELDOM[name]
    return glued(name, scope) or unbound(name, scope, index) or nearest(name, scope.known(), FUNCTIONS)


def glued(name: str, scope: Scope) -> str:
    """`Sz`, `S_z`, `S_i`: a family with its component or index."""
    match = GLUED.match(name)
    if not match or not scope.families or match[1] not in scope.declared.families:
        return ""
    if match[2] not in "xyz":
        return f"vectors are written `{match[1]}[{match[2]}]`"
    alone = is_single(scope.declared.families[match[1]])
    return f"components are written `{match[1]}{'' if alone else '[i]'}.{match[2]}`"


def unbound(name: str, scope: Scope, index: bool) -> str:
    """An index where `over` binds others, or none."""
    if index and scope.indices and not scope.inside:
        return "`over` binds " + " and ".join(f"`{bound}`" for bound in scope.indices)
    if not scope.time or scope.indices or scope.inside or not re.match(r"[i-n]\Z", name):
        return ""
    return f'`over` binds indices: `over = "site({name}) of {next(iter(scope.declared.families), "w")}"`'
