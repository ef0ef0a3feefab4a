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
    "run": "every step of the run solves the step equation, recomputed in extended precision",
    "whole space": "steps from states throughout phase space solve the step equation",
    "branch": "long steps are either refused or lie on the branch that starts at W = w for h = 0",
    "refusals": "a step is refused only if this branch has no solution",
    "order": "errors decrease with the order of the method, also where H depends on time",
    "symplectic": "one step is a symplectic (Poisson) map",
    "tracers' area": "tracers are moved by an area-preserving map",
    "tangent map": "the generated tangent map is the derivative of the step",
    "tangent symplectic": "the generated tangent map is symplectic",
    "reversible": "a step of -h is the inverse of a step of h",
    "equivariant": "the step commutes with rotations that leave H unchanged",
    "momentum": "the momentum that belongs to these rotations is conserved",
    "quadratic integrals": "quadratic integrals of single sites are conserved",
    "energy": "the energy is conserved exactly",
    "casimirs": "every w stays on its sphere or leaf",
    "sums": "sums are compensated: nothing is lost in rounding W = w + u",
    "round-off": "round-off is a random walk: errors grow like sqrt(N)",
    "round-off size": "errors from round-off are small",
    "field": "the field agrees with the spec",
    "energy formula": "the energy agrees with the spec",
    "outputs": "energies, momentum, Casimirs and observables agree with the spec",
    "step": "one step equals that of the independent interpreter",
    "residual": "the step equation holds, recomputed in extended precision",
    "iterations": "iterations start as close to the solution as the previous steps allow",
    "predictor": "this holds for each degree of the extrapolation",
    "settled": "iterations end when only round-off is left",
    "tolerance": "iterations end within the requested tolerance",
    "restore": "a run from a restored state continues bit for bit as if it had not been interrupted",
    "ensemble": "each member of an ensemble agrees bit for bit with a run on its own",
    "by rows": "a lattice is processed by rows only if its sweeps contract",
    "threads": "sharing a step among threads does not change a bit",
    "wavefronts": "wavefronts, which large lattices use, do not change a bit",
    "ranks": "sharing a step among MPI ranks does not change a bit",
    "noise": "steps with thermal noise agree with those of the independent interpreter, noise included",
    "noise restored": "restarted runs with thermal noise agree bit for bit with uninterrupted ones",
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
