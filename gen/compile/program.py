"""What a library depends on: the selected spec without what is given when it runs."""
from __future__ import annotations

from dataclasses import replace

from ..language.spec import Parameter, Spec


def program_of(spec: Spec) -> Spec:
    """The spec as its library knows it: no texts, starts or runs, and no value of a run-time parameter.

    Values that decide how a step is solved, sizes above all, come in through the plan alone (`gen/compile/plan/plan.py`).
    """
    return replace(spec, title="", path="", digest="", sources=(), starts=(), runs=(), units=None,
                   parameters=tuple(map(unset, spec.parameters)), effects=tuple(e.untitled for e in spec.effects),
                   observables=tuple(o.untitled for o in spec.observables))


def unset(p: Parameter) -> Parameter:
    """Without its texts and, unless it is compiled in, without its value."""
    return replace(p, meaning="", unit="") if p.fixed else replace(p, meaning="", unit="", default=None, fill=False)
