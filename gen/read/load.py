"""From a spec file or text to a `Spec`, or a `SpecError` with up to ten diagnostics."""
from __future__ import annotations

import difflib
import hashlib
import os
from collections.abc import Iterable
from dataclasses import replace
from typing import Optional

from ..errors import Diagnostic, SpecError
from ..language import limits
from ..effects.kinds import ordered
from ..language.spec import Spec
from ..public import public
from ..language import codes
from . import checks
from .called import called_for, refuse_gone, with_parameters
from .files import Files
from .flat_text import flat_text
from .formulas import Formulas
from .graphs import Graphs
from .lattices import Lattices
from .names import identifier
from .over import OverReader
from .parameters import FormulaReader, ParameterReader, bounded, undeclared
from .problems import Bad, Problems
from .runs import RunReader
from .scene import flat
from .scope import Declared
from .source import Source, Span
from .space import SpaceReader
from .starts import StartReader
from .terms import TermReader
from .text import meaning
from .tree import Node
from .units import UnitsReader
from .vectors import Places
from .values import defaults, filled, with_values

SECTIONS = ("scene", "model", "units", "space", "parameters", "formulas", "lattices", "graphs", "effects",
            "observables", "starts", "runs")


def load(path, library=(), recorded: bool = False) -> Spec:
    """Read the spec file at `path`; library: folders of further files; recorded: by a result, of an earlier version perhaps. Raises SpecError."""
    name = os.fspath(path)
    return reader_of(read_file(name), name, library, recorded).spec()


def read_file(name: str) -> str:
    """The text of a spec file; SpecError where there is none."""
    try:
        with open(name, "rb") as f:
            data = f.read(limits.FILE_BYTES + 1)
    except OSError as e:
        raise SpecError([Diagnostic(codes.FILE, name, 0, 0, "", (e.strerror or "cannot be read").lower(),
                                    "give the path of a spec, a TOML file")]) from None
    return decoded(data, name)


def shown(path, library=()) -> str:
    """The flat text of a spec file, with the place of every value. Raises SpecError."""
    name = os.fspath(path)
    reader = reader_of(read_file(name), name, library)
    return flat_text(reader.spec(), reader.root)


def decoded(data: bytes, name: str) -> str:
    """The text of a file; SpecError when it is not UTF-8."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as e:
        good = data[:e.start].decode("utf-8")
        rest = data[e.start:].decode("utf-8", "replace")
        problems = Problems(Source(good + rest, name))
        problems.note(codes.ENCODING, Span(len(good), len(good) + 1), "the byte "
                      f"0x{data[e.start]:02x} is not UTF-8 text", "save the file as UTF-8")
        raise SpecError(problems.ordered()) from None


@public
def load_text(text: str, path: str | os.PathLike = "", library: Iterable[str | os.PathLike] = ()) -> Spec:
    """Read a spec from a string.

    :param path: the name to use in messages; files named in the spec are looked for in its folder.
    :param library: additional folders in which to look for these files.
    :raises SpecError: with up to ten errors.
    """
    return reader_of(text, os.fspath(path), library).spec()


def reader_of(text: str, path: str, library, recorded: bool = False) -> Reader:
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    folder = os.path.dirname(os.path.abspath(path)) if path else ""
    return Reader(path, Files(folder, library), Problems(Source(text, path or "<text>", folder=folder), recorded))


class Reader:
    """Reads the sections in the order in which they depend on each other."""

    def __init__(self, path: str, files: Files, problems: Problems):
        self.path, self.files, self.problems = path, files, problems
        self.declared = Declared()
        self.formulas = Formulas(self.declared, problems)

    def spec(self) -> Spec:
        try:
            return self.read()
        except Bad:
            self.problems.finish()
            raise

    def read(self) -> Spec:
        self.scene = flat(self.problems, self.files, SECTIONS)
        self.root = self.scene.root
        self.root.table(*SECTIONS)
        self.declared.broken |= self.scene.aside.names
        self.marks = self.root.marks
        self.respelt = self.unknown_sections()
        spec = filled(self.sections())
        if not self.problems.found:
            spec = self.called_for(spec) if self.scene.left_out else spec
            spec = with_parameters(spec, self.scene.inherited("parameters"))
        self.check(spec)                # with errors: what was read without one
        self.problems.finish()
        return spec

    def called_for(self, spec: Spec) -> Spec:
        """A result may hold a scene that names outputs which it leaves out: earlier versions took it."""
        spec, gone = called_for(spec, self.scene.left_out)
        if not self.problems.recorded:
            refuse_gone(self.root, gone)
        return spec

    def unknown_sections(self) -> dict[str, Node]:
        """Those that are most likely misspelt, by the name that was meant; of others the names count as declared."""
        found = {}
        for node in [n for n in self.root.items() if n.name not in SECTIONS]:
            meant = [s for s in difflib.get_close_matches(node.name, SECTIONS, 1, 0.6) if not self.root.has(s)]
            if meant:
                found[meant[0]] = node
            elif isinstance(node.raw, dict):
                self.declared.broken |= set(node.raw)
        return found

    def find(self, name: str) -> Optional[Node]:
        """A section under its name, or under one that was meant for it."""
        return self.root.get(name) or self.respelt.get(name)

    def section(self, name: str, most: Optional[int] = None) -> Node:
        """A section that may be absent."""
        node = self.find(name) or Node({}, (name,), self.marks, self.problems)
        node.table()
        if most is not None:
            bounded(node, most, name)
        return node

    def sections(self) -> Optional[Spec]:
        head = dict(name="", title="", orientation=1)
        with self.problems.guard():
            head = self.model()
        self.declarations()
        over = self.over_reader()
        terms = TermReader(self.declared, self.formulas, over, self.problems)
        effects = self.guarded(lambda: terms.effects(self.effects()))
        observables = self.guarded(lambda: terms.read(
            self.section("observables", limits.OBSERVABLES), "value", "observable",
            {e.name for e in effects}))
        starts = self.guarded(lambda: StartReader(
            self.declared, self.formulas, self.files, self.problems).read(
                self.section("starts", limits.STARTS)))
        runs = self.guarded(lambda: self.run_reader().read(self.section("runs", limits.RUNS)))
        return self.assemble(head, effects, observables, starts, runs)

    def guarded(self, read) -> tuple:
        with self.problems.guard():
            return read()
        return ()

    def effects(self) -> Node:
        node = self.find("effects")
        if node is None and any(n.name not in SECTIONS for n in self.root.items()):
            raise Bad                   # an unknown section, which is noted, was to hold them
        if node is None or node.raw == {}:
            self.problems.fail(codes.MISSING, Span(0, 1), "the spec has no [effects]",
                               'add an energy: [effects.name] with `energy = "..."`')
        return self.section("effects", limits.EFFECTS)

    def run_reader(self) -> RunReader:
        """Runs refer to names, also to those of items that have errors."""
        def names(section):
            node = self.find(section)
            return list(node.raw) if node and isinstance(node.raw, dict) else []
        return RunReader(self.declared, self.formulas, self.problems, names("effects"),
                         names("observables"), names("starts"), self.scene)

    def model(self) -> dict:
        node = self.find("model") or self.root.need("model", 'start with [model] and `name = "..."`')
        node.table("name", "title", "orientation")
        return dict(zip(("name", "title", "orientation"), self.problems.together(
            lambda: self.name(node), lambda: meaning(node, "title"), lambda: self.orientation(node))))

    def name(self, node: Node) -> str:
        name = node.need("name", 'give the model a name: `name = "my_model"`')
        return identifier(self.problems, name.span, name.string(), "model")

    def orientation(self, node: Node) -> int:
        child = node.get("orientation")
        if child is None:
            return 1
        if not child.is_integer() or child.raw not in (1, -1):
            child.wrong(codes.CHOICE, "the orientation must be 1 or -1", "use 1 for w' = w x dH/dw, "
                        "or -1 to reverse every bracket")
        return child.raw

    def declarations(self) -> None:
        """Units, then parameters, then formulas, lattices and graphs, then the space."""
        with self.problems.guard():
            self.declared.units = UnitsReader(self.problems).read(self.section("units"))
            self.problems.measured = self.declared.units is not None
        with self.problems.guard():
            ParameterReader(self.declared, self.formulas, self.files, self.problems).read(
                self.section("parameters"))
        with self.problems.guard():
            FormulaReader(self.declared, self.problems).read(self.section("formulas"))
        self.index_families()
        with self.problems.guard():
            self.find("space") or self.root.need("space", 'describe the space: [space] with '
                           '`w = { sphere = 1 }`')
            SpaceReader(self.declared, self.formulas, self.problems, self.lattices, self.graphs).read(self.section("space"))
        undeclared(self.declared, self.problems)

    def over_reader(self) -> OverReader:
        over = OverReader(self.declared, self.lattices, self.graphs, self.problems)
        terms = [node for name in ("effects", "observables") if self.root.has(name) and isinstance(self.root.raw[name], dict) for node in self.root.get(name).items()]
        texts = [node.get("over").text() for node in terms if isinstance(node.raw, dict) and isinstance(node.raw.get("over"), str)]
        self.declared.places = Places(over.read, texts, self.problems)
        return over

    def index_families(self) -> None:
        """The lattices and graphs."""
        self.lattices, self.graphs = lattices, graphs = Lattices(self.formulas, self.problems), Graphs(self.formulas, self.files, self.problems)
        for name, most, reader in (("lattices", limits.LATTICES, lattices),
                                   ("graphs", limits.GRAPHS, graphs)):
            with self.problems.guard():
                for node in self.section(name, most).items():
                    with self.problems.guard():
                        reader.declare(node)

    def assemble(self, head: dict, effects, observables, starts, runs) -> Spec:
        sources = (("", self.problems.sources.files[0].text),) + tuple(sorted(self.files.texts.items()))
        return Spec(head["name"], head["title"], tuple(self.declared.parameters.values()),
                    tuple(f for f in self.declared.families.values() if f.name not in self.declared.unread),
                    ordered(effects), observables, tuple(self.declared.tables.items()), starts, runs, head["orientation"],
                    self.path, digest(sources), sources, self.units())

    def units(self):
        """With the dimensions of all that has a name."""
        units, declared = self.declared.units, self.declared
        named = [(("name", name), dimension) for name, dimension in declared.dimensions.items()]
        told = [((what, name), dimension) for name, pair in declared.conserved.items() for what, dimension in zip(("momentum", "casimir"), pair)]
        return units and replace(units, dimensions=(*named, *told))

    # What depends on values

    def check(self, spec: Spec) -> None:
        values = defaults(spec)
        found = list(checks.model_and_starts(spec, values))
        for trouble in found:
            self.report(trouble)
        for run in spec.runs:
            self.check_run(spec, run, values, {(t.path, t.code) for t in found})

    def check_run(self, spec: Spec, run, values: dict, known: set) -> None:
        """A run with its own values: the model and its start again, and the run itself."""
        values = with_values(spec, values, dict(run.parameters))
        again = [t for t in checks.model_and_starts(spec, values, (run.start,)) if (t.path, t.code) not in known] \
            if run.parameters else []
        for t in again:
            self.report(replace(t, path=("runs", run.name, "set"), cause=f"{t.cause} with these values", part=None))
        for trouble in checks.run(spec, run, values) if not again else ():
            if not (trouble.code == codes.METHOD and self.declared.hollow):     # a family with errors may fit
                self.report(trouble)

    def report(self, trouble) -> None:
        """Point at the value, or at the nearest table that holds it."""
        mark = self.nearest_mark(trouble.path)
        span = mark.value if mark else Span(0, 1)
        if mark and mark.text:
            span = self.problems.places.get((mark.text.whole, trouble.part), span)
        self.problems.note(trouble.code, span, trouble.cause, trouble.hint)

    def nearest_mark(self, path: tuple):
        """A start of the only family stands in [starts.name] itself."""
        if path[0] == "starts" and path[:3] not in self.marks:
            path = path[:2] + path[3:]
        while path and path not in self.marks:
            path = path[:-1]
        return self.marks.get(path)


def digest(sources) -> str:
    """sha256 of the spec's text and of the files it names, each with its name and length."""
    h = hashlib.sha256()
    for name, text in sources:
        data = text.encode("utf-8", "surrogatepass")
        h.update(f"{name}\0{len(data)}\0".encode() + data)
    return h.hexdigest()
