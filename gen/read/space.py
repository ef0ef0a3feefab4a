"""[space]: the families of spheres, Lie-Poisson R^3 and Nambu factors."""
from __future__ import annotations

from dataclasses import replace

from ..language import limits
from ..language.expr import Elem, Expr, Idx, Num, Op
from ..language.spec import Family
from ..language import codes
from ..language.units import ACTION, MOMENT, NONE, product, quotient, said, unit
from .formulas import Formulas
from .names import COLUMNS, identifier
from .parameters import bounded
from .problems import Bad, Problems, meant
from .quadratic import NotPolynomial, matrix
from .scope import Declared, Scope
from .tree import Node
from .units import Measure

KINDS = ("sphere", "r3", "nambu")
SPACES = ("the spaces are `sphere`, `r3` (of so(3)), `nambu` (grad C x grad H, C quadratic: SO(2,1), SE(2), SE(1,1), Heisenberg), and products of these; canonical pairs, e(3), so(4) and su(n) are not supported")
KEYS = {"sphere": ("kappa", "moment", "radius", "tracer", "fixed"), "r3": ("kappa", "tracer", "fixed"),
        "nambu": ("kappa", "C", "tracer")}

KAPPA = 'give `moment = "1 mu_B"`, from which kappa = moment/gamma follows, or `kappa = "1 hbar"`'


class SpaceReader:
    """Reads [space] into `declared.families`."""

    def __init__(self, declared: Declared, formulas: Formulas, problems: Problems, lattices, graphs):
        self.declared, self.formulas, self.problems = declared, formulas, problems
        self.homes = lattices, graphs
        self.found: dict = {}       # dimensions of the family that is being read, of kappa, radius and C

    def read(self, section: Node) -> None:
        bounded(section.table(), limits.FAMILIES, "families")
        if not section.raw:
            section.wrong(codes.MISSING, "the space is empty", 'write `w = { sphere = 1 }`')
        self.declared.pending = {node.name for node in section.items()} - self.declared.names()
        self.declared.hollow = False
        for node in section.items():
            with self.problems.guard():
                self.family(node)
        self.declared.pending = set()

    def family(self, node: Node) -> None:
        """Declare it. Plain parts stand in for those with errors, so that what names it can be read."""
        name, parts = self.problems.tried(lambda: self.name(node), lambda: self.parts(node))
        kind, count, kappa, leaf, tracer, fixed = ("sphere", Bad, Bad, Bad, Bad, Bad) if parts is Bad else parts
        self.declared.nameless |= name is Bad
        self.declared.unread |= {node.name} if count is Bad else set()
        self.declared.rough |= {node.name} if leaf is Bad else set()
        count, home = (count, None) if count is Bad else count
        plain = (Num(1) if kind == "sphere" else None, None)
        if name is not Bad:
            self.declared.families[name] = Family(name, kind, *(Num(1) if x is Bad else x for x in (count, kappa)),
                                                  *(plain if leaf is Bad else leaf), tracer=tracer is True, fixed=fixed is True, lattice=home and replace(home, family=name))
        if Bad in (name, count, kappa, leaf, tracer, fixed):
            self.declared.hollow = True
            raise Bad

    def name(self, node: Node) -> str:
        name = identifier(self.problems, node.key, node.name, "family of vectors")
        if name in self.declared.names() or name in COLUMNS:
            self.declared.broken.add(name)
            self.problems.fail(codes.CLASH, node.key, f"`{name}` is already in use{self.elsewhere(node)}",
                               "choose another name")
        return name

    def elsewhere(self, node: Node) -> str:
        """Where what has its name stands, in another file."""
        mark = next((node.marks[path] for path in (("parameters", node.name), ("formulas", node.name)) if path in node.marks), None)
        file = self.problems.sources.of(mark.key.start if mark else node.key.start)
        return f", in {file.name}, line {file.place(mark.key.start - file.begin)[0]}" if file is not self.problems.sources.of(node.key.start) else ""

    def parts(self, node: Node) -> tuple:
        """kind, and what can be read of count, kappa, (radius, casimir), tracer, fixed."""
        kind = self.kind(node)
        node.table(kind, *KEYS[kind])
        self.found = {}
        parts = (kind, *self.problems.tried(
            lambda: self.sites(node.get(kind)), lambda: self.kappa(node, node.name),
            lambda: (self.radius(node, kind), self.casimir(node, node.name) if kind == "nambu" else None),
            lambda: node.has("tracer") and node.get("tracer").flag(), lambda: node.has("fixed") and node.get("fixed").flag()))
        return self.with_dimension(node, *parts) if self.declared.units else parts

    def with_dimension(self, node: Node, kind: str, count, kappa, *rest) -> tuple:
        """The parts; notes the dimension of the vectors, and has no kappa where it does not fit them."""
        found = Bad if Bad in (kappa, rest[0]) else self.problems.tried(lambda: self.vectors(node, kind))[0]
        w = self.found.get("radius") or NONE if found is Bad else found
        C = product(self.found.get("C") or NONE, product(w, w))
        self.declared.dimensions[node.name] = w
        self.declared.conserved[node.name] = product(self.found.get("kappa") or NONE, w), C
        return (kind, count, Bad if found is Bad else kappa, *rest)

    def vectors(self, node: Node, kind: str) -> tuple:
        """The dimension of the vectors w: on a sphere that of its radius; else it follows from w' = (1/kappa) grad C x grad H."""
        kappa, radius, C = (self.found.get(key) or NONE for key in ("kappa", "radius", "C"))
        if kind != "sphere":
            return quotient(product(C, ACTION), kappa)
        if product(kappa, radius) != ACTION:
            at = node.get("kappa") or node.get("moment")
            if at is None and node.has("fixed") and node.get("fixed").flag():        # of what does not move none is needed
                return radius
            if at is None:
                node.wrong(codes.MEASURE, f"`{node.label}` has no strength: kappa is {said(quotient(ACTION, radius))} in w' = (1/kappa) w x dH/dw", KAPPA)
            at.wrong(codes.DIMENSION, f"kappa is {said(quotient(ACTION, radius))} in w' = (1/kappa) w x dH/dw, but this is {said(kappa)}", KAPPA)
        return radius

    def sites(self, node: Node) -> tuple:
        """(how many there are, the lattice or graph of that name on which they lie, or None)."""
        for home in self.homes if isinstance(node.raw, str) and node.raw not in self.declared.names() else ():
            if node.raw in home.broken:
                raise Bad
            if node.raw in home.known:
                return home.home(node)
        return self.formulas.count(node), None

    def kind(self, node: Node) -> str:
        node.table()
        given = [k for k in KINDS if node.has(k)]
        self.other_space(node)
        if len(given) != 1:
            node.table(*(KINDS + KEYS["sphere"] + ("C",)))
            if not given and any(n.name not in KEYS["sphere"] + ("C",) for n in node.items()):
                raise Bad       # the unknown key was to be the kind
            node.wrong(codes.MISSING if not given else codes.CONFLICT,
                       f"`{node.label}` must have exactly one of sphere, r3, nambu",
                       'write `{ sphere = "n" }`, `{ r3 = 1 }` or `{ nambu = 1, C = "..." }`')
        return given[0]

    def other_space(self, node: Node) -> None:
        """Refuse a phase space that is none of these, by saying which there are; what is nearly a known key is a misspelt one."""
        known = KINDS + KEYS["sphere"] + ("C",)
        for child in () if any(map(node.has, KINDS)) else node.items():
            if child.name not in known and not meant(child.name, known):
                self.problems.fail(codes.UNKNOWN_KEY, child.key, f"`{node.label}` cannot be `{child.name}`", SPACES)

    def kappa(self, node: Node, name: str) -> Expr:
        """A number, a list (one entry per site), or a formula in `i`."""
        child = node.get("kappa")
        if node.has("moment"):
            return self.moment(node)
        if child is None:
            return Num(1)
        if isinstance(child.raw, list):
            return self.listed(child, name)
        return self.measured(child, "kappa", "a strength", "i")

    def measured(self, node: Node, key: str, what: str, index: str) -> Expr:
        """A formula whose dimension is noted under a key."""
        result = self.formulas.measured(node, what, index)
        self.found[key] = result.dimension
        return result.expr

    def moment(self, node: Node) -> Expr:
        """kappa = moment/gamma, that of spins with g = 2."""
        child, units = node.get("moment"), self.declared.units
        if units is None:
            child.wrong(codes.MEASURE, "a moment needs units", "add a section [units], or give `kappa`")
        if node.has("kappa"):
            child.wrong(codes.CONFLICT, f"`{node.label}` has both a moment and a kappa", "keep one of them: kappa = moment/gamma")
        moment = self.formulas.free(child, "`moment`", "i", MOMENT)
        share = float(units.factor(unit("gamma") ** -1))
        self.found["kappa"] = ACTION
        return Num(moment.value * share) if isinstance(moment, Num) else Op("*", (moment, Num(share)))

    def listed(self, child: Node, name: str) -> Expr:
        table = f"{name}_kappa"
        if table in self.declared.names() | self.declared.broken | self.declared.pending:
            child.wrong(codes.CLASH, f"the list is stored as `{table}`, which is already declared",
                        f"rename `{table}`")
        measure = Measure(self.declared.units)
        self.declared.tables[table] = tuple(float(measure.number(e)) for e in child.entries())
        self.found["kappa"] = measure.found
        return Elem(table, Idx("i"))

    def radius(self, node: Node, kind: str):
        if kind != "sphere":
            return None
        return self.measured(node.get("radius"), "radius", "a radius", "i") if node.has("radius") else Num(1)

    def casimir(self, node: Node, name: str):
        """The matrix of C, a formula in the family's own vector."""
        child = node.need("C", 'give the Casimir: `C = "(w.x^2 - w.y^2)/2"`')
        alone = replace(self.declared, families={name: Family(name, "nambu", Num(1), Num(1))},
                        pending=self.declared.pending - {name})
        c = Formulas(alone, self.problems).number(child.text(), Scope(alone, "C", whole=name))
        self.found["C"] = c.dimension
        try:
            return matrix(c.expr)
        except NotPolynomial as reason:
            child.wrong(codes.CASIMIR, f"C must be homogeneous quadratic in the components of "
                        f"`{name}`: {reason}", "such as `(w.x^2 - w.y^2)/2` or `w.x*w.y`")
