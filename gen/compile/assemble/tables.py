"""Constant tables: of the spec, edges and weights of graphs, the pattern of a sparse elimination."""
from __future__ import annotations

import numpy as np

from ...language.spec import Graph
from ..lower.code import Table
from ..lower.loops import graph_name
from .norms import share_tables
from .visiting import edge_order, visit_tables


def tables(model) -> list:
    found = [Table(f"table_{name}", "double", tuple(values)) for name, values in model.low.constants().items()]
    graphs = {graph_name(t.over): t.over for t in (*model.fields, *model.observables) if isinstance(t.over, Graph)}
    found += [table for name, over in graphs.items() for table in graph_tables(name, over)]
    found += [*share_tables(model), *visit_tables(model)]
    return found + (pattern_tables(model.plan.pattern) if model.plan.solver == "sparse" else [])


def graph_tables(name: str, over: Graph) -> list:
    """Edges, weights, and the edges that each site begins and ends, with their other ends."""
    order = edge_order(over)
    ends = over.ends[order]
    found = [Table(f"{name}_edge", "int32_t", tuple(map(tuple, ends.tolist())), columns=2)]
    found += [Table(f"{name}_{column}", "double", tuple(np.array(values)[order].tolist())) for column, values in over.columns]
    for side, label in enumerate(("first", "second")):
        starts, edges = np.cumsum(np.bincount(ends[:, side], minlength=1 + over.highest)), np.argsort(ends[:, side], kind="stable")
        found += [whole_table(f"{name}_{label}_row", (0, *starts.tolist())),
                  whole_table(f"{name}_{label}", edges.tolist()), whole_table(f"{name}_{label}_end", ends[edges, 1 - side].tolist())]
    return found


def whole_table(name: str, numbers) -> Table:
    """Of numbers of sites and edges, which `limits.EDGES` and `limits.SITES` keep below 2^31; a table of C has an entry at least."""
    return Table(name, "int32_t", tuple(numbers) or (0,))


def pattern_tables(pattern) -> list:
    entries = {"rows": pattern.rowptr, "columns": pattern.col, "diagonal": pattern.diag, "block_rows": pattern.place}
    return [Table(f"smg_{name}", "int32_t", tuple(map(int, values)), wanted=True) for name, values in entries.items()]
