"""The syntax tree of a formula, with the place of every node."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from ..language.units import Unit
from .source import Span


@dataclass(frozen=True)
class Number:
    value: Union[int, float]
    span: Span


@dataclass(frozen=True)
class Quantity:
    """A number with the units that follow it."""
    value: Union[int, float]
    unit: Unit
    span: Span


@dataclass(frozen=True)
class Name:
    name: str
    span: Span


@dataclass(frozen=True)
class Call:
    """`name(args)`; `head` is the place of the name alone."""
    name: str
    args: tuple["Syntax", ...]
    head: Span
    span: Span


@dataclass(frozen=True)
class Item:
    """`name[index]`."""
    name: str
    index: "Syntax"
    head: Span
    span: Span


@dataclass(frozen=True)
class Component:
    """`base.x`, `base.y` or `base.z`."""
    base: "Syntax"
    axis: str
    span: Span


@dataclass(frozen=True)
class Operation:
    """A unary or binary operator; op is a name of `expr.SIGNATURES`."""
    op: str
    args: tuple["Syntax", ...]
    sign: Span
    span: Span


Syntax = Union[Number, Quantity, Name, Call, Item, Component, Operation]
