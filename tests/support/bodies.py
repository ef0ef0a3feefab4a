"""Measurements on the rigid bodies: errors against the exact solution, energy over long times."""
import numpy as np

import smidgen
from smidgen.run.step.start import initial_state
from smidgen.check.witness import Witness

from .elliptic import curve
from .systems import CLASSICAL, SPHERICAL, load

TENSORS = {"(1, 2, 4)": (1.0, 2.0, 4.0), "(1, 4/3, 2)": (1.0, 4 / 3, 2.0)}
STEPS = tuple(2.0**-k for k in range(1, 10))


def body(moments, method, **more):
    """The compiled free rigid body with these moments of inertia."""
    values = {f"I{k}": moment for k, moment in enumerate(moments, 1)}
    return smidgen.build(load("free_rigid_body"), method=method, parameters=values, **more)


def largest_error(moments, method, h, end=10.0):
    """Largest Euclidean distance from the exact solution at the steps in [0, end]."""
    count = round(end / h)
    top = body(moments, method).start("paper", h=h)
    states = np.array([top.step().w[0].copy() for _ in range(count)])
    exact = curve(moments, h * np.arange(1, count + 1))
    return float(np.sqrt(np.sum((states - exact)**2, axis=1)).max())


def ratios_over_starts(moments, angles, h=2.0**-5, end=10.0):
    """CM/SM, the ratio of largest errors on [0, end], for starts (cos a, 0, sin a)."""
    values, found = {f"I{k}": moment for k, moment in enumerate(moments, 1)}, []
    flow, times = Witness(load("free_rigid_body"), values), h * np.arange(1, round(end / h) + 1)
    for a in angles:
        w = np.array([[np.cos(a), 0, np.sin(a)]])
        exact, errors = flow.flow(w, 0.0, times), []
        for method in (CLASSICAL, SPHERICAL):
            top = body(moments, method).start(w.copy(), h=h)
            states = np.array([top.step().w.copy() for _ in times])
            errors.append(np.sqrt(np.sum((states - exact)**2, axis=2)).max())
        found.append(float(errors[0] / errors[1]))
    return found


def irreversible(method, **more):
    """The compiled irreversible body at its normalised start, h = 1/2."""
    return smidgen.build(load("irreversible_rigid_body"), method=method, **more).start("paper", h=0.5)


def energy_errors(method, end):
    """H - H(0) of the irreversible body after every step of [0, end], h = 1/2; and H(0)."""
    top = irreversible(method)
    start = top.energy()
    return np.array([top.step().energy() - start for _ in range(round(2 * end))]), start


def drift(times):
    """Energy error of the classical midpoint at `times`."""
    errors, _ = energy_errors(CLASSICAL, max(times))
    return [float(errors[round(2 * t) - 1]) for t in times]


def band(end):
    """(smallest, largest) energy error of the spherical midpoint on [0, end]."""
    errors, _ = energy_errors(SPHERICAL, end)
    return float(errors.min()), float(errors.max())


def start_length():
    """The length of the irreversible body's start as the source prints it: normalised."""
    printed = load("irreversible_rigid_body").starts[0].families[0].value[0]
    return float(np.linalg.norm(printed)), initial_state(load("irreversible_rigid_body"), "paper")
