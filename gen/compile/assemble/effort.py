"""The most that one step can take, whatever w and h: counted loop by loop, as the headers of runtime/ have them, by the numbers that stand there.

A part that changes the way of a step says so (`most`, `most_around` of `part.py`). tests/runtime/test_most.py counts evaluations of steps that are as hard as
can be, and measures their stack.
"""
from __future__ import annotations

from dataclasses import astuple, dataclass, replace

from ...resources import runtime_numbers


@dataclass(frozen=True)
class Effort:
    """gradients: evaluations of dH/dw of a site; hessians: of d2H/dw2, as blocks of a matrix, or times a vector; iterations: as the report
    counts them; stack: bytes."""
    gradients: int
    hessians: int = 0
    iterations: int = 0
    stack: int = 0

    def __add__(self, other: Effort) -> Effort:
        """One after the other; the last one that iterates reports."""
        return replace(self.either(other), gradients=self.gradients + other.gradients, hessians=self.hessians + other.hessians)

    def __mul__(self, times: int) -> Effort:
        """So many times, with one report."""
        return replace(self, gradients=times * self.gradients, hessians=times * self.hessians)

    def either(self, other: Effort) -> Effort:
        return Effort(*map(max, astuple(self), astuple(other)))

    def times_reported(self, times: int) -> Effort:
        """So many times, all iterations in one report."""
        return replace(self * times, iterations=times * self.iterations)


NOTHING = Effort(0)
# Bytes of stack with gcc and clang at -O1 or more, registers of any width, in doubles: tests/runtime/test_most.py measures 4,100 at most where there are no
# lattices, 33,000 with the basis of a Krylov space (smg_krylov_small), 55,000 by rows, whose pieces stand there.
STACK, LARGE_STACK = 8192, 65536


def number(name: str, which=max) -> int:
    """The value of a macro of runtime/; of several, by its conditions, one."""
    return which(runtime_numbers()[name])


def most(model) -> Effort:
    """Of one step of the model."""
    step = of_midpoints(model) if model.method.of_midpoints else of_method(model.method)
    for part in model.parts:
        step = part.most(model, step)
    for part in model.parts:
        step = part.most_around(model, step)
    return replace(step, stack=LARGE_STACK if large_stack(model) else STACK)


def large_stack(model) -> bool:
    """By rows, by blocks of tracers, or without a matrix."""
    return model.plan.layout == "rows" or model.alone_in_lanes is not None or bool(model.coupled) and not model.plan.matrix


# Methods that are no midpoints

def of_method(method) -> Effort:
    """One stage of a splitting; a step of any other."""
    if method.splitting:
        return Effort({"axes": 5, "sublattices": 2, "pairs": 2}[method.splitting])
    how = method.how[0]
    if how == "fixed-point":
        return by_fixed_point(dict(method.defines).get("SMG_STAGES", 1), method.points)
    if method.controlled:       # of each try all stages; the first size takes one more
        return Effort(1 + 12 * number("SMG_MOST_TRIES"), iterations=number("SMG_MOST_TRIES"))
    return Effort(method.points)


def by_fixed_point(stages: int, points: int) -> Effort:
    """smg_solve_stages: twice, from the polynomial and from rest; as many sweeps as it has stages to begin with, and an eighth as many again at the end."""
    sweeps = number("SMG_MOST_SWEEPS")
    return Effort(2 * stages * points * (stages + sweeps + 1 + (sweeps - 1) // 8), iterations=2 * sweeps)


# Midpoints

def of_midpoints(model) -> Effort:
    """Sites that are solved together and sites alone are different ones: no site has both."""
    together = coupled(model) if model.coupled else NOTHING
    alone = [closed_form() if model.closed_form(f) else alone_by_newton(model.method.divided) for f in model.alone]
    for one in alone:
        together = together.either(one)
    return together


def newton(model) -> Effort:
    """smg_newton: the loop, the branch (two evaluations where it begins), and the end, plain or by Newton on the increment with the noise of the field (smg_noise_of_all)."""
    loop, rounds = number("SMG_MAX_NEWTON"), number("SMG_ROUNDS")
    end = max(number("SMG_REFINEMENTS"), rounds + 1 + 2 * number("SMG_PROBES") + 1)
    systems = loop + rounds
    products = 0 if model.plan.matrix else (systems + 1) * products_of_a_system() + 4 * number("SMG_LANCZOS_STEPS")
    return Effort(loop + 1 + 2 + end, loop + 1 + 2 + rounds + 1 + products, systems)


def products_of_a_system() -> int:
    """smg_krylov_solve: no basis is begun after so many; each ends with one product more."""
    return number("SMG_KRYLOV_PRODUCTS") + number("SMG_KRYLOV_BASIS")


def curve(model) -> Effort:
    """smg_follow: corrections of every point, two systems each; without a matrix the sign of det J of every point, by Lanczos or elimination."""
    points, corrections = number("SMG_MAX_POINTS"), number("SMG_MAX_CORRECTIONS")
    evaluations = 1 + points * corrections
    if model.plan.matrix:
        return Effort(evaluations, 2 * evaluations)
    sign = 2 * number("SMG_LANCZOS_STEPS") + number("SMG_KRYLOV_DENSE")
    return Effort(evaluations, 2 * evaluations * (1 + products_of_a_system()) + points * sign)


def coupled(model) -> Effort:
    """smg_solve_coupled: sweeps, Newton from the extrapolated start and from rest, then the curve and Newton at its end."""
    tries = newton(model) * (4 if model.plan.swept else 3)
    return tries + curve(model) + (sweeps(model) if model.plan.swept else NOTHING)


def sweeps(model) -> Effort:
    """smg_sweeps, until Newton: they begin with one, and are followed by looks at the increments, and at the midpoints."""
    tried = (model.plan.tried if model.plan.rotation else 0) or number("SMG_TRIED_SWEEPS", min if model.plan.matrix else max)
    if model.plan.matrix:
        return Effort(tried + 3, 0, tried)
    return Effort(tried + 6, 4 + 4 * number("SMG_LANCZOS_STEPS") + products_of_a_system(), tried)


def closed_form() -> Effort:
    """smg_solve_linear."""
    return Effort(1)


def alone_newton() -> Effort:
    """smg_site_newton: any iteration may measure the noise of the field, and a last one try its increment and measure again."""
    loop, probed = number("SMG_MAX_NEWTON"), 1 + number("SMG_PROBES")
    return Effort(2 * probed * (loop + 1) + number("SMG_REFINEMENTS"), loop, loop)


def alone_by_newton(divided: bool) -> Effort:
    """smg_site_solve: Newton, then the curve, and Newton at its end; of a divided method Newton for each stage of h."""
    if divided:
        return alone_newton() * (1 + number("SMG_CONTINUATION_STEPS"))
    evaluations = 1 + number("SMG_MAX_POINTS") * number("SMG_MAX_CORRECTIONS")
    return alone_newton() * 2 + Effort(evaluations, 2 * evaluations)


def single_sphere() -> Effort:
    """smg_sphere_step, where its Newton iteration leaves too much: smg_sphere_afresh, _resume, and _hard, which iterates from there, then from rest."""
    in_a_row, loop = number("SMG_MOST_IN_A_ROW"), number("SMG_MAX_NEWTON")
    quick = Effort(2, 1) + Effort(4, 1) + Effort(in_a_row + 1, in_a_row)
    return quick + Effort(2 * loop + 2, 2 * loop, loop) * 2 + alone_by_newton(False)


def widened() -> Effort:
    """smg_widen."""
    return Effort(1, number("SMG_WIDE_TERMS"))


def few_in_lanes() -> Effort:
    """smg_few_iterate."""
    return Effort(number("SMG_FEW_ROUNDS"), 0, number("SMG_FEW_ROUNDS"))


def by_rows() -> Effort:
    """smg_row_step: passes of all colours, and the end of every round."""
    passes = number("SMG_ROW_PASSES")
    return Effort(passes + number("SMG_ROW_ROUNDS") + 2, 0, passes)


def beyond_rows() -> Effort:
    """smg_sweeps of smg_row_beyond.h: what is left after each of its calls may be overstepped by two sweeps."""
    sweeps = number("SMG_BEYOND_SWEEPS") + number("SMG_PATH_SWEEPS")
    return Effort(sweeps + 8, 0, sweeps)
