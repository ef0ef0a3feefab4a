"""What a scene still calls for: families, and with them starts, observables and outputs; parameters of its bases."""
from __future__ import annotations

from dataclasses import replace

from ..language.names_used import unused
from ..language.spec import Run, Spec
from .names import COMPUTED, OUTPUTS


def called_for(spec: Spec) -> Spec:
    """The spec without the families that no effect moves or names, and without what speaks of them."""
    left = set().union(*(e.families for e in spec.effects))
    if left == {f.name for f in spec.families}:
        return spec
    observables = tuple(o for o in spec.observables if o.families <= left)
    kept = {*OUTPUTS, *COMPUTED, *(o.name for o in observables)}
    return replace(spec, families=tuple(f for f in spec.families if f.name in left), observables=observables,
                   starts=tuple(replace(s, families=tuple(p for p in s.families if p.family in left)) for s in spec.starts),
                   runs=tuple(with_outputs(run, kept) for run in spec.runs))


def with_outputs(run: Run, kept: set[str]) -> Run:
    """A run without the outputs that are gone."""
    averages = run.averages and replace(run.averages, what=tuple(word for word in run.averages.what if "." in word or word in kept))
    return replace(run, what=tuple(word for word in run.what if word in kept), averages=averages)


def with_parameters(spec: Spec, inherited: set[str]) -> Spec:
    """The spec, and its runs, without those of these parameters that nothing uses."""
    idle = inherited and inherited & set(unused(spec))
    if not idle:
        return spec
    runs = tuple(replace(run, parameters=tuple(p for p in run.parameters if p[0] not in idle)) for run in spec.runs)
    return with_parameters(replace(spec, parameters=tuple(p for p in spec.parameters if p.name not in idle), runs=runs), inherited)
