"""Compiled code against the witness: what must agree, how well, and whether it does.

    report = validate(spec, "demo")
    print(report.text())
    report.check()              # ValidationError when a line fails

docs/witness.md says what each line compares and where its bound comes from.
"""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping

import numpy as np

from ..chance import generator
from ..errors import RunError, UsageError, ValidationError
from ..extremes import largest, smallest, with_largest
from ..methods import METHODS
from ..language.spec import Spec
from ..language.units import TIME
from ..public import html_of, public
from ..read.shipped import SpecLike, spec_or_name
from ..run.settings import Settings, model_of, settle, whole
from ..run.step.evaluated import casimir_matrices
from ..run.step.prepared import scene_of
from ..run.step.start import given_or_at
from ..tables import text_of
from .witness import EQUATIONS, Witness

STEPS = 100             # compared where nobody says how many
ROUND_OFF = 1e-13       # agreement asked for, in units of the largest number compared
SENSITIVE = 10.0        # a tangent map that grows less than this excuses nothing
NUDGE = 1e-7            # size of the perturbation that measures the growth, in units of |w|
LINEAR = 1e5            # growth beyond which the perturbation, then a hundredth of |w|, measures none: what follows is not compared
STIR = 1e-9             # relative change of w and of t that shows how a formula enlarges round-off
TINY = float(np.finfo(float).tiny)
EPSILON = 2.0 ** -52
DENSE = 128             # sites: above, a step is checked by its residual
STIFF = 30              # sites: above, the implicit reference flow is left out
RESOLVED = 10           # times FLOOR: errors below are those of the reference
ORDER = (0.9, 1.1)      # observed order between h/2 and h/4, in units of the method's
FLOOR = 1e-10           # errors of the flow below this measure the reference instead
HALVINGS, DOUBLINGS = 7, 6
NOT_SEEN = ("these bounds detect neither round-off faults nor a wrong Hessian, which slows Newton's method without changing its result; "
            "`smidgen verify` measures both")


@dataclasses.dataclass(frozen=True)
class Line:
    """One comparison: `measured` must not exceed `bound` (for an order: lie in it)."""
    check: str
    measured: float
    bound: str
    passed: bool
    note: str = ""


@dataclasses.dataclass(frozen=True)
class Report:
    """All comparisons of one run. `growth`: of the tangent map over the steps compared."""
    spec: str
    run: str
    method: str
    h: float
    sites: int
    steps: int
    growth: float
    lines: tuple[Line, ...]
    time: str = ""

    @property
    def passed(self) -> bool:
        return all(line.passed for line in self.lines)

    def __repr__(self) -> str:
        return (f"<Report {self.spec} {self.run}: {self.method}, "
                f"{sum(x.passed for x in self.lines)} of {len(self.lines)} lines passed>")

    def check(self) -> "Report":
        """Itself, or ValidationError with the lines that failed."""
        failed = [f"{x.check}: {x.measured:.3g}, bound {x.bound} {x.note}".rstrip()
                  for x in self.lines if not x.passed]
        if failed:
            raise ValidationError(f"{self.spec} {self.run}: compiled code and witness "
                                  "disagree\n" + "\n".join(failed))
        return self

    def as_dict(self) -> dict:
        """The report as JSON has it (a NaN or infinity becomes null)."""
        facts = dataclasses.asdict(self) | {"passed": self.passed, "not_seen": NOT_SEEN}
        for line in facts["lines"]:
            line["measured"] = line["measured"] if math.isfinite(line["measured"]) else None
        facts["growth"] = facts["growth"] if math.isfinite(facts["growth"]) else None
        return facts

    def table(self):
        """A rich Table."""
        from rich.table import Table
        table = Table(title=f"{self.spec} {self.run}: {self.method}, h = {self.h:g}{' ' * bool(self.time)}{self.time}, "
                            f"{self.sites} site{'s' * (self.sites != 1)}")
        for name in ("check", "measured", "bound", "", "note"):
            table.add_column(name, overflow="fold")
        for x in self.lines:
            table.add_row(x.check, f"{x.measured:.3g}", x.bound, "ok" if x.passed else "FAILED",
                          x.note)
        return table

    def _repr_html_(self) -> str:
        return html_of(self.text())

    def text(self) -> str:
        """The table as plain text, a line for each comparison, however long."""
        return text_of(self.table())


@public
@spec_or_name
def validate(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None,
             h: float | str | None = None, steps: int | None = None, effects: Iterable[str] | None = None,
             parameters: Mapping[str, object] | None = None, seed: int | None = None, real: str = "double",
             native: bool | None = None, points: int = 5) -> Report:
    """Compare the compiled integrator of a run with the witness, an independent interpreter of the spec. Other arguments are as for `run`.

    Compared are the field and the energy at random states, conserved quantities and observables, steps of the same method, and the order
    of convergence to the exact flow.

    :param steps: the number of steps to compare; by default 100.
    :param points: the number of random states.
    :returns: a Report; `report.check()` raises ValidationError if a comparison failed. A step that fails is a failed comparison.
    :raises UsageError: for an argument that does not fit.
    """
    steps, points = STEPS if steps is None else whole(steps, "steps"), whole(points, "points")
    if steps < 1 or points < 1:
        raise UsageError("validation needs at least one step and one random state")
    case = Case(settle(spec, run, steps=steps, every=1, start=start, method=method, solver=solver, h=h,
                       effects=effects, parameters=parameters, seed=seed, real=real, native=native), spec.calm, points)
    lines = [*field_lines(case), *value_lines(case)]
    step_lines, growth = case.guarded(f"{steps} steps", lambda: compare_steps(case), math.nan)
    step_lines = [*step_lines, *case.guarded("noise", lambda: (compare_noise(case, spec, growth), None), None)[0]]
    flow_lines, _ = case.guarded("order of convergence", lambda: (compare_flow(case), None), None)
    s = case.settings
    return Report(spec.name, s.run, s.method, s.h, case.witness.sites, steps, growth,
                  tuple([*lines, *step_lines, *flow_lines]), spec.units.spelt(TIME) if spec.units else "")


class Case:
    """Both sides of a comparison and where it starts. w: shape (sites, 3)."""

    def __init__(self, settings: Settings, spec: Spec, points: int):
        s = self.settings = settings
        self.points = points
        self.witness = Witness(spec, s.parameters, s.effects)
        self.radius = s.numbers.radii
        self.dice = generator("validate")
        self.model = model_of(spec, s)
        self.w = self._start(spec, s)
        self.compared = s.steps     # after which the states are compared

    def _start(self, spec, s):
        if s.start is None and not spec.starts:
            return self.on_spheres(self.dice.standard_normal((self.witness.sites, 3)))
        return given_or_at(s.numbers.of(scene_of(spec, s.effects, s.parameters)), s.start, s.seed)

    def on_spheres(self, w):
        """Each w_i of a sphere scaled to its radius; the others as they are."""
        scale = np.where(np.isnan(self.radius), 1.0, self.radius / np.linalg.norm(w, axis=1))
        return w * scale[:, None]

    def random_state(self):
        """Anywhere on the spheres; elsewhere the start, each component changed by some 10 %."""
        dice = self.dice.standard_normal((2, self.witness.sites, 3))
        near = self.w + 0.1 * np.linalg.norm(self.w, axis=1)[:, None] * dice[0]
        return self.on_spheres(np.where(np.isnan(self.radius)[:, None], near, dice[1]))

    def nudged(self):
        """The start moved by NUDGE, in a random direction, on its spheres."""
        return self.on_spheres(self.w + NUDGE * np.linalg.norm(self.w, axis=1)[:, None] * self.dice.uniform(-1, 1, self.w.shape))

    def begin(self, w, h):
        self.model.start(np.array(w), h=h)
        return self.model

    @staticmethod
    def guarded(check, compare, otherwise):
        """What compare returns, or a line that failed when a step or the flow does."""
        try:
            return compare()
        except RunError as error:
            return [Line(check, math.nan, "a result", False, str(error))], otherwise


def difference(a, b) -> float:
    """max |a - b|; infinite if only one of them is finite."""
    gap = np.abs(np.asarray(a, float) - np.asarray(b, float))
    return float(np.max(np.where(np.isnan(gap), np.inf, gap), initial=0.0))


def agreement(check, measured, bound, note="") -> Line:
    return Line(check, measured, f"{bound:.2g}", bool(measured <= bound), note)


# -- (a) field, energy, values at states ---------------------------------------------------

def field_lines(case: Case) -> list[Line]:
    """Worst of the random states, each in units of its own bound."""
    seen, refused = {}, 0
    for _ in range(case.points):
        w, t = case.random_state(), case.dice.uniform() * STEPS * case.settings.h
        case.begin(case.w, case.settings.h)
        try:
            found = compare_at(case, w, t)
        except RunError:
            refused += 1
            continue
        for name, pair in found.items():
            seen.setdefault(name, []).append(pair)
    if refused == case.points:
        return [Line("field", math.nan, "a result", False, "not finite at any random state")]
    note = f"at {case.points - refused} random states" + f", {refused} not finite" * bool(refused)
    return [agreement(name, *with_largest(pairs, in_bounds), note) for name, pairs in seen.items()]


def in_bounds(pair) -> float:
    """What was measured, in units of its bound."""
    measured, bound = pair[:2]
    return measured / bound


def compare_at(case, w, t) -> dict:
    """{'field': (difference, bound), 'energy': ...} at one state and time.

    Bounds: ROUND_OFF of the largest number, and what a change of w and t by some units in the
    last place does to it (a difference of nearly equal numbers loses digits).
    """
    one = case.witness
    b, parts = one.field(w, t), one.energies(w, t)
    power = float(np.sum(np.abs(b) * np.abs(w) * np.abs(one.kappa)[:, None]))
    return {
        "field": (difference(case.model.field(w, t), b), ROUND_OFF * largest(TINY, np.abs(b).max()) + scatter(case, one.field, w, t)),
        "energy": (difference(case.model.energy(w, t), sum(parts.values())),
                   ROUND_OFF * largest(TINY, power, *np.abs(list(parts.values()))) + scatter(case, one.energy, w, t)),
    }


def scatter(case: Case, number, w, t) -> float:
    """What 32 units in the last place of w and of t do to the numbers of the witness."""
    at = number(w, t)
    return (difference(number(stirred(case, w), t), at) + difference(number(w, t * (1 + STIR)), at)) / STIR * 32 * EPSILON


def stirred(case: Case, w):
    return w * (1 + STIR * case.dice.uniform(-1, 1, w.shape))


def value_lines(case: Case) -> list[Line]:
    """Energy of each effect, momentum, observables and Casimirs: the columns of a run, at the start."""
    model = case.begin(case.w, case.settings.h)
    mine, near = ({**expected_values(case.witness, w, 0.0), "casimirs": expected_casimirs(case.witness, w)} for w in (case.w, stirred(case, case.w)))
    columns = {**dict(zip(model.columns, model.values())), "casimirs": model.casimirs()}
    found = [(difference(value, mine[name]), ROUND_OFF * largest(TINY, np.abs(mine[name]).max(), difference(near[name], mine[name]) / STIR), name)
             for name, value in columns.items()]
    measured, bound, worst = with_largest(found, in_bounds)
    return [agreement("values at the start", measured, bound, f"{len(columns)} columns, "
                      f"worst: {worst}")]


def expected_casimirs(one: Witness, w) -> np.ndarray:
    """|w|^2 of every site, C(w) on a Nambu factor: shape (sites,)."""
    twice = np.einsum("sa,sab,sb->s", w, casimir_matrices(one.spec, one.values), w)
    half = np.zeros(one.sites, bool)
    for family in one.spec.families:
        first, count = one.families[family.name]
        half[first:first + count] = family.kind == "nambu"
    return np.where(one.absent, 0, np.where(half, twice / 2, twice))


def expected_values(one: Witness, w, t) -> dict:
    """The witness's numbers under the names of `integrator.value_columns`."""
    found = {"energy": one.energy(w, t), **one.observables(w, t)}
    found.update({f"energy.{name}": e for name, e in one.energies(w, t).items()})
    for family, (first, count) in one.families.items():
        part = slice(first, first + count)
        total = [math.fsum(column) for column in (np.where(one.absent, 0, one.kappa)[part, None] * w[part]).T]
        found.update({f"momentum.{family}.{axis}": total[k] for k, axis in enumerate("xyz")})
    return found


# -- (b) the same method with the same step ------------------------------------------------

def compare_steps(case: Case):
    """(lines, growth of the tangent map). Above DENSE sites by residuals instead."""
    if case.witness.sites > DENSE and case.settings.method in EQUATIONS:
        return [compare_residuals(case)], math.nan
    s = case.settings
    mine = case.witness.steps(case.w, 0.0, s.h, s.steps, s.method)
    other = case.witness.steps(case.nudged(), 0.0, s.h, s.steps, s.method)
    apart = np.abs(other - mine).max(axis=(1, 2)) / (NUDGE * size(case.w))
    case.compared = max(1, int(np.argmax(apart > LINEAR)) - 1) if np.any(apart > LINEAR) else s.steps
    growth, upto = largest(*apart[:case.compared + 1]), slice(case.compared + 1)
    compiled = trajectory(case, case.w, s.h, s.steps)
    note = f"tangent map grows {growth:.3g}" + (", allowed for" if growth > SENSITIVE else "") + (
        f"; compared for {case.compared} steps, then it grows beyond {LINEAR:g}" * (case.compared < s.steps))
    return [agreement(f"{s.steps} steps", difference(compiled[upto], mine[upto]), allowed(case, mine, growth), note)], growth


def allowed(case: Case, states, growth) -> float:
    """The bound of a difference of states: of each hundred steps, and as the tangent map grows."""
    s = case.settings
    return ((FLOOR if METHODS[s.method].controlled else ROUND_OFF) * size(states) * (growth if growth > SENSITIVE else 1.0)
            * max(1.0, case.compared / STEPS))


def compare_noise(case, spec, growth) -> list[Line]:
    """The same steps with thermal noise, which stretches no distance. The other lines are those of the step without it."""
    s, one = case.settings, Witness(spec, case.settings.parameters, case.settings.effects, seed=case.settings.seed or 0)
    if one.diffusion is None or one.sites > DENSE:
        return []
    mine = one.steps(case.w, 0.0, s.h, s.steps, s.method)
    model = model_of(spec, s).start(np.array(case.w), h=s.h, seed=s.seed)
    found = np.array([mine[0], *(np.array(model.step().w, float) for _ in range(s.steps))])
    upto = slice(case.compared + 1)
    return [agreement(f"{s.steps} steps with noise", difference(found[upto], mine[upto]), allowed(case, mine, growth))]


def compare_residuals(case):
    """Each compiled step put into the witness's step equation."""
    s, worst = case.settings, 0.0
    model = case.begin(case.w, s.h)
    for k in range(s.steps):
        before = np.array(model.w, float)
        model.step()
        worst = largest(worst, case.witness.residual(before, model.w, k * s.h, s.h, s.method))
    return agreement(f"residual of {s.steps} steps", worst, ROUND_OFF * size(model.w),
                     f"more than {DENSE} sites, so the witness takes no steps of its own")


def trajectory(case, w, h, count):
    """Compiled states after 0 .. count steps."""
    model = case.begin(w, h)
    states = [np.array(model.w, float)]
    for _ in range(count):
        model.step()
        states.append(np.array(model.w, float))
    return np.array(states)


# -- (c) convergence to the flow -----------------------------------------------------------

def compare_flow(case: Case) -> list[Line]:
    """Order of convergence at a fixed time, and the two reference flows against each other."""
    start = moving(case)
    if METHODS[case.settings.method].controlled:
        return compare_end(case, start)
    time, steps, errors, tried = converge(case, start)
    claimed = METHODS[case.settings.method].order
    low, high = (claimed * part for part in ORDER)
    note = (f"errors {', '.join(f'{e:.2e}' for e in errors)} at t = {time:.4g} after "
            f"{steps}, {2 * steps}, {4 * steps} steps{tried}")
    if largest(*errors) <= FLOOR * size(start):
        lines = [agreement("order of convergence", largest(*errors), FLOOR * size(start),
                           "exact here; " + note)]
    elif largest(*errors) <= RESOLVED * FLOOR * size(start) and not shows_order(errors, size(start), claimed):
        lines = [agreement("order of convergence", largest(*errors), RESOLVED * FLOOR * size(start),
                           "too small for the order to be visible; " + note)]
    else:
        lines = [Line("order of convergence", observed(errors, size(start)), f"{low:g} .. {high:g}",
                      shows_order(errors, size(start), claimed), note)]
    return lines + implicit_line(case, start, time)


def size(w) -> float:
    """The largest |w_i|."""
    return largest(TINY, np.linalg.norm(w, axis=-1).max())


def moving(case):
    """The start; where it is at rest, a state beside it."""
    speed = float(np.abs(case.witness.vector_field(case.w, 0.1 * case.settings.h)).max())
    if abs(case.settings.h) * speed > 1e-7 * size(case.w):
        return case.w
    length = np.linalg.norm(case.w, axis=1)[:, None]
    return case.on_spheres(case.w + 0.1 * np.where(length > 0, length, 1) * case.dice.standard_normal(case.w.shape))


def converge(case, start):
    """(time, steps, errors, what was done): steps of h, h/2, h/4 over one time.

    From 8 steps of the run's h. While h is too large for the order to show, h is halved at
    the same time; while the errors are at round-off, the time is doubled, as far as the
    reference flows agree.
    """
    time, steps, tried = 8 * case.settings.h, 8, ""
    halved = doubled = 0
    while True:
        errors = flow_errors(case, start, time, steps)
        if errors is not None and errors[-1] <= FLOOR * size(start):
            if doubled == DOUBLINGS or halved or not flows_agree(case, start, 2 * time):
                return time, steps, errors, tried
            time, steps, doubled = 2 * time, 2 * steps, doubled + 1
            tried = f" (the time was doubled {doubled} times so that errors exceed round-off)"
        elif errors is not None and shows_order(errors, size(start), METHODS[case.settings.method].order) or halved == HALVINGS:
            return time, steps, errors or [math.nan] * 3, tried
        else:
            steps, halved = 2 * steps, halved + 1
            tried = f" (h was halved {halved} times before the order was visible)"


def compare_end(case: Case, start) -> list[Line]:
    """Of a method with step control: the state after eight steps, against the flow."""
    time = 8 * case.settings.h
    errors = flow_errors(case, start, time, 8)
    return [agreement("distance from the flow", largest(*(errors or [math.nan])), FLOOR * size(start), f"at t = {time:.4g}"), *implicit_line(case, start, time)]


def observed(errors, scale) -> float:
    """The order between the last two errors that the reference flow resolves, of the first two at least."""
    pairs = [(a, b) for a, b in zip(errors, errors[1:]) if b > RESOLVED * FLOOR * scale] or [errors[:2]]
    a, b = pairs[-1]
    return math.log2(a / b) if a > 0 and b > 0 else math.nan


def shows_order(errors, scale, order):
    """Small errors, the observed order near that of the method, and the one before it not far from it."""
    first = math.log2(errors[0] / errors[1]) / order if smallest(*errors) > 0 else math.nan
    return errors[0] < 0.1 * scale and ORDER[0] <= observed(errors, scale) / order <= ORDER[1] and abs(first - 1) < 0.25


def flow_errors(case, start, time, steps):
    """Max errors with `steps`, 2 and 4 times as many steps; None where a step fails."""
    exact = case.witness.flow(start, 0.0, [time])[0]
    try:
        return [difference(case.begin(start, time / n).steps(n).w, exact)
                for n in (steps, 2 * steps, 4 * steps)]
    except RunError:
        return None


def implicit_line(case, start, time):
    """The explicit and the implicit reference flow agree (the witness with itself), over the time that begins the search for the order:
    over longer ones their own errors add up."""
    time = math.copysign(min(abs(time), 8 * abs(case.settings.h)), time)
    if case.witness.sites > STIFF:
        return []
    a = case.witness.flow(start, 0.0, [time])[0]
    b = case.witness.flow(start, 0.0, [time], "bsimp", 1e-12)[0]
    return [agreement("reference flows agree", difference(a, b), 1e-8 * size(a),
                      "rk8pd and bsimp")]


def flows_agree(case, start, time):
    """Does the reference still resolve errors of FLOOR after this time? A flow with ten times the local error is no further off."""
    try:
        a, b = (case.witness.flow(start, 0.0, [time], tol=tol)[0] for tol in (1e-13, 1e-12))
    except RunError:
        return False
    return difference(a, b) <= FLOOR * size(a)
