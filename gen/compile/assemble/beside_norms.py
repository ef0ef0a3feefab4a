"""Bounds on the norms of the Hessian's blocks between a site of a lattice and what stands beside it, one by one: with them the bound of smg_row_beyond.h
has weights where sites are unlike each other.
"""
from __future__ import annotations

import sympy as sp

from ..lower.code import Argument, Function, If, Return
from ..lower.integers import Index, compare, total
from ..lower.kernels import COEFFICIENTS
from .bond_values import unlike_bonds
from .extent import OneTime
from .row_bounds import Spins, block_norms
from .rows import beside, bonds_of, neighbours, radii_of, row_roles
from .site_values import differs


def beside_norms(model, low, found):
    """Of each place in the cell: (that of a site with itself, those of its neighbours in the order of smg_offsets); None where they differ from site to site."""
    roles = row_roles(model, found.whole)
    if found.norm is None or found.rated or any(differs(t) or unlike_bonds(t) for t, _ in roles):
        return None
    at = OneTime(low) if found.timely else low
    blocks = {(t.prefix, k): block_norms(at, t, k, Spins(low, t, radii_of(model))) for t, k in roles}
    kernels = [low.kernel(of_place(model, found, roles, blocks, sub), {}) for sub in range(found.over.sites)]
    return None if any(k.values for k in kernels) else [k.results for k in kernels]


def of_place(model, found, roles, blocks, sub: int) -> list:
    known = neighbours(model, sub, found.whole)
    own, others = sp.S.Zero, [sp.S.Zero] * len(known)
    for t, k in roles:
        for bond in bonds_of(t, k, sub):
            for q, norm in blocks[t.prefix, k].items():
                if q == k:
                    own += norm
                else:
                    others[known.index(beside(t, bond, k, q))] += norm
    return [own, *others]


def norm_function(found) -> list:
    """smg_beside_norm(c, sub, n): with the n-th neighbour of a site at this place, with the site itself for n = -1, and 0 beyond."""
    if found.norms is None:
        return []
    arguments = (COEFFICIENTS, Argument("int64_t", "sub"), Argument("int64_t", "n"))
    lines = [If((compare(Index("sub"), "==", total(sub)), compare(Index("n"), "==", total(n))), (Return(norm),))
             for sub, norms in enumerate(found.norms) for n, norm in enumerate(norms, -1)]
    return [Function("smg_real", "smg_beside_norm", arguments, (*lines, Return(total(0))), wanted=True)]
