"""Integrators of sites that do more than precess in their field: a part of the tests alone, and the same step by other means.

    w' = (o/kappa) (w x F + w x (w x Q)),   F = f g + F0,   Q = q g + Q0,   g = dH/dw.
"""
import hashlib
from dataclasses import dataclass

import numpy as np

from smidgen.build.binary import build_library
from smidgen.compile.emit.emit import emitted
from smidgen.compile.plan.contributions import contributions_of
from smidgen.effects.motion import Contribution, Response
from smidgen.compile.plan.plan import choose
from smidgen.compile.program import program_of
from smidgen.language.expr import Num
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import prepare

SPHERICAL = "spherical-midpoint"


@dataclass(frozen=True)
class Law:
    """f, q and the vectors F0 and Q0 as numbers."""
    f: float = 1.0
    q: float = 0.0
    F0: tuple = (0.0, 0.0, 0.0)
    Q0: tuple = (0.0, 0.0, 0.0)

    def response(self) -> Response:
        return Response(Num(self.f), Num(self.q), tuple(map(Num, self.F0)), tuple(map(Num, self.Q0)))

    def torque(self, m, g):
        """m x F + m x (m x Q), shape (sites, 3)."""
        return np.cross(m, self.f * g + np.array(self.F0)) + np.cross(m, np.cross(m, self.q * g + np.array(self.Q0)))


def parts(spec, response, family="w") -> tuple:
    return (*contributions_of(spec), Contribution("stub", ((family, "i"),), conservative=False, response=response))


def files_of(spec, response, method=SPHERICAL, solver="auto", features=()):
    contributions = parts(spec, response)
    return emitted(program_of(spec), choose(spec, method, solver, contributions), features, contributions)


def library(spec, response, method=SPHERICAL, solver="auto", real="double", native=None, features=()):
    """`build_library` of sites with this response."""
    def made(spec, method, solver, features, *_):
        return files_of(spec, response, method, solver, features)
    told = hashlib.sha256(repr(response).encode()).hexdigest()[:16]
    return build_library(spec, method, solver, real, native, features, generate=made, defines=(f"-DSMG_TOLD_{told}",))


def integrator(spec, law: Law, method=SPHERICAL, solver="auto", real="double", features=()) -> Integrator:
    prepared = prepare(spec, method, solver=solver)
    return Integrator(prepared, library(prepared.scene, law.response(), method, solver, real, features=features))


def midpoint(w, h, kappa, gradient, law: Law):
    """The step of the spherical midpoint method by fixed-point iteration in extended precision."""
    w = np.asarray(w, np.longdouble)
    radius, end = np.sqrt((w * w).sum(1, keepdims=True)), w
    for _ in range(3000):
        m = w + end
        m = radius * m / np.sqrt((m * m).sum(1, keepdims=True))
        before, end = end, w + np.longdouble(h) / np.longdouble(kappa) * law.torque(m, gradient(m))
        if np.array_equal(before, end):
            return end
    assert np.abs(end - before).max() < 1e-18
    return end
