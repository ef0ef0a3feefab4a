"""The order in which sweeps visit the sites of a large graph: neighbours soon after each other, so that they are found in the cache.

That is the order of Cuthill and McKee (Reducing the bandwidth of sparse symmetric matrices, Proc. 24th ACM Nat. Conf. (1969)): breadth first,
of the neighbours of a site those with few neighbours first. States are kept in the order of the spec. The edges of such graphs stand in the
tables in the same order, whatever their order in the file. Small graphs fit the cache as they are.
"""
from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...language.spec import Graph
from ..lower.code import Call, For, Let, Table
from ..lower.integers import ZERO, Cell, Index, total
from ..lower.loops import graph_name
from .part import Part
from .sums import swept_by_site

LARGE = 4096        # sites: fewer fit the cache
NEAR = 1024         # numbers between the ends of an edge on the average: those between them fit the cache
AHEAD = 16          # visits before that of a site, what it needs is fetched
TABLE = "smg_visits"


class VisitedInOrder(Part):
    """A large graph whose sites are visited in an order of their own: `visited`, the graphs and the order."""
    name = "visited"

    def made(self, model, low):
        overs = tuple(dict.fromkeys(t.over for t in model.coupled_effects() if len(t.slots) > 1))
        if len(model.coupled) != 1 or not overs or not all(isinstance(over, Graph) for over in overs) or not swept_by_site(model):
            return None
        order = visits(overs)
        return None if order is None else (overs, order)

    def first(self, model) -> list:
        order = model.visited[1].tolist()
        return [Table(TABLE, "int32_t", (*order, *order[-1:] * AHEAD))]

    def settings(self, model) -> dict:
        return {"SMG_ORDERED": 1}


def in_order(visited, count, call) -> tuple:
    """The visits of all sites, those that edges meet first; call(site, the site that is visited AHEAD later)."""
    (overs, order), site = visited, Index("site")
    rows = [f"{graph_name(over)}_{side}_row" for over in overs for side in ("first", "second")]
    lines = (Let("site", Cell(TABLE, (Index("n"),))), Let("ahead", Cell(TABLE, (Index("n") + AHEAD,))),
             *(Call("SMG_FETCH", (Cell(row, (Index("ahead"),)),)) for row in rows), *call(site, Index("ahead")))
    rest = () if count == total(len(order)) else (For("site", total(len(order)), count, call(site, site)),)
    return (For("n", ZERO, total(len(order)), lines), *rest)


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
