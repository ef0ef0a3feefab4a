"""[effects] and [observables]: named sums over index families."""
from __future__ import annotations

from ..language import limits
from ..language.expr import Num, Op, Spin, walk
from ..language.spec import Each, Effect, Graph, Lattice, Once, Over, Sites, Term, families_of
from ..effects.kinds import KINDS, kind_of
from ..language import codes
from ..language.units import ENERGY, NONE, Scale
from .formulas import Formulas
from .names import COLUMNS, identifier
from .over import OverReader
from .parse import parse
from .problems import Bad, Problems
from .scope import Declared, Scope, Typed, is_single
from .text import meaning
from .tree import Node
from .units import of_dimension
from .vectors import with_columns
from .work import derivatives


class TermReader:
    """Reads effects, by their kinds, and observables (key `value`)."""

    def __init__(self, declared: Declared, formulas: Formulas, over: OverReader,
                 problems: Problems):
        self.declared, self.formulas, self.over_reader = declared, formulas, over
        self.problems = problems
        self.told_in: dict[str, str] = {}       # units of observables

    def effects(self, section: Node) -> tuple[Effect, ...]:
        """Each read by its kind."""
        readers, found, nodes = {kind: kind.reader(self) for kind in KINDS}, [], list(section.table().items())
        for node in nodes:
            with self.problems.guard():
                found.append(readers[kind_of(node.raw if isinstance(node.raw, dict) else ())].read(node))
        if len(found) == len(nodes) and found and not any(e.moves for e in found):     # others may be energies with an error
            section.wrong(codes.MISSING, "no effect has an energy", 'damping requires the field of an energy: add `energy = "..."`')
        return tuple(found)

    def read(self, section: Node, key: str, what: str, taken=()) -> tuple[Term, ...]:
        terms = []
        for node in section.table().items():
            with self.problems.guard():
                terms.append(Term(*self.term(node, key, what, taken)))
        return tuple(terms)

    def term(self, node: Node, key: str, what: str, taken) -> tuple:
        """What a `Term` has."""
        node.table("over", key, "meaning", "unit")
        name, (over, value), said, unit = self.problems.together(
            lambda: self.name(node, what, taken), lambda: self.sum(node, key, what),
            lambda: self.text(node, "meaning"), lambda: self.text(node, "unit"))
        if key == "energy":
            self.unit_of_effect(node, ENERGY)
        elif self.declared.units:
            unit = self.told_in[name]
        return name, over, value, said, unit

    def told(self, node: Node, found: Typed):
        """The value of an observable, in its `unit` where [units] says that numbers have some."""
        units, dimension = self.declared.units, found.dimension or NONE
        if units is None:
            return found.expr
        shown = units.shown(dimension)
        if node.has("unit"):
            given = node.get("unit")
            shown = Scale(given.string().strip(), of_dimension(given, dimension, f"the unit of `{node.name}`"))
        self.told_in[node.name] = shown.text
        share = units.share(shown)
        return found.expr if share == 1 else Op("/", (found.expr, Num(share)))

    def unit_of_effect(self, node: Node, dimension) -> None:
        """With [units] a `unit` says what it is; the numbers have that of the model."""
        if self.declared.units and node.has("unit"):
            of_dimension(node.get("unit"), dimension, f"the unit of `{node.name}`")

    @staticmethod
    def text(node: Node, key: str) -> str:
        return meaning(node, key)

    def name(self, node: Node, what: str, taken) -> str:
        name = identifier(self.problems, node.key, node.name, what)
        bearer = ("a family" if name in self.declared.families else "an effect" if name in taken else
                  "an output" if name in COLUMNS else None)
        if bearer:
            self.problems.fail(codes.CLASH, node.key, f"`{name}` is already the name of {bearer}",
                               f"outputs of a run must have different names: rename the {what}")
        return name

    def sum(self, node: Node, key: str, what: str):
        """(index family, formula); without the first the second is only parsed."""
        over, formula = self.problems.together(lambda: self.over(node, key), lambda: node.need(
            key, f'give its {key}: `{key} = "..."`'))
        found = self.formulas.number(formula.text(), self.scope(over, what))
        if key == "energy":
            self.formulas.fits(found, formula.text().whole, "`energy`", ENERGY)
        value = found.expr if key == "energy" else self.told(node, found)
        over = with_columns(over, value)
        self.known({*families_of(over).values(), *(e.family for e in walk(value) if isinstance(e, Spin))})
        if key == "energy" and not isinstance(over, Once):
            over, value = self.summed(formula, over, value)
        if key == "energy":
            self.affordable(node, formula, value)
        if key == "energy" and len(self.tracers(value)) > 1:
            formula.wrong(codes.NOT_HERE, "this energy couples two tracers, which do not act on other sites",
                          "couple tracers to families that are not tracers")
        return over, value

    @staticmethod
    def affordable(node: Node, formula: Node, value) -> None:
        """Refuse a formula whose derivatives would take too long."""
        if (work := derivatives(value)) > limits.DERIVATIVES:
            formula.wrong(codes.BIG, f"the derivatives of `{node.name}` take some {work} operations; at most {limits.DERIVATIVES} are "
                          "allowed", "simplify it, or split the sum into several effects")

    with_columns = staticmethod(with_columns)

    def known(self, families: set) -> None:
        """Leave a term of families whose declaration has errors: what it does to them is not known."""
        if families & self.declared.unread:
            raise Bad

    def over(self, node: Node, key: str) -> Over:
        try:
            return self.over_reader.read(node.get("over").text() if node.has("over") else None)
        except Bad:
            if node.has(key) and isinstance(node.get(key).raw, str):
                parse(node.get(key).text(), self.problems)
            raise

    def scope(self, over: Over, what: str) -> Scope:
        weights = frozenset(n for n, _ in over.columns) if isinstance(over, Graph) else frozenset()
        numbers = frozenset({over.number} - {""}) if isinstance(over, Lattice) else frozenset()
        return Scope(self.declared, f"an {what}", time=True, indices=families_of(over), weights=weights, numbers=numbers, over=over)

    def tracers(self, value) -> set:
        """The vectors of tracers that `value` depends on."""
        return {(e.family, e.slot) for e in walk(value)
                if isinstance(e, Spin) and self.declared.families[e.family].tracer}

    def summed(self, node: Node, over: Over, value):
        """In a sum of energies every vector stands at a bound index.

        The only vector of a single family joins the combinations: `each(i of p, k of w)`.
        """
        fixed = {e.family for e in walk(value) if isinstance(e, Spin) and isinstance(e.slot, int)}
        if not fixed:
            return over, value
        families = families_of(over)
        alone = all(is_single(self.declared.families[f]) and f not in families.values()
                    for f in fixed)
        if not (alone and isinstance(over, (Sites, Each))):
            node.wrong(codes.INDEX, "all vectors in a sum of energies must have bound indices",
                       "write `each(i of p, j of w)` for all combinations, or a graph for some")
        extra: dict[str, str] = {}
        for f in sorted(fixed):
            extra[f] = unused(f"{f}_site", {*families, *extra.values(), *self.declared.names()})
        over = Each(tuple(families) + tuple(extra.values()),
                    tuple(families.values()) + tuple(extra))
        return over, moved(value, extra)


def unused(name: str, taken: set) -> str:
    """The name, with a number behind it where it is taken."""
    return next(one for one in (name, *(f"{name}{k}" for k in range(2, len(taken) + 3))) if one not in taken)


def moved(e, extra: dict[str, str]):
    """`e` with the fixed vectors of the families in `extra` at their new index."""
    if isinstance(e, Spin) and isinstance(e.slot, int):
        return Spin(e.family, extra[e.family])
    if isinstance(e, Op):
        return Op(e.op, tuple(moved(a, extra) for a in e.args))
    return e
