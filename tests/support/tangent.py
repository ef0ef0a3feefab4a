"""Tangents of a step by central differences in extended precision, and its Poisson defect.

On the symplectic leaf of site i (a sphere, or a level set of its C) with normal n = grad C(w),
the bracket w' = (1/kappa) n x grad H has the structure matrix

    K_i(w) = (1/kappa_i) [n]_x = (|n|/kappa_i) (e2 e1^T - e1 e2^T)

for any right-handed orthonormal frame (e1, e2, n/|n|). A map w -> W with tangent M is Poisson,
on R^3 factors too as long as it keeps the leaf, when M K(w) M^T = K(W): with the frames above

    sum_i (|n_i|/kappa_i) ((M e2_i)(M e1_i)^T - (M e1_i)(M e2_i)^T) = K(W),

which asks for derivatives along the leaf only. The defect is the largest entry of the
difference. On the unit sphere with kappa = 1 it is the relative change of area.
"""
from dataclasses import dataclass

import numpy as np

import smidgen
from smidgen.run.step.evaluated import casimir_matrices, kappas, radii

from .systems import SPHERICAL, Begin

WIDTH = 1e-3        # of a difference; its error is about (width)^6 and the last bit / width
OFFSETS = np.array([1, 2, 3])
WEIGHTS = np.array([45, -9, 1], np.longdouble) / 60      # of f(x + k d) - f(x - k d)


@dataclass(frozen=True)
class Leaves:
    """kappa (sites,), casimir (sites, 3, 3), and which sites lie on spheres (their radius, else nan)."""
    kappa: np.ndarray
    casimir: np.ndarray
    radius: np.ndarray

    def normal(self, w):
        """n = grad C(w) of every site, shape (sites, 3)."""
        return np.einsum("sab,sb->sa", self.casimir, w)

    def structure(self, w):
        """K(w), shape (3*sites, 3*sites): blocks (1/kappa) [n]_x."""
        out = np.zeros((3 * len(w), 3 * len(w)), np.longdouble)
        for i, n in enumerate(self.normal(w)):
            block = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
            out[3 * i:3 * i + 3, 3 * i:3 * i + 3] = block / self.kappa[i]
        return out


def leaves_of(case: Begin) -> Leaves:
    """The leaves of a spec; the orientation of its bracket changes K(w) and K(W) alike."""
    return Leaves(kappas(case.spec, case.values).astype(np.longdouble),
                  casimir_matrices(case.spec, case.values).astype(np.longdouble),
                  radii(case.spec, case.values))


def frame(n):
    """Orthonormal e1, e2 with e1 x e2 = n/|n|, and |n|."""
    size = np.sqrt(n @ n)
    low = np.eye(3, dtype=np.longdouble)[np.argmin(np.abs(n))]
    e1 = np.cross(low, n)
    e1 /= np.sqrt(e1 @ e1)
    return e1, np.cross(n / size, e1), size


def moved(w, leaves, site, direction, s):
    """w with one site shifted by s along a unit tangent: on its sphere along a great circle."""
    out = w.copy()
    r = leaves.radius[site]
    if np.isnan(r):
        out[site] = w[site] + s * direction
    else:
        out[site] = np.cos(s / r) * w[site] + np.sin(s / r) * r * direction
    return out


def derivative(step, w, leaves, site, direction, width=WIDTH):
    """M v for the unit tangent v = direction of one site: seven-point central difference."""
    width = np.longdouble(width)
    total = np.zeros_like(w)
    for k, weight in zip(OFFSETS, WEIGHTS):
        after, before = (step(moved(w, leaves, site, direction, sign * k * width)) for sign in (1, -1))
        total += weight * (after - before)
    return (total / width).ravel()


def pulled(step, w, leaves, sites, width=WIDTH):
    """M K(w) M^T from the tangent vectors of `sites`; exact when the others do not matter."""
    out = np.zeros((w.size, w.size), np.longdouble)
    for i in sites:
        e1, e2, size = frame(leaves.normal(w)[i])
        a, b = (derivative(step, w, leaves, i, e, width) for e in (e1, e2))
        out += size / leaves.kappa[i] * (np.outer(b, a) - np.outer(a, b))
    return out


def poisson_defect(step, w, leaves, sites=None, width=WIDTH):
    """max |M K(w) M^T - K(W)| over the sites given (a closed subsystem), by default all."""
    sites = np.arange(len(w)) if sites is None else np.asarray(sites)
    gap = pulled(step, w, leaves, sites, width) - leaves.structure(step(w))
    rows = (3 * sites[:, None] + np.arange(3)).ravel()
    return float(np.abs(gap[np.ix_(rows, rows)]).max())


class LongStep:
    """One step of the long-double build as a function of the state; `t` is where it begins."""

    def __init__(self, case: Begin, method=SPHERICAL, h=None, t=0.0, **more):
        self.model = smidgen.build(case.spec, method=method, parameters=case.values,
                                   real="long double", **more)
        self.h, self.t = case.h if h is None else h, t

    def __call__(self, w):
        return self.model.start(w.copy(), t0=self.t, h=self.h).step().state()


def long_start(case: Begin, steps=20):
    """A generic state in extended precision: the start, some steps on, exactly on its spheres."""
    model = smidgen.build(case.spec, parameters=case.values, real="long double")
    radius = leaves_of(case).radius
    w = polished(case.w.astype(np.longdouble), radius)
    return polished(model.start(w, h=case.h).steps(steps).state(), radius)


def polished(w, radius):
    """Sites of spheres scaled to their radius in the precision of w."""
    sphere = ~np.isnan(radius)
    length = np.sqrt(np.sum(w * w, axis=1))
    scale = np.where(sphere, np.where(sphere, radius, 1) / length, np.longdouble(1))
    return w * scale[:, None]
