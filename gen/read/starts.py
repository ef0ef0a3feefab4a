"""[starts]: where each family begins."""
from __future__ import annotations

from math import cos, sin

from ..language.expr import Expr, Num, Op
from ..language.spec import Family, FamilyStart, Start
from ..language import codes
from ..language.units import ANY, NONE, said
from .files import Files
from .formulas import Formulas
from .names import identifier
from .problems import Problems
from .scope import Declared
from .text import meaning
from .tree import Node
from .units import Measure

FORMS = {"vectors": ("vectors",), "formula": ("x", "y", "z"), "angles": ("theta", "phi"),
         "random": ("random",), "file": ("file",)}
KEYS = tuple(k for keys in FORMS.values() for k in keys) + ("normalise", "unit")
SEED = 2 ** 53
HELP = "give vectors, or x, y, z, or theta, phi, or random = seed, or file"


class StartReader:
    """Reads [starts] against the declared families."""

    def __init__(self, declared: Declared, formulas: Formulas, files: Files,
                 problems: Problems):
        self.declared, self.formulas, self.files = declared, formulas, files
        self.problems = problems

    def read(self, section: Node) -> tuple[Start, ...]:
        starts = []
        for node in section.table().items():
            with self.problems.guard():
                starts.append(self.start(node))
        return tuple(starts)

    def start(self, node: Node) -> Start:
        node.table()
        name, parts, _ = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "start"),
            lambda: self.parts(node, self.families(node)), lambda: meaning(node, "meaning"))
        if not self.declared.families:
            self.formulas.silently()
        wrong = self.declared.rough | self.declared.unread
        return Start(name, tuple(part for part in parts if part.family not in wrong))

    def families(self, node: Node) -> dict[str, Family]:
        """The families to start; without a space, spheres under the names that are written."""
        names = ["w"] if any(node.has(k) for k in KEYS) else [n.name for n in node.items() if isinstance(n.raw, dict)]
        return self.declared.families or {name: Family(name, "sphere", Num(1), Num(1), Num(1)) for name in names}

    def parts(self, node: Node, families: dict) -> tuple[FamilyStart, ...]:
        """A family without a table of its own begins as the keys of the start itself say: the only family, or the only other one."""
        tables = [f for f in families if node.has(f) and (f not in KEYS or isinstance(node.get(f).raw, dict))]  # one may be named x
        others = [f for f in families if f not in tables]
        itself = any(node.has(k) for k in KEYS if k not in tables)
        if len(others) == 1 and (itself or not tables):
            return tuple(self.problems.together(*(
                lambda f=f: self.family(node, f, (*tables, "meaning")) if f.name in others else self.of(node, f) for f in families.values())))
        if itself:
            self.problems.fail(codes.START, node.key, "the space has several families: "
                               + ", ".join(families), f"give each its own table, or all but one: {', '.join(f'[{node.label}.{name}]' for name in families)}")
        node.table(*families, "meaning")
        return tuple(self.problems.together(*(lambda f=f: self.of(node, f) for f in families.values())))

    def of(self, node: Node, family: Family) -> FamilyStart:
        child = node.need(family.name, f"every family needs a start: [{node.label}.{family.name}]")
        return self.family(child.table(), family, ())

    def family(self, node: Node, family: Family, more: tuple) -> FamilyStart:
        node.table(*KEYS, *more)
        given = [f for f, keys in FORMS.items() if any(node.has(k) for k in keys)]
        if len(given) != 1:
            code = codes.MISSING if not given else codes.CONFLICT
            self.problems.fail(code, node.key, f"`{node.label}` "
                               + ("does not say where to start" if not given else "gives more than one start"), HELP)
        normalise, (kind, value) = self.problems.together(
            lambda: self.normalise(node, family), lambda: getattr(self, given[0])(node, family))
        return FamilyStart(family.name, kind, value, normalise)

    def normalise(self, node: Node, family: Family) -> bool:
        chosen = node.has("normalise") and node.get("normalise").flag()
        if chosen and family.kind != "sphere":
            node.get("normalise").wrong(codes.START, f"`{family.name}` is not on a sphere, so there is nothing to normalise to", "leave `normalise` out")
        return chosen

    def of_vector(self, node: Node, family: Family) -> Measure:
        """What reads the components of a vector; of one that is normalised they may have any unit."""
        loose = node.has("normalise") and node.get("normalise").flag()
        return self.measure(node, ANY if loose else self.dimension(family), f"the unit of `{family.name}`")

    def measure(self, node: Node, dimension, what: str) -> Measure:
        """What reads numbers of a dimension; without a unit of their own they have that of `unit`."""
        if node.has("unit") and self.declared.units is None:
            node.get("unit").wrong(codes.MEASURE, "units in a start require a section [units]", "leave it out")
        found = Measure(self.declared.units, node.get("unit"))
        if dimension is not ANY:
            found.needed(node.get("unit"), dimension, what)
        return found

    def dimension(self, family: Family) -> tuple:
        return self.declared.dimensions.get(family.name, NONE)

    def plain(self, node: Node, family: Family) -> None:
        """Refuse directions for vectors that have a unit and no sphere that gives their length."""
        if self.declared.units and family.kind != "sphere" and self.dimension(family) != NONE:
            node.wrong(codes.MEASURE, f"this gives `{family.name}` the length 1, but it is {said(self.dimension(family))}", "give x, y, z or vectors, with units")

    def vectors(self, node: Node, family: Family):
        entries, measure = node.get("vectors").entries("list of vectors"), self.of_vector(node, family)
        return "vectors", tuple(self.vector(entry, measure) for entry in entries)      # of a list of data the first error is enough

    def vector(self, entry: Node, measure: Measure) -> tuple[float, ...]:
        row = entry.entries("vector of three numbers")
        if len(row) != 3:
            entry.wrong(codes.START, f"a vector has three components, not {len(row)}", "write `[x, y, z]`")
        return tuple(float(measure.number(c)) for c in row)

    def file(self, node: Node, family: Family):
        rows = self.files.rows(node.get("file"), 3, "rows `x, y, z`")
        if len(rows[0]) != 3:
            node.get("file").wrong(codes.TABLE, f"`{node.get('file').raw}` has {len(rows[0])} "
                                   "columns", "it should contain rows `x, y, z`")
        return "vectors", tuple(self.of_vector(node, family).rows(node.get("file"), rows))

    def random(self, node: Node, family: Family):
        if family.kind == "nambu":
            node.get("random").wrong(codes.START, "random starts require spheres or r3",
                                     "give vectors or x, y, z")
        self.plain(node.get("random"), family)
        return "random", node.get("random").integer(0, SEED)

    def formula(self, node: Node, family: Family):
        loose = node.has("normalise") and node.get("normalise").flag()
        return "formula", tuple(self.components(node, FORMS["formula"], ANY if loose else self.dimension(family), family.name))

    def components(self, node: Node, keys, wanted, family: str) -> list[Expr]:
        return self.problems.together(*(lambda k=k: self.component(node, k, wanted, family) for k in keys))

    def component(self, node: Node, key: str, wanted, family: str) -> Expr:
        child = node.need(key, f"give either `{' '.join(FORMS['formula'])}` or `theta phi`")
        if node.has("unit"):
            measure = self.measure(node, wanted, "the unit of an angle" if key in FORMS["angles"] else f"the unit of `{family}`")
            if child.is_number():
                return Num(measure.number(child))
            if wanted == NONE:
                child.wrong(codes.MEASURE, "`unit` is that of numbers, but this is a formula", "remove `unit`, and write the unit in the formula: `10 deg`")
        return self.formulas.free(child, "a start", "i", wanted, family)

    def angles(self, node: Node, family: Family):
        """theta from the z axis, phi around it; times the radius of a sphere."""
        if family.kind == "nambu":
            self.problems.fail(codes.START, node.key, "angles require spheres or r3",
                               "give vectors or x, y, z")
        if any(node.has(k) and isinstance(node.get(k).raw, list) for k in FORMS["angles"]):
            return self.listed_angles(node, family)
        self.plain(node.get("theta") or node, family)
        theta, phi = self.components(node, FORMS["angles"], NONE, family.name)
        s = Op("sin", (theta,))
        unit = (Op("*", (s, Op("cos", (phi,)))), Op("*", (s, Op("sin", (phi,)))),
                Op("cos", (theta,)))
        if family.radius in (None, Num(1)):
            return "formula", unit
        return "formula", tuple(Op("*", (family.radius, c)) for c in unit)

    def listed_angles(self, node: Node, family: Family):
        """`theta = [0.7, 1.1]`, `phi = [0.2, 2.0]`: one pair for each site."""
        self.plain(node.get("theta") or node, family)
        measure = self.measure(node, NONE, "the unit of an angle")
        theta, phi = ([measure.number(e) for e in node.need(k, "theta and phi must both be given").entries(
            "list of angles, like the other one")] for k in FORMS["angles"])
        if len(theta) != len(phi):
            node.get("phi").wrong(codes.START, f"{len(phi)} angles phi for {len(theta)} angles "
                                  "theta", "give one pair for every site")
        if not isinstance(family.radius or Num(1), Num):
            node.get("theta").wrong(codes.START, "lists of angles need a radius that is a number",
                                    "give formulas in i, or vectors")
        r = family.radius.value if family.radius else 1
        return "vectors", tuple(
            (r * sin(a) * cos(b), r * sin(a) * sin(b), r * cos(a)) for a, b in zip(theta, phi))
