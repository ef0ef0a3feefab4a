"""The energy and the momentum that are reported, and what of them is conserved: one rule for all.

The energy is that of the effects that no tracer feels: a tracer moves in a given flow, and what
it adds to H is not conserved. It is conserved when none of these effects depends on time, no site is damped and no torque acts. The
momentum is sum kappa w of the sites that are not tracers; the directions in which it is
conserved follow from the field.
"""
from __future__ import annotations

import numpy as np

from ...chance import generator
from ...language.expr import slots_of, timed
from ...language.held import standing
from ...language.tracers import moves_tracers

STATES = 6          # random states at which the torque is looked at
EPSILON = 1e-10     # a torque below this part of its terms is round-off


def with_tracers(spec) -> set[str]:
    """Names of the effects that move tracers alone: their energy is not conserved."""
    tracers = {f.name for f in spec.families if f.tracer}
    return {e.name for e in spec.energies if moves_tracers(e.over, slots_of(e.value), tracers)}


def of_time(spec, effects=None) -> bool:
    """Does an effect (of those named) depend on the time?"""
    return any(timed(e.value) for e in spec.energies if effects is None or e.name in effects)


def driven(spec, effects=None) -> bool:
    """Does the reported energy (of the effects named) change along the flow: does it depend on time, is a site damped or moved by a torque?"""
    called = set(spec.effect_names if effects is None else effects)
    return of_time(spec, called - with_tracers(spec)) or any(e.name in called and not e.conservative for e in spec.effects)


def energy_of(values, without=()):
    """The reported energy from columns name -> number or array; None when there is none.

    without: names of the effects that tracers feel.
    """
    if not without:
        return values.get("energy")
    kept = [v for n, v in values.items() if n.startswith("energy.") and n.removeprefix("energy.") not in without]
    return np.sum(kept, axis=0) if kept else None


def momentum_of(values, spec) -> np.ndarray:
    """(.., 3): sum kappa w without tracers, from columns `momentum.<family>` of shape (.., 3)."""
    return sum((np.asarray(values[f"momentum.{f.name}"]) for f in spec.families if not f.tracer), np.zeros(3))


def conserved_axes(model, span: float = 5.0) -> np.ndarray:
    """Orthonormal rows (k, 3), k = 0, 1 or 3: the directions in which the field keeps the momentum.

    d/dt sum kappa w = sum kappa w x b vanishes along them at random states and times within
    `span` of the present one. Nambu factors have other brackets, and no such momentum; nor has what is damped, moved by torques or pinned.
    """
    spec, own = model.scene, acting_sites(model)
    if not own.size or not spec.conservative or standing(spec) or any(f.kind == "nambu" for f in spec.families):
        return np.zeros((0, 3))
    dice, kappa = generator("conserved momentum"), model.prepared.numbers.kappas[own, None]
    rows = [torque(model, random_state(model, dice), model.t + dice.uniform(0, 1) * span, own, kappa)
            for _ in range(STATES)]
    rows = [row for row in rows if np.isfinite(row).all()]
    if not rows:
        return np.zeros((0, 3))
    _, size, axes = np.linalg.svd(np.array([*rows, np.zeros(3), np.zeros(3)]))
    return axes[size <= EPSILON]


def round_off_of_momentum(model) -> float:
    """Half an ulp of the largest kappa w there is: directions are known to round-off too, and the part of a change along one has digits below it."""
    own = acting_sites(model)
    if not own.size:
        return 0.0
    size = np.abs(model.prepared.numbers.kappas[own]) * np.linalg.norm(np.asarray(model.w, float)[own], axis=1)
    return float(np.finfo(model.real).eps / 2 * size.max())


def random_state(model, dice) -> np.ndarray:
    """Uniform on the spheres, and on the unit sphere for other factors; shape (sites, 3)."""
    w, radius = dice.standard_normal((model.sites, 3)), model.prepared.numbers.radii
    return w * (np.where(np.isnan(radius), 1, radius) / np.linalg.norm(w, axis=1))[:, None]


def torque(model, w, t: float, own, kappa) -> np.ndarray:
    """sum kappa w x b of the sites `own`, in units of the sizes of its terms; shape (3,)."""
    with np.errstate(all="ignore"):         # a field that is not finite gives a row that is left out
        terms = kappa * np.cross(w, np.asarray(model.field(w, t), float))[own]
        return terms.sum(axis=0) / (np.abs(terms).sum() or 1)


def acting_sites(model) -> np.ndarray:
    """Numbers of the sites that are there and no tracers."""
    parts = [first + np.flatnonzero(model.prepared.numbers.present[first:first + count]) for f in model.scene.families if not f.tracer
             for first, count in [model.families[f.name]]]
    return np.concatenate([np.arange(0), *parts])
