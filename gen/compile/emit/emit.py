"""Emission: kernels and a plan -> the C files of a model, through the templates.

A model is the functions that runtime/core/smg_model.h asks for; the method and the solvers are headers of runtime/.
"""
from __future__ import annotations

from jinja2 import Environment, FunctionLoader, StrictUndefined

from ...methods import DEFAULT, METHODS
from ...errors import UsageError
from ...language.spec import Graph, Spec
from ...resources import folder
from ..features import chosen_features
from ..lower.cprint import number
from ..lower.indices import one_site, safe_indices
from ..lower.kernels import term_kernels
from ..lower.loops import Loops, graph_name
from ..lower.lowering import Lowering
from ..plan.plan import Plan, choose, require_free_body
from ..program import program_of
from .amalgamate import inline_runtime
from .bounds import BoundParts
from .families import FamilyParts
from .interface import InterfaceParts
from .memory import MemoryParts
from .settings import SettingParts
from .solo import SoloParts
from .statics import Static, needed_statics
from .sums import SumParts
from .sweeps import SweepParts
from .tables import graph_tables, pattern_tables
from .wide import WideParts


class Files(dict):
    """File name -> text. `notes`: what was chosen and why, for people."""
    notes: dict


def read_template(name: str) -> str:
    return (folder("templates") / name).read_text()


def environment() -> Environment:
    return Environment(loader=FunctionLoader(read_template), undefined=StrictUndefined,
                       keep_trailing_newline=True)


class Emitter(FamilyParts, SumParts, SweepParts, SoloParts, WideParts, MemoryParts, BoundParts, SettingParts, InterfaceParts):
    """Emission of one model with one method."""

    def __init__(self, spec: Spec, plan: Plan, features=()):
        self.features = chosen_features(features)
        self.spec = safe_indices(one_site(spec))
        self.method, self.plan = METHODS[plan.method], plan
        missing = [name for name in self.features if name not in self.method.features]
        if missing:
            raise UsageError(f"method {plan.method} has no feature '{missing[0]}'")
        if self.method.free_body:
            require_free_body(self.spec, plan.method)
        self.low = Lowering(self.spec)
        self.M = spec.name
        self.families = self.family_texts()
        self.by_name = {f.name: f for f in self.families}
        self.loops = Loops(self.low, lambda family: self.by_name[family].count)
        self.effects = [term_kernels(self.low, e, "effect") for e in self.spec.effects]
        self.observables = [term_kernels(self.low, o, "observe", False) for o in self.spec.observables]
        self.tracers = {f.name for f in self.spec.families if f.tracer}
        self.env = environment()
        self.solo = self.is_solo()

    def render(self, template: str, **slots) -> str:
        return self.env.get_template(template).render(M=self.M, **slots)

    def chosen(self, names):
        return [f for f in self.families if f.name in names]

    def tables(self):
        found = [Static(f"table_{name}", f"static const double table_{name}[] = {{{', '.join(number(x) for x in values)}}};")
                 for name, values in self.low.used_tables.items()]
        graphs = {graph_name(t.over): t.over for t in [*self.effects, *self.observables] if isinstance(t.over, Graph)}
        texts = [text for name, over in graphs.items() for text in graph_tables(name, over)]
        texts += pattern_tables(self.plan.pattern) if self.plan.solver == "sparse" else []
        return found + [Static(text.partition("[")[0].split()[-1], text, "smg_" in text) for text in texts]

    def kernels(self):
        return [Static(name, text) for k in [*self.effects, *self.observables] for name, text in k.text.items()]

    def model_functions(self):
        """All that the model offers, in an order in which each follows what it calls."""
        found = [*self.kernels(), *self.number_functions(), *self.site_functions(), *self.sum_functions(), *self.site_sums(), *self.visits(),
                 *(self.solo_kernels() if self.solo else []), *self.wide_functions()]
        self.low.close()    # what these have hoisted is computed by the coefficients
        return [*self.coefficient_functions(), *found]

    def source(self) -> str:
        functions = self.model_functions()
        interface = self.interface()
        kept = needed_statics([*self.tables(), *functions], interface)
        tables = [s.text for s in kept if s.text.startswith("static const")]
        return self.render("model.c.j2", tables=tables, functions=[s.text for s in kept if s.text not in tables],
                           settings=self.settings(), headers=self.headers(), method=self.method_header(), layout=self.layout(), interface=interface, **self.banner())


def generate(spec: Spec, method: str = DEFAULT, solver: str = "auto",
             amalgamate: bool = False, features=()) -> Files:
    """The C files of a model: {name}.h, {name}.c, {name}_abi.c; `.notes` says what was chosen.

    `amalgamate` puts the runtime into the two files that a program needs; features: names of
    `features.FEATURES`.
    """
    files = emitted(spec, choose(spec, method, solver), features)
    if amalgamate:
        files = inline_runtime(files, spec.name)
    return files


def generate_program(spec: Spec, method: str, solver: str, features=()) -> Files:
    """The same C for a caller that gives every value, as a library from the cache does: without `{name}_defaults`.

    It is one text for all values that lead to the same plan.
    """
    return emitted(program_of(spec), choose(spec, method, solver), features)


def emitted(spec: Spec, plan: Plan, features) -> Files:
    emitter = Emitter(spec, plan, features)
    source = emitter.source()
    name = spec.name
    files = Files({f"{name}.h": emitter.header(), f"{name}.c": source, f"{name}_abi.c": emitter.abi()})
    files.notes = {"method": plan.method, "solver": plan.solver, "reason": plan.reason,
                   "local": list(plan.local), "coupled": list(plan.coupled)}
    return files
