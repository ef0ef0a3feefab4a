"""Functions of a model take the arguments that they use: the others go from the definition and from every call, and with them the
constants that were declared for them alone. What the runtime calls (`wanted`) keeps the arguments of its contract. Of functions that
then say the same, one stays: blocks d2e/dw_i dw_j and d2e/dw_j dw_i are often alike.
"""
from __future__ import annotations

from dataclasses import fields, replace

import sympy as sp

from .code import Call, Function, Let, Name, Real, Table, Value, Zeros, mentions, walk
from .integers import Computed, Node


def trim(definitions, bodies) -> tuple[list, list]:
    """(definitions, bodies) without unused arguments; bodies: statements printed elsewhere that call the same functions."""
    kept = unused = None
    while kept is None or unused:
        unused = unused_arguments(definitions, bodies)
        kept = definitions = [without(one, unused) for one in definitions]
        bodies = [tuple(without(one, unused) for one in body) for body in bodies]
    same = alike(definitions, handed_on(definitions, bodies))
    return ([renamed(one, same) for one in definitions if one.name not in same],
            [used_constants(tuple(renamed(one, same) for one in body)) for body in bodies])


def alike(definitions, apart) -> dict:
    """Name of a function -> an earlier one with the same text; of those that are called by name alone."""
    first, same = {}, {}
    for f in definitions:
        if isinstance(f, Function) and not f.wanted and f.name not in apart:
            earlier = first.setdefault((repr(replace(f, name="")), digits(f)), f.name)
            if earlier != f.name:
                same[f.name] = earlier
    return same


def digits(f: Function) -> tuple:
    """All digits of the numbers in its formulas, of which a text has fifteen."""
    return tuple(tuple(sorted(map(float, one.expr.atoms(sp.Float)))) for one in walk(f) if isinstance(one, Real))


def renamed(node, same: dict):
    """The tree with these functions called by their other name."""
    if isinstance(node, Table):
        return node
    found = rebuilt(node, lambda part: renamed(part, same))
    return replace(found, function=same[found.function]) if isinstance(found, (Call, Computed)) and found.function in same else found


def unused_arguments(definitions, bodies) -> dict:
    """Name of a function -> the positions of arguments that its body does not mention; of those that are called by name alone."""
    apart = handed_on(definitions, bodies)
    return {f.name: places for f in definitions if isinstance(f, Function) and not f.wanted and f.name not in apart
            if (places := unmentioned(f))}


def handed_on(definitions, bodies) -> set:
    """Names that are values somewhere: among them functions that are handed to others."""
    statements = [*definitions, *(one for body in bodies for one in body)]
    return {one.text for top in statements if not isinstance(top, Table) for one in walk(top) if isinstance(one, Name)}


def unmentioned(f: Function) -> frozenset:
    known = mentions(*f.body)
    return frozenset(k for k, a in enumerate(f.arguments) if a.name not in known)


def without(node, unused: dict):
    """The tree without these arguments, in definitions and in calls."""
    if isinstance(node, Table):
        return node
    found = rebuilt(node, lambda part: without(part, unused))
    if isinstance(found, Function):
        return replace(found, arguments=others(found.arguments, unused.get(found.name)), body=used_constants(found.body))
    if isinstance(found, (Call, Computed)) and found.function in unused:
        return replace(found, args=others(found.args, unused[found.function]))
    return found


def others(items: tuple, places) -> tuple:
    """The items but those at these places."""
    return tuple(one for k, one in enumerate(items) if k not in places) if places else items


def used_constants(body) -> tuple:
    """The body without the values, and the arrays of zeros, that no later statement of it mentions."""
    kept: list = []
    for one in reversed(body):
        if isinstance(getattr(one, "body", None), tuple):
            one = replace(one, body=used_constants(one.body))
        if not isinstance(one, (Let, Value, Zeros)) or one.name.partition("[")[0] in mentions(*kept):
            kept.append(one)
    return tuple(reversed(kept))


def rebuilt(node: Node, change) -> Node:
    """The node with `change` applied to the nodes directly inside; itself where nothing changed."""
    new = {}
    for f in fields(node):
        value = getattr(node, f.name)
        if isinstance(value, Node):
            made = change(value)
        elif isinstance(value, tuple) and any(isinstance(part, Node) for part in value):
            made = tuple(change(part) if isinstance(part, Node) else part for part in value)
        else:
            continue
        if made != value:
            new[f.name] = made
    return replace(node, **new) if new else node
