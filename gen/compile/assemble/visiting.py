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
from ..lower.loops import side_table
from .part import Part
from .sums import swept_by_site

LARGE = 4096        # sites: fewer fit the cache
NEAR = 1024         # mean distance between the numbers of two neighbours: the sites between them fit the cache
GAIN = 2            # by which an order must lower that distance: a graph without places, such as a random one, has no better order
AHEAD = 16          # data of a site is fetched this many visits ahead
TABLE = "smg_visits"


class VisitedInOrder(Part):
    """A large graph whose sites are visited in an order of their own: `visited`, the sites in that order."""
    name = "visited"

    def made(self, model, low):
        overs = [t.over for t in model.coupled_effects() if len(t.slots) > 1]
        if len(model.coupled) != 1 or model.lattice(model.coupled[0].name) or not swept_by_site(model) or not all(isinstance(over, Graph) for over in overs):
            return None
        return visit_order(tuple({over.hashed: over for over in overs}.values()))       # of those with the same edges one

    def first(self, model) -> list:
        order = model.visited.tolist()
        return [Table(TABLE, "int32_t", (*order, *order[-1:] * AHEAD))]

    def settings(self, model) -> dict:
        return {"SMG_FETCHED_AHEAD": 1}


def in_order(model, f, call) -> tuple:
    """The visits of all sites of a family, those after the last one with an edge by number; call(site, the one that is visited AHEAD later)."""
    site, ahead, end = Index("site"), Index("ahead"), total(len(model.visited))
    lines = (Let("site", Cell(TABLE, (Index("n"),))), Let("ahead", Cell(TABLE, (Index("n") + AHEAD,))),
             *(Call("SMG_FETCH", (Cell(row, (ahead,)),)) for row in rows_of(model, f)), *call(site, ahead))
    rest = () if f.count == end else (For("site", end, f.count, call(site, site)),)
    return (For("n", ZERO, end, lines), *rest)


def rows_of(model, f) -> list:
    """The tables of the rows that a visit reads; not those of graphs that have fewer sites, where a row may be missing."""
    found = [(t.over, t.over.bound.index(t.slots[k][1])) for t, k in model.roles(f.name) if isinstance(t.over, Graph)]
    return list(dict.fromkeys(f"{side_table(over, side)}_row" for over, side in found if over.highest == model.visited.max()))


@lru_cache(maxsize=8)
def visit_order(graphs: tuple):
    """The sites up to the last one with an edge, in the order of Cuthill and McKee; None if the order of their numbers is about as good."""
    edges = np.concatenate([np.empty((0, 2), np.int64), *(over.ends for over in graphs)])
    sites = 1 + int(edges.max(initial=-1))
    by_number = np.arange(sites)
    if sites < LARGE or distance(edges, by_number) < NEAR:
        return None
    order = cuthill_mckee(edges, sites)
    return order if GAIN * distance(edges, np.argsort(order)) < distance(edges, by_number) else None


def places(model, over: Graph):
    """The place of each site of a graph in the order of visits; by number where that order does not have them all, as of an observable's graph."""
    if model.visited is None or len(model.visited) <= over.highest:
        return np.arange(1 + over.highest)
    return np.argsort(model.visited[model.visited <= over.highest])


def edge_order(model, over: Graph, place):
    """The edges of a large graph by the places of their ends; those of others, and where the method takes bonds in turn, as they are."""
    if 1 + over.highest < LARGE or model.method.splitting == "pairs":
        return np.arange(len(over.edges))
    low, high = np.sort(place[over.ends], axis=1).T
    return np.argsort(low * len(place) + high, kind="stable")


def distance(edges, place) -> float:
    """Mean distance between the ends of an edge, by the places of sites in an order."""
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
