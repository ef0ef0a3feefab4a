"""A method and a step for an accuracy, found by measuring.

    pick = smidgen.choose(spec, "demo", error=1e-8, time=100)
    print(pick)                         # why
    smidgen.run(spec, "demo", **pick.settings)
"""
from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..extremes import largest
from ..methods import METHODS
from ..public import public
from ..read.shipped import SpecLike, spec_or_name
from ..run.step.prepared import choose as one_of, scene_of
from ..run.settings import settle
from .measure.case import Case, asked_time, candidates
from .even import general, steps_until_even
from .measure.reference import Reference, reference
from .report import duration, label
from .measure.sweep import LOOSEST, PART, TOLERANCES, TURN, WITHIN, Row, loosened, one, ratio
from .measure.timing import asked as asked_tolerance, take_times
from .weak import weak_cost
from .weak_choice import WeakChoice, asked_mean, weak_choice

SPENT = 60.0        # seconds that are measured at a temperature
MARGIN = 0.6        # of the error asked for, which the choice aims at
SLOWER = 4.0        # times the best so far: a method that needs more is left
ROUNDS = 40         # runs of a method at most while its step is looked for
LARGER = 1, 10, 100     # times the tolerance that surely is small enough
TRIES = 3           # runs that bring the step closer to the largest one that is good enough
SECONDS = 10.0      # a run that takes longer is too long to choose by
COMPILED = 0.05     # seconds of the processor: what takes less was in the cache


@dataclass(frozen=True)
class Choice:
    """The result of `choose`.

    :ivar row: the fastest combination of method and step (`sweep.Row`).
    :ivar others: rows of the other methods that are accurate enough, fastest first.
    :ivar short: the methods that are not accurate enough, with reasons.
    :ivar asked: the requested accuracy. `known`: the reference solution.
    :ivar general: the run of a general-purpose integrator that is accurate enough, or None.
    """
    row: Row
    others: list
    short: dict
    asked: dict
    known: Reference
    general: Row | None = None

    @property
    def settings(self) -> dict:
        """Keywords for `smidgen.run`: method, h, steps and, if it saves time, tolerance."""
        found = {"method": self.row.method, "h": self.row.h, "steps": self.row.steps, "tolerance": asked_tolerance(self.row)}
        return {word: value for word, value in found.items() if value is not None}

    @property
    def even(self) -> float | None:
        """The number of steps after which the choice, including compilation, is faster than the general-purpose integrator; infinite if it
        never is, None if there is no such integrator.
        """
        return None if self.general is None else steps_until_even(self.row, self.general, True)

    def as_dict(self) -> dict:
        """The choice as data for JSON."""
        return {**self.settings, "asked": self.asked, "row": vars(self.row), "others": [vars(r) for r in self.others], "short": self.short,
                "general": vars(self.general) if self.general is not None else None, "even": self.even}

    def __str__(self) -> str:
        return "\n".join(words(self))

    def __repr__(self) -> str:
        return f"<Choice {', '.join(f'{word}={value!r}' for word, value in self.settings.items())}; print() explains it>"


@public
@spec_or_name
def choose(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, time: float | str | None = None,
           effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None, seed: int | None = None,
           native: bool | None = None, methods: Iterable[str] | None = None, error: float | None = None, energy: float | None = None,
           symplectic: bool = False, seconds: float = SPENT, mean: str | None = None,
           progress: Callable[[str, float], object] = lambda what, done: None) -> Choice | WeakChoice:
    """Find the method and step that reach an accuracy in the least time. Arguments not listed here are as for `cost`.

    :param error: the error of the final state, relative to the largest |w|. At a temperature: the absolute error of a mean over time and
        members.
    :param energy: the largest absolute error of the energy during the run. `error`, `energy` or both must be given.
    :param symplectic: whether to consider symplectic methods only.
    :param mean: at a temperature, the quantity whose mean is judged; by default the energy.
    :param seconds: a limit on the time of the measurement.
    :raises UsageError: for an argument that does not fit; if no method reaches the accuracy; or if the final state cannot be computed well
        enough to judge (the motion is chaotic: ask for an energy error instead).
    """
    methods = known_methods(methods)
    settings = settle(spec, run, start=start, effects=effects, parameters=parameters, seed=seed, native=native)
    if scene_of(spec, settings.effects, settings.parameters).heated:
        target = asked_mean(error, energy, symplectic)
        return weak_choice(weak_cost(spec, settings, time, methods, mean, seconds, dict, progress), target)
    no_mean(mean)
    asked = asked_errors(error, energy)
    case = Case(spec, settings, asked_time(spec, settings, time))
    if case.energy_changes and energy is not None:
        raise UsageError("the energy is not conserved, because H depends on time, sites are damped or torques act: ask for an error of the final state")
    progress("reference", 0.0)
    known = reference(case, min(1e-13, (error or 1e-6) / 1000))
    if error is not None and not known.error <= error / 3:
        raise UsageError(f"the final state is not known to within {error:g}: two methods with the smallest steps differ by {known.error:.1e} "
                         "(the motion is chaotic, or the run is too long); ask for an energy error, or for a shorter time")
    names = [n for n in high_orders_first(candidates(case, methods)) if METHODS[n].symplectic or not symplectic]
    good, short = search(case, names, known, asked, progress)
    if not good:
        raise UsageError("no method reaches this accuracy: " + "; ".join(f"{label(n)}: {why}" for n, why in short.items()))
    progress("a general integrator", 0.95)
    beside = general(case, asked, known)
    take_times(case, good if beside is None else [*good, beside], 2.0)
    good.sort(key=lambda row: row.seconds)
    return Choice(good[0], good[1:], short, asked, known, beside)


def no_mean(mean) -> None:
    if mean is not None:
        raise UsageError(f"the mean of `{mean}` is defined only at a temperature, but no effect of the scene has kT")


def known_methods(methods) -> list | None:
    """The names that are asked for. Raises UsageError for one that is none."""
    return None if methods is None else [one_of("method", m, tuple(METHODS)) for m in methods]


def asked_errors(error, energy) -> dict:
    """What is asked for, by the name of the column."""
    asked = {k: float(v) for k, v in (("end_error", error), ("energy", energy)) if v is not None}
    if not asked:
        raise UsageError("give the accuracy: an error of the final state (--error 1e-8) or an energy error (--energy 1e-10)")
    for value in asked.values():
        if not 0 < value < math.inf:
            raise UsageError(f"an error must be a positive number, not {value:g}")
    return asked


def high_orders_first(names) -> list[str]:
    """They find the best time soon, so that slower methods are left soon."""
    return sorted(names, key=lambda name: (-METHODS[name].order, name))


def search(case: Case, names, known: Reference, asked: dict, progress):
    """(rows that are good enough, method -> why not)."""
    good, short, best = [], {}, SECONDS / SLOWER
    for k, name in enumerate(names):
        progress(f"step of {name}", k / len(names))
        row, why = largest_step(case, name, known, asked, SLOWER * best)
        if row is None:
            short[name] = why
        else:
            good += [row, *with_tolerance(case, row, known, asked)]
            best = min(best, row.seconds)
    return good, short


def largest_step(case: Case, name: str, known: Reference, asked: dict, limit: float):
    """(row, "") of about the largest step that is good enough, or of a smaller one that takes less time; or (None, why)."""
    if METHODS[name].controlled:
        return largest_tolerance(case, name, known, asked)
    steps, failed = case.fewest(TURN), None
    for _ in range(ROUNDS):
        row = one(case, name, steps, known)
        if enough(row, asked):
            return quicker(case, closer(case, name, known, asked, row, failed), known, asked), ""
        if not row.status and row.seconds * ratio(name) > limit:
            return None, f"takes more than {limit:.3g} s, and still has an error of {misses(row, asked)}"
        failed, steps = row, max(steps + 1, round(steps * jump(name, row, asked)))
    return None, f"its error stays at {misses(row, asked)}" if not row.status else row.status


def largest_tolerance(case: Case, name: str, known: Reference, asked: dict):
    """The same of a method that takes steps of its own: about the largest tolerance that is good enough."""
    for tolerance in TOLERANCES:
        row = one(case, name, min(WITHIN, case.fewest(TURN)), known, tolerance)
        if enough(row, asked):
            return larger_tolerance(case, row, known, asked), ""
    return None, f"its error stays at {misses(row, asked)}" if not row.status else row.status


def larger_tolerance(case: Case, row: Row, known: Reference, asked: dict) -> Row:
    """The same to a tolerance that is larger by what the error leaves: between two of TOLERANCES they go together."""
    left = min(MARGIN * value / max(getattr(row, what), 1e-300) for what, value in asked.items())
    if left < 1.2:
        return row
    found = one(case, row.method, row.steps, known, min(LOOSEST, row.tolerance * min(left, TOLERANCES[0] / TOLERANCES[1])))
    return found if enough(found, asked) else row


def with_tolerance(case: Case, row: Row, known: Reference, asked: dict) -> list[Row]:
    """The same run with iterations that leave a part of what was asked for, where there are some: to the largest tolerance that is good enough. What
    steps leave is seldom of one sign, so that together they leave less than their number times the tolerance."""
    found: list[Row] = []
    for larger in LARGER if "end_error" in asked else ():
        rows = loosened(case, row, known, larger * PART * MARGIN * asked["end_error"] / row.steps)
        if not all(enough(one, asked) for one in rows):
            break
        found = rows or found
    return found


def jump(name: str, row: Row, asked: dict) -> float:
    """How many times more steps to take next: as the order promises, within a factor of 4 and not below a neighbour's."""
    if row.status:
        return 1.5
    excess = largest(*(getattr(row, what) / (MARGIN * value) for what, value in asked.items()))
    return float(np.clip(excess ** (1 / METHODS[name].order) if excess == excess else 2.0, 1.1, 4.0))


def closer(case: Case, name: str, known: Reference, asked: dict, good: Row, failed: Row | None) -> Row:
    """A larger step that is good enough, between one that is and one that is not."""
    for _ in range(TRIES):
        if failed is None or good.steps < 1.12 * failed.steps:
            return good
        row = one(case, name, round(math.sqrt(good.steps * failed.steps)), known)
        good, failed = (row, failed) if enough(row, asked) else (good, row)
    return good


def quicker(case: Case, row: Row, known: Reference, asked: dict) -> Row:
    """Smaller steps, where they are solved so much sooner that twice as many of them take less time."""
    while row.iterations > 0:
        found = one(case, row.method, 2 * row.steps, known)
        if not (enough(found, asked) and found.seconds < row.seconds):
            return row
        row = found
    return row


def enough(row: Row, asked: dict) -> bool:
    """Does the row meet what is asked for, with the margin?"""
    return not row.status and all(getattr(row, what) <= MARGIN * value for what, value in asked.items())


def misses(row: Row, asked: dict) -> str:
    """The errors of a row, in words."""
    return " and ".join(f"{getattr(row, what):.1e}" for what in asked)


def words(choice: Choice) -> list[str]:
    """The pick, and why."""
    row = choice.row
    kinds = {"end_error": "final error", "energy": "energy error"}
    tolerance = f", tolerance {row.tolerance:.3g} (--tolerance)" if row.tolerance == row.tolerance else ""
    said = [f"{label(row.method)} (--method {row.method}) with h = {row.h:.17g}, {row.steps} steps{tolerance}",
            f"takes {duration(row.seconds)} ({duration(row.ns_step / 1e9)} a step); "
            + ", ".join(f"{kinds[w]} {getattr(row, w):.1e} where {v:g} is requested" for w, v in choice.asked.items()),
            f"measured against {' and '.join(choice.known.methods)} in extended precision, which agree to {choice.known.error:.1e}"]
    if not METHODS[row.method].symplectic:
        said.append("not symplectic" + ", but it conserves the energy" * METHODS[row.method].keeps_energy + ": for longer runs, ask for a symplectic method (--symplectic)")
    for other in choice.others[:4]:
        said.append(f"  {label(other.method)}{', to a tolerance' * (other.tolerance == other.tolerance)}: takes {other.seconds / row.seconds:.3g} times as long, h = {other.h:.4g}")
    return said + broken_even(choice)


def broken_even(choice: Choice) -> list[str]:
    """After how many steps the pick has paid for its compiler: beside a general integrator, and the next one."""
    row, beside = choice.row, choice.general
    if not row.compiled >= COMPILED:
        said = "  it is already compiled, so it is faster from the first step than {}, which takes {} times as long for this error"
        return [said.format(label(beside.method), f"{beside.seconds / row.seconds:.3g}")] if beside is not None and beside.seconds > row.seconds else []
    found = [(label(beside.method), steps_until_even(row, beside, True))] if beside is not None else []
    found += [(f"{label(choice.others[0].method)}, already compiled", steps_until_even(row, choice.others[0], True))] if choice.others else []
    said = [f"compared with {name}, this pays off after {steps:.2g} steps" for name, steps in found if steps < math.inf]
    return [f"  compilation took {duration(row.compiled)} of processor time: {'; '.join(said)}"] if said else []
