"""[runs]: named computations."""
from __future__ import annotations

from .. import limits
from ..spec import Run
from . import codes
from .formulas import Formulas
from .names import OUTPUTS, identifier
from .problems import Problems, nearest
from .scope import Declared
from .text import meaning
from .tree import Node
from .values import ValueReader

METHODS = ("spherical-midpoint", "classical-midpoint", "moser-veselov")
SOLVERS = ("auto", "newton", "rotation", "plain")
KEYS = ("start", "method", "h", "time", "steps", "effects", "set", "solver", "output", "meaning",
        "checkpoint", "substeps")


class RunReader:
    """Reads [runs] against the effects, observables and starts."""

    def __init__(self, declared: Declared, formulas: Formulas, problems: Problems,
                 effects, observables, starts):
        self.declared, self.formulas, self.problems = declared, formulas, problems
        self.effects, self.observables, self.starts = effects, observables, starts

    def read(self, section: Node) -> tuple[Run, ...]:
        runs = []
        for node in section.table().items():
            with self.problems.guard():
                runs.append(self.run(node))
        return tuple(runs)

    def run(self, node: Node) -> Run:
        name = identifier(self.problems, node.key, node.name, "run")
        node.table(*KEYS)
        start = self.choice(node.need("start", 'name a start: `start = "..."`'), self.starts,
                            "start")
        h = self.formulas.free(node.need("h", "give the step: `h = 0.1`"), "a step")
        return Run(name, start, self.word(node, "method", METHODS), h, *self.duration(node),
                   **self.output(node), effects=self.chosen(node),
                   solver=self.word(node, "solver", SOLVERS),
                   values=self.values(node), meaning=meaning(node, "meaning"), **self.safety(node))

    def safety(self, node: Node) -> dict:
        """checkpoint, substeps."""
        found = {}
        if node.has("checkpoint"):
            found["checkpoint"] = node.get("checkpoint").integer(1, limits.EVERY)
        if node.has("substeps"):
            found["substeps"] = node.get("substeps").flag()
        return found

    def choice(self, node: Node, known, what: str) -> str:
        word = node.string()
        if word in self.declared.broken:
            self.formulas.silently()
        if word not in known:
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
        return self.formulas.free(node.get("time"), "a duration"), None

    def chosen(self, node: Node):
        if not node.has("effects"):
            return None
        listed = node.get("effects")
        names = tuple(self.choice(e, self.effects, "effect")
                      for e in listed.entries("list of effects"))
        return self.unique(listed, names)

    def unique(self, node: Node, names: tuple) -> tuple:
        """The names of a list: at least one, and each once."""
        if not names:
            node.wrong(codes.MISSING, f"`{node.label}` is empty", "leave it out, or name what "
                       "you want")
        for name in names:
            if names.count(name) > 1:
                node.wrong(codes.CLASH, f"`{name}` is listed twice", "name it once")
        return names

    def output(self, node: Node) -> dict:
        """every, section, what."""
        if not node.has("output"):
            return {}
        out, found = node.get("output").table("every", "section", "what"), {}
        if out.has("every") and out.has("section"):
            self.problems.fail(codes.CONFLICT, out.get("every").key,
                               "`every` and `section` exclude each other", "keep one of them")
        if out.has("every"):
            found["every"] = out.get("every").integer(1, limits.EVERY)
        if out.has("section"):
            found["section"] = self.formulas.free(out.get("section"), "a section period")
        if out.has("what"):
            found["what"] = self.what(out.get("what"))
        return found

    def what(self, node: Node) -> tuple[str, ...]:
        known = OUTPUTS + tuple(self.observables)
        names = []
        for entry in node.entries("list of outputs"):
            word = entry.string()
            if word not in known and word not in self.declared.broken:
                entry.wrong(codes.OUTPUT, f"there is no output `{word}`", nearest(word, known))
            names.append(word)
        return self.unique(node, tuple(names))

    def values(self, node: Node):
        if not node.has("set"):
            return ()
        reader = ValueReader(self.declared)
        return tuple(reader.read(child) for child in node.get("set").table().items())
