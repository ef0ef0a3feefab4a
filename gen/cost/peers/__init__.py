"""General integrators beside which the methods are measured: for the comparison only, nothing else needs them.

    known, missing = of_case(case)      # name -> integrator on that case, name -> what it needs
"""
from __future__ import annotations

from dataclasses import dataclass

from ..measure.case import Case
from .by_hand import ByHand
from .compiled import Compiled, Missing
from .scipy_rk import SciPy
from .taylor import Taylor

__all__ = ["PEERS", "Peer", "of_case"]


@dataclass(frozen=True)
class Peer:
    """label: in tables and legends; makes: the class that runs it; source, kind: of those in C."""
    label: str
    makes: type
    source: str = "gsl.c"
    kind: int = 0


PEERS = {"gsl-rk8pd": Peer("GSL rk8pd", Compiled), "gsl-msadams": Peer("GSL msadams", Compiled, "gsl.c", 1),
         "gsl-msbdf": Peer("GSL msbdf", Compiled, "gsl.c", 2), "cvode-adams": Peer("CVODE Adams", Compiled, "cvode.c", 0),
         "cvode-bdf": Peer("CVODE BDF", Compiled, "cvode.c", 1), "arkode": Peer("ARKODE order 8", Compiled, "arkode.c"),
         "c-by-hand": Peer("DOP853 by hand", ByHand, "by_hand.c"),
         "scipy": Peer("SciPy DOP853", SciPy), "heyoka": Peer("heyoka", Taylor)}


def of_case(case: Case, names=tuple(PEERS)) -> tuple[dict, dict]:
    """(name -> integrator, name -> what is missing)."""
    found, missing = {}, {}
    if not case.conservative:
        return {}, {name: "a right-hand side with damping or torques, which it does not provide" for name in names}
    for name in names:
        peer = PEERS[name]
        try:
            found[name] = peer.makes(case, peer.source, peer.kind)
        except Missing as needs:
            missing[name] = str(needs)
    return found, missing
