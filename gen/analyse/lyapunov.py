"""Lyapunov exponents, by the tangent map and by nearby trajectories.

    top = smidgen.build(spec, features=("tangent",))
    found = smidgen.lyapunov.exponents(top, w, h=0.1, steps=100_000)
    found.values        # the spectrum per unit of time, largest first

The exponents of an orbit are the rates at which tangent vectors grow,

    lambda_i = lim (1/t) ln |M(t) v_i|,    M the derivative of the state at t by the start.

For a symplectic map they come in pairs lambda_i = -lambda_(n+1-i); on a regular orbit vectors
grow in proportion to t, and estimates fall as ln(t)/t. Vectors have no part at sites that are pinned or absent.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..chance import generator
from ..errors import UsageError
from ..public import few, public
from ..run.settings import whole
from ..run.step.integrator import Integrator
from ..run.step.noise import noisy

OFFSET = 1e-8       # separation of nearby trajectories: about the root of the round-off


class Exponents(NamedTuple):
    """Estimates of Lyapunov exponents, per unit of time.

    :ivar values: the estimates at the end of the run, largest first, shape (columns,).
    :ivar times: the times since the start at the end of each block, shape (blocks,).
    :ivar running: the estimates after each block, shape (blocks, columns).
    :ivar growth: the logarithms of the growth in each block, shape (blocks, columns). The estimates are their sums, divided by the time.
    """
    values: np.ndarray
    running: np.ndarray
    times: np.ndarray
    growth: np.ndarray

    def __repr__(self) -> str:
        return f"<Exponents {few(f'{x:.4g}' for x in self.values)} after t = {self.times[-1]:.6g}>"

    def error(self, batches: int = 20) -> np.ndarray:
        """Standard errors (columns,) of `values`, from means over `batches` parts of the run.

        They are honest once a part is longer than the time in which the orbit forgets. Raises
        UsageError where there are fewer blocks than batches, or fewer batches than 2.
        """
        if whole(batches, "batches") < 2:
            raise UsageError(f"an error needs at least 2 batches, not {batches}")
        size = len(self.times) // batches
        if size < 1:
            raise UsageError(f"{len(self.times)} blocks cannot be divided into {batches} batches")
        parts = self.growth[:size * batches].reshape(batches, size, -1).sum(axis=1)
        span = self.times[0] * size
        return parts.std(axis=0, ddof=1) / span / np.sqrt(batches)


@public
def exponents(model: Integrator, w, h: float, steps: int, columns: int | None = None, every: int = 1, t0: float = 0.0,
              seed: int = 0) -> Exponents:
    """The largest Lyapunov exponents of an orbit, by the tangent map.

    Orthonormal vectors tangent to the leaves are propagated and orthonormalised again by a QR factorisation; the logarithms of the
    diagonal of R are summed: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9.

    :param model: an Integrator with the feature "tangent".
    :param w: the start: an array of shape (sites, 3), or the name of a start.
    :param columns: the number of exponents, at most twice the number of sites that move; by default all.
    :param every: the number of steps between orthonormalisations.
    :param seed: the seed of the first vectors.
    :raises UsageError: for an argument that does not fit.
    :raises RunError: if a step fails.
    """
    blocks = _blocks(steps, every)
    model.start(w, h=h, t0=t0)
    v = tangent_vectors(model, 2 * int(model.prepared.numbers.moving.sum()) if columns is None else columns, seed)
    columns = len(v)
    growth = np.empty((blocks, columns))
    for k in range(blocks):
        model.push_forward(v, every)
        v, growth[k] = orthonormal(on_leaves(model, v))
    return _exponents(growth, every * abs(h))


def orthonormal(v):
    """(q, logs) of vectors v (columns, sites, 3): V = Q R and ln |R_ii|, Q of the shape of v."""
    q, r = np.linalg.qr(v.reshape(len(v), -1).T.astype(float))
    return np.ascontiguousarray(q.T).reshape(v.shape).astype(v.dtype), np.log(np.abs(np.diag(r)))


def tangent_vectors(model, columns: int, seed: int = 0) -> np.ndarray:
    """`columns` orthonormal random vectors (columns, sites, 3), tangent to the leaves at the state of model. Raises UsageError."""
    most = 2 * int(model.prepared.numbers.moving.sum())
    if not 1 <= columns <= most:
        raise UsageError(f"columns must be from 1 to {most}, twice the sites of {model.name} that move; not {columns}")
    v = generator("tangent vectors", seed).standard_normal((columns, model.sites, 3))
    return orthonormal(on_leaves(model, v.astype(model.real)))[0]


def on_leaves(model, v) -> np.ndarray:
    """v (columns, sites, 3) without its parts across the leaves at the state of model, and at sites that do not move.

    In exact arithmetic there are none. What rounding leaves of them neither grows nor decays, and so
    would outgrow vectors that decay.
    """
    numbers = model.prepared.numbers
    n = np.einsum("sab,sb->sa", numbers.casimir_matrices, model.w)
    square = np.sum(n * n, axis=1)
    across = np.einsum("csa,sa->cs", v, n) / np.where(square > 0, square, 1)
    return np.where(numbers.moving[:, None], v - across[..., None] * n, v.dtype.type(0))


@public
def nearby(model: Integrator, w, h: float, steps: int, every: int, t0: float = 0.0, offset: float = OFFSET,
           seed: int = 0) -> Exponents:
    """The largest Lyapunov exponent of an orbit, from the separation of two trajectories, without the tangent map.

    The separation is reset to `offset` every `every` steps: G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338. The
    other arguments and the errors are those of `exponents`; models with thermal noise are refused, unless kT is 0.
    """
    if noisy(model.prepared.numbers):
        raise UsageError(f"{model.name} has thermal noise, which would begin anew with each separation: leave out the effect with `kT`")
    blocks, radius = _blocks(steps, every), model.prepared.numbers.radii
    here = model.start(w, h=h, t0=t0).state()
    direction = tangent_vectors(model, 1, seed)[0]
    growth = np.empty((blocks, 1))
    for k in range(blocks):
        beside = _on_spheres(here + offset * direction, radius)
        begun, t = np.linalg.norm(beside - here), t0 + k * every * h
        here, beside = (model.start(x, h=h, t0=t).steps(every).state() for x in (here.copy(), beside))
        apart = np.linalg.norm(beside - here)
        direction, growth[k] = (beside - here) / apart, np.log(apart / begun)
    return _exponents(growth, every * abs(h))


def _on_spheres(w, radius):
    """w with the sites of spheres scaled back to their radius."""
    length = np.linalg.norm(w, axis=1)
    return w * np.where(np.isnan(radius), 1, radius / length)[:, None]


def _blocks(steps: int, every: int) -> int:
    steps, every = whole(steps, "steps"), whole(every, "every")
    if every < 1 or steps < every:
        raise UsageError(f"every must be from 1 to the number of steps, {steps}; not {every}")
    return steps // every


def _exponents(growth, block: float) -> Exponents:
    """Running means of the growth over blocks that last `block` each, the columns in the order of the last."""
    times = block * np.arange(1, len(growth) + 1)
    growth = growth[:, np.argsort(-growth.sum(axis=0), kind="stable")]
    running = np.cumsum(growth, axis=0) / times[:, None]
    return Exponents(running[-1].copy(), running, times, growth)
