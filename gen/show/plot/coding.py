"""Numbers in a page: base64 of little-endian numbers; what is long is deflated, as changes from output to output."""
from __future__ import annotations

import base64
import zlib

import numpy as np

LEVELS, MASK = 2046, 2047       # greatest coordinate of a direction: right to 0.12 degrees, along the axes exact; `web/load.mjs` reads the same


def packed(values, kind: str) -> str:
    """An array as base64 of little-endian numbers."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def deflated(values, kind: str) -> dict:
    """The same with zlib's compression."""
    return {"deflated": base64.b64encode(zlib.compress(np.ascontiguousarray(values, dtype=kind).tobytes(), 6)).decode("ascii")}


def folded(u) -> np.ndarray:
    """Unit vectors (.., 3) -> points (.., 2) of a square, 0 to LEVELS: the octahedron abs(x) + abs(y) + abs(z) = 1, unfolded.

    Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer, Journal of Computer Graphics Techniques 3 (2014) 1; 0 where u = 0.
    """
    p = u[..., :2] / np.maximum(np.abs(u).sum(axis=-1, keepdims=True), 1e-300)
    low = u[..., 2:] < 0
    p = np.where(low, (1 - np.abs(p[..., ::-1])) * np.where(p < 0, -1, 1), p)
    return np.rint((p + 1) * (LEVELS / 2)).astype(np.uint16)


def changes(q, mask: int) -> dict:
    """Integers (k, ..) as their changes modulo mask + 1: all low bytes, then all high bytes."""
    q = np.asarray(q, np.uint16)
    moves = np.concatenate([q[:1], q[1:] - q[:-1]]) & np.uint16(mask)
    return deflated(np.stack([moves & 255, moves >> 8]), "u1")


def vectors(w, quantum: float, small: bool, ball: bool) -> dict:
    """The states (k, n, 3) of one family: integers in units of `quantum`; of many sites on spheres their directions."""
    if small:
        return {"w": packed(np.rint(w / quantum), "<i2")}
    if not ball:
        return {"changes": changes(np.rint(w / quantum).astype(np.int16).view(np.uint16), 65535)}
    lengths = np.linalg.norm(w[0], axis=1)
    return {"changes": changes(np.stack([folded(state) for state in w]), MASK), "lengths": deflated(lengths, "<f4")}
