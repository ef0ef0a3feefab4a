"""From tokens to the syntax tree: precedence climbing, depth bounded.

    or < and < not < comparison < + - < * / < unary - < ^ (right) < postfix . [ ] ( )
"""
from __future__ import annotations

import math

from ..language import limits
from ..language import codes
from ..language.units import unit
from .names import FUNCTIONS
from .problems import Problems
from .quantities import at_unit, quantity
from .source import Span, Text
from .syntax import Call, Component, Item, Name, Number, Operation, Syntax
from .tokens import Token, tokenize

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
LEFT = (("or",), ("and",), COMPARISONS, ("+", "-"), ("*", "/"))
NOT, COMPARE = 2, 2     # `not` binds more loosely than the level of the comparisons


def join(a: Span, b: Span) -> Span:
    return Span(a.start, max(a.end, b.end))


class Parser:
    """A cursor over the tokens of one formula; text: what messages call it."""
    text = "the formula"

    def __init__(self, text: Text, problems: Problems):
        self.problems = problems
        self.tokens = tokenize(text, problems)
        self.k = self.depth = 0

    # Tokens

    @property
    def now(self) -> Token:
        return self.tokens[self.k]

    def take(self) -> Token:
        token = self.now
        self.k += token.kind != "end"
        return token

    def at(self, *texts: str) -> bool:
        return self.now.text in texts and self.now.kind != "end"

    def expect(self, text: str, what: str) -> Token:
        if not self.at(text):
            self.fail(f"`{text}` is missing {what}", self.misplaced() or self.opened(text) or self.here())
        return self.take()

    def here(self) -> str:
        """What stands at the cursor."""
        return f"{self.text} ends here" if self.now.kind == "end" else f"`{self.now.text}` stands here"

    def fail(self, cause: str, hint: str):
        self.problems.fail(codes.SYNTAX, self.now.span, cause, hint)

    def name(self, what: str) -> Token:
        if self.now.kind != "name":
            self.fail(f"{what} is missing", self.here())
        return self.take()

    def end(self) -> None:
        """Refuse whatever follows a complete formula."""
        if self.now.kind == "end":
            return
        hint = self.product() or "an operator such as `*` is missing"
        if self.at(")", "]"):
            hint = "there is an extra bracket"
        self.fail(f"`{self.now.text}` is not expected here", self.misplaced() or hint)

    def product(self) -> str:
        """`2 t` as the product that was meant."""
        before = self.tokens[max(self.k - 1, 0)]
        inside = self.k > 1 and self.tokens[self.k - 2].text == "."         # a component: what is multiplied begins before it
        plain = not inside and before.kind in ("number", "name") and self.now.kind in ("number", "name")
        known = plain and before.kind == "number" and unit(self.now.text) and not self.problems.measured
        also = "; units require a section [units]" if known else ""
        return f"a product is written with `*`: `{before.text}*{self.now.text}`{also}" if plain else ""

    def opened(self, closing: str) -> str:
        """Which bracket waits for `closing`, where the formula ends without it."""
        opening, open_ones = {")": "(", "]": "["}.get(closing), []
        for token in self.tokens[:self.k] if opening and self.now.kind == "end" else ():
            if token.text in ("(", "["):
                open_ones.append(token)
            elif token.text in (")", "]") and open_ones:
                open_ones.pop()
        if not open_ones:
            return ""
        rest = "".join({"(": ")", "[": "]"}[t.text] for t in reversed(open_ones))
        many = f"; {len(open_ones)} brackets are not closed" if len(open_ones) > 1 else ""
        place = open_ones[-1].span.start - self.tokens[0].span.start + 1
        return f"the `{open_ones[-1].text}` at character {place} of the formula is not closed{many}: write `{rest}` where it ends"

    def misplaced(self) -> str:
        """What to write in place of a comma or an index that stands wrongly here."""
        before, after = self.tokens[max(self.k - 1, 0)], self.tokens[min(self.k + 1, len(self.tokens) - 1)]
        if self.at(",") and before.kind == after.kind == "number":
            return f"decimals are written with a point: `{before.text}.{after.text}`"
        if self.at(","):
            return "commas separate the arguments of a function"
        if self.at("[") and before.text in ("x", "y", "z", "]"):
            return "the index comes first, then the component: `w[i].z`"
        return ""

    # Expressions

    def expression(self, level: int = 0) -> Syntax:
        if level == NOT and self.at("not"):
            return self.prefix("not", NOT)
        if level == len(LEFT):
            return self.unary()
        left = self.expression(level + 1)
        while self.at(*LEFT[level]):
            sign = self.take()
            right = self.expression(level + 1)
            left = Operation(sign.text, (left, right), sign.span, join(left.span, right.span))
            if level == COMPARE and self.at(*COMPARISONS):
                self.fail("comparisons cannot be chained", "write `a < b and b < c`")
        return left

    def prefix(self, op: str, level: int) -> Syntax:
        sign = self.take()
        with self.deeper(sign.span):
            arg = self.expression(level) if op == "not" else self.unary()
        return Operation(op, (arg,), sign.span, join(sign.span, arg.span))

    def unary(self) -> Syntax:
        if self.at("-"):
            return self.prefix("neg", len(LEFT))
        if self.at("+"):
            self.take()
            return self.unary_plus()
        return self.power()

    def unary_plus(self) -> Syntax:
        with self.deeper(self.now.span):
            return self.unary()

    def power(self) -> Syntax:
        base = self.postfix()
        if not self.at("^", "**"):
            return base
        sign = self.take()
        with self.deeper(sign.span):
            exponent = self.unary()
        return Operation("^", (base, exponent), sign.span, join(base.span, exponent.span))

    def postfix(self) -> Syntax:
        node = self.atom()
        while self.at("."):
            self.take()
            axis = self.name("`x`, `y` or `z` after the dot")
            if axis.text not in ("x", "y", "z"):
                self.problems.fail(codes.SYNTAX, axis.span, f"a vector has no `.{axis.text}`",
                                   "its components are `.x`, `.y` and `.z`")
            node = Component(node, axis.text, join(node.span, axis.span))
        return node

    def atom(self) -> Syntax:
        if self.now.kind == "number":
            return self.number()
        if self.at("("):
            return self.parenthesis()
        if self.now.kind != "name" or self.at("and", "or", "not", "of", "on"):
            self.fail("a number, name or `(` is missing", "vectors are written `vec(x, y, z)`"
                      if self.at("[") else self.here())
        name = self.take()
        if self.at("("):
            return self.call(name)
        if self.at("["):
            return self.item(name)
        if name.text in FUNCTIONS and self.now.kind in ("name", "number"):
            self.fail(f"`{name.text}` needs parentheses around its argument", f"write `{name.text}(..)`, with all of its argument in the parentheses")
        return Name(name.text, name.span)

    def parenthesis(self) -> Syntax:
        with self.deeper(self.take().span):
            node = self.expression()
        self.expect(")", "after this expression")
        return node

    def call(self, name: Token) -> Syntax:
        args = []
        with self.deeper(self.take().span):
            while not args or self.at(","):
                if args:
                    self.take()
                args.append(self.expression())
        last = self.expect(")", f"at the end of the arguments of `{name.text}`")
        return Call(name.text, tuple(args), name.span, join(name.span, last.span))

    def item(self, name: Token) -> Syntax:
        with self.deeper(self.take().span):
            index = self.expression()
        last = self.expect("]", "after this index")
        return Item(name.text, index, name.span, join(name.span, last.span))

    def number(self) -> Syntax:
        token = self.take()
        if self.now.kind in ("name", "number") and self.now.span.start == token.span.end:
            between = " " if self.problems.measured and unit(self.now.text) else "*"
            self.fail(f"`{token.text}{self.now.text}` is neither a number nor a name",
                      f"write `{token.text}{between}{self.now.text}`")
        if self.problems.measured and at_unit(self):
            return quantity(self, self.number_value(token), token.span)
        return Number(self.number_value(token), token.span)

    def number_value(self, token: Token):
        """An int if written as one, else a float; never beyond the limits."""
        whole = token.text.isdigit()
        if whole and (len(token.text) > 17 or int(token.text) > limits.INTEGER):
            self.problems.fail(codes.NUMBER, token.span, "this integer is beyond 2^53",
                               f"write it as a real number, such as `{token.text[:1]}.0e9`")
        value = int(token.text) if whole else float(token.text)
        size = abs(value)
        if not math.isfinite(value) or size > limits.LARGEST or 0 < size < limits.SMALLEST:
            self.problems.fail(codes.NUMBER, token.span, "this number is not between "
                               f"{limits.SMALLEST:g} and {limits.LARGEST:g} in absolute value",
                               "choose other units")
        return value

    def deeper(self, span: Span) -> "Deeper":
        return Deeper(self, span)


class Deeper:
    """Counts nesting while a bracket, sign or power is open."""

    def __init__(self, parser: Parser, span: Span):
        self.parser, self.span = parser, span

    def __enter__(self):
        self.parser.depth += 1
        if self.parser.depth > limits.DEPTH:
            self.parser.problems.fail(
                codes.LIMIT, self.span, f"the formula has more than {limits.DEPTH} nested brackets, signs or powers", "split it into named [formulas]")

    def __exit__(self, *_):
        self.parser.depth -= 1


def parse(text: Text, problems: Problems) -> Syntax:
    """The syntax tree of a whole formula."""
    parser = Parser(text, problems)
    if parser.now.kind == "end":
        problems.fail(codes.SYNTAX, text.whole, "the formula is empty", "write an expression")
    tree = parser.expression()
    parser.end()
    return tree
