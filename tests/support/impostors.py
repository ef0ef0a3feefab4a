"""Integrators that a certificate must refuse, each with what it does well and what it does not.

All have the protocol of `smidgen.check.verify.subject.Subject`. Those in numpy step whole arrays of states
(..., sites, 3) in the precision that they are given; those in C are generated text with a fault
planted before it is compiled.
"""
import dataclasses
import tempfile
from pathlib import Path

import numpy as np

from smidgen.build import binary
from smidgen.build.binary import REALS, SHARED, Built, compile_shared, find_compiler, write_files
from smidgen.compile.emit.emit import generate
from smidgen.language.expr import Op
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import prepare, scene_of
from smidgen.check.verify.subject import Emitted

NEXT, LAST = [1, 2, 0], [2, 0, 1]

# -- systems: field b = dH/dw and energy, kappa = 1 on unit spheres, w' = w x b ------------------


def cross(a, b):
    """np.cross for vectors along the last axis, in a third of its time."""
    return a[..., NEXT] * b[..., LAST] - a[..., LAST] * b[..., NEXT]


class IrreversibleBody:
    """H = sum w_k^2 (1 + sigma w_k)/(2 I_k) of specs/irreversible_rigid_body.toml."""
    name = "irreversible_rigid_body"

    def __init__(self, inertia=(1, 2, 4), sigma=2 / 3):
        self.inertia, self.sigma = np.array(inertia, float), sigma

    def field(self, w, t):
        return (w + 1.5 * w.dtype.type(self.sigma) * w * w) / self.inertia.astype(w.dtype)

    def energy(self, w, t):
        return np.sum(w * w * (1 + w.dtype.type(self.sigma) * w) / (2 * self.inertia.astype(w.dtype)))


class FreeBody(IrreversibleBody):
    """H = sum w_k^2/(2 I_k) of specs/free_rigid_body.toml."""
    name = "free_rigid_body"

    def __init__(self):
        super().__init__(sigma=0.0)


class Chain:
    """H = sum w_i.w_{i+1} on a ring, specs/heisenberg_chain.toml."""
    name = "heisenberg_chain"

    def field(self, w, t):
        return np.roll(w, 1, axis=-2) + np.roll(w, -1, axis=-2)

    def energy(self, w, t):
        return np.sum(w * np.roll(w, -1, axis=-2))


# -- methods -----------------------------------------------------------------------------------


class Impostor:
    """A step in numpy; subclasses say `motion`, one step from (t, w)."""

    def __init__(self, system):
        self.system = system
        self.field, self.energy = system.field, system.energy

    def x(self, w, t):
        """X = w x b."""
        return cross(w, self.field(w, t))

    def step(self, w, t, h):
        return self.motion(w, w.dtype.type(t), w.dtype.type(h))

    def run(self, starts, t, h, counts):
        w, done, out = starts.copy(), 0, []
        for count in counts:
            for k in range(done, count):
                w = self.motion(w, t + k * h, h)
            done = count
            out.append(w)
        return np.array(out)

    def tangent(self, w, t, h, v):
        return None

    def outputs(self, w, t):
        return None


def unit(w):
    return w / np.sqrt(np.sum(w * w, axis=-1, keepdims=True))


def turned(w, axis, angle):
    """w turned about unit axes by angles of shape (..., 1)."""
    c, s = np.cos(angle), np.sin(angle)
    return c * w + s * cross(axis, w) + (1 - c) * np.sum(axis * w, axis=-1, keepdims=True) * axis


class Implicit(Impostor):
    """W - w = increment(m, h) with m = middle((w + W)/2), by plain iteration to the last bit."""
    tolerance = 0.0

    def motion(self, w, t, h):
        u, best = np.zeros_like(w), np.inf
        for _ in range(200):
            v = self.increment(self.middle(w + u / 2), t + h / 2, h)
            moved, u = np.abs(v - u).max(), v
            if moved <= self.tolerance or moved >= best and moved < 1e-13 or not moved < 1e3:
                break
            best = min(best, moved)
        return w + u

    def middle(self, w):
        return unit(w)

    def increment(self, m, t, h):
        return h * self.x(m, t)


class ClassicalMidpoint(Implicit):
    """Order 2, reversible, keeps spheres and momentum; not symplectic."""

    def middle(self, w):
        return w


class GeodesicMidpoint(Implicit):
    """W - w = (2 sin(h|X|/2)/|X|) X(m): order 2, reversible, on the sphere; not symplectic."""

    def increment(self, m, t, h):
        x = self.x(m, t)
        size = np.sqrt(np.sum(x * x, axis=-1, keepdims=True))
        return 2 * np.sin(h * size / 2) / size * x


class EarlyStop(Implicit):
    """The right equation, left at 1e-12: what remains drifts."""
    tolerance = 1e-12


class FrozenSublattices(Impostor):
    """Even sites turn in the field of the odd ones, then odd, then even: exact energy, spheres and
    volume, reversible, order 2; half of every coupled term is frozen, and the map not symplectic."""

    def motion(self, w, t, h):
        for parity, part in ((0, h / 2), (1, h), (0, h / 2)):
            b = self.field(w, t)
            size = np.sqrt(np.sum(b * b, axis=-1, keepdims=True))
            chosen = (np.arange(w.shape[-2]) % 2 == parity)[:, None]
            w = np.where(chosen, turned(w, b / size, -part * size), w)
        return w


class AxisSplitting(Impostor):
    """x, y, z, y, x parts of the chain in turn: symplectic and reversible, but no symmetry is kept."""

    def motion(self, w, t, h):
        for axis, part in ((0, h / 2), (1, h / 2), (2, h), (1, h / 2), (0, h / 2)):
            n = np.eye(3, dtype=w.dtype)[axis]
            w = turned(w, np.broadcast_to(n, w.shape), -part * self.field(w, t)[..., axis:axis + 1])
        return w


class RenormalisedEuler(Impostor):
    """(w + h X)/|w + h X|: on the sphere, of order 1."""

    def motion(self, w, t, h):
        return unit(w + h * self.x(w, t))


class ProjectedMidpoint(Impostor):
    """The explicit midpoint rule, put back on the sphere after each step: order 2 and no more."""

    def motion(self, w, t, h):
        return unit(w + h * self.x(w + h / 2 * self.x(w, t), t + h / 2))


class ExplicitMidpoint(Impostor):
    """Without the projection: it leaves the sphere."""

    def motion(self, w, t, h):
        return w + h * self.x(w + h / 2 * self.x(w, t), t + h / 2)


class Composed(Impostor):
    """What another subject's steps become when something is added; `run` goes through `step`."""

    def __init__(self, subject):
        self.subject, self.field, self.energy = subject, subject.field, subject.energy

    def motion(self, w, t, h):
        return np.array([self.subject.step(x, t, h) for x in w]) if w.ndim == 3 else self.subject.step(w, t, h)


class WrongTangent(Composed):
    """The right step with the tangent map of a step of another length: symplectic, and not its own."""

    def tangent(self, w, t, h, v):
        return self.subject.tangent(w, t, h * (1 + 1e-6), v)


class RoughTangent(Composed):
    """The right tangent map to nine digits and a half."""

    def tangent(self, w, t, h, v):
        return self.subject.tangent(w, t, h, v) * (1 + 3e-10)


class Lopsided(Composed):
    """The right step, and a turn about x by a millionth of h: symplectic, of order 0 with the flow."""

    def motion(self, w, t, h):
        axis = np.broadcast_to(np.eye(3, dtype=w.dtype)[0], w.shape)
        return turned(super().motion(w, t, h), axis, 1e-6 * h * np.ones_like(w[..., :1]))


# -- generated C with a fault --------------------------------------------------------------------


def compiled(spec, change, method="spherical-midpoint", values=None) -> Emitted:
    """The generated code after change(text) of its .c file. A change that finds nothing is an error."""
    def made(real, features=()):
        scene, place = scene_of(spec, None, values), Path(tempfile.mkdtemp(prefix="impostor-"))
        files = generate(scene, method, features=features, amalgamate=True)
        source = f"{scene.name}.c"
        text = change(files[source])
        assert text != files[source], "the planted fault finds no place"
        files[source] = text
        write_files(files, place)
        compile_shared(place, sorted(f for f in files if f.endswith(".c")), find_compiler(), (*binary.FLAGS, *SHARED, *REALS[real]))
        built = Built(scene.name, place / "model.so", place, real, "cc", (), dict(files.notes), "impostor")
        return Integrator(prepare(spec, method, None, values), built)
    return Emitted(made("double"), made("long double"), made("double", ("tangent",)))


def frozen_time(text):
    """Time is read where the step begins."""
    return text.replace("smg_time_at(s, (smg_real)0.5)", "smg_time_at(s, 0)").replace("smg_set_time_at(&s->c, s, (smg_real)0.5)", "smg_set_time_at(&s->c, s, 0)")


def turned_round(text):
    """The orientation of the bracket is reversed."""
    return text.replace("return SMG_ORIENTATION * (smg_real)h;", "return -SMG_ORIENTATION * (smg_real)h;")


def wrong_sign(spec, effect):
    """The spec with one effect reversed, field and Hessian alike: its step stays symplectic."""
    return dataclasses.replace(spec, effects=tuple(
        dataclasses.replace(e, value=Op("neg", (e.value,))) if e.name == effect else e for e in spec.effects))
