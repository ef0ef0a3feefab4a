"""What a spec, effects and parameter values come to, made ready once for all that a run asks of them."""
from __future__ import annotations

import dataclasses
import numbers
from collections.abc import Iterable, Mapping

from ...compile.plan.plan import Plan, choose as plan_of
from ...errors import UsageError
from ...language.spec import LOOSEST, Run, Spec
from ...methods import NAMES as METHODS, SOLVERS
from ...public import by_its_end
from ...read.given import scaled
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
    choose("method", method, METHODS)
    choose("solver", solver, SOLVERS)
    scene = scene_of(spec, effects, parameters)
    numbers = Evaluated(spec, parameters) if numbers is None else numbers
    return Prepared(spec, scene, numbers.of(scene), method, solver, plan_of(scene, method, solver))


def find_run(spec: Spec, name: str | None) -> Run:
    """The run of that name; None: the first one, or an empty one for a spec without runs."""
    if not isinstance(spec, Spec):
        raise UsageError(f"expected a spec as returned by smidgen.load, not a {type(spec).__name__}")
    if not (name is None or isinstance(name, str)):
        raise UsageError(f"a run is selected by its name, not by a {type(name).__name__}; the start of an ensemble is its keyword `start`")
    if name is None:
        return spec.runs[0] if spec.runs else Run("", None, METHODS[0], None)
    for run_ in spec.runs:
        if run_.name == name:
            return run_
    names = ", ".join(r.name for r in spec.runs) or "none"
    hint = f"; that is a method: method='{name}'" if name in METHODS else ""
    raise UsageError(f"{spec.name} has no run '{name}'; it has: {names}{hint}")


def asked(spec: Spec, run: str | None, method: str | None = None, solver: str | None = None, effects: Iterable[str] | None = None,
          parameters: Mapping[str, object] | None = None) -> Run:
    """The run of that name (None: the first), with what is given in place of what it says."""
    base = find_run(spec, run)
    return dataclasses.replace(base, method=base.method if method is None else method, solver=base.solver if solver is None else solver,
                               effects=base.effects if effects is None else tuple(effects),
                               parameters=tuple({**dict(base.parameters), **scaled(spec, parameters or {})}.items()))


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
    close = by_its_end(name, names) or meant(name, names) if isinstance(name, str) else None
    return f"did you mean '{close}'?" if close else f"there are {len(names)}, such as {', '.join(names[:LISTED])}"


def checked_threads(threads) -> int | None:
    """Raises UsageError for what is no number of threads."""
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, numbers.Integral) or not 1 <= threads <= MOST_THREADS):
        raise UsageError(f"threads must be a number from 1 to {MOST_THREADS}, not {threads}")
    return None if threads is None else int(threads)


def checked_tolerance(tolerance) -> float:
    """0 for None. Raises UsageError for what is no tolerance."""
    if tolerance is None:
        return 0.0
    if not isinstance(tolerance, numbers.Real) or not 0 < tolerance <= LOOSEST:
        raise UsageError(f"a tolerance must be a number above 0 and at most {LOOSEST:g}, not {tolerance}")
    return float(tolerance)
