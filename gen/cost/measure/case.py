"""What is measured: one system from one start over one time, and the compiled models of its methods."""
from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from ...errors import BuildError, RunError, SmidgenError, UsageError
from ...language.spec import Spec
from ...methods import METHODS
from ...read.given import time as time_of
from ...run.record.conserved import driven, with_tracers
from ...run.step.integrator import Integrator
from ...run.settings import Settings, model_of, number
from ...run.step.noise import refuse_with_noise
from ...run.step.prepared import scene_of
from ...run.step.start import given_or_at
from .clock import processor_seconds


class Case:
    """spec and settings of a run; time: how long; w: its start, (sites, 3); rate: the fastest turning at the start,
    max |(1/kappa) dH/dw|; size: the largest |w|; energy_changes: does H depend on time, or are sites damped, do torques act? conservative: do energies alone move sites? peers: general integrators beside
    the methods, name -> integrator (`peers.of_case`)"""

    def __init__(self, spec: Spec, settings: Settings, time: float | None = None):
        self.spec, self.settings = spec, settings
        self.time = float(settings.h * settings.steps if time is None else time)
        if not self.time:
            raise UsageError("the time must not be 0")
        self.models, self.refused, self.compiled, self.peers = {}, {}, {}, {}
        scene = scene_of(spec, settings.effects, settings.parameters)
        refuse_with_noise(scene, "`choose`", "the error of a mean is only known to within its standard error: `smidgen cost` shows it for every method and step")
        self.w = given_or_at(settings.numbers.of(scene), settings.start, settings.seed)
        any_model = self.model(settings.method)
        if any_model is None:
            raise UsageError(self.refused[settings.method, "double"])
        any_model.start(self.w.copy(), h=settings.h)
        self.rate = float(np.linalg.norm(np.asarray(any_model.field(), float), axis=1).max())
        self.size = float(np.linalg.norm(self.w, axis=1).max())
        self.energy_changes, self.conservative = driven(any_model.scene), any_model.scene.conservative

    def model(self, method: str, real: str = "double") -> Integrator | None:
        """The compiled model, from memory; None where the method refuses the spec: `refused` says why."""
        key = method, real
        if key not in self.models:
            s, began = self.settings, processor_seconds()
            try:
                self.models[key] = model_of(self.spec, replace(s, method=method, solver=s.solver if method == s.method else "auto"), real)
            except BuildError:
                raise
            except SmidgenError as error:
                self.models[key], self.refused[key] = None, str(error)
            self.compiled[key] = processor_seconds() - began
        return self.models[key]

    @functools.cache
    def meter(self) -> Integrator | None:
        """A model whose energy is that of the effects that no tracer feels; None where there are none."""
        model = self.model(self.settings.method)
        kept = [name for name in model.scene.effect_names if name not in with_tracers(model.scene)]
        if not kept:
            return None
        return model_of(self.spec, replace(self.settings, effects=tuple(kept))).start(self.w.copy(), h=self.settings.h)

    def end(self, method: str, steps: int, real: str = "double") -> np.ndarray | None:
        """The state after the time, by that many steps; None where one fails."""
        model = self.model(method, real)
        try:
            model.start(self.w.copy(), h=self.time / steps)
            return np.array(model.steps(steps).w)
        except RunError:
            return None

    def distance(self, a, b) -> float:
        """The largest distance of a site, in units of the largest |w|."""
        return float(np.linalg.norm(np.asarray(a - b, np.longdouble), axis=1).max()) / self.size

    def fewest(self, turn: float) -> int:
        """Steps that turn the fastest site of the start by that angle, at least one."""
        return max(1, int(np.ceil(abs(self.time) * self.rate / turn)))


def asked_time(spec: Spec, settings: Settings, time) -> float | None:
    """The time as a number; a formula of the spec's parameters is one."""
    if time is None:
        return None
    asked = time_of(time, "the time", spec) if isinstance(time, str) else time
    return number(asked, settings.numbers.values, "the time")


def candidates(case: Case, methods=None) -> list[str]:
    """The methods that serve this spec, in the order of the registry: those asked for by name, or all that are no variants."""
    return [name for name, m in METHODS.items() if (not m.variant if methods is None else name in methods) and case.model(name) is not None]
