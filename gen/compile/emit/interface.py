"""The interface: parameters, header, flat functions for ctypes; what the templates are filled with."""
from __future__ import annotations

from ...version import __version__ as VERSION
from ..assemble.buffers import buffers, keeps_history
from ..assemble.model import Model
from ..assemble.parameters import run_time
from ..lower.code import mentions
from ...language.c_names import in_c
from ...language.units import ENERGY, FIELD, LENGTH, TIME, quotient
from .formulas import number
from .print_scalar import indent
from .signatures import flat
from .targets import PRINTERS
from .text import comment


SLOTS = ("structs", "between", "public", "bodies", "flat")


def interface_slots(model: Model, M: str, sums: list) -> dict:
    """Of interface.c.j2; sums: `value_sums`, without arguments that nothing reads."""
    values = [value_slots(*one) for one in sums]
    energy = " + ".join(f"{M}_energy_{name}(model, t, w)" for name in model.sums)
    return dict(divided=any(part.divides for part in model.parts), defaults=defaults(model), values=values, energy_sum=energy or "0", **shell(model))


def value_slots(kind: str, name: str, body) -> dict:
    """Of one function that adds up the values of a term; coefficients: does it read them?"""
    known = mentions(*body)
    unused = [*(() if "c" in known else ("model", "t")), *(() if "w" in known else ("w",))]
    return dict(function=f"{kind}_{name}", sums="\n".join(indent(PRINTERS["scalar"].lines(body))), unused=unused, coefficients="c" in known)


def shell(model: Model) -> dict:
    """What the parts of a model add to the templates: slot -> files; has: their names."""
    found = {slot: [part.templates[slot] for part in model.parts if slot in part.templates] for slot in SLOTS}
    return {**found, "has": {part.name for part in model.parts}}


def defaults(model: Model):
    """Statements of `_defaults`; None where the caller gives all values."""
    if any(p.default is None for p in run_time(model.spec)):
        return None
    lines = []
    for p in run_time(model.spec):
        if p.kind == "array":
            values = ", ".join(number(x) for x in p.default)
            lines.append(f"static const double default_{p.name}[] = {{{values}}};")
            lines.append(f"p->{in_c(p.name)} = default_{p.name};")
        else:
            lines.append(f"p->{in_c(p.name)} = {int(p.default) if p.kind == 'int' else number(p.default)};")
    return lines


def header_slots(model: Model) -> dict:
    """Of model.h.j2."""
    return dict(
        params=[declare(p) for p in run_time(model.spec)], arrays=buffers(model), H=model.history, keeps_history=keeps_history(model), composed=model.method.stages > 1,
        held=[member for part in model.parts for member in part.held(model)],
        members=[member for part in model.parts for member in part.members(model)],
        first=[member for part in model.parts for member in part.first_members(model)], included=[name for part in model.parts for name in part.included(model)],
        integer_names=[name for name, _ in model.coefficients.sizes], effects=list(model.sums),
        model_names=model.coefficients.of_model, state_names=model.coefficients.of_state, observables=[o.name for o in model.spec.observables],
        **{slot: value for part in model.parts for slot, value in part.slots(model).items()})


def declare(p) -> dict:
    kind = {"int": "int64_t ", "real": "double ", "array": "const double *"}[p.kind]
    note = ", ".join(x for x in (p.meaning, p.unit and f"[{p.unit}]") if x)
    return dict(declaration=kind + in_c(p.name), comment=f"/* {comment(note)} */" if note else "")


def banner(model: Model) -> dict:
    """What the comments at the head of the files say."""
    spec, plan = model.spec, model.plan
    counts = [f"{t.derived.term.name} {t.operations[1]}" for t in model.fields]
    return dict(
        title=comment(spec.title or spec.name), version=VERSION, digest=spec.digest[:16] or "(no file)",
        method_text=model.method.summary + not_symplectic(model), solver_text=comment(f"{plan.solver}: {plan.reason}"),
        bracket_text=f"{'' if spec.orientation > 0 else 'minus '}w x (1/kappa) dH/dw" + "".join(comment(e.note) for e in spec.effects),
        units_text=[comment(line) for line in units_lines(spec)],
        effects_text=comment(", ".join(model.effects) or "none"),
        **shell(model),
        operations_text=comment("gradient of one term: " + ", ".join(counts)),
        families_text=comment(", ".join(f.name for f in model.families)),
        family_names=comment(", ".join(f.name for f in model.families)))


def units_lines(spec) -> list[str]:
    """In which units arguments and values are: those of parameters stand beside them."""
    if spec.units is None:
        return []
    units, told = spec.units, spec.units.spelt
    families = [f"{f.name} in {told(units.of('name', f.name))}, its kappa in {told(quotient(units.of('momentum', f.name), units.of('name', f.name)))}, its momentum in "
                f"{told(units.of('momentum', f.name))}, its Casimirs in {told(units.of('casimir', f.name))}" for f in spec.families]
    observables = [f"{o.name} in {o.unit}" for o in spec.observables]
    sizes = ", ".join(f"{told(one)} = {float(units.size(one)):.10g} {si}" for one, si in ((ENERGY, "J"), (TIME, "s"), (LENGTH, "m"), (FIELD, "T")))
    return [f"Units: t and h in {told(TIME)}, energies in {told(ENERGY)}; {'; '.join([*families, *observables])}.", f"Sizes of units by CODATA {units.codata}: {sizes}."]


def not_symplectic(model: Model) -> str:
    """What is given up of a symplectic method."""
    why = model.spec.given_up("by", "damped sites")
    return f"; not symplectic in this model, because of {why}" * (not model.spec.conservative and model.method.symplectic)


def abi_slots(model: Model, M: str) -> dict:
    """Of abi.c.j2."""
    scalars = [p for p in run_time(model.spec) if p.kind != "array"]
    arrays = [p for p in run_time(model.spec) if p.kind == "array"]
    lines = [f"p.{in_c(p.name)} = {'(int64_t)' if p.kind == 'int' else ''}scalars[{k}];"
             for k, p in enumerate(scalars)]
    lines += [f"p.{in_c(p.name)} = arrays[{k}];" for k, p in enumerate(arrays)]
    effects, observables = list(model.sums), [o.name for o in model.spec.observables]
    return dict(assignments=lines, scalars=len(scalars), arrays=len(arrays), prototypes=[one.declared(M, "_abi_") for one in flat(shell(model)["has"])], **shell(model),
                effects=effects, observables=observables, families=model.families,
                columns=1 + len(effects) + 3 * len(model.families) + len(observables))
