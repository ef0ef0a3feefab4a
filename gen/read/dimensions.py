"""The dimension of an operation from those of its arguments, or the error that says which argument does not fit."""
from __future__ import annotations

from fractions import Fraction

from ..language import codes
from ..language.units import ANY, NONE, power, product, quotient, said
from .scope import Typed
from .source import Span

ALIKE = ("+", "-", "min", "max", "mod", "vec", "<", "<=", ">", ">=", "==", "!=", "atan2")      # all arguments have one dimension
KEPT = ("neg", "abs", "norm", "x", "y", "z", "kept")                    # the dimension of the argument
PRODUCTS = ("*", "dot", "cross", "triple")
PURE = ("<", "<=", ">", ">=", "==", "!=", "atan2", "and", "or", "not")  # their value has no dimension
LARGEST = 100       # denominator of an exponent that is a constant, such as 1/2


class Dimensions:
    """fail(code, span, cause, hint) reports an error and leaves the formula."""

    def __init__(self, fail):
        self.fail = fail

    def of(self, op: str, args: list[Typed], spans: list[Span]):
        """Of the value of an operation; spans: where its arguments stand."""
        found = [a.dimension for a in args]
        if op in ALIKE:
            return self.alike(op, found, spans)
        if op in PRODUCTS:
            return self.times(found)
        if op in KEPT:
            return found[0]
        if op == "if":
            return self.alike("the branches of `if`", found[1:], spans[1:])
        return {"/": self.over, "^": self.power, "sqrt": self.root}.get(op, self.pure)(op, args, spans)

    def alike(self, op: str, found, spans):
        known = next((d for d in found if d is not ANY), ANY)
        for d, span in zip(found, spans):
            if d not in (ANY, known):
                first = op if " " in op else f"`{op}`"
                self.fail(codes.DIMENSION, span, f"{first} combines {said(known)} and {said(d)}", self.advice(known, d))
        return NONE if op in PURE else known

    @staticmethod
    def advice(wanted, given) -> str:
        """What would make one of the other."""
        if given == NONE:
            return f"write a unit after the number, or multiply it by {said(wanted)}"
        if wanted == NONE:
            return f"divide it by {said(given)}"
        return f"multiply it by {said(quotient(wanted, given)) if quotient(wanted, given) != NONE else 'a number'}, or correct a unit"

    @staticmethod
    def times(found):
        whole = NONE
        for d in found:
            whole = product(whole, d)
        return whole

    @staticmethod
    def over(op, args, spans):
        return quotient(args[0].dimension, args[1].dimension)

    @staticmethod
    def root(op, args, spans):
        return power(args[0].dimension, Fraction(1, 2))

    def power(self, op, args, spans):
        base, exponent = args
        self.number(exponent, spans[1], "an exponent")
        if base.dimension in (ANY, NONE):
            return base.dimension
        share = exponent.value is not None and Fraction(exponent.value).limit_denominator(LARGEST)
        if exponent.value is None or float(share) != exponent.value:
            self.fail(codes.DIMENSION, spans[1], f"{said(base.dimension)} has an exponent that is not constant",
                      "write the exponent as a number, or make the base dimensionless")
        return power(base.dimension, share)

    def pure(self, op, args, spans):
        """Functions of numbers without a unit: sin, exp, log, floor, .."""
        for a, span in zip(args, spans):
            self.number(a, span, f"the argument of `{op}`")
        return NONE

    def number(self, a: Typed, span: Span, what: str) -> None:
        if a.kind == "s" and a.dimension not in (ANY, NONE):
            self.fail(codes.DIMENSION, span, f"{what} is {said(a.dimension)}, but must be a number without a unit",
                      f"divide it by {said(a.dimension)}")
