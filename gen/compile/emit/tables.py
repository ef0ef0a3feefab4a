"""Constant tables: edges and weights of graphs, the pattern of a sparse elimination."""
from __future__ import annotations

from ...language.spec import Graph
from ..lower.cprint import number


def graph_tables(name: str, over: Graph):
    """Edges, weights, and the edges that each site begins and ends."""
    pairs = ", ".join(f"{{{i}, {j}}}" for i, j in over.edges)
    tables = [f"static const int64_t {name}_edge[][2] = {{{pairs}}};"]
    for column, values in over.columns:
        tables.append(f"static const double {name}_{column}[] = {{{', '.join(number(x) for x in values)}}};")
    sites = 1 + max((max(e) for e in over.edges), default=0)
    for side, label in ((0, "first"), (1, "second")):
        rows = [[k for k, e in enumerate(over.edges) if e[side] == s] for s in range(sites)]
        starts, at = [0], 0
        for r in rows:
            at += len(r)
            starts.append(at)
        flat = [str(k) for r in rows for k in r] or ["0"]
        tables.append(f"static const int64_t {name}_{label}_row[] = {{{', '.join(map(str, starts))}}};")
        tables.append(f"static const int64_t {name}_{label}[] = {{{', '.join(flat)}}};")
    return tables


def pattern_tables(pattern):
    entries = {"rows": pattern.rowptr, "columns": pattern.col, "diagonal": pattern.diag,
               "block_rows": pattern.place}
    return [f"static const int32_t smg_{name}[] = {{{', '.join(str(int(x)) for x in values)}}};"
            for name, values in entries.items()]
