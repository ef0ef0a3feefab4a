"""Stage `select`: a scene keeps the effects it names and the values it is given."""
from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..language.expr import Elem, Par, walk
from ..language.spec import Lattice, Parameter, Spec
from ..read import checks
from ..read.given import scaled
from ..read.problems import nearest
from ..read.tree import number_trouble
from ..read.values import defaults, with_values


def select(spec: Spec, effects=None, values=None) -> Spec:
    """The spec with the named `effects` only (None: all) and `values` as defaults.

    values: parameter name -> number or sequence of numbers. Parameters and tables that
    nothing uses any more are dropped. Raises UsageError for unknown names (with the
    nearest known), values that are not finite or of the wrong kind, strengths that
    become zero and sizes that do not fit.
    """
    spec = with_defaults(spec, dict(values or {}))
    spec = used(with_effects(spec, effects))
    for trouble in checks.model(spec, defaults(spec)):
        raise UsageError(f"{trouble.cause}: {trouble.hint}" if trouble.hint else trouble.cause)
    return spec


def with_effects(spec: Spec, names) -> Spec:
    if names is None:
        return spec
    known = spec.effect_names
    if not names:
        raise UsageError("no effect is selected; there are: " + ", ".join(known))
    for name in names:
        if name not in known:
            raise UsageError(f"there is no effect `{name}` in {spec.name}: "
                             + nearest(name, known))
    kept = replace(spec, effects=tuple(e for e in spec.effects if e.name in set(names)))
    if not any(e.moves for e in kept.effects):
        raise UsageError(f"damping alone moves nothing: add an energy, such as {next(e.name for e in spec.effects if e.moves)}")
    return kept


def with_defaults(spec: Spec, given: dict) -> Spec:
    known = {p.name: p for p in spec.parameters}
    for name in given:
        if name not in known:
            raise UsageError(f"there is no parameter `{name}` in {spec.name}: "
                             + nearest(name, known))
    given = {name: converted(known[name], value) for name, value in scaled(spec, given).items()}
    values = with_values(spec, defaults(spec), given)
    return replace(spec, parameters=tuple(
        replace(p, default=values[p.name], fill=len(given[p.name]) == 1 if p.kind == "array" and p.name in given else p.fill)
        for p in spec.parameters))


def converted(p: Parameter, value):
    """`value` as the kind of `p`; UsageError when it does not fit."""
    value = value.item() if isinstance(value, np.ndarray) and not value.ndim else value
    if p.kind == "array":
        entries = value if hasattr(value, "__len__") else (value,)
        if p.vector and len(entries) == 1 and not hasattr(entries[0], "__len__"):
            raise UsageError(p.too_few)
        return tuple(float(finite(p, v)) for entry in entries for v in (entry if hasattr(entry, "__len__") and not isinstance(entry, str) else (entry,)))
    if hasattr(value, "__len__"):
        raise UsageError(f"`{p.name}` is one number, not a list")
    value = finite(p, value)
    if p.kind == "int" and value != int(value):
        raise UsageError(f"`{p.name}` is an integer parameter, but {value} is not an integer")
    return int(value) if p.kind == "int" else float(value)


def finite(p: Parameter, value):
    if isinstance(value, (bool, str, complex, np.complexfloating)) or not hasattr(value, "__float__"):
        raise UsageError(f"`{p.name}` needs a number, not {value!r}")
    value = value if isinstance(value, int) else float(value)
    trouble = number_trouble(value)
    if trouble:
        raise UsageError(f"`{p.name}` = {value} {trouble}")
    return value


# What is still used

def used(spec: Spec) -> Spec:
    """Drop parameters and tables that no kept formula names."""
    names = {e.name for root in formulas(spec) for e in walk(root)
             if isinstance(e, (Par, Elem))}
    sizes = {e.name for p in spec.parameters if p.name in names and p.size is not None
             for e in walk(p.size) if isinstance(e, Par)}
    names |= sizes
    return replace(spec,
                   parameters=tuple(p for p in spec.parameters if p.name in names),
                   tables=tuple(t for t in spec.tables if t[0] in names))


def formulas(spec: Spec):
    """All expressions of the space, terms, starts and runs."""
    for f in spec.families:
        yield from (f.count, f.kappa)
        yield from () if f.radius is None else (f.radius,)
        yield from (e for row in f.casimir or () for e in row)
    for e in spec.effects + spec.observables:
        yield from e.formulas.values()
        yield from e.over.size if isinstance(e.over, Lattice) else ()
    for start in spec.starts:
        for part in start.families:
            yield from part.value if part.kind == "formula" else ()
    for r in spec.runs:
        yield from (e for e in (r.h, r.time, r.steps, r.period) if e is not None)
