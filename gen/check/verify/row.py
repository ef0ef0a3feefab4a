"""One line of a certificate: what is claimed, what was measured, the criterion and the verdict."""
from __future__ import annotations

import dataclasses
import math

YES, NO, NOT_APPLICABLE = "yes", "no", "does not apply"
VERDICTS = (YES, NO, NOT_APPLICABLE)
MOST, LEAST = "<=", ">="

# name -> what the row claims of an integrator
CLAIMS = {
    "steps": "the run's own steps can be taken",
    "run": "every one of them solves the step equation, recomputed in extended precision",
    "whole space": "so do steps from states throughout phase space",
    "branch": "long steps are on the branch of W = w at h = 0, or refused",
    "refusals": "a step is refused only if that branch has no solution",
    "order": "errors fall with the order of the method, time dependence included",
    "symplectic": "one step is a symplectic (Poisson) map",
    "tracers' area": "tracers are moved by an area-preserving map",
    "tangent map": "the generated tangent map is the derivative of the step",
    "tangent symplectic": "the generated tangent map is symplectic",
    "reversible": "a step of -h is the inverse of a step of h",
    "equivariant": "rotations that leave H unchanged commute with the step",
    "momentum": "the momentum of these rotations is conserved",
    "quadratic integrals": "quadratic integrals of single sites are conserved",
    "energy": "the energy is conserved exactly",
    "casimirs": "every w stays on its sphere or leaf",
    "sums": "sums are compensated: rounding W = w + u loses nothing",
    "round-off": "round-off is a random walk: errors grow like sqrt(N)",
    "round-off size": "and its errors are small",
    "field": "the field is that of the spec",
    "energy formula": "the energy is that of the spec",
    "outputs": "energies, momentum, Casimirs and observables are those of the spec",
    "step": "one step equals that of the independent interpreter",
    "residual": "the step equation holds, recomputed in extended precision",
    "iterations": "iterations start as close as the previous steps allow",
    "predictor": "and for each degree of the extrapolation",
    "settled": "they end when only round-off is left",
    "tolerance": "or within the requested tolerance",
    "restore": "a restored state continues with the bits of the uninterrupted run",
    "ensemble": "each member of an ensemble has the same bits as on its own",
    "by rows": "a lattice is processed by rows only if its sweeps are a contraction",
    "threads": "threads share a step without changing a bit",
    "wavefronts": "so do wavefronts, which large lattices use",
    "ranks": "and the ranks of MPI",
    "noise": "steps with thermal noise are those of the independent interpreter, with its noise",
    "noise restored": "and after a restart they have the bits of the uninterrupted run",
}
# row -> unit of what is measured
UNITS = {"reversible": "ulp", "equivariant": "ulp", "momentum": "ulp", "quadratic integrals": "ulp",
         "noise": "ulp", "energy": "ulp", "casimirs": "ulp", "step": "ulp", "residual": "ulp",
         "run": "ulp", "whole space": "ulp", "round-off size": "ulp", "settled": "ulp"}


@dataclasses.dataclass(frozen=True)
class Row:
    """One property. measured is None where nothing could be; note says where and why.

    relation and bound are the criterion: `measured <= bound` or `measured >= bound`.
    """
    name: str
    measured: float | None
    relation: str
    bound: float | None
    verdict: str
    note: str = ""

    @property
    def claim(self) -> str:
        return CLAIMS[self.name]

    @property
    def criterion(self) -> str:
        """The criterion in words."""
        if self.bound is None:
            return ""
        return f"{self.relation} {self.bound:.3g} {UNITS.get(self.name, '')}".rstrip()


def verdict(measured, relation: str, bound) -> str:
    """What the numbers say; a NaN meets no criterion."""
    if bound is None:
        return NOT_APPLICABLE
    if measured is None or not math.isfinite(measured):
        return NO
    return YES if (measured <= bound if relation == MOST else measured >= bound) else NO


def at_most(name: str, measured: float, bound: float, note: str = "") -> Row:
    """yes when measured <= bound."""
    return Row(name, float(measured), MOST, float(bound), verdict(measured, MOST, bound), note)


def at_least(name: str, measured: float, bound: float, note: str = "") -> Row:
    """yes when measured >= bound."""
    return Row(name, float(measured), LEAST, float(bound), verdict(measured, LEAST, bound), note)


def refused(name: str, why: str) -> Row:
    """no, because the integrator gave nothing to measure."""
    return Row(name, None, "", None, NO, why)


def not_applicable(name: str, why: str) -> Row:
    """The question makes no sense here, and why."""
    return Row(name, None, "", None, NOT_APPLICABLE, why)
