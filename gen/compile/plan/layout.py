"""The layout of a step: how sites stand in memory, and how many of them go at once.

    sites      one after the other
    single     one sphere alone, in registers
    few        few sites, one in each lane
    rows       a lattice row after row of a colour, its sites in lanes
    members    an ensemble of single spheres, a state in each lane

What a layout needs (kernels in lanes, bounds of the Hessian) the parts of a model find or do not; which of those that are offered is taken is
decided here, and nowhere else. By rows it is settled for each state whether h is small enough: `smg_choose_rows` of
runtime/lattice/smg_row_state.h.
"""
from __future__ import annotations

from dataclasses import replace

from ...methods import Method
from .plan import Plan

HISTORY = 7     # increments kept for the predictor where a layout has no number of its own; its degree adapts up to one less
LAYOUTS = ("members", "rows", "few", "single", "sites")     # the first that is offered is taken; the last always is
MIDPOINT_ROWS = "by rows in lanes if h is so small that sweeps must converge"
TURN_ROWS = "sites of a row in lanes if the periodic directions fit the colours"
STAGE_ROWS = "sites of a row in lanes"
ALL_PAIRS = "all pairs: fixed-point iteration in lanes while it converges fast"
FEW = "few sites: fixed-point iteration in lanes while it converges fast, otherwise dense Newton"


def with_layout(plan: Plan, method: Method, offered) -> Plan:
    """The plan with the layout that is taken of those that are offered, and what there is to say of it."""
    layout = next(name for name in LAYOUTS if name in {*offered, "sites"})
    laid = replace(plan, layout=layout)
    if layout == "rows":
        return laid.also(MIDPOINT_ROWS if method.of_midpoints else TURN_ROWS if method.splitting else STAGE_ROWS)
    if layout == "few":
        return replace(laid, reason=FEW if plan.solver == "dense" else f"{ALL_PAIRS}; {plan.reason}")
    return laid


def by_threads(plan: Plan, method: Method) -> bool:
    """May several threads share a step?"""
    return plan.layout == "rows" and not method.takes_fields and method.splitting != "pairs"


def by_ranks(plan: Plan, method: Method) -> bool:
    """May several ranks of MPI?"""
    return plan.layout == "rows" and method.of_midpoints
