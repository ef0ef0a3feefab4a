"""What a spec, effects and parameter values come to, made ready once for all that a run asks of them."""
from __future__ import annotations

import dataclasses
import numbers
from collections.abc import Iterable, Mapping

from ...compile.plan.plan import Plan, choose as plan_of
from ...errors import UsageError
from ...language.spec import LOOSEST, Spec
from ...methods import NAMES as METHODS, SOLVERS
from ...read.problems import meant
from .evaluated import Evaluated

MOST_THREADS = 1024
LISTED = 12         # names that a message has at most


@dataclasses.dataclass(frozen=True)
class Prepared:
    """scene: the spec with its effects and values selected; numbers: those of the scene, evaluated; plan: of a step by this
    method and solver."""
    spec: Spec
    scene: Spec
    numbers: Evaluated
    method: str
    solver: str
    plan: Plan

    def with_parameters(self, parameters: Mapping[str, object]) -> Prepared:
        """The same scene and plan with other values of parameters that decide neither."""
        return dataclasses.replace(self, numbers=Evaluated(self.scene, {**self.numbers.parameters, **parameters}))


def prepare(spec: Spec, method: str, effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None,
            solver: str = "auto", numbers: Evaluated | None = None) -> Prepared:
    """Select, evaluate and plan. numbers: those of the spec with these parameters, where they are known.

    Raises UsageError for a name that is not known, a value that does not fit, and a method that does not serve the scene.
    """
    no_run(spec, method)
    choose("method", method, METHODS)
    choose("solver", solver, SOLVERS)
    scene = scene_of(spec, effects, parameters)
    numbers = Evaluated(spec, parameters) if numbers is None else numbers
    return Prepared(spec, scene, numbers.of(scene), method, solver, plan_of(scene, method, solver))


def scene_of(spec: Spec, effects=None, parameters=None) -> Spec:
    """The spec with these effects, and the values of `parameters` for defaults."""
    from ...compile.select import select
    return select(spec, None if effects is None else tuple(effects), dict(parameters or {}))


def choose(what: str, name: str, names) -> str:
    """`name`, if it is one of `names`; else UsageError with the nearest, or the list."""
    if name not in names:
        raise UsageError(f"no {what} '{name}'; {listed(name, tuple(names))}")
    return name


def listed(name, names: tuple) -> str:
    """The names that there are; of many, the one that was probably meant, and the first few."""
    if len(names) <= LISTED:
        return f"there are: {', '.join(names)}"
    close = meant(name, names) if isinstance(name, str) else None
    return f"did you mean '{close}'?" if close else f"there are {len(names)}, such as {', '.join(names[:LISTED])}"


def no_run(spec: Spec, method) -> None:
    """Raises UsageError where the name of a run stands for a method: `build(spec, "demo")`."""
    run = next((r for r in spec.runs if r.name == method), None)
    if run is not None and method not in METHODS:
        raise UsageError(f"no method '{method}': that is a run of {spec.name}. `smidgen.run(spec, '{method}')` takes it; "
                         f"`smidgen.build(spec, '{run.method}')` builds what it uses")


def checked_threads(threads) -> int | None:
    """Raises UsageError for what is no number of threads."""
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, numbers.Integral) or not 1 <= threads <= MOST_THREADS):
        raise UsageError(f"threads are a number from 1 to {MOST_THREADS}, not {threads}")
    return threads


def checked_tolerance(tolerance) -> float:
    """0 for None. Raises UsageError for what is no tolerance."""
    if tolerance is None:
        return 0.0
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance <= LOOSEST:
        raise UsageError(f"a tolerance is a number above 0 and up to {LOOSEST:g}, not {tolerance}")
    return float(tolerance)
