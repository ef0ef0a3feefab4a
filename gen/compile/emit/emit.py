"""Emission: a model as data -> its C files, by the printers and the templates.

A model is the functions that runtime/core/smg_model.h asks for; the method and the solvers are headers of runtime/.
"""
from __future__ import annotations

import functools
from dataclasses import asdict

from jinja2 import Environment, FunctionLoader, StrictUndefined

from ...language.spec import Spec
from ...methods import DEFAULT
from ...resources import folder
from ..assemble.buffers import layout
from ..assemble.effort import most
from ..assemble.functions import definitions
from ..assemble.model import Model
from ..assemble.plain import is_plain, own_settings
from ..lower.code import Table
from ..plan.layout import by_ranks, by_threads
from ..plan.plan import Plan, choose
from ..program import program_of
from .amalgamate import inline_runtime
from .interface import abi_slots, banner, header_slots, interface_slots
from .memory import array_bytes, model_bytes, state_bytes
from .signatures import heads
from .settings import headers, method_headers, most_lanes, settings, units
from .targets import printed


class Files(dict):
    """File name -> text. `notes`: what was chosen and why, for people; most: what a step takes at most, and the memory of a model and its states."""
    notes: dict
    most: dict


def read_template(name: str) -> str:
    return (folder("templates") / name).read_text()


@functools.cache
def environment() -> Environment:
    """The templates, compiled once in a process."""
    return Environment(loader=FunctionLoader(read_template), undefined=StrictUndefined,
                       keep_trailing_newline=True)


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


def emitted(spec: Spec, plan: Plan, features, contributions=None) -> Files:
    """contributions: what moves the sites, as the plan was made for; None: the effects of the spec."""
    model, M, templates = Model(spec, plan, features, contributions), spec.name, environment()

    def render(template: str, **slots) -> str:
        return templates.get_template(template).render(M=M, **heads(M), **slots)

    slots, step = header_slots(model), most(model)
    said, (kept, values) = banner(model), definitions(model)
    files = Files({f"{M}.h": render("model.h.j2", **slots, most=asdict(step), memory=array_bytes(model, {}), **said),
                   f"{M}.c": render("model.c.j2", **source_slots(model, kept), interface=render("interface.c.j2", **interface_slots(model, M, values)), **said),
                   f"{M}_abi.c": render("abi.c.j2", **abi_slots(model, M))})
    files.notes = {"method": plan.method, "solver": plan.solver, "reason": model.plan.reason + f"; site by site, because {model.by_site}" * bool(model.by_site),
                   "local": list(plan.local), "coupled": list(plan.coupled), "lanes": most_lanes(model) > 0, "units": units(model), "rows": model.plan.layout == "rows", "threads": by_threads(model.plan, model.method), "ranks": by_ranks(model.plan, model.method)}
    files.most = {**asdict(step), "model": model_bytes(slots), "state": state_bytes(slots),
                  "memory": array_bytes(model, {p.name: p.default for p in spec.parameters if p.kind == "int" and p.default is not None})}
    return files


def source_slots(model: Model, kept: list) -> dict:
    """Of model.c.j2; every definition is printed once."""
    functions = [printed(d) for d in kept if not isinstance(d, Table) and not is_plain(d)]
    return dict(tables=[printed(d) for d in kept if isinstance(d, Table)], functions=functions,
                settings=[*settings(model), *own_settings(kept)], headers=headers(model), types=[word for part in model.parts for word in part.types], method=method_headers(model), layout=printed(layout(model)))
