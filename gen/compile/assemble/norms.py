"""Bounds on the norms of Hessian blocks, where no site enters them: they show that sweeps are a contraction.

The sum of a row is taken in a norm that fits the coupling. With positive d_k a matrix M has no larger spectral radius than

    max_k (1/d_k) sum_j |M_kj| d_j

(Gershgorin's circles of D^-1 M D). On a lattice all d are 1; on a graph they are nearly the eigenvector of its adjacency of the largest
eigenvalue, for which that is the spectral radius itself: of a star with 100 ends 10, where plain row sums are 100.
"""
from __future__ import annotations

import numpy as np
import sympy as sp

from ...language.spec import Graph, Lattice, Sites
from ..derive.derivatives import switched
from ..lower.code import Argument, Assign, Call, Entry, Function, Name, Ordered, Return, Table, Variable, real_of, tidy
from ..lower.integers import ONE, Index
from ..lower.loops import SITE as OWN
from ..lower.lowering import CLOCK
from .extent import expanded
from .families import SITE, by_family

ROUNDS = 30     # of the iteration for d; a graph of a thousand sites gains less than 1 % by more
SHARES = "smg_shares"


def norm_functions(model) -> list:
    """smg_hessian_row_norm, and what it calls."""
    if model.reach is None:
        return []
    return [*model.edge_norms.values(), by_family("smg_real", "smg_hessian_row_norm", SITE, lambda f: row_norm(model, f), model.coupled, index="site", wanted=True)]


def row_norm(model, f) -> tuple:
    """The sum of a row: what all sites have alike, and the edges of this one."""
    if not (edges := of_edges(model, f)):
        return (Return(model.reach[f.name]),)
    loops = [line for t, k in edges for line in model.loops.gather(t.over, t.slots[k], (edge_norm(model, t, k),))]
    return (Variable("smg_real", "sum", model.reach[f.name]), *tidy(loops), Return(Name("sum")))


def of_edges(model, f) -> list:
    return [(t, k) for t, k in model.roles(f.name) if isinstance(t.over, Graph)]


def edge_norm(model, t, k: int) -> Assign:
    """sum += that of one edge."""
    other = t.over.second if t.slots[k][1] == t.over.first else t.over.first
    ratio = Ordered("/", share(Index(other)), share(OWN)) if graphs_alone(model) else ONE
    return Assign(Name("sum"), Call(model.edge_norms[t.prefix, k].name, (*t.common(), ratio)), "+=")


def share(site):
    return real_of(Entry(SHARES, site))


def edge_norms(model, low) -> dict:
    """(effect, slot) -> the function of the norms of its blocks in the row of that slot: of the one on the diagonal, and ratio times that beside it."""
    return {(t.prefix, k): edge_kernel(low, t, k) for f in model.coupled for t, k in of_edges(model, f)}


def edge_kernel(low, t, k: int) -> Function:
    ratio = sp.Symbol("ratio", positive=True)
    value = sum(spectral_bound(block, t.derived.joined) * (1 if a == b else ratio) for (a, b), block in blocks_of(low, t) if a == k)
    kernel = low.kernel([value], t.derived.leaves)
    given = (*(a for a in t.arguments() if a.name[:1] != "v"), Argument("smg_real", ratio.name))
    return Function("smg_real", f"{t.prefix}_norm_{k}", given, (*kernel.values, Return(kernel.results[0])))


# The norm that fits

def graphs_alone(model) -> bool:
    """Do edges of graphs join sites of one family, and nothing else?"""
    joint = [t for t in model.coupled_effects() if len(t.slots) > 1]
    return len(model.coupled) == 1 and all(isinstance(t.over, Graph) for t in joint)


def share_tables(model) -> list:
    """d of every site that an edge meets."""
    if model.reach is None or not model.edge_norms or not graphs_alone(model):
        return []
    edges = np.concatenate([over.ends for over in dict.fromkeys(t.over for t in model.coupled_effects() if isinstance(t.over, Graph))])
    return [Table(SHARES, "double", tuple(float(f"{d:.3g}") for d in shares(edges)))]


def shares(edges):
    """Nearly the eigenvector of A of its largest eigenvalue, by powers of A + a/2, a the mean number of neighbours: of a bipartite graph A
    alone has another one as large."""
    d, ends = np.ones(int(edges.max()) + 1), edges.T.copy()
    mean = 2 * len(edges) / len(d)
    for _ in range(ROUNDS):
        d = sum(np.bincount(ends[a], d[ends[1 - a]], len(d)) for a in (0, 1)) + mean / 2 * d
        d /= d.max()
    return np.maximum(d, 1e-6)


# Norms of blocks

def reach(model, low):
    """Family -> sum of bounds on the norms of the Hessian blocks in a row, edges of graphs left out, where they are the same for all
    sites; None where a site enters."""
    if any(f.kind == "nambu" for f in model.coupled) or not all(constant(low, t) for f in model.coupled for t, k in of_edges(model, f)):
        return None
    found = {f.name: row_sums(model, low, f, lambda t, k: 0 if isinstance(t.over, Graph) else block_norm(low, t, k)) for f in model.coupled}
    return None if None in found.values() else found


def constant(low, t) -> bool:
    """Do both ends of the edge stand at bound indices, and enter no block of the row?"""
    sites = {v for vector in t.derived.vectors for v in vector}
    bound = all(slot in t.over.bound for _, slot in t.slots)
    return bound and not t.derived.parts and not switched(t.derived) and not any(sites & block.free_symbols for _, block in blocks_of(low, t))


def blocks_of(low, t) -> list:
    return [(pair, sp.Matrix(3, 3, [low.number_values(x) for x in block])) for pair, block in t.derived.hessian.items()]


def row_sums(model, low, f, norm):
    """Sum of norm(term, slot) over the terms that a site feels; of a lattice of several places in a cell the sum over them; None where a
    norm is."""
    rows = [0] * max([over.sites for over in model.lattices(f.name)] or [1])
    for t, k in model.roles(f.name):
        one = norm(t, k)
        if one is None:
            return None
        for sub, times_seen in meetings(t, k, len(rows)) if one != 0 else ():
            rows[sub] += times_seen * one
    kernel = low.kernel(rows, {})
    if kernel.values and all(sp.sympify(row).is_number for row in rows):       # that share parts
        kernel = low.kernel([max(map(sp.N, rows))], {})
    return None if kernel.values else added(dict.fromkeys(kernel.results))


def added(values):
    """Their sum, as it stands."""
    first, *others = values
    for other in others:
        first = Ordered("+", first, other)
    return first


def block_norm(low, t, k):
    """A bound on the norms of the Hessian blocks in the row of slot k, if no site enters them."""
    if not isinstance(t.over, (Lattice, Sites)):
        return None
    total_norm = sp.S.Zero
    for (a, _), block in t.derived.hessian.items():
        if a == k:
            values = [low.number_values(x) for x in block]
            if any(low.when(x) > CLOCK for x in values):
                return None
            total_norm += spectral_bound(sp.Matrix(3, 3, values), t.derived.joined)
    return total_norm


def spectral_bound(block, joined=()):
    """A bound on the spectral norm: of the symmetric part, which is exact for multiples of I, Frobenius elsewhere; and exact of the
    antisymmetric one. joined: of a sum, from which the multiple of I is taken first, so that the bound is about that of its terms, or less."""
    even, odd = (block + block.T) / 2, (block - block.T) / 2
    scale, even = isotropic(even) if joined else (sp.S.Zero, even)
    return sp.Abs(scale) + even_bound(even.applyfunc(expanded)) + sp.sqrt(sum(expanded(x) ** 2 for x in (odd[0, 1], odd[0, 2], odd[1, 2])))


def isotropic(block) -> tuple:
    """(the third of the trace, the rest)."""
    scale = expanded(block.trace() / 3)
    return scale, block - scale * sp.eye(3)


def even_bound(block):
    if block == block[0, 0] * sp.eye(3):
        return sp.Abs(block[0, 0])
    return sp.sqrt(sum(x ** 2 for x in block))


def meetings(t, k: int, subs: int):
    """How often a site of each place in the cell stands at slot k of a term: [(sub, times)]."""
    if isinstance(t.over, Sites):
        return [(sub, 1) for sub in range(subs)]
    position = t.over.indices.index(t.slots[k][1])
    places = [bond[position][0] for bond in t.over.bonds]
    return [(sub, places.count(sub)) for sub in range(subs)]
