"""A spectrum from the file that `Spectrum.save` wrote; what the file says is checked before anything is made of it."""
from __future__ import annotations

import os

import numpy as np

from ..public import public
from ..run.files.kinds import count, either, flag, listed, none, number, table, text
from ..run.files.received import Wrong, checked, from_npz, head_of, opened, parsed, refusing, rows_of
from .spectrum import COMPONENTS, Spectrum, saved_as
from .spin_waves import ARRAYS, SpinWaves

ASKED = {"family": text, "waves": text, "window": text, "parts": count, "in_parts": count}     # beside what a run says of itself

PLACED = {"zone": lambda value: isinstance(value, dict) and all(rows_of_numbers([q]) for q in value.values()), "reciprocal": lambda value: rows_of_numbers(value)}    # of lattices with places


THEORY = {"spec": text, "family": text, "cell": listed(count), "turns": listed(number), "torque": number, "moved": number,
          "energy": number, "stable": flag, "between": count, "units": either(none, table(text)), "notes": listed(text)}


def rows_of_numbers(value) -> bool:
    return isinstance(value, list) and all(isinstance(row, list) and 0 < len(row) <= 4 and all(type(x) in (int, float) for x in row) for row in value)


@public
def load_spectrum(path: str | os.PathLike) -> Spectrum:
    """Read a spectrum from a file written by `Spectrum.save` or `smidgen spectrum --out`.

    A .csv contains q, omega and s only; equal_time and autocorrelation are then None.

    :raises UsageError: if it is not such a file.
    """
    read = from_npz if saved_as(path).suffix == ".npz" else from_csv
    with refusing(path), opened(path) as file:
        given, arrays = read(file, os.fstat(file.fileno()).st_size)
        meta = known(given)
        arrays.setdefault("tau", meta["h"] * meta["every"] * np.arange(arrays["omega"].size))
        fit(arrays)
        theory = unpacked(arrays, meta)
        names = ("q", "omega", "s", "equal_time", "tau", "autocorrelation", "neutron")
        return Spectrum(meta, *map(arrays.get, names), theory)


def from_csv(file, size) -> tuple:
    """(text of the metadata, arrays): a row for each q and omega, all frequencies of one wave after the other."""
    comments, header = head_of(file)
    names = header.strip().split(",")
    directions = len(names) - 1 - len(COMPONENTS)
    if directions < 1 or names != [*(f"q{k}" for k in range(directions)), "omega", *COMPONENTS]:
        raise Wrong("it does not have the columns of a spectrum")
    rows = rows_of(file)
    omega = rows[:, directions]
    waves = int(np.sum(omega == omega[0]))
    cube = rows.reshape(waves, -1, len(names))
    if np.any(cube[:, :, :directions] != cube[:, :1, :directions]) or np.any(cube[:, :, directions] != cube[0, :, directions]):
        raise Wrong("its rows are not ordered as in a spectrum")
    return comments.get("meta", ""), {"q": cube[:, 0, :directions], "omega": cube[0, :, directions], "s": cube[:, :, directions + 1:]}


def known(given: str) -> dict:
    """The metadata, in their order, with every key that a spectrum has and no other."""
    meta = parsed(given, lambda value: isinstance(value, dict))
    of_run = checked(meta)
    wrong = [key for key, kind in ASKED.items() if key not in meta or not kind(meta[key])]
    if wrong:
        raise Wrong(f"'{wrong[0]}' is missing from its metadata, or invalid")
    wrong = [key for key, kind in PLACED.items() if key in meta and not kind(meta[key])]
    if wrong:
        raise Wrong(f"'{wrong[0]}' in its metadata is invalid")
    return {**{key: meta[key] for key in meta if key in of_run or key in ASKED or key in PLACED}, **{key: of_run[key] for key in of_run if key not in meta}}


def unpacked(arrays: dict, meta: dict) -> SpinWaves | None:
    """The lines of linear spin waves, where the file has them. Raises Wrong."""
    found = [arrays.get(f"theory_{name}") for name in ARRAYS]
    text_ = arrays.get("theory_meta")
    if text_ is None and all(array is None for array in found):
        return None
    if text_ is None or text_.dtype.kind != "U" or text_.shape != () or any(array is None or array.dtype.kind != "f" for array in found):
        raise Wrong("arrays of its theory are missing")
    q, omega, weights, growth, w = found
    if q.ndim != 2 or q.shape[1] != arrays["q"].shape[1] or omega.ndim != 2 or len(omega) != len(q) or growth.shape != omega.shape \
            or weights.shape != (*omega.shape, 3) or w.ndim != 2 or w.shape[1] != 3:
        raise Wrong("the arrays of its theory have inconsistent shapes")
    given = parsed(str(text_), lambda value: isinstance(value, dict))
    known_ = set(given) == set(THEORY) and all(kind(given[name]) for name, kind in THEORY.items())
    if not known_ or len(q) - 1 != given["between"] * (len(arrays["q"]) - 1):
        raise Wrong("the metadata of its theory are invalid")
    return SpinWaves(given, *found)


def fit(arrays: dict) -> None:
    """Do all shapes fit? Raises Wrong."""
    if any(name not in arrays or arrays[name].dtype.kind != "f" for name in ("q", "omega", "s", "tau")):
        raise Wrong("it does not contain the arrays of a spectrum")
    waves, m = len(arrays["q"]), arrays["omega"].shape
    wanted = {"s": (waves, *m, 3), "tau": m, "equal_time": (waves, 3), "autocorrelation": (waves, *m, 3), "neutron": (waves, *m)}
    if arrays["q"].ndim != 2 or len(m) != 1 or any(name in arrays and arrays[name].shape != shape for name, shape in wanted.items()):
        raise Wrong("the shapes of its arrays are not consistent")
