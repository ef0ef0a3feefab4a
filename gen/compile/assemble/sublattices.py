"""Sublattices: the sites of one colour, and the field in which each of them turns."""
from __future__ import annotations

from dataclasses import replace

from ..lower.code import Argument, Braces, Call, For, Function, If, Let, Name, Return, Zeros, mentions
from ..lower.integers import ONE, ZERO, Field, Index, compare, modulo, remainder, times, total
from ..lower.kernels import COEFFICIENTS
from ..lower.loops import SITE
from ..plan.splitting import sublattices
from .families import by_family
from .part import Part
from .sums import COORDINATES, G, gathered, own

VISIT = (COEFFICIENTS, Argument("int64_t", "colour"), Argument("void *", "context"), Argument("void", "visit", "void *context, smg_lattice_site at"))
PULL = (COEFFICIENTS, Argument("smg_lattice_site", "at"), Argument("const smg_real *", "all"), G)


def pull(model) -> Function:
    """g += dH/dw of a site, which does not depend on its own w."""
    placed = sublattices(model.spec) is not None

    def calls(model, t, k):
        outputs = [own("g") if q == k else Name(f"o{q}") for q in range(len(t.slots))]
        return (*(Zeros(f"o{q}", 3) for q in range(len(t.slots)) if q != k), t.call("gradient", [model.vector("all", s) for s in t.slots], *outputs))

    def body(f):
        found = gathered(model, f.name, calls, placed)
        read = mentions(*found) if placed else ()
        return (*(Let(x, Field("at", x)) for x in COORDINATES if x in read), *found)
    return by_family("void", "smg_pull", PULL, body, model.families, number=Field("at", "k"), index="site", wanted=True)


def colour_functions(model) -> list:
    """smg_colours, how many there are, and smg_each_of_colour, a visit of all sites of one. On a lattice whose ring is no multiple of its
    colours, and where there is no lattice, every site is a colour of its own."""
    found = sublattices(model.spec)
    if found is None and all(len(t.slots) < 2 for t in model.energies):
        return [colours(Return(ONE)), each_of_colour(For("site", ZERO, model.total, called(SITE, ZERO, ())))]
    alone = called(Index("colour"), ZERO, ())
    if found is None:
        return [colours(Return(model.total)), each_of_colour(*alone)]
    number, lines, alone = Return(total(found.colours.colours)), coloured(model, found), placed_alone(found, model)
    fits = fitting(model, found)
    if not fits:
        return [colours(number), each_of_colour(*lines)]
    return [colours(If(fits, (number,)), Return(model.total)), each_of_colour(If(fits, (*lines, Return())), *alone)]


def colours(*body) -> Function:
    return Function("int64_t", "smg_colours", (COEFFICIENTS,), body, wanted=True)


def each_of_colour(*body) -> Function:
    """Inlined, so that the call of `visit` is, too."""
    return Function("void", "smg_each_of_colour", VISIT, body, wanted=True, inlined="always")


def called(site, sub, cells) -> tuple:
    """The visit of a site."""
    at = Braces((site, sub, *cells, *[ZERO] * (4 - len(cells))))
    return Let("at", at, "const smg_lattice_site"), Call("visit", (Name("context"), Name("at")))


def fitting(model, found) -> tuple:
    """Does every ring keep the colours apart?"""
    weights, number = found.colours.weights, found.colours.colours
    return tuple(compare(modulo(times(w, model.low.size(size)), number), "==", ZERO)
                 for w, size, closed in zip(weights, found.over.size, found.closed) if closed and w % number)


def coloured(model, found) -> tuple:
    """All sites of one colour."""
    cells = [Index(f"s{d}") for d in range(len(found.over.size))]
    return tuple(line for sub in range(found.over.sites) for line in model.loops.cells_of_colour(found.over, found.colours, sub, visit_of(model, found, sub, cells)))


def visit_of(model, found, sub: int, cells) -> tuple:
    """Of the site at a place of a cell; families stand one after the other, each with as many places."""
    own = of_one_family(model, found.over)
    family, place = model.families[sub // own.sites], sub % own.sites
    return called(family.first + model.loops.site(own, "site", place, (0,) * len(cells), cells, []).value, total(place), cells)


def of_one_family(model, over):
    """The lattice with the places of one family alone."""
    return replace(over, sites=over.sites // len(model.families))


def placed_alone(found, model) -> tuple:
    """The site of the number `colour`, and where it stands."""
    cells, own, number = [Index(f"s{d}") for d in range(len(found.over.size))], of_one_family(model, found.over), Index("colour")
    within = number if len(model.families) == 1 else remainder(number, model.families[0].count)
    return (Let("site", within), *model.loops.cell_of_site(own), *called(SITE if within is number else number, Index("sub") if own.sites > 1 else ZERO, cells))


class Sublattices(Part):
    """The sites of each colour, for sublattice rotations."""
    name = "sublattices"

    def made(self, model, low):
        return True if model.method.splitting == "sublattices" else None

    def functions(self, model):
        """What runtime/method/explicit/smg_sublattice_rotations.h asks of a model."""
        return [pull(model), *colour_functions(model)]
