"""Constant tables: of the spec, edges and weights of graphs, the pattern of a sparse elimination."""
from __future__ import annotations

import numpy as np

from ...language.spec import Graph
from ..lower.code import Table
from ..lower.loops import graph_name, side_table
from .norms import share_tables
from .visiting import edge_order, places


def tables(model) -> list:
    found = [Table(f"table_{name}", "double", tuple(values)) for name, values in model.low.constants().items()]
    graphs = {graph_name(t.over): t.over for t in (*model.fields, *model.observables) if isinstance(t.over, Graph)}
    found += [table for name, over in graphs.items() for table in graph_tables(model, name, over)]
    found += share_tables(model)
    return found + (pattern_tables(model.plan.pattern) if model.plan.solver == "sparse" else [])


def graph_tables(model, name: str, over: Graph) -> list:
    """Edges and weights in an order that fits the visits; and by site the edges that it begins and ends, with their other ends."""
    place = places(model, over)
    order = edge_order(model, over, place)
    ends = over.ends[order]
    found = [pairs(f"{name}_edge", ends)]
    found += [Table(f"{name}_{column}", "double", tuple(np.array(values)[order].tolist())) for column, values in over.columns]
    for side in (0, 1):
        found += adjacency(side_table(over, side), ends[:, side], ends[:, 1 - side], place)
    return found


def adjacency(name: str, own, other, place) -> list:
    """Rows of edges by site, those of sites that are visited one after the other side by side; for each site the first of its row and the one
    after its last."""
    edges = np.argsort(place[own], kind="stable")
    end = np.cumsum(np.bincount(place[own], minlength=len(place)))[place]
    rows = np.stack([end - np.bincount(own, minlength=len(place)), end], axis=1)
    return [pairs(f"{name}_row", rows), whole_table(name, edges.tolist()), whole_table(f"{name}_end", other[edges].tolist())]


def pairs(name: str, rows) -> Table:
    """Of two whole numbers in a row."""
    return whole_table(name, map(tuple, rows.tolist()), 2)


def whole_table(name: str, numbers, columns: int = 0) -> Table:
    """Of numbers of sites and edges, which `limits.SITES` and `limits.EDGES` keep below 2^31. An array of C has at least one entry."""
    return Table(name, "int32_t", tuple(numbers) or (0,), columns)


def pattern_tables(pattern) -> list:
    entries = {"rows": pattern.rowptr, "columns": pattern.col, "diagonal": pattern.diag, "block_rows": pattern.place}
    return [Table(f"smg_{name}", "int32_t", tuple(map(int, values)), wanted=True) for name, values in entries.items()]
