"""Constant tables: of the spec, edges and weights of graphs, the pattern of a sparse elimination."""
from __future__ import annotations

import numpy as np

from ...language.spec import Graph
from ..lower.code import Table
from ..lower.loops import graph_name
from .norms import share_tables


def tables(model) -> list:
    found = [Table(f"table_{name}", "double", tuple(values)) for name, values in model.low.constants().items()]
    graphs = {graph_name(t.over): t.over for t in (*model.fields, *model.observables) if isinstance(t.over, Graph)}
    found += [table for name, over in graphs.items() for table in graph_tables(name, over)]
    found += share_tables(model)
    return found + (pattern_tables(model.plan.pattern) if model.plan.solver == "sparse" else [])


def graph_tables(name: str, over: Graph) -> list:
    """Edges, weights, and the edges that each site begins and ends."""
    found = [Table(f"{name}_edge", "int64_t", over.edges, columns=2)]
    found += [Table(f"{name}_{column}", "double", values) for column, values in over.columns]
    for side, label in enumerate(("first", "second")):
        starts = np.cumsum(np.bincount(over.ends[:, side], minlength=1 + over.highest))
        found += [Table(f"{name}_{label}_row", "int64_t", (0, *starts.tolist())),
                  Table(f"{name}_{label}", "int64_t", tuple(np.argsort(over.ends[:, side], kind="stable").tolist()) or (0,))]
    return found


def pattern_tables(pattern) -> list:
    entries = {"rows": pattern.rowptr, "columns": pattern.col, "diagonal": pattern.diag, "block_rows": pattern.place}
    return [Table(f"smg_{name}", "int32_t", tuple(map(int, values)), wanted=True) for name, values in entries.items()]
