"""[runs]: named computations."""
from __future__ import annotations

from ..methods import NAMES as METHODS, SOLVERS
from ..language import limits
from ..language.spec import LOOSEST, Averages, Run
from ..language import codes
from ..language.units import TIME
from .formulas import Formulas
from .names import COMPUTED, OUTPUTS, identifier
from .problems import Problems, nearest
from .scope import Declared
from .text import meaning
from .tree import Node
from .values import ValueReader

KEYS = ("start", "method", "h", "time", "steps", "effects", "without", "set", "solver", "output", "meaning",
        "checkpoint", "substeps", "tolerance", "averages")
OUTPUT, AVERAGES = ("every", "period", "what"), ("what", "after", "bins")


class RunReader:
    """Reads [runs] against the effects, observables and starts."""

    def __init__(self, declared: Declared, formulas: Formulas, problems: Problems,
                 effects, observables, starts, scene):
        """Runs of a base do without effects that the scene leaves out, and have those that it adds."""
        self.declared, self.formulas, self.problems = declared, formulas, problems
        self.effects, self.observables, self.starts, self.scene = effects, observables, starts, scene

    def read(self, section: Node) -> tuple[Run, ...]:
        runs = []
        for node in section.table().items():
            with self.problems.guard():
                runs.append(self.run(node))
        return tuple(runs)

    def run(self, node: Node) -> Run:
        node.table(*KEYS, output=OUTPUT, averages=AVERAGES)
        name, start, method, h, length, output, effects, solver, values, said, safety = self.problems.together(
            lambda: identifier(self.problems, node.key, node.name, "run"), lambda: self.start(node),
            lambda: self.word(node, "method", METHODS), lambda: self.step(node), lambda: self.duration(node),
            lambda: self.output(node), lambda: self.chosen(node), lambda: self.word(node, "solver", SOLVERS),
            lambda: self.values(node), lambda: meaning(node, "meaning"), lambda: self.safety(node))
        return Run(name, start, method, h, *length, **output, effects=effects, solver=solver, parameters=values,
                   meaning=said, **safety)

    def start(self, node: Node) -> str:
        return self.choice(node.need("start", 'name a start: `start = "..."`'), self.starts, "start")

    def step(self, node: Node):
        return self.formulas.free(node.need("h", "give the step: `h = 0.1`"), "a step", wanted=TIME)

    def safety(self, node: Node) -> dict:
        """checkpoint, substeps, tolerance, averages."""
        return self.given(node, checkpoint=lambda child: child.integer(1, limits.EVERY), substeps=Node.flag, tolerance=self.tolerance, averages=self.averages)

    def averages(self, node: Node) -> Averages:
        node.table(*AVERAGES)
        return Averages(**self.given(node, what=self.averaged, bins=lambda child: child.integer(2, limits.LIST),
                                     after=lambda child: self.formulas.free(child, "the time of the first sample", wanted=TIME)))

    def averaged(self, node: Node) -> tuple[str, ...]:
        """Names of numbers; those of effects and families are looked up when a run starts, which may do without them."""
        entries = node.entries("list of numbers")
        return self.unique(node, tuple(self.problems.together(*(lambda e=e: self.number(e) for e in entries))))

    def number(self, entry: Node) -> str:
        word, known = entry.string(), ("energy", *(f"energy.{name}" for name in (*self.effects, *self.scene.left_out)), *self.observables)
        if word not in known and not word.startswith("momentum.") and word not in self.declared.broken:
            entry.wrong(codes.OUTPUT, f"there is no quantity `{word}` to average", nearest(word, known))
        return word

    def tolerance(self, node: Node) -> float:
        value = node.number()
        if not 0 < value <= LOOSEST:
            node.wrong(codes.LIMIT, f"`{node.label}` is {node.raw}", f"a tolerance must be above 0 and at most {LOOSEST:g}")
        return float(value)

    def given(self, node: Node, **readers) -> dict:
        """key -> what its reader makes of it, for the keys that are there."""
        keys = [key for key in readers if node.has(key)]
        return dict(zip(keys, self.problems.together(*(lambda k=key: readers[k](node.get(k)) for key in keys))))

    def choice(self, node: Node, known, what: str) -> str:
        word = node.string()
        if word not in known and word not in self.declared.broken:
            node.wrong(codes.UNKNOWN_NAME, f"there is no {what} `{word}`", nearest(word, known))
        return word

    def word(self, node: Node, key: str, known: tuple) -> str:
        """One of `known`; the first when the key is absent."""
        if not node.has(key):
            return known[0]
        child = node.get(key)
        if child.string() not in known:
            child.wrong(codes.CHOICE, f"there is no {key} `{child.raw}`",
                        nearest(child.raw, known))
        return child.raw

    def duration(self, node: Node):
        """(time, steps): one of them."""
        if node.has("time") == node.has("steps"):
            both = node.has("time")
            self.problems.fail(codes.CONFLICT if both else codes.MISSING, node.key,
                               f"`{node.label}` has " + ("both `time` and `steps`" if both else
                                                         "neither `time` nor `steps`"),
                               "write `time = 100` or `steps = 1000`")
        if node.has("steps"):
            return None, self.formulas.count(node.get("steps"))
        return self.formulas.free(node.get("time"), "a duration", wanted=TIME), None

    def chosen(self, node: Node):
        """The effects of `effects`, or all, but for those of `without`; None: all."""
        if not (node.has("effects") or node.has("without")):
            return None
        listed, without = self.problems.together(lambda: self.listed(node, "effects"), lambda: self.listed(node, "without"))
        left = tuple(name for name in (self.effects if listed is None else listed) if name not in (without or ()))
        if not left:
            self.problems.fail(codes.MISSING, node.key, f"`{node.label}` selects no effect", "add at least one energy")
        return left

    def listed(self, node: Node, key: str):
        """Effects of the scene that a list names; None without the list."""
        if not node.has(key):
            return None
        known, child = [*self.effects, *self.scene.left_out], node.get(key)
        names = self.problems.together(*(lambda e=e: self.choice(e, known, "effect") for e in child.entries("list of effects")))
        for entry in child.entries() if self.problems.sources.of(child.span.start) is self.problems.sources.files[0] else ():
            if key == "effects" and entry.raw in self.scene.left_out:
                entry.wrong(codes.UNKNOWN_NAME, f"the scene leaves out `{entry.raw}`", "add it to [scene], or remove it from this run")
        added = self.added(child) if key == "effects" else ()
        return tuple(name for name in (*self.unique(child, tuple(names)), *added) if name not in self.scene.left_out)

    def added(self, node: Node) -> list[str]:
        """The effects of files that build on the one in which a list stands."""
        files = self.problems.sources.files
        number = files.index(self.problems.sources.of(node.span.start))
        return [name for name in self.effects if self.scene.known.get(name, number) < number and name not in node.raw]

    def unique(self, node: Node, names: tuple) -> tuple:
        """The names of a list: at least one, and each once."""
        if not names:
            node.wrong(codes.MISSING, f"`{node.label}` is empty", "omit it, or name the outputs")
        for name in names:
            if names.count(name) > 1:
                node.wrong(codes.CLASH, f"`{name}` is listed twice", "name it once")
        return names

    def output(self, node: Node) -> dict:
        """every, period, what; a run with averages has no rows unless it asks for some."""
        rows = {"what": ()} if node.has("averages") else {}
        if not node.has("output"):
            return rows
        out = node.get("output").table(*OUTPUT)
        if out.has("every") and out.has("period"):
            self.problems.fail(codes.CONFLICT, out.get("every").key,
                               "`every` and `period` exclude each other", "keep one of them")
        return rows | self.given(out, every=lambda child: child.integer(1, limits.EVERY), what=self.what,
                          period=lambda child: self.formulas.free(child, "a period of outputs", wanted=TIME))

    def what(self, node: Node) -> tuple[str, ...]:
        entries = node.entries("list of outputs")
        return self.unique(node, tuple(self.problems.together(*(lambda e=e: self.kept(e) for e in entries))))

    def kept(self, entry: Node) -> str:
        """The name of an output."""
        word, known = entry.string(), OUTPUTS + COMPUTED + tuple(self.observables)
        if word not in known and word not in self.declared.broken:
            entry.wrong(codes.OUTPUT, f"there is no output `{word}`", nearest(word, known))
        return word

    def values(self, node: Node):
        if not node.has("set"):
            return ()
        reader = ValueReader(self.declared)
        children = node.get("set").table().items()
        return tuple(self.problems.together(*(lambda c=child: reader.read(c) for child in children)))
