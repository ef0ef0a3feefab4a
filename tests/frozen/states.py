"""The bits of one case: digests of its states after some steps, or how it ends."""
from __future__ import annotations

import hashlib

import numpy as np

import smidgen
from smidgen.errors import RunError, SmidgenError
from smidgen.run.settings import settle
from smidgen.run.step.evaluated import radii, sizes

STEPS, STARTS = 20, 2       # after 16 steps the degree of the predictor has been chosen
LARGE = 8                   # the second step size, in units of the first, takes the solvers' slower paths
MEMBERS = 11                # of an ensemble: no multiple of any number of lanes


def bits(case) -> tuple[str, str]:
    """A digest for the step size of the spec's first run and one for LARGE times it; the name of the error where the case is refused."""
    spec, values = smidgen.load(case.spec), dict(case.values)
    h = settle(spec, spec.runs[0].name, parameters=values).h
    found = of_ensemble if "ensemble" in case.features else of_integrator
    try:
        return tuple(digest(found(case, spec, values, size)) for size in (h, LARGE * h))
    except SmidgenError as refusal:
        return (type(refusal).__name__,) * 2


def of_integrator(case, spec, values, h):
    """Bytes of the states, and of tangent vectors where the case has a tangent map."""
    model = smidgen.build(spec, method=case.method, parameters=values, solver=case.solver, real=case.real, features=case.features)
    for k in range(STARTS):
        try:
            model.start(start(spec, values, 7 * k), h=h)
        except RunError as refusal:
            yield str(refusal.status).encode()
            continue
        yield repr(model.advance(STEPS)).encode()
        yield significant(model.state())
        if "tangent" in case.features and model.count:
            yield pushed(model)


def of_ensemble(case, spec, values, h):
    """Bytes of the last states of all members, with the steps that each has taken."""
    starts = np.array([start(spec, values, 7 * k) for k in range(MEMBERS)])
    found = smidgen.ensemble(spec, start=starts, parameters=values, h=h, steps=STEPS, method=case.method, solver=case.solver, threads=1)
    yield found.steps.tobytes()
    yield significant(found.w)


def pushed(model) -> bytes:
    """Two tangent vectors after one step more, or the status of the step that fails."""
    vectors = np.arange(6.0 * model.sites).reshape(2, model.sites, 3) % 5 - 2
    try:
        return significant(model.push_forward(vectors, 1))
    except RunError as failure:
        return str(failure.status).encode()


def start(spec, values, first: int) -> np.ndarray:
    """A state of shape (sites, 3) made from whole numbers, so that no library decides its bits: on the spheres, and off the cones C = 0."""
    sites = sum(count for _, count in sizes(spec, values).values())
    rows = np.array([[(7 * k + 3) % 11 - 5, (4 * k * k + k + 2) % 13 - 6.5, (5 * k + 1) % 7 - 2.5] for k in range(first, first + sites)])
    radius = radii(spec, values)
    return rows / np.sqrt((rows * rows).sum(axis=1))[:, None] * np.where(np.isnan(radius), 1, radius)[:, None]


def significant(numbers: np.ndarray) -> bytes:
    """The bytes of doubles, and those of extended numbers without their padding."""
    if numbers.dtype == np.float64:
        return numbers.tobytes()
    return np.ascontiguousarray(numbers).view(np.uint8).reshape(-1, numbers.dtype.itemsize)[:, :10].tobytes()


def digest(parts) -> str:
    """16 hexadecimal digits of sha256."""
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
    return found.hexdigest()[:16]
