"""What a scene still calls for: families, and with them starts, observables and outputs; parameters of its bases."""
from __future__ import annotations

from dataclasses import replace

from ..language import codes
from ..language.names_used import unused
from ..language.spec import Run, Spec
from .tree import Node

Gone = dict[tuple[str, ...], str]       # the first two words of an output or of a number to average -> why there is none
LISTS = (("output", "what"), ("averages", "what"))


def called_for(spec: Spec, left_out) -> tuple[Spec, Gone]:
    """The spec without the families that no effect moves or names, and without what speaks of them or of the effects left out; and what is gone."""
    left = set().union(*(e.families for e in spec.effects))
    gone = gone_from(spec, left_out, left)
    return replace(spec, families=tuple(f for f in spec.families if f.name in left),
                   observables=tuple(o for o in spec.observables if (o.name,) not in gone),
                   starts=tuple(replace(s, families=tuple(p for p in s.families if p.family in left)) for s in spec.starts),
                   runs=tuple(with_outputs(run, gone) for run in spec.runs)), gone


def gone_from(spec: Spec, left_out, left: set[str]) -> Gone:
    """left_out: effects; left: families."""
    found = {("energy", effect): f"the scene leaves out the effect `{effect}`" for effect in left_out}
    for family in sorted({f.name for f in spec.families} - left):
        why = f"the scene has no effect that moves or names `{family}`"
        found |= {("momentum", family): why} | {(o.name,): why for o in spec.observables if family in o.families}
    return found


def is_gone(word: str, gone: Gone) -> str | None:
    """Why an output, or a number to average, is gone; None: it is there."""
    return gone.get(tuple(word.split(".")[:2]))


def with_outputs(run: Run, gone: Gone) -> Run:
    """A run without the outputs that are gone; one with none left has those of a run that names none."""
    what, means = (tuple(word for word in words if not is_gone(word, gone)) for words in (run.what, run.averages.what if run.averages else ()))
    return replace(run, what=what or (() if run.averages else Run.what), averages=run.averages and replace(run.averages, what=means))


def refuse_gone(root: Node, gone: Gone) -> None:
    """Errors for the lists of the scene's own file that name what is gone; those of its bases do without."""
    own = root.problems.sources.files[0]
    for run in root.get("runs").items() if root.has("runs") else ():
        for entry in (e for keys in LISTS for e in listed(run, keys)):
            if root.problems.sources.of(entry.span.start) is own and is_gone(entry.raw, gone):
                root.problems.note(codes.OUTPUT, entry.span, f"there is no `{entry.raw}`: {is_gone(entry.raw, gone)}",
                                   "remove it from this list, or add the effect to [scene]")


def listed(run: Node, keys) -> list[Node]:
    """The entries of a list of a run, none where it has no such list."""
    table, key = keys
    held = run.get(table)
    return held.get(key).entries() if held and held.has(key) else []


def with_parameters(spec: Spec, inherited: set[str]) -> Spec:
    """The spec, and its runs, without those of these parameters that nothing uses."""
    idle = inherited and inherited & set(unused(spec))
    if not idle:
        return spec
    runs = tuple(replace(run, parameters=tuple(p for p in run.parameters if p[0] not in idle)) for run in spec.runs)
    return with_parameters(replace(spec, parameters=tuple(p for p in spec.parameters if p.name not in idle), runs=runs), inherited)
