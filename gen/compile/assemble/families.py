"""The sites of the phase space as the contract of runtime/core/smg_model.h asks for them: numbers, strengths, leaves."""
from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp

from ...language.spec import Family
from ..derive.derivatives import scalar
from ..lower.code import Argument, Assign, Call, Element, Function, If, Let, Name, Ordered, Return, mentions
from ..lower.integers import ZERO, Index, Int, compare, total, whole
from ..lower.kernels import COEFFICIENTS
from ..lower.lowering import Kernel, index_names
from ..plan.held import there

ALWAYS = ("smg_kind", "smg_kappa", "smg_present", "smg_radius", "smg_normal")     # what runtime/core asks of every model
KINDS = {"sphere": "SMG_SPHERE", "r3": "SMG_R3", "nambu": "SMG_NAMBU"}
SITE = (COEFFICIENTS, Argument("int64_t", "k"))
V = {f"v0{axis}": Element("v", a) for a, axis in enumerate("xyz")}      # the vector in C(v), of numbers as the target has them


@dataclass(frozen=True)
class FamilyCode:
    """A family as the generated code has it: its size, its first site, its first row among the coupled ones (or among those
    that are alone), and its formulas of the local index i."""
    family: Family
    count: Int
    first: Int
    row: Int
    kappa: Kernel
    radius: Kernel | None
    normal: Kernel | None
    h_over_kappa: object
    there: Kernel

    @property
    def name(self):
        return self.family.name

    @property
    def kind(self):
        return self.family.kind

    @property
    def tracer(self):
        return self.family.tracer

    @property
    def unit(self) -> bool:
        """Spheres of radius 1?"""
        return self.kind == "sphere" and not self.radius.values and self.radius.results[0].is_number(1)


def family_codes(low, spec, coupled) -> tuple:
    """The families one after the other, with their numbers."""
    found, first, rows = [], [], {True: [], False: []}
    for f in spec.families:
        count, mine = low.size(f.count), rows[f.name in coupled]
        kappa = low.formula(f.kappa)
        radius = low.formula(f.radius) if f.kind == "sphere" else None
        normal = normal_kernel(low, f) if f.kind == "nambu" else None
        found.append(FamilyCode(f, count, total(*first), total(*mine), kappa, radius, normal, h_over(low, f), low.formula(there(spec, f))))
        first.append(count)
        mine.append(count)
    return tuple(found)


def normal_kernel(low, f) -> Kernel:
    """C v, the gradient of C(v) = v.C v/2: three sums over the non-zero entries of C."""
    values, leaves = [], {}
    for e in (e for row in f.casimir for e in row):
        value, more = scalar(e)
        values.append(value)
        leaves.update(more)
    v = sp.symbols(list(V), real=True)
    return low.kernel([sum(values[3 * r + k] * v[k] for k in range(3)) for r in range(3)], leaves, own=V)


def h_over(low, f):
    """h/kappa, as a product with a hoisted inverse where kappa is the same for all sites."""
    value, leaves = scalar(f.kappa)
    inverse = low.kernel([1 / value], leaves)
    if inverse.results[0].is_number(1):
        return Name("h")
    if inverse.values or index_names(f.kappa):
        return Ordered("/", Name("h"), Call("smg_kappa", (Name("c"), Name("k"))))
    return Ordered("*", Name("h"), inverse.results[0])


def returned(kernel: Kernel) -> tuple:
    return (*kernel.values, Return(kernel.results[0]))


# Functions of one site, by family

def by_family(kind: str, name: str, arguments, body_of, families, number: Int = Index("k"), first: str = "first", index: str = "i", **how) -> Function:
    """A function of a site `number` that does what `body_of(family)` says, in the local index of that name, which is the argument's where there is
    one family; a single text for all families alike."""
    bodies = [tuple(body_of(f)) for f in families]
    if len(set(bodies)) == 1 and index not in mentions(*bodies[0]):
        return Function(kind, name, arguments, bodies[0], **how)
    if len(families) == 1 and isinstance(number, Index) and number - getattr(families[0], first) == number and number.name not in mentions(*bodies[0]):
        return Function(kind, name, tuple(replace(a, name=index) if a.name == number.name else a for a in arguments), bodies[0], **how)
    whole_bodies = [(*local_index(body, index, number - getattr(f, first)), *body) for f, body in zip(families, bodies)]
    done = (Return(),) if kind == "void" else ()
    tested = [If((compare(number, "<", getattr(f, first) + f.count),), (*body, *done)) for f, body in zip(families[:-1], whole_bodies)]
    return Function(kind, name, arguments, (*tested, *whole_bodies[-1]), **how)


def local_index(body, index: str, number: Int) -> tuple:
    """The number within the family, where the body needs it."""
    return (Let(index, number),) if index in mentions(*body) else ()


def number_functions(model) -> list:
    """How sites are numbered: in all, among those that are solved together, among those alone, by family."""
    coupled, alone, lifted = model.coupled, model.alone, "tangent" in model.features
    every = Call("smg_sites", (Name("c"),))
    found = [size_function("smg_sites", model.total), family_end(model.families, every)]
    if coupled:
        found += [size_function("smg_coupled", every if coupled == list(model.families) else model.rows),
                  moved("smg_site", "row", coupled, "row", "first"), moved("smg_row", "k", coupled, "first", "row")]
    if alone and (not model.solo or lifted):
        found += [size_function("smg_alone", model.alone_rows), moved("smg_alone_site", "n", alone, "row", "first")]
    if alone and not model.solo:
        found.append(flag("smg_tracer", alone, lambda f: f.tracer))
    if len({model.closed_form(f) for f in alone}) == 2:     # sites alone of both kinds
        found.append(flag("smg_is_linear", alone, model.closed_form))
    return found


def size_function(name: str, n) -> Function:
    return Function("int64_t", name, (COEFFICIENTS,), (Return(n),), wanted=True)


def flag(name: str, families, holds) -> Function:
    return by_family("int", name, SITE, lambda f: (Return(whole(int(holds(f)))),), families, wanted=True)


def moved(name: str, number: str, families, start: str, to: str) -> Function:
    """The number counted from another beginning."""
    return by_family("int64_t", name, (COEFFICIENTS, Argument("int64_t", number)),
                     lambda f: (Return(getattr(f, to) + Index(number) - getattr(f, start)),), families, Index(number), start, wanted=True)


def family_end(families, every) -> Function:
    """The number of the site after the last of each family; every: how many sites there are."""
    ends = [*(f.first + f.count for f in families[:-1]), every]
    tests = [If((compare(Index("f"), "==", total(k)),), (Return(end),)) for k, end in enumerate(ends[:-1])]
    return Function("int64_t", "smg_family_end", (COEFFICIENTS, Argument("int", "f")), (*tests, Return(ends[-1])), wanted=True)


def site_functions(model) -> list:
    """Kind, strength, radius, normal of every site."""
    vector = (Argument("const smg_real *", "v"), Argument("smg_real *", "n"))
    functions = [("int", "smg_kind", SITE, lambda f: (Return(Name(KINDS[f.kind])),)),
                 ("smg_real", "smg_kappa", SITE, lambda f: returned(f.kappa)),
                 ("smg_real", "smg_h_over_kappa", (*SITE, Argument("smg_real", "h")), lambda f: (Return(f.h_over_kappa),)),
                 ("smg_real", "smg_present", SITE, lambda f: returned(f.there)),
                 ("smg_real", "smg_radius", SITE, lambda f: returned(f.radius) if f.radius else (Return(ZERO),)),
                 ("void", "smg_normal", (*SITE, *vector), lambda f: normal_body(f.normal))]
    needs = () if model.motion else model.method.needs      # whose field alone has the strength in it
    return [by_family(*f, model.families, wanted=f[1] in ALWAYS or f[1] in needs) for f in functions]


def normal_body(normal: Kernel | None) -> tuple:
    """n = grad C(v), or v itself."""
    if normal is None:
        return tuple(Assign(Element("n", a), Element("v", a)) for a in range(3))
    return (*normal.values, *(Assign(Element("n", a), value) for a, value in enumerate(normal.results)))
