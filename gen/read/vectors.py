"""`r(i)`, where a site stands, and `r(i, j)`, the vector of a bond: formulas of the numbers of sites, and numbers of each bond."""
from __future__ import annotations

from dataclasses import replace

from ..language import codes
from ..language.expr import Expr, Idx, Num, Op, Weight, walk
from ..language.places import best, bond_vector, is_on, within_cell
from ..language.spec import Graph, Lattice, Over
from ..language.units import LENGTH, NONE
from .problems import Bad, Problems
from .scope import Typed

AXES = "xyz"
HINT = "give the lattice `vectors`, or use one that has a name, such as `square(nx, ny, periodic)`"


class Places:
    """The lattice or graph on which the sites of each family stand, by what [space] says, else by all index families of the spec.

    They are read when they are first asked for; errors in them are told where they stand.
    """

    def __init__(self, read, texts, problems: Problems):
        """read: of the text of an `over`; texts: of all effects and observables."""
        self.read, self.texts, self.problems, self.overs, self.unread = read, texts, problems, None, False

    def of(self, family) -> Lattice | Graph | None:
        """None where there are none; ValueError where two are as good."""
        if family.lattice is not None:
            return family.lattice
        if self.overs is None:
            found = self.problems.tried(*(lambda t=t: self.read(t) for t in self.texts))
            self.overs, self.unread = [over for over in found if over is not Bad], Bad in found
        return best([over for over in self.overs if isinstance(over, (Lattice, Graph)) and is_on(over, family.name)])


def vector(resolver, node, args: list[Typed]) -> Typed:
    """`r(i)` or `r(i, j)` where a formula stands."""
    for a, written in zip(args, node.args):
        if not isinstance(a.expr, Idx) and not (len(args) == 1 and isinstance(a.expr, Num) and isinstance(a.expr.value, int)):
            resolver.fail(codes.INDEX, written.span, "the arguments of `r` must be bound indices", "such as `r(i)` of a site, or `r(i, j)` of a bond")
    if len(args) == 1:
        return typed(*site(resolver, node, args[0].expr))
    if len(args) == 2:
        return typed(*bond(resolver, node, *(a.expr.name for a in args)))
    resolver.fail(codes.ARITY, node.head, f"`r` takes 1 or 2 arguments, not {len(args)}", "give a site, or the two sites of a bond")


def typed(parts, over) -> Typed:
    """With its size, which counts; a length where the lattice constant is one, else in units of that."""
    nodes = sum(1 for part in parts for _ in walk(part))
    length = isinstance(over, Lattice) and over.places.measured
    return Typed(Op("vec", tuple(parts)), "v", 1 + nodes, 1 + max(map(deep, parts)), dimension=LENGTH if length else NONE)


def deep(e: Expr) -> int:
    return 1 + max((deep(a) for a in getattr(e, "args", ())), default=0)


# Of a site

def site(resolver, node, number: Expr) -> tuple:
    """(the three components of its place, the lattice or graph that says it)."""
    scope = resolver.scope
    name = (resolver.indices().get(number.name) or scope.site) if isinstance(number, Idx) else scope.site or only(resolver)
    places = scope.declared.places
    if name not in scope.declared.families or places is None:
        resolver.fail(codes.NOT_HERE, node.head, f"`r` is not allowed in {scope.place}", "it is allowed in effects, observables, conditions and starts")
    try:
        over = places.of(scope.declared.families[name])
    except ValueError:
        resolver.fail(codes.OVER, node.head, f"`{name}` is on several lattices, any of which could give the positions of its sites",
                      f"choose one in [space]: `{name} = {{ sphere = \"LATTICE\" }}`, where LATTICE is declared in [lattices]")
    if over is None and (places.unread or name in scope.declared.unread):
        raise Bad       # the error is in the lattice or in the index family
    if over is None or over.places is None:
        resolver.fail(codes.OVER, node.head, f"the sites of `{name}` have no positions", HINT)
    return by_number(over, number), over


def only(resolver) -> str:
    """The only family, where its vectors may stand."""
    families = resolver.scope.declared.families
    return next(iter(families)) if len(families) == 1 and resolver.scope.families else ""


def by_number(over, number: Expr) -> tuple:
    """The place of a site as a formula of its number."""
    if isinstance(over, Graph):
        return tuple(chosen(number, [row[k] for row in over.places]) for k in range(3))
    cell, sub = number, Num(0)
    if over.sites > 1:
        cell, sub = Op("floor", (Op("/", (number, Num(over.sites))),)), Op("mod", (number, Num(over.sites)))
    counts = []
    for size in over.size[:-1]:
        counts.append(Op("mod", (cell, size)))
        cell = Op("floor", (Op("/", (cell, size)),))
    counts.append(cell)
    return tuple(total([(count, v[k]) for count, v in zip(counts, over.places.vectors)], chosen(sub, within_cell(over)[:, k].tolist())) for k in range(3))


def total(products, rest: Expr) -> Expr:
    """The sum of products, without those that are 0, and what is left."""
    parts = [count if factor == 1 else Op("*", (Num(factor), count)) for count, factor in products if factor]
    parts += [] if isinstance(rest, Num) and rest.value == 0 and parts else [rest]
    found = parts[0]
    for part in parts[1:]:
        found = Op("+", (found, part))
    return found


def chosen(number: Expr, values: list) -> Expr:
    """The value of a number from 0 on."""
    if isinstance(number, Num) or len(set(values)) == 1:
        return Num(float(values[number.value if isinstance(number, Num) else 0]))
    half = len(values) // 2
    return Op("if", (Op("<", (number, Num(half))), chosen_of(number, values, 0, half), chosen_of(number, values, half, len(values))))


def chosen_of(number: Expr, values: list, first: int, last: int) -> Expr:
    """Of those from the first to before the last, by halves."""
    if len(set(values[first:last])) == 1:
        return Num(float(values[first]))
    half = (first + last) // 2
    return Op("if", (Op("<", (number, Num(half))), chosen_of(number, values, first, half), chosen_of(number, values, half, last)))


# Of a bond

def bond(resolver, node, i: str, j: str) -> tuple:
    """(the three components of the vector from site i to site j, as columns of the index family; that family)."""
    over = resolver.scope.over
    if not isinstance(over, (Lattice, Graph)) or not {i, j} <= set(ends(over)) or i == j:
        resolver.fail(codes.NOT_HERE, node.head, "`r(i, j)` is the vector of a bond", "its indices must be bound by `bond(..)` or `edge(..)`; otherwise write `r(j) - r(i)`")
    if over.places is None:
        resolver.fail(codes.OVER, node.head, "these bonds have no vectors, because their sites have no positions", HINT)
    return tuple(number(over, i, j, k) for k in range(3)), over


def ends(over) -> tuple[str, ...]:
    """The indices of its sites."""
    return over.indices if isinstance(over, Lattice) else over.bound


def number(over, i: str, j: str, axis: int) -> Expr:
    """One component: a number where all bonds have the same."""
    values = along(over, i, j, axis)
    return Num(values[0]) if len(set(values)) == 1 else Weight(column(i, j, axis))


def column(i: str, j: str, axis: int) -> str:
    """A name that no user can give."""
    return f"r_{i}_{j}_{AXES[axis]}_"


def along(over, i: str, j: str, axis: int) -> tuple:
    if isinstance(over, Graph):
        sign = 1 if (i, j) == over.bound else -1
        return tuple(float(sign * (over.places[b][axis] - over.places[a][axis])) for a, b in over.edges)
    a, b = over.indices.index(i), over.indices.index(j)
    return tuple(float(bond_vector(over, (member[a], member[b]))[axis]) for member in over.bonds)


def with_columns(over: Over, value: Expr) -> Over:
    """The index family with the numbers of its bonds that a formula names."""
    if not isinstance(over, (Lattice, Graph)):
        return over
    named = {e.name for e in walk(value) if isinstance(e, Weight)}
    pairs = [(i, j, k) for i in ends(over) for j in ends(over) for k in range(3) if column(i, j, k) in named]
    return replace(over, columns=over.columns + tuple((column(*one), along(over, *one)) for one in pairs)) if pairs else over
