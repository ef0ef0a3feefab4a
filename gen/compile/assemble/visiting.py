"""The order in which sweeps visit the sites of a large graph: neighbours soon after each other, so that they are found in the cache.

That is the order of Cuthill and McKee (Reducing the bandwidth of sparse symmetric matrices, Proc. 24th ACM Nat. Conf. (1969)): breadth first,
of the neighbours of a site those with few neighbours first. States are kept in the order of the spec. The edges of such graphs stand in the
tables in the same order, whatever their order in the file. Small graphs fit the cache as they are.
"""
from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...language.spec import Graph
from ..lower.code import Table

LARGE = 4096        # sites: fewer fit the cache
NEAR = 1024         # numbers between the ends of an edge on the average: those between them fit the cache
VISITS = "smg_visits"


def visit_tables(model) -> list:
    found = [visits_of(model, f) for f in model.coupled]
    return [Table(VISITS, "int32_t", tuple(order.tolist())) for order in found if order is not None]


def visits_of(model, f):
    """The sites of a family that edges meet, in the order of visits, or None where that is the order of their numbers."""
    overs = tuple(dict.fromkeys(t.over for t in model.coupled_effects() if len(t.slots) > 1))
    return visits(overs) if len(model.coupled) == 1 and overs and all(isinstance(over, Graph) for over in overs) else None


@lru_cache(maxsize=8)
def visits(overs: tuple):
    """The sites that edges meet in the order of Cuthill and McKee; None where their numbers are a good order, or hardly a worse one."""
    edges = np.concatenate([over.ends for over in overs])
    sites = 1 + int(edges.max(initial=-1))
    by_number = np.arange(sites)
    if sites < LARGE or distance(edges, by_number) < NEAR:
        return None
    order = cuthill_mckee(edges, sites)
    return order if 2 * distance(edges, np.argsort(order)) < distance(edges, by_number) else None


def places(over: Graph):
    """The place of each site in the order of visits, if it is that graph alone that joins sites."""
    order = visits((over,))
    return np.arange(1 + over.highest) if order is None else np.argsort(order)


def edge_order(over: Graph, place):
    """The edges of a large graph by the places of their ends, those of others as they are."""
    if 1 + over.highest < LARGE:
        return np.arange(len(over.edges))
    low, high = np.sort(place[over.ends], axis=1).T
    return np.argsort(low * len(place) + high, kind="stable")


def distance(edges, place) -> float:
    """How far apart the ends of an edge are on the average, by the places of sites in an order."""
    return float(np.abs(place[edges[:, 0]] - place[edges[:, 1]]).mean())


def cuthill_mckee(edges, sites: int):
    """Breadth first from a site with the fewest neighbours, then from the next one that was not reached."""
    degree = np.bincount(edges.ravel(), minlength=sites)
    fewest_first = np.argsort(degree, kind="stable")
    rank = np.argsort(fewest_first)
    keys = np.sort(np.concatenate([edges[:, a] * sites + rank[edges[:, 1 - a]] for a in (0, 1)]))
    near, start, seen, order = fewest_first[keys % sites].tolist(), [0, *np.cumsum(degree).tolist()], bytearray(sites), []
    for root in fewest_first.tolist():
        if not seen[root]:
            breadth_first(order, root, near, start, seen)
    return np.array(order, dtype=np.int64)


def breadth_first(order: list, root: int, near: list, start: list, seen: bytearray) -> None:
    """Adds a root and the sites that edges join with it. The neighbours of site i are near[start[i]:start[i + 1]]."""
    at, seen[root] = len(order), 1
    order.append(root)
    while at < len(order):
        for other in near[start[order[at]]:start[order[at] + 1]]:
            if not seen[other]:
                seen[other] = 1
                order.append(other)
        at += 1
