"""What moves the sites of a spec, and what methods, solvers and features ask of it."""
from __future__ import annotations

from ...effects.held import fixed
from ...effects.motion import Response, times, where
from ...errors import UsageError
from ...language.expr import Num
from ...language.spec import Spec
from ...methods import METHODS, Method


def contributions_of(spec: Spec, method: Method | None = None) -> tuple:
    """One of each effect, as the method takes it, and of each family that is fixed."""
    return (*(e.contribution(spec, method) for e in spec.effects), *(fixed(f) for f in spec.families if f.fixed))


def fields_of(spec: Spec, contributions, method: Method) -> tuple:
    """(effect, the field that it adds to dH/dw of the site that it moves), of those that are no part of a response."""
    laws, bending = responses_of(contributions), {c.name: c.slots[0][0] for c in contributions if c.bends}
    return tuple((e, e.field(spec, laws[bending[e.name]].drag, method.across)) for e in spec.effects if e.name in bending)


def diffusions_of(contributions) -> dict:
    """Family -> its D, of those with noise."""
    moves = shares_of(contributions)
    return {family: where(moves.get(family, Num(1)), c.diffusion) for c in contributions if c.diffusion is not None for family, _ in c.slots}


def shares_of(contributions) -> dict:
    """Family -> 1 where a site moves, 0 where it does not; of those that have sites of both kinds, or none that moves."""
    found = {}
    for c in contributions:
        if c.moves is not None:
            found[c.slots[0][0]] = times(found.get(c.slots[0][0], Num(1)), c.moves)
    return found


def responses_of(contributions) -> dict:
    """Family -> its `Response`, of those that have one: its law, or nothing at sites that do not move."""
    found = laws_of(contributions)
    for family, share in shares_of(contributions).items():
        found[family] = found.get(family, Response()).times(share)
    return found


def laws_of(contributions) -> dict:
    """Family -> the `Response` of those of its sites that move: a law, with what torques add to it. Raises UsageError where a family has two laws."""
    found = {}
    for c in contributions:
        for family in dict.fromkeys(family for family, _ in c.slots if c.response is not None):
            if family in found:
                raise UsageError(f"'{c.name}' is a second law of motion for '{family}', which can have only one")
            found[family] = c.response
    for c in contributions:
        family = c.slots[0][0] if c.push or c.bends else None
        if family:
            law = found.get(family, Response())
            found[family] = law.pushed(*c.push) if c.push else law
    return found


def beyond_precession(contributions) -> str:
    """What makes sites do more than precess in their field, and the first effect that does."""
    kinds = (("damping", lambda c: c.response is not None), ("torques", lambda c: c.push or c.bends), ("sites that do not move", lambda c: c.moves is not None))
    return next(f"{kind} (effect '{c.name}')" for kind, has in kinds for c in contributions if has(c))


def require_of_responses(spec: Spec, contributions, method: Method) -> None:
    """Raises UsageError where sites move in their field in a way that the method or their space has no step for."""
    responses = responses_of(contributions)
    if responses and not method.responds:
        fitting = [m.name for m in METHODS.values() if m.responds and m.symmetric and m.stages == 1]
        raise UsageError(f"method {method.name} does not support {beyond_precession(contributions)}; use {' or '.join(fitting[:3])}")
    strange = [f.name for f in spec.families if f.name in responses and f.kind == "nambu"]
    if strange:
        raise UsageError(f"sites that do more than precess must be on spheres or in R^3, but '{strange[0]}' is a Nambu factor")


def all_offer(contributions, asked) -> bool:
    return not any(c.lacks(asked) for c in contributions)


def require(contributions, asked, who: str, instead: str = "") -> None:
    """Raises UsageError where a contribution does not offer what `who` asks of each."""
    for c in contributions:
        for what in c.lacks(asked):
            raise UsageError(f"{who} needs the {what} of every effect, but '{c.name}' does not provide it" + (f"; use {instead}" if instead else ""))


def require_of_method(contributions, method: Method) -> None:
    """What the method asks of every contribution, with the methods that ask no more than they offer."""
    fitting = [m.name for m in METHODS.values() if not m.free_body and all_offer(contributions, m.asks)]
    require(contributions, method.asks, f"method {method.name}", " or ".join(fitting[:3]))
    for c in contributions:
        if method.free_body and not c.conservative:
            raise UsageError(f"method {method.name} supports energies only, but '{c.name}' does not derive from an energy")
