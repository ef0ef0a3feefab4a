"""Elimination order and fill of a sparse block matrix, found once, when code is generated.

The matrix has a block wherever two sites share a term (both ways) and on the diagonal. Its
block LU factors in an order of minimum degree; see runtime/newton/smg_sparse.h for the numbers' side.
"""
from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np


class TooMuchFill(ValueError):
    """The factors would have more blocks than the limit."""


@dataclass(frozen=True)
class Pattern:
    """Pattern of L + U in the order of elimination; all arrays int32.

    perm[new] = old and place[old] = new number of a site; row `new` has the columns
    col[rowptr[new]:rowptr[new + 1]], ascending; col[diag[new]] == new.
    """
    size: int
    perm: np.ndarray = field(repr=False)
    place: np.ndarray = field(repr=False)
    rowptr: np.ndarray = field(repr=False)
    col: np.ndarray = field(repr=False)
    diag: np.ndarray = field(repr=False)
    fill: int
    multiplications: int

    @property
    def blocks(self) -> int:
        """Number of blocks of L + U, the fill included."""
        return len(self.col)

    def position(self, i, j) -> np.ndarray:
        """Where the block of the sites i, j (arrays of old numbers) stands among the blocks.

        Raises KeyError for a pair outside the pattern.
        """
        rows, cols = self.place[np.asarray(i)], self.place[np.asarray(j)]
        found = np.searchsorted(self._keys, rows.astype(np.int64) * self.size + cols)
        found = np.minimum(found, self.blocks - 1)
        if np.any(self._keys[found] != rows.astype(np.int64) * self.size + cols):
            raise KeyError("some of these pairs have no block in the pattern")
        return found.astype(np.int32)

    @cached_property
    def _keys(self) -> np.ndarray:
        rows = np.repeat(np.arange(self.size, dtype=np.int64), np.diff(self.rowptr))
        return rows * self.size + self.col


def symbolic(size: int, edges, limit: int | None = None) -> Pattern:
    """Order `size` sites joined by `edges` (pairs, any direction, repeats allowed) and find the fill.

    Raises TooMuchFill as soon as the factors are sure to hold more than `limit` blocks, and
    ValueError for an edge that leaves the sites. Same input, same output.
    """
    edges = np.asarray(edges if isinstance(edges, np.ndarray) else list(edges), dtype=np.int64).reshape(-1, 2)
    if limit is not None and size + 2 * _distinct(edges) > limit:
        raise TooMuchFill(f"the factors need more than {limit} blocks")
    if edges.size and (edges.min() < 0 or edges.max() >= size):
        raise ValueError(f"an edge names a site that does not exist: there are {size} sites")
    order, higher = minimum_degree(_adjacency(size, edges), limit)
    return _pattern(size, edges, order, higher)


def _adjacency(size: int, edges: np.ndarray) -> list[set[int]]:
    neighbours: list[set[int]] = [set() for _ in range(size)]
    for i, j in edges.tolist():
        if i != j:
            neighbours[i].add(j)
            neighbours[j].add(i)
    return neighbours


def minimum_degree(neighbours: list[set[int]], limit: int | None = None):
    """The elimination game (Rose 1972), least degree first, least number on a tie.

    Eliminating a site joins its neighbours to a clique. Returns the order and, for each
    site, the neighbours that were left when it went: its row of U. Spoils `neighbours`.
    Every pair that is joined stays in the factors: the blocks known so far only grow.
    """
    heap = [(len(near), site) for site, near in enumerate(neighbours)]
    heapq.heapify(heap)
    order, higher, blocks = [], {}, len(neighbours) + sum(map(len, neighbours))
    while heap:
        if limit is not None and blocks > limit:
            raise TooMuchFill(f"the factors need more than {limit} blocks")
        degree, site = heapq.heappop(heap)
        if site in higher or degree != len(neighbours[site]):
            continue
        order.append(site)
        higher[site] = neighbours[site]
        blocks += _join(neighbours, site, heap)
    return order, higher


def _join(neighbours: list[set[int]], site: int, heap: list) -> int:
    """How many blocks it adds."""
    clique, added = neighbours[site], 0
    for other in sorted(clique):
        near = neighbours[other]
        before = len(near)
        near |= clique
        near -= {site, other}
        added += len(near) - before + 1
        heapq.heappush(heap, (len(near), other))
    return added


def _pattern(size: int, edges: np.ndarray, order: list[int], higher: dict) -> Pattern:
    place = np.empty(size, dtype=np.int32)
    place[order] = np.arange(size, dtype=np.int32)
    rows: list[list[int]] = [[new] for new in range(size)]
    for site, above in higher.items():
        for other in above:
            rows[place[site]].append(int(place[other]))
            rows[place[other]].append(int(place[site]))
    starts = np.cumsum([0] + [len(row) for row in rows], dtype=np.int64)
    columns = np.array([c for row in rows for c in sorted(row)], dtype=np.int32)
    lower = [sum(c < new for c in row) for new, row in enumerate(rows)]
    degrees = np.array([len(higher[site]) for site in order], dtype=np.int64)
    return Pattern(
        size=size, perm=np.array(order, dtype=np.int32), place=place,
        rowptr=starts.astype(np.int32), col=columns,
        diag=(starts[:-1] + np.array(lower, dtype=np.int64)).astype(np.int32),
        fill=len(columns) - size - 2 * _distinct(edges),
        multiplications=int(np.sum(degrees * (degrees + 1))))


def _distinct(edges: np.ndarray) -> int:
    low, high = edges.min(axis=1), edges.max(axis=1)
    keys = np.sort((low * (high.max(initial=0) + 1) + high)[low != high])
    return int(np.count_nonzero(np.diff(keys, prepend=-1)))
