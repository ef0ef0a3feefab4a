"""The instances of an index family: which numbers its indices take, term by term."""
from __future__ import annotations

import numpy as np

from .evaluate import integer
from .spec import Each, Graph, Lattice, Once, Pairs, Sites


def instances_of(over, env: dict, places: dict) -> tuple[dict, dict]:
    """(index name -> int array, column name -> float array), all of equal length.

    env: parameter values; places: family -> (first site, number of sites).
    """
    return _KINDS[type(over)](over, env, places)


def _once(over, env, places):
    return {}, {}


def _sites(over, env, places):
    return {over.index: np.arange(places[over.family][1])}, {}


def _pairs(over, env, places):
    first, second = np.triu_indices(places[over.family][1], 1)
    return {over.first: first, over.second: second}, {}


def _each(over, env, places):
    counts = [places[family][1] for family in over.families]
    return dict(zip(over.indices, np.indices(counts).reshape(len(counts), -1))), {}


def _graph(over, env, places):
    edges = over.ends
    columns = {name: np.array(values, dtype=float) for name, values in over.columns}
    return {over.first: edges[:, 0], over.second: edges[:, 1]}, columns


def _lattice(over: Lattice, env, places):
    size = [integer(e, env, "the size of a lattice") for e in over.size]
    cells = np.indices(size[::-1]).reshape(len(size), -1)[::-1]    # first direction fastest
    bonds = [_bond(over, size, cells, bond) for bond in over.bonds]
    found = np.concatenate(bonds, axis=1)
    columns = {name: np.repeat(values, [bond.shape[1] for bond in bonds]) for name, values in over.columns}
    return {**dict(zip(over.indices, found)), **({over.number: np.arange(found.shape[1])} if over.number else {})}, columns


def _bond(over, size, cells, bond):
    """The sites (one row an index) of one bond in every cell where it exists."""
    ends = [_end(over, size, cells, sub, offset) for sub, offset in bond]
    inside = np.logical_and.reduce([there for _, there in ends])
    return np.array([site[inside] for site, _ in ends])


def _end(over, size, cells, sub, offset):
    """Site numbers cell*sites + sub of the shifted cells, and which of them exist."""
    number, inside = np.zeros(cells.shape[1], np.int64), np.ones(cells.shape[1], bool)
    for c, n, shift, periodic in reversed(list(zip(cells, size, offset, over.periodic))):
        moved = c + shift
        inside &= periodic | ((moved >= 0) & (moved < n))
        number = number * n + moved % n
    return number * over.sites + sub, inside


_KINDS = {Once: _once, Sites: _sites, Pairs: _pairs, Each: _each, Graph: _graph,
          Lattice: _lattice}
