"""Sums over the index families: every term once (scatter), or the terms of one site (gather)."""
from __future__ import annotations

from ..lower.code import Argument, At, Call, Function, Let, Member, Name, Unary, Zeros, mentions, tidy
from ..lower.integers import ZERO, Field
from ..lower.kernels import COEFFICIENTS
from .families import by_family

COORDINATES = ("sub", "s0", "s1", "s2", "s3")
STATE = (Argument("const smg_state *", "s"),)
W, G = Argument("const smg_real *", "w"), Argument("smg_real *", "g")
V, Y, D = Argument("const smg_real *", "v"), Argument("smg_real *", "y"), Argument("const smg_real *", "dm")
GATHERED = (COEFFICIENTS, Argument("smg_lattice_site", "at"), Argument("const smg_real *", "all"), Argument("const smg_real *", "own"))


def sums(model, terms, body_of) -> tuple:
    """All terms of some effects; body_of(term): statements, none where a term has nothing to say."""
    found = []
    for t in terms:
        body = tuple(body_of(t))
        found += model.loops.scatter(t.over, body) if body else ()
    return tidy(found)


# Bodies of one term

def gradient_body(model, t, vectors="w", out="g") -> tuple:
    unfelt = model.unfelt(t)
    if len(unfelt) == len(t.slots):
        return ()
    outputs = [Name(f"spare{k}") if k in unfelt else model.vector(out, s, True) for k, s in enumerate(t.slots)]
    return (*(Zeros(f"spare{k}", 3) for k in unfelt), t.call("gradient", [model.vector(vectors, s) for s in t.slots], *outputs))


def block_body(model, t) -> list:
    """The Hessian blocks for Newton's matrix, which asks for their products."""
    vectors = [model.vector(Member("s", "m"), s) for s in t.slots]
    return [Call("SMG_BLOCK", (model.site(t.slots[k]), model.site(t.slots[l]), t.call(f"hessian_{k}{l}", vectors, Name("direction"), Name("product"))))
            for k, l in t.derived.hessian]


# The contract: gradients, Hessian blocks and products over all sites

def sum_functions(model) -> list:
    every = sums(model, model.fields, lambda t: gradient_body(model, t))
    some = sums(model, model.coupled_effects(), lambda t: gradient_body(model, t))
    found = [sum_gradient("smg_gradient", every)]
    if model.plan.coupled:
        found.append(sum_gradient("smg_coupled_gradient", some if some != every else (Call("smg_gradient", (Name("c"), Name("w"), Name("g"))),)))
        found.append(over_state("smg_hessian_blocks", sums(model, model.coupled_effects(), lambda t: block_body(model, t))))
    if model.plan.coupled and not model.plan.matrix:
        found.append(over_state("smg_hessian_vector", sums(model, model.coupled_effects(), lambda t: hessian_vector_body(model, t))))
    return found


def hessian_vector_body(model, t) -> list:
    """The blocks that join two sites: s->hessian_v += B s->v."""
    vectors = [model.vector(Member("s", "m"), s) for s in t.slots]
    return [t.call(f"hessian_{k}{l}", vectors, model.vector(Member("s", "v"), t.slots[l]), model.vector(Member("s", "hessian_v"), t.slots[k], True))
            for k, l in t.derived.hessian if k != l]


def sum_gradient(name: str, body) -> Function:
    return Function("void", name, (COEFFICIENTS, W, G), body, wanted=True)


def over_state(name: str, body, arguments=STATE) -> Function:
    """A function of the state, with its coefficients at hand."""
    return Function("void", name, arguments, (*held(body, "c", "smg_coefficients"), *body), wanted=True)


def held(body, name: str, kind: str) -> tuple:
    """A pointer to the coefficients in the state, where the body reads them."""
    return (Let(name, Unary("&", Member("s", name)), f"const {kind} *"),) if name in mentions(*body) else ()


# The contract: one site

def swept_by_site(model) -> bool:
    """Do sweeps go from site to site, and not by rows?"""
    return model.plan.rotation and not (model.in_rows and model.method.of_midpoints)


def site_sums(model) -> list:
    """Gradient, Hessian and the pull of the neighbours of one site."""
    tangent = "tangent" in model.features and (model.plan.local or model.lifts())
    newton = any(not model.closed_form(f) for f in model.alone)
    found, lifted = [], tangent and model.lifts()
    if model.plan.local or swept_by_site(model):
        found.append(of_site(model, "smg_gather", (G,), gradient_calls, swept_by_site(model)))
    if newton or tangent:
        found.append(of_site(model, "smg_site_hessian_vector", (V, Y), own_hessian_calls, lifted))
    if tangent:
        found.append(of_site(model, "smg_bend", (D, Y), bend_calls, lifted))
    return found


def of_site(model, name: str, more, calls_of, coupled: bool) -> Function:
    """A function of sites that are solved alone, and of `coupled` ones where they too are asked one by one."""
    def body(f):
        found = gathered(model, f.name, calls_of)
        read = mentions(*found) if model.lattice(f.name) is not None else ()
        return (*(Let(x, Field("at", x)) for x in COORDINATES if x in read), *found)
    return by_family("void", name, (*GATHERED, *more), body, [f for f in model.families if f.name in model.plan.local or coupled], number=Field("at", "k"), index="site", wanted=True)


def gathered(model, family: str, calls_of, placed: bool | None = None) -> tuple:
    """Loops over the terms of one site, with the statements `calls_of(model, term, slot)` of each; placed: its cell is known (None:
    where the plan has it swept on a lattice)."""
    found, placed = [], model.lattice(family) is not None if placed is None else placed
    for t, k in model.roles(family):
        calls = tuple(calls_of(model, t, k))
        found += model.loops.gather(t.over, t.slots[k], calls, placed) if calls else ()
    return tidy(found)


def points(model, t, k) -> list:
    return [Name("own") if q == k else model.vector("all", s) for q, s in enumerate(t.slots)]


def gradient_calls(model, t, k):
    others = [q for q in range(len(t.slots)) if q != k]
    outputs = [own("g") if q == k else Name(f"o{q}") for q in range(len(t.slots))]
    return (*(Zeros(f"o{q}", 3) for q in others), t.call("gradient", points(model, t, k), *outputs))


def own_hessian_calls(model, t, k):
    return [t.call(f"hessian_{k}{k}", points(model, t, k), Name("v"), own("y"))] if (k, k) in t.derived.hessian else []


def bend_calls(model, t, k):
    return [t.call(f"hessian_{k}{l}", points(model, t, k), model.vector("dm", t.slots[l]), own("y"))
            for l in range(len(t.slots)) if l != k and (k, l) in t.derived.hessian]


def own(array: str) -> At:
    """The site's own vector, written."""
    return At(Name(array), ZERO, True)
