"""Couplings from arrays and sparse matrices, and sites from atoms: what `Model.graph` and `Model.crystal` write into a spec."""
from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..errors import UsageError
from ..language import limits
from ..language.shells import SHELLS, Unclear, shell
from ..packages import needed

SAME = 1e-9         # of a cell: closer fractions are equal


def edges_of(name: str, couplings) -> np.ndarray:
    """Rows i, j, J: of a square matrix, dense or of scipy.sparse, its entries above the diagonal, or of rows as they are.

    A matrix is symmetric, or has entries on one side of the diagonal alone; an entry below stands for the one above. Raises UsageError.
    """
    if hasattr(couplings, "tocoo"):
        coo = couplings.tocoo()
        coo.sum_duplicates()
        return of_matrix(name, coo.shape, coo.row, coo.col, coo.data)
    rows = np.asarray(couplings, float)
    if rows.ndim != 2 or not rows.size:
        raise UsageError(f"the couplings of '{name}' must be a square matrix or rows i, j, J, not an array of shape {rows.shape}")
    if rows.shape[0] == rows.shape[1] and not is_list(rows):
        return of_matrix(name, rows.shape, *np.nonzero(rows), rows[np.nonzero(rows)])
    return rows


def is_list(rows) -> bool:
    """Are three rows of three numbers a list of edges? Where their first two columns are numbers of different sites, and they are no symmetric matrix."""
    pairs = rows[:, :2]
    return rows.shape == (3, 3) and np.all(pairs == np.rint(pairs)) and np.all(pairs >= 0) and np.all(pairs[:, 0] != pairs[:, 1]) and not np.array_equal(rows, rows.T)


def of_matrix(name: str, shape, row, column, data) -> np.ndarray:
    """The pairs that a matrix couples, each once."""
    if shape[0] != shape[1]:
        raise UsageError(f"the couplings of '{name}' must be a square matrix, not one of {shape[0]} x {shape[1]}")
    some = np.asarray(data) != 0
    row, column, data = np.asarray(row)[some].astype(np.int64), np.asarray(column)[some].astype(np.int64), np.asarray(data, float)[some]
    if np.any(row == column):
        site = row[np.argmax(row == column)]
        raise UsageError(f"the couplings of '{name}' couple site {site} to itself; an anisotropy is an effect over \"site(i) of w\"")
    found: dict = {}
    for i, j, J in zip(row.tolist(), column.tolist(), data.tolist()):
        other = found.setdefault((min(i, j), max(i, j)), J)
        if other != J:
            raise UsageError(f"the couplings of '{name}' are not symmetric: {other:g} and {J:g} for sites {min(i, j)} and {max(i, j)}")
    if not found:
        raise UsageError(f"the couplings of '{name}' are all 0")
    return np.array([(i, j, J) for (i, j), J in sorted(found.items())], float)


def loaded(couplings):
    """A matrix from a file: .npz of scipy.sparse, .mtx of Matrix Market, .npy; anything else as it is."""
    if not isinstance(couplings, (str, os.PathLike)):
        return couplings
    path = Path(couplings)
    if path.suffix not in (".npz", ".mtx", ".npy"):
        raise UsageError(f"{path}: couplings must be in an .npz file of scipy.sparse, an .mtx file or an .npy file")
    try:
        if path.suffix == ".npy":
            return np.load(path, allow_pickle=False)
        return needed("scipy.sparse", f"{path}").load_npz(path) if path.suffix == ".npz" else needed("scipy.io", f"{path}").mmread(path)
    except (OSError, ValueError) as problem:
        raise UsageError(f"cannot read {path}: {problem}") from None


def atoms_of(source):
    """Atoms as ASE has them; of a path, such as one of a .cif, by ase.io.read. Raises UsageError, MissingTool without the package ase."""
    if not isinstance(source, (str, os.PathLike)):
        if not all(hasattr(source, name) for name in ("cell", "pbc", "get_scaled_positions", "get_chemical_symbols")):
            raise UsageError(f"atoms must be an ase.Atoms or the path of a file that ASE reads, not a {type(source).__name__}")
        return source
    try:
        return needed("ase.io", f"{source}").read(source)
    except (OSError, ValueError, KeyError, IndexError, StopIteration, AssertionError) as problem:
        raise UsageError(f"cannot read {source}: {problem}") from None


def lattice_of(name: str, source, elements) -> dict:
    """vectors, positions and boundary of the lattice of these atoms; elements: those that carry a vector, by default all."""
    atoms = atoms_of(source)
    symbols = np.array(atoms.get_chemical_symbols())
    wanted = [elements] if isinstance(elements, str) else list(elements or dict.fromkeys(symbols.tolist()))
    missing = [element for element in wanted if element not in symbols]
    if missing or not len(symbols):
        raise UsageError(f"'{name}' has no atoms{f' of {missing[0]}' if missing else ''}; there are: {', '.join(dict.fromkeys(symbols.tolist()))}")
    periodic = np.broadcast_to(atoms.pbc, 3).astype(bool)
    fractions = in_one_cell(name, np.asarray(atoms.get_scaled_positions(wrap=False), float)[np.isin(symbols, wanted)], periodic)
    if len(fractions) > limits.CELL:
        raise UsageError(f"'{name}' has {len(fractions)} sites in a cell; at most {limits.CELL} are allowed")
    return {"vectors": np.asarray(atoms.cell, float).tolist(), "positions": fractions.tolist(),
            "boundary": ["periodic" if closed else "open" for closed in periodic]}


def in_one_cell(name: str, fractions, periodic):
    """Fractions from 0 to below 1: modulo 1 where cells repeat; along an open direction all atoms are moved together, so that they keep their distances."""
    steps = np.where(periodic, np.floor(fractions + SAME), np.floor(fractions.min(axis=0) + SAME))
    steps = np.where(~periodic & (np.max(fractions - steps, axis=0) >= 1 - SAME), fractions.min(axis=0), steps)
    found = fractions - steps
    found = np.where(np.abs(found) < SAME, 0.0, found)
    if len(beyond := np.flatnonzero(found.max(axis=0) >= 1)):
        raise UsageError(f"the atoms of '{name}' extend beyond one cell along vector {beyond[0] + 1}, which is not periodic; use a longer vector")
    return found


def shells_within(name: str, says: dict, size, couplings, cutoff: float | None) -> dict:
    """Shell -> its coupling. Raises UsageError for more couplings than shells, or one of a shell beyond the cutoff or beyond open ends."""
    couplings = list(couplings)
    if not 1 <= len(couplings) <= len(SHELLS):
        raise UsageError(f"'{name}' has {len(couplings)} couplings; give one for each shell, from 1 to {len(SHELLS)}")
    for k in range(len(couplings)):
        bonds = bonds_of(name, says, k)
        length = length_of(says, bonds[0])
        if not any(stays(offset, size, says["boundary"]) for _, (_, offset) in bonds):
            raise UsageError(f"the {SHELLS[k]} shell of '{name}', at {length:.6g}, has no bonds: all of them leave the crystal along vectors that are not periodic; use longer vectors there")
        if cutoff is not None and length > cutoff:
            raise UsageError(f"the {SHELLS[k]} shell of '{name}' is at {length:.6g}, beyond the cutoff {cutoff:g}: {len(couplings)} couplings are too many")
    return dict(zip(SHELLS, couplings))


def bonds_of(name: str, says: dict, k: int) -> tuple:
    """Those of a shell."""
    try:
        return shell(says["vectors"], says["positions"], 3, k)
    except (Unclear, np.linalg.LinAlgError) as problem:
        raise UsageError(f"the cell of '{name}' has no shells: {problem}") from None


def stays(offset, size, boundary) -> bool:
    """Is a bond of this offset in the crystal? A size that is a formula may be large enough."""
    return all(ends == "periodic" or not isinstance(n, int) or abs(away) < n for away, n, ends in zip(offset, size, boundary))


def length_of(says: dict, bond) -> float:
    """The distance of the neighbours that it joins."""
    vectors, positions = np.array(says["vectors"]), np.array(says["positions"])
    (a, _), (b, offset) = bond
    return float(np.linalg.norm((np.array(offset) + positions[b] - positions[a]) @ vectors))
