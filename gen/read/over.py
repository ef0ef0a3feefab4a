"""The index families, such as `site(i) of w` and `bond(i, j) of chain(n, periodic)`.

    over   = head ["of" target] ["on" family]
    head   = name "(" item {"," item} ")"      item = index ["of" family]
    target = name ["(" argument {"," argument} ")"] ["." name]
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from ..language import limits
from ..language.spec import Each, Once, Over, Pairs, Sites
from ..language import codes
from .names import identifier
from .parse import Parser
from .problems import Bad, Problems, nearest
from .scope import Declared
from .source import Span, Text
from .tokens import Token

HEADS = ("site", "pair", "each", "bond", "edge")


@dataclass
class Written:
    """An `over` as written, before its names are looked up."""
    head: Token
    items: list[tuple[Token, Optional[Token]]]
    target: Optional[Token]
    member: Optional[Token]
    args: Optional[list]
    family: Optional[Token]
    span: Span


class OverParser(Parser):
    """Reads the grammar above."""
    text = "`over`"

    def over(self) -> Written:
        head = self.name("one of " + ", ".join(HEADS))
        items = self.listed("(", self.indexed, f"after `{head.text}`")
        target = member = args = family = None
        if self.at("of"):
            self.take()
            target = self.name("a family, lattice or graph after `of`")
            if self.at("("):
                args = self.listed("(", self.expression, "")
            if self.at("."):
                self.take()
                member = self.name("the name of a bond list or shell")
        if self.at("on"):
            self.take()
            family = self.name("a family after `on`")
        self.end()
        return Written(head, items, target, member, args, family, head.span)

    def end(self) -> None:
        if self.now.kind != "end":
            self.fail(f"`{self.now.text}` is not expected in an index family",
                      "such as `site(i) of w` or `bond(i, j) of chain(n, periodic)`")

    def listed(self, opening: str, item, where: str) -> list:
        self.expect(opening, where)
        found = [item()]
        while self.at(","):
            self.take()
            found.append(item())
        if not self.at(")"):
            self.fail("`,` or `)` is missing in this list", self.here())
        self.take()
        return found

    def indexed(self) -> tuple[Token, Optional[Token]]:
        index = self.name("an index name")
        if not self.at("of"):
            return index, None
        self.take()
        return index, self.name("a family after `of`")


class OverReader:
    """Turns the text of an `over` into a value of `spec.Over`.

    lattices and graphs are the declared ones, by name (see lattices.py and graphs.py).
    """

    def __init__(self, declared: Declared, lattices, graphs, problems: Problems):
        self.declared, self.lattices, self.graphs = declared, lattices, graphs
        self.problems = problems

    def read(self, text: Optional[Text]) -> Over:
        if text is None:
            return Once()
        w = OverParser(text, self.problems).over()
        if w.head.text not in HEADS:
            self.problems.fail(codes.OVER, w.head.span, f"there is no index family "
                               f"`{w.head.text}`", nearest(w.head.text, HEADS))
        self.indices(w)
        return getattr(self, w.head.text)(w)

    def indices(self, w: Written) -> None:
        """Index names: new, different, and not too many."""
        seen: set[str] = set()
        for index, family in w.items:
            name = identifier(self.problems, index.span, index.text, "index")
            if name in seen or name in self.declared.names():
                self.problems.fail(codes.CLASH, index.span, f"`{name}` already has a meaning",
                                   "choose another index name")
            if family is not None and w.head.text not in ("each", "bond"):
                self.problems.fail(codes.OVER, family.span, "only `each` and `bond` take a family for "
                                   "every index", f"write `{w.head.text}(...) of {family.text}`")
            seen.add(name)
        most = 2 + limits.COLUMNS if w.head.text == "edge" else limits.BOUND + (w.head.text == "bond")
        if len(w.items) > most:
            self.problems.fail(codes.LIMIT, w.items[most][0].span,
                               f"at most {most} indices may be bound here",
                               "split the term into several effects")

    def expect(self, w: Written, count: int, form: str) -> list[str]:
        if len(w.items) != count:
            self.problems.fail(codes.OVER, w.head.span, f"`{w.head.text}` binds {count} "
                               f"ind{'ex' if count == 1 else 'ices'}, not {len(w.items)}",
                               f"write `{form}`")
        return [index.text for index, _ in w.items]

    def only_family(self, w: Written) -> str:
        """The one family of the space; needed when an `over` does not name it."""
        if not self.declared.families or self.declared.nameless:
            raise Bad                   # what is wrong with the space is noted
        if len(self.declared.families) != 1:
            families = ", ".join(self.declared.families)
            self.problems.fail(codes.OVER, w.head.span, "the space has several families: "
                               f"{families}", "name one: `... on "
                               f"{next(iter(self.declared.families), 'w')}`")
        return next(iter(self.declared.families))

    def family(self, token: Token) -> str:
        known = token.text in self.declared.families
        if token.text in self.declared.broken or self.declared.nameless and not known:
            raise Bad
        if not known:
            self.problems.fail(codes.UNKNOWN_NAME, token.span, f"there is no family "
                               f"`{token.text}`", nearest(token.text, self.declared.families))
        return token.text

    def target_family(self, w: Written) -> str:
        """The family of `site(i) of w` and `pair(i, j) of w`."""
        if w.member or w.args is not None or w.family:
            self.problems.fail(codes.OVER, w.head.span, f"`{w.head.text}` runs over a family",
                               f"write `{w.head.text}(...) of w`")
        return self.family(w.target) if w.target else self.only_family(w)

    def home(self, w: Written) -> str:
        """The family whose sites a lattice or graph connects."""
        return self.family(w.family) if w.family else self.only_family(w)

    def site(self, w: Written) -> Over:
        (i,) = self.expect(w, 1, "site(i) of w")
        if w.target and w.member and w.target.text in self.lattices.known.keys() | self.lattices.broken:
            return self.lattices.sublattice(w, i, self.home(w))
        return Sites(i, self.target_family(w))

    def pair(self, w: Written) -> Over:
        i, j = self.expect(w, 2, "pair(i, j) of w")
        return Pairs(i, j, self.target_family(w))

    def each(self, w: Written) -> Over:
        if w.target or any(family is None for _, family in w.items) or len(w.items) < 2:
            self.problems.fail(codes.OVER, w.head.span, "`each` must bind two or more indices, each with its own family", "write `each(i of p, j of w)`")
        families = tuple(self.family(f) for _, f in w.items)
        if len(set(families)) != len(families):
            self.problems.fail(codes.OVER, w.head.span, "`each` requires different families",
                               "for pairs of one family write `pair(i, j) of w`")
        return Each(tuple(i.text for i, _ in w.items), families)

    def bond(self, w: Written) -> Over:
        if w.target is None:
            self.problems.fail(codes.OVER, w.head.span, "`bond` needs a lattice",
                               "write `bond(i, j) of chain(n, periodic)`")
        if w.target.text in self.graphs.known.keys() | self.graphs.broken:
            self.problems.fail(codes.OVER, w.head.span, f"`{w.target.text}` is a graph, with edges",
                               f"write `edge(...) of {w.target.text}`")
        return self.lattices.over(w, self)

    def edge(self, w: Written) -> Over:
        if w.target is None or w.args is not None or w.member:
            self.problems.fail(codes.OVER, w.head.span, "`edge` needs a graph",
                               "write `edge(i, j) of g` with a table [graphs.g]")
        if w.target.text in self.lattices.known.keys() | self.lattices.broken:
            self.problems.fail(codes.OVER, w.head.span, f"`{w.target.text}` is a lattice, with bonds",
                               f"write `bond(...) of {w.target.text}`")
        return self.graphs.over(w, self)
