"""Sums of the values of terms, by loops that compilers turn into lanes (runtime/core/smg_sum.h): each finds the values of many terms before they are added.

Along direction 0 of a lattice the neighbours of a cell follow each other as the cells do, but where a bond reaches over the end: so every bond has
loops of its own, over cells between which nothing changes.
"""
from __future__ import annotations

from ..lower.code import Assign, At, Call, For, If, Let, Name, Scope, Unary, tidy
from ..lower.integers import ZERO, Computed, Index, Int, times, total, whole
from ..lower.loops import Loops

FROM, HELD = Index("from"), Index("SMG_HELD")       # where a loop over held values begins; how many there may be


def value_sums(model) -> list:
    """[(kind, name of the term, statements that add up its values)] of the energies and observables."""
    terms = [("energy", *named) for named in model.sums.items()] + [("observe", t.derived.term.name, [t]) for t in model.observables]
    loops = (DividedLoops if "distributed" in model.features else ValueLoops)(model.low, model.loops.count)
    return [(kind, name, tidy(line for t in parts for line in value_lines(model, loops, t))) for kind, name, parts in terms]


def value_lines(model, loops, t) -> tuple:
    """The loops of one term; of a single value none."""
    value = t.call("value", [model.vector("w", s) for s in t.slots])
    found = loops.scatter(t.over, (Assign(Unary("*", Name("held")), value),))
    return held_loops(found) if any(isinstance(one, For) for one in found) else (held(whole(1)), *found)


def held(size: Int) -> Let:
    """The place of so many values."""
    return Let("held", Call("smg_sum_room", (Unary("&", Name("sum")), size)), "smg_real *")


def held_loops(lines) -> tuple:
    """Innermost loops in two: of each round of SMG_HELD values one finds them."""
    return tuple(held_loop(one) if isinstance(one, For) and is_innermost(one) else with_body(one, held_loops(one.body)) if isinstance(one, (For, If, Scope)) else one
                 for one in lines)


def is_innermost(loop: For) -> bool:
    return not any(isinstance(one, (For, If, Scope)) for one in loop.body)


def with_body(block, body):
    return type(block)(**{**vars(block), "body": body})


def held_loop(loop: For) -> For:
    end, place = Computed("smg_held_end", (FROM, loop.end)), At(Name("held"), Index(loop.index) - FROM, True)
    *before, last = loop.body
    inner = with_body(loop, (*before, Assign(Unary("*", place), last.value)))
    return For("from", loop.start, loop.end, (held(total(end) - FROM), For(loop.index, FROM, end, inner.body, over=loop.over)), step=HELD, over=loop.over)


class ValueLoops(Loops):
    """Every term once, bond after bond in each row of cells; turned: shift along direction 0 -> how often it comes around there, in the loop under way."""
    turned: dict = {}

    def of_bonds(self, over, some, body):
        cells = [Index(f"c{d}") for d in range(len(over.size))]
        lines = tuple(line for n in some for line in self.along(over, n, cells, body))
        for d, size in list(enumerate(over.size))[1:]:
            lines = (For(f"c{d}", ZERO, self.low.size(size), lines, over="cells"),)
        return lines

    def along(self, over, n: int, cells, body):
        """Loops over direction 0 of one bond; tests of the other directions stand around them."""
        for start, end, self.turned in self.stretches(over, n):
            found = self.bond(over, n, cells, body)
            loop = For("c0", start, end, found.body, over="cells")
            yield If(found.tests, (loop,)) if isinstance(found, If) else loop

    def stretches(self, over, n: int) -> list:
        """(first cell, end, turned) where its sites come around alike."""
        size, shifts = self.low.size(over.size[0]), sorted({offset[0] for _, offset in over.bonds[n]} - {0})
        if not over.periodic[0]:
            return [(whole(max(0, -min(shifts, default=0))), size - max(0, max(shifts, default=0)), dict.fromkeys(shifts, 0))]
        if not shifts or shifts[0] < 0 < shifts[-1]:       # some come around at either end: found cell by cell
            return [(ZERO, size, {})]
        ends = [ZERO, *(total(size) - s if s > 0 else whole(-s) for s in reversed(shifts)), total(size)]
        return [(first, end, turns(shifts, k)) for k, (first, end) in enumerate(zip(ends, ends[1:]))]

    def moved(self, over, d: int, cell, shift: int, tests):
        if d or not shift or shift not in self.turned:
            return super().moved(over, d, cell, shift, tests)
        return cell + shift - self.turned[shift] * self.low.size(over.size[0])


class DividedLoops(ValueLoops):
    """The same over the part of a rank (runtime/core/smg_own.h): its sites, or its layers of the slowest direction."""

    def scatter_sites(self, over, body):
        return tuple(divided(one, whole(1)) for one in super().scatter_sites(over, body))

    def of_bonds(self, over, some, body):
        found = super().of_bonds(over, some, body)
        layer = times(over.sites, *(self.low.size(size) for size in over.size[:-1]))
        return tuple(divided(one, layer) for one in found)


def divided(line, per: Int):
    """A loop over what a rank has of it, `per` sites each; within a test too."""
    if isinstance(line, If):
        return with_body(line, tuple(divided(one, per) for one in line.body))
    return with_ends(line, Computed("smg_part_begin", (line.start, per)), Computed("smg_part_end", (line.end, per)))


def with_ends(loop: For, start: Int, end: Int) -> For:
    return type(loop)(**{**vars(loop), "start": start, "end": end})


def turns(shifts, k: int) -> dict:
    """In the k-th stretch of a ring: of shifts forward the k longest come around, of those backward all but the k shortest."""
    longest = list(reversed(shifts))
    return {s: int(i < k) if s > 0 else -int(i >= k) for i, s in enumerate(longest)}
