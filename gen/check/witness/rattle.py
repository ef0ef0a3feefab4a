"""RATTLE on T*S^3 by numpy, as it is written down: with all of q and p, both multipliers, and q that does not begin at 1.

Quaternions are arrays (sites, 4), the real part first. J = vec(q* p)/2 is w, and with the extension (c/2)(q.p)^2 of H(J)

    dH/dp = q b/2 + c (q.p) q,   dH/dq = -p b/2 + c (q.p) p,   b = (1/kappa) dH/dw at J, with the sign of the bracket, as a quaternion
without a real part.
"""
from __future__ import annotations

import numpy as np

from ...errors import RunError
from .lie import at_rest

EXTENSION = 0.25        # c on the unit sphere
BEGIN = np.array([0.1, -0.7, 0.5, 0.5])     # q, of length 1


def times(p, q):
    """Quaternions multiplied."""
    real = p[:, :1] * q[:, :1] - np.sum(p[:, 1:] * q[:, 1:], axis=1)[:, None]
    return np.concatenate((real, p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])), axis=1)


def conjugate(q):
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def pure(v):
    return np.concatenate((np.zeros((len(v), 1)), v), axis=1)


def dots(p, q):
    return np.sum(p * q, axis=1)[:, None]


class Phase:
    """Both slopes of the extended H at (q, p), of all sites."""

    def __init__(self, witness, t: float, c):
        self.witness, self.t, self.c = witness, t, c

    def slopes(self, q, p):
        """(dH/dq, dH/dp)."""
        b = self.witness.spec.orientation * pure(self.witness.field(times(conjugate(q), p)[:, 1:] / 2, self.t))
        return self.c * dots(q, p) * p - times(p, b) / 2, self.c * dots(q, p) * q + times(q, b) / 2


def solved(residual, x):
    """x with residual(x) = 0 by Newton's method, its matrix from central differences; None where there is none to be found."""
    def matrix(x):
        moves = 1e-5 * np.eye(x.size).reshape(-1, *x.shape)
        return np.stack([(residual(x + d) - residual(x - d)).ravel() / 2e-5 for d in moves], axis=1)
    try:
        for _ in range(4):
            inverse = np.linalg.inv(matrix(x))
            x = x - (inverse @ residual(x).ravel()).reshape(x.shape)
        return at_rest(lambda y: y - (inverse @ residual(y).ravel()).reshape(y.shape), x)
    except (np.linalg.LinAlgError, RunError):       # the field is no number there
        return None


def followed(residual, x):
    """The same of residual(x, part) at part = 1, from that of parts of the step where it is not found at once."""
    found = solved(lambda y: residual(y, 1.0), x)
    for part in () if found is not None else (0.25, 0.5, 0.75, 1.0):
        found = x = solved(lambda y, part=part: residual(y, part), x)
        if x is None:
            break
    return found


def step(witness, w, t: float, h: float, c: float = EXTENSION):
    """p = p0 - (h/2) dH/dq(q0, p) - l q0, q1 = q0 + (h/2)(dH/dp(q0, p) + dH/dp(q1, p)), |q1| = 1: nine equations a site for q1, p, l;
    then p1 = p - (h/2) dH/dq(q1, p) - m q1 across q1."""
    r = np.linalg.norm(w, axis=1)[:, None]
    phase, q0 = Phase(witness, t + h / 2, c / np.where(r > 0, r, 1)), np.tile(BEGIN, (len(w), 1))
    p0 = times(q0, pure(2 * w))

    def residual(x, part):
        q1, p, multiplier = x[:, :4], x[:, 4:8], x[:, 8:]
        (q_slope, p_slope), (_, ended) = phase.slopes(q0, p), phase.slopes(q1, p)
        return np.concatenate((q1 - q0 - part * h / 2 * (p_slope + ended), p - p0 + part * h / 2 * q_slope + multiplier * q0, dots(q1, q1) - 1), axis=1)
    found = followed(residual, np.concatenate((q0, p0, 0 * r), axis=1))
    if found is None:
        return None
    q1, p = found[:, :4], found[:, 4:8]
    p1 = p - h / 2 * phase.slopes(q1, p)[0]
    return times(conjugate(q1), p1 - dots(q1, p1) * q1)[:, 1:] / 2
