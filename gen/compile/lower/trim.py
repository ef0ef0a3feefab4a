"""Functions of a model take the arguments that they use: the others go from the definition and from every call, and with them the
constants that were declared for them alone. What the runtime calls (`wanted`) keeps the arguments of its contract.
"""
from __future__ import annotations

from dataclasses import fields, replace

from .code import Call, Function, Let, Name, Table, mentions, walk
from .integers import Node


def trim(definitions, bodies) -> tuple[list, list]:
    """(definitions, bodies) without unused arguments; bodies: statements printed elsewhere that call the same functions."""
    kept = unused = None
    while kept is None or unused:
        unused = unused_arguments(definitions, bodies)
        kept = definitions = [without(one, unused) for one in definitions]
        bodies = [tuple(without(one, unused) for one in body) for body in bodies]
    return definitions, [used_constants(body) for body in bodies]


def unused_arguments(definitions, bodies) -> dict:
    """Name of a function -> the positions of arguments that its body does not mention; of those that are called by name alone."""
    statements = [*definitions, *(one for body in bodies for one in body)]
    handed_on = {one.text for top in statements if not isinstance(top, Table) for one in walk(top) if isinstance(one, Name)}
    return {f.name: places for f in definitions if isinstance(f, Function) and not f.wanted and f.name not in handed_on
            if (places := unmentioned(f))}


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
    if isinstance(found, Call) and found.function in unused:
        return replace(found, args=others(found.args, unused[found.function]))
    return found


def others(items: tuple, places) -> tuple:
    """The items but those at these places."""
    return tuple(one for k, one in enumerate(items) if k not in places) if places else items


def used_constants(body) -> tuple:
    """The body without the constants that no later statement of it mentions."""
    kept: list = []
    for one in reversed(body):
        if isinstance(getattr(one, "body", None), tuple):
            one = replace(one, body=used_constants(one.body))
        if not isinstance(one, Let) or one.name.partition("[")[0] in mentions(*kept):
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
