"""The dynamical structure factor S(q, omega) of a lattice, without the trajectory.

    found = smidgen.spectrum(spec, q="0 1/2", time=200, every=10)
    found.omega[found.mean.argmax(axis=1)]      # where each wave is strongest

At each output the spatial Fourier components S_q(t) of the chosen q are kept and nothing else. From M of them, dt apart, and
a window g_n,

    S_a(q, omega_m) = |sum_n g_n S_q,a(t_n) exp(i omega_m t_n)|^2 / (M sum_n g_n^2),    omega_m = 2 pi m/(M dt),

for each component a = x, y, z, so that the sum over omega is the mean of |S_q,a|^2 over time, weighted by g_n^2 (Parseval).
A wave cos(2 pi q.r - omega t) is at (q, omega) and at (-q, -omega).
"""
from __future__ import annotations

import io
import json
import math
import os
import zipfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import OutputError, UsageError
from ..public import ReadOnly, public
from ..read.shipped import SpecLike, spec_or_name
from ..run.files.durable import write_new
from ..run.fields.field import Field
from ..run.fields.grid import Grid, family_of, of
from ..run.step.prepared import choose
from ..run.record.record import Recorder
from ..run.run import MEMORY, advance, describe
from ..run.settings import model_of, settle, whole
from .spin_waves import SpinWaves, is_path, packed, state_of, theory as theory_of
from .waves import Components, waves, zone

WINDOWS = ("none", "hann")
COMPONENTS = ("xx", "yy", "zz")
BETWEEN = 8             # steps of the theory's q between two waves of the lattice
BLOCK = 2 ** 18         # complex numbers that are transformed at a time: 4 MiB


@dataclass(repr=False)
class Spectrum(ReadOnly):
    """S(q, omega) of a family, in the units of the spec.

    :ivar q: the wave vectors in units of the reciprocal lattice vectors, shape (waves, directions).
    :ivar omega: the angular frequencies in ascending order, shape (frequencies,).
    :ivar s: S for each component, shape (waves, frequencies, 3).
    :ivar equal_time: the mean of |S_q|^2 over time, shape (waves, 3); None if the spectrum was read from a .csv.
    :ivar autocorrelation: the mean of conj(S_q(t)) S_q(t + tau) over t, shape (waves, frequencies, 3), for the times `tau`, shape
        (frequencies,); both are None if not requested.
    :ivar neutron: the quantity measured by neutron scattering, the sum over a, b of S_ab (delta_ab - q_a q_b/|q|^2), shape (waves, frequencies); None if not requested.
    :ivar theory: the lines of linear spin waves, a `SpinWaves`; None if not requested, and if the spectrum was read from a .csv.
    :ivar meta: everything else about the run.
    """
    INSTEAD = {"": "compute another spectrum with smidgen.spectrum(spec, ...)"}
    meta: dict
    q: np.ndarray
    omega: np.ndarray
    s: np.ndarray
    equal_time: np.ndarray | None
    tau: np.ndarray
    autocorrelation: np.ndarray | None = None
    neutron: np.ndarray | None = None
    theory: SpinWaves | None = None

    def __repr__(self) -> str:
        return (f"<Spectrum {self.meta['spec']} {self.meta['run']}: {self.meta['family']}, {len(self.q)} waves, "
                f"{len(self.omega)} frequencies {self.omega[0]:.6g} .. {self.omega[-1]:.6g}>")

    @property
    def names(self) -> list[str]:
        """The name of each wave vector that is a special point of the zone, otherwise ""."""
        zone = self.meta.get("zone", {})
        return [next((name for name, corner in zone.items() if np.allclose(q, corner, rtol=0, atol=1e-9)), "") for q in self.q]

    @property
    def wave_vectors(self) -> np.ndarray | None:
        """The wave vectors in space, in units of 1/length, shape (waves, 3); None if the spec gives no positions."""
        return self.q @ np.array(self.meta["reciprocal"]) if self.meta.get("reciprocal") else None

    @property
    def mean(self) -> np.ndarray:
        """The mean of s over the three components, shape (waves, frequencies)."""
        return self.s.mean(axis=-1)

    @property
    def resolution(self) -> float:
        """The distance between two frequencies, 2 pi over the duration of a part."""
        return float(self.omega[1] - self.omega[0])

    def save(self, path: str | os.PathLike) -> Path:
        """Write a .npz with all arrays and `meta` as JSON, or a .csv with a row for each q and omega. `smidgen.load_spectrum` reads both.

        :raises OutputError: if the file cannot be written.
        """
        path = saved_as(path)
        data = self._npz() if path.suffix == ".npz" else self._csv()
        try:
            write_new(path, data)
        except OSError as problem:
            raise OutputError(f"cannot write {path}: {problem.strerror or problem}") from None
        return path

    def _npz(self) -> bytes:
        arrays = {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as archive:
            for name, value in {**arrays, **packed(self.theory), "meta": np.array(json.dumps(self.meta))}.items():
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:     # without a date: the same run gives the same bytes
                    np.lib.format.write_array(member, np.ascontiguousarray(value) if value.ndim else value, allow_pickle=False)
        return out.getvalue()

    def _csv(self) -> bytes:
        names = [*(f"q{k}" for k in range(self.q.shape[1])), "omega", *COMPONENTS]
        q = np.repeat(self.q, len(self.omega), axis=0)
        rows = np.hstack([q, np.tile(self.omega, len(self.q))[:, None], self.s.reshape(-1, 3)])
        out = io.BytesIO()
        out.write(f"# meta: {json.dumps(self.meta)}\n{','.join(names)}\n".encode())
        np.savetxt(out, rows, "%.17g", delimiter=",")
        return out.getvalue()


def saved_as(path) -> Path:
    """`path`, if its ending is one that a spectrum has. Raises UsageError."""
    if Path(path).suffix not in (".npz", ".csv"):
        raise UsageError(f"{path}: the name of a spectrum must end in .npz or .csv")
    return Path(path)


@public
@spec_or_name
def spectrum(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | Field | None = None, method: str | None = None,
             solver: str | None = None, h: float | str | None = None, steps: int | None = None, time: float | str | None = None,
             every: int | None = None, effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None,
             seed: int | None = None, native: bool | None = None, threads: int | None = None, family: str | None = None, q="all",
             window: str = "none", parts: int = 1, autocorrelation: bool = False, neutron: bool = False,
             theory: bool | str | np.ndarray | SpinWaves = False, basis=None, progress: Callable[[int], object] = lambda done: None) -> Spectrum:
    """Run a spec and compute the spectrum S(q, omega) of the spins of a family on its lattice. Arguments not listed here are as for `run`.

    :param family: the family; needed if there are several.
    :param q: "all" wave vectors of the first zone; a path such as "0,0 1/2,0 1/2,1/2" or "Gamma K M Gamma", for all wave vectors of the
        lattice on it; or an array of shape (waves, directions). In units of the reciprocal lattice vectors.
    :param window: "none", or "hann" to suppress leakage from strong lines: g_n = sin^2(pi n/M) (F. J. Harris, Proc. IEEE 66 (1978) 51).
    :param parts: the number of equal parts into which the run is divided and whose spectra are averaged (M. S. Bartlett, Biometrika 37
        (1950) 1), for less noise and memory but wider lines.
    :param autocorrelation: whether to compute autocorrelations in time too.
    :param neutron: whether to also compute the quantity measured by neutron scattering; at q = 0 it is averaged over all directions of q.
    :param theory: True for the lines of linear spin waves near the equilibrium that relaxation reaches from the start; or an equilibrium, as
        the name of a start or as a state of shape (sites, 3); or lines of `spin_waves` at the same q, for instance of some effects only.
    :param basis: the positions of the sites of a cell, shape (sites, directions); by default those of the spec, otherwise fractions of the
        diagonal of the cell.
    :raises UsageError: for an argument that does not fit.
    :raises RunError: if a step fails. Errors of `build`.

    Outputs at t = 0, dt, 2 dt, ... with dt = h every are used, except the one at the end. A part with M outputs resolves frequencies 2
    pi/(M |dt|) apart, up to pi/|dt|; faster waves are aliased to lower frequencies. The formula is in docs/lattices.md. For each wave vector,
    72 bytes per output of a part are needed (120 with autocorrelation), at most 2 GiB in total.
    """
    settings = settle(spec, run, start=start, method=method, solver=solver, h=h, steps=steps, time=time, every=every,
                      effects=effects, parameters=parameters, seed=seed, native=native, threads=threads)
    choose("window", window, WINDOWS)
    family = family_of(spec, family)
    grid = of(spec, family, settings.parameters)
    m, length = waves(grid, q), part_length(settings, parts)
    affordable(len(m) * length, autocorrelation)
    lines = found_lines(settings, settings.prepared(spec).numbers, family, grid, m, q, theory, basis)
    across = directions(grid, m) if neutron else None
    model = model_of(spec, settings)
    model.start(settings.own_start, h=settings.h, seed=settings.seed, tolerance=settings.tolerance)
    keeper = Keeper(family, Components(grid, m, basis), len(m), length, window, parts, autocorrelation, across)
    recorder = stepped(model, settings, family, grid, keeper, progress)
    chosen = {"family": family, "waves": q.strip() if isinstance(q, str) else "given", "window": window, "parts": parts, "in_parts": len(recorder.substeps), **told_of(grid)}
    return keeper.result({**describe(model, settings, "complete"), **chosen}, m / np.array(grid.size), settings.h * settings.every, lines)


def found_lines(settings, numbers, family: str, grid: Grid, m, q, theory, basis) -> SpinWaves | None:
    """The lines that are asked for, smooth along a path. Raises UsageError before the run."""
    if theory is False:
        return None
    if isinstance(theory, SpinWaves):
        return fitting(theory, family, m / np.array(grid.size))
    w = state_of(numbers, settings.start, settings.seed) if theory is True else state_of(numbers, theory, None)
    between = BETWEEN if is_path(q) else 1
    return theory_of(numbers, family, grid, m / np.array(grid.size), w, relax=theory is True, basis=basis, between=between)


def fitting(theory: SpinWaves, family: str, q) -> SpinWaves:
    """Lines that are given. Raises UsageError where they are those of another family or of other wave vectors."""
    if theory.meta["family"] != family:
        raise UsageError(f"the lines given are those seen in '{theory.meta['family']}', not in '{family}'")
    own = theory.q[::theory.meta["between"]]
    if own.shape != q.shape or not np.allclose(own, q, rtol=0, atol=1e-9):
        raise UsageError("the lines given belong to other wave vectors: compute them with the same q")
    return theory


def directions(grid: Grid, m) -> np.ndarray:
    """q/|q| of each wave, (waves, 3); 0 at q = 0. Raises UsageError without places."""
    reciprocal = grid.reciprocal()
    if reciprocal is None:
        raise UsageError("the neutron factor needs the direction of q in space: use a named lattice, or one with vectors and positions")
    q = m / np.array(grid.size) @ reciprocal
    length = np.linalg.norm(q, axis=1, keepdims=True)
    return q / np.where(length > 0, length, 1)


def told_of(grid: Grid) -> dict:
    """Its zone for the metadata: corners by name, and the reciprocal vectors in units of 1/length, [] without places."""
    reciprocal = grid.reciprocal()
    return {"zone": {name: [float(x) for x in q] for name, q in zone(grid).items()}, "reciprocal": [] if reciprocal is None else reciprocal.tolist()}


def part_length(settings, parts) -> int:
    """Outputs of a part."""
    parts = whole(parts, "parts")
    length = settings.steps // settings.every // parts if parts else 0
    if length < 2:
        raise UsageError(f"{settings.steps} steps with an output every {settings.every} cannot be divided into {parts} parts of at least two outputs")
    return length


def affordable(numbers: int, autocorrelation: bool) -> None:
    """Raise UsageError for a spectrum beyond MEMORY."""
    total = numbers * (120 if autocorrelation else 72)
    if total > MEMORY:
        raise UsageError(f"the spectrum takes {total / 2 ** 30:.1f} GiB of memory, but at most {MEMORY / 2 ** 30:.0f} are allowed: choose fewer q, a larger every, or more parts")


def stepped(model, settings, family: str, grid: Grid, keeper: Keeper, progress) -> Recorder:
    """Take all steps; the keeper sees the states on the way. Raises RunError, and KeyboardInterrupt on Ctrl-C."""
    recorder = Recorder(model, {family: ((grid.count, 3), model.real)}, [keeper], settings.steps * settings.h)
    status, error = advance(model, settings, recorder, progress, lambda: None)
    if error is not None:
        raise error
    if status != "complete":
        raise KeyboardInterrupt
    recorder.flush()
    return recorder


class Keeper:
    """A sink that keeps the components of the states of one part, and the sums of their spectra over the parts."""

    def __init__(self, family: str, components: Components, count: int, length: int, window: str, parts: int, lagged: bool, across=None):
        self.family, self.components, self.parts, self.seen = family, components, parts, 0
        self.rows = np.empty((length, count, 3), complex)
        self.window = np.sin(np.pi * np.arange(length) / length) ** 2 if window == "hann" else np.ones(length)
        self.s, self.equal_time = np.zeros((count, length, 3)), np.zeros((count, 3))
        self.lagged = np.zeros((count, length, 3), complex) if lagged else None
        self.across, self.neutron = across, None if across is None else np.zeros((count, length))

    def write(self, chunk: dict) -> None:
        """More outputs; those behind the last part are left out."""
        for w in chunk[self.family]:
            part, k = divmod(self.seen, len(self.rows))
            if part == self.parts:
                return
            self.rows[k] = self.components.of(w)
            self.seen += 1
            if k == len(self.rows) - 1:
                self.add()

    def add(self) -> None:
        """The part that is complete, some waves at a time."""
        size = max(1, BLOCK // (6 * len(self.rows)))
        for begin in range(0, self.rows.shape[1], size):
            now = slice(begin, begin + size)
            rows = self.rows[:, now]
            s = power(rows, self.window).swapaxes(0, 1)
            self.s[now] += s
            if self.across is not None:
                self.neutron[now] += seen_by_neutrons(s, rows, self.across[now], self.window)
            self.equal_time[now] += np.mean(np.abs(rows) ** 2, axis=0)
            if self.lagged is not None:
                self.lagged[now] += lagged(rows).swapaxes(0, 1)

    def result(self, meta: dict, q, dt: float, theory: SpinWaves | None) -> Spectrum:
        """Means over the parts, frequencies in rising order."""
        length, self.rows = len(self.rows), None        # their memory is that of the copies below
        omega = 2 * np.pi * np.fft.fftfreq(length, dt)
        order = np.argsort(omega)
        for sums in (self.s, self.equal_time, *(one for one in (self.lagged, self.neutron) if one is not None)):
            sums /= self.parts
        return Spectrum(meta, q, omega[order], self.s[:, order], self.equal_time, dt * np.arange(length), self.lagged,
                        None if self.neutron is None else self.neutron[:, order], theory)


def power(rows, window) -> np.ndarray:
    """|sum_n g_n x_n exp(2 pi i m n/M)|^2/(M sum g_n^2) of rows (M, ..): numpy's inverse transform has this sign, and 1/M before the sum."""
    found = np.fft.ifft(rows * window[:, None, None], axis=0)
    return np.abs(found) ** 2 * (len(rows) / math.fsum(window ** 2))


def seen_by_neutrons(s, rows, across, window) -> np.ndarray:
    """(waves, M): the sum of S_aa less |q^.S|^2, q^ = q/|q|, of rows (M, waves, 3) with the power s; at q = 0 the mean over directions."""
    along = power(np.einsum("tqa,qa->tq", rows, across)[..., None], window)[..., 0].T
    return s.sum(axis=2) * np.where(across.any(axis=1), 1, 2 / 3)[:, None] - along


def lagged(rows) -> np.ndarray:
    """(1/(M - j)) sum_n conj(x_n) x_(n+j) for j = 0 .. M-1, by a transform of twice the length (Wiener and Khinchin)."""
    length = len(rows)
    sums = np.fft.ifft(np.abs(np.fft.fft(rows, 2 * length, axis=0)) ** 2, axis=0)[:length]
    return sums / (length - np.arange(length))[:, None, None]
