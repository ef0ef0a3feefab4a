"""The plan of a step: which families are solved together, and by which solver.

A family whose sites feel only themselves (or, as tracers, only others) is `local`: each site is
solved alone. The rest is coupled: one Newton matrix of blocks, or sweeps without a matrix.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from ...methods import GRADIENT, HESSIAN, METHODS, SITE_GRADIENT, Method, others
from ...errors import UsageError
from ...language.counts import constant_integer, runtime_names
from ...language.expr import Time, walk
from ...language.spec import Graph, Lattice, Spec
from ...language.sublattice import together
from ...language.tracers import moves_tracers
from ..by_bond import by_bond
from .colouring import Colouring, field_colouring, row_colouring
from .contributions import all_offer, contributions_of, require, require_of_method, require_of_responses

DENSE_UNKNOWNS = 600       # a dense factorisation beyond this is dearer than sweeps
DENSE_SMALL = 24           # below this nothing beats a dense factorisation
BAND_LIMIT = 4             # widest block band
FILL_LIMIT = 400_000       # blocks of a sparse factorisation that still fit
TRIED = (12, 200)          # sweeps that are tried before a sparse factorisation, at least and at most
ASKS = {"local": (SITE_GRADIENT, HESSIAN), "newton": (GRADIENT, HESSIAN), "rotation": (GRADIENT, SITE_GRADIENT, HESSIAN),
        "plain": (GRADIENT, HESSIAN)}      # of every contribution; where sweeps do not settle, Newton takes Hessians
KINDS = {"sphere": "spheres", "r3": "factors R^3", "nambu": "Nambu factors"}


@dataclass(frozen=True)
class Plan:
    """method, the solver of the coupled part and what to say about it.

    local, coupled: family names, of midpoint methods; solver: 'local', 'dense', 'band', 'sparse', 'rotation', 'plain';
    band: width in sites; wrap: whether the band is cyclic; pattern: the sparse elimination;
    rotation: rotation sweeps, alone or tried before Newton; tried: how many of them, 0: as the runtime has it;
    lanes: fixed-point iteration in lanes is tried before dense Newton or sweeps, where the terms allow it;
    auto: was the solver left to the plan? coupling: what joins the sites, where Newton has a matrix; layout: one of `LAYOUTS` of layout.py;
    colours: for sweeps by rows of a lattice of these sizes.
    """
    method: str
    local: tuple
    coupled: tuple
    solver: str
    reason: str
    band: int = 0
    wrap: bool = False
    pattern: object = None
    rotation: bool = False
    tried: int = 0
    lanes: bool = False
    auto: bool = False
    coupling: str = "few sites"
    layout: str = "sites"
    colours: Colouring | None = None

    @property
    def block(self) -> int:
        """Unknowns per site: 2 in the tangent plane, 3 where the midpoint is not projected."""
        return METHODS[self.method].unknowns

    @property
    def matrix(self) -> bool:
        """Whether Newton's matrix is stored and factored; where not, GMRES takes its products with vectors."""
        return self.solver in ("dense", "band", "sparse")

    @property
    def swept(self) -> bool:
        """Whether sweeps (rotations, or the plain fixed point) are tried before Newton."""
        return bool(self.coupled) and (self.rotation or not self.matrix)

    def also(self, reason: str) -> Plan:
        """The same, of which more is said."""
        return replace(self, reason=f"{self.reason}; {reason}")


def coupled_families(spec: Spec, contributions=None) -> tuple:
    """Families with a term that joins several of their sites, and those whose midpoints move tracers."""
    tracers = {f.name for f in spec.families if f.tracer}
    coupled = set()
    for c in contributions_of(spec) if contributions is None else contributions:
        active = [s for s in c.slots if s[0] not in tracers]
        passive = [s for s in c.slots if s[0] in tracers]
        if len(passive) > 1:
            raise UsageError(f"effect '{c.name}' couples two tracers; tracers do not act on other sites")
        if passive or len(active) > 1 and not moves_tracers(c.over, c.slots, tracers):
            coupled.update(f for f, _ in active)
    return tuple(f.name for f in spec.families if f.name in coupled)


def site_count(spec: Spec, families) -> int:
    parameters = {p.name: p for p in spec.parameters}
    return sum(constant_integer(f.count, parameters) for f in spec.families if f.name in families)


def fixed_size(spec: Spec, families) -> bool:
    parameters = {p.name: p for p in spec.parameters}
    return not any(runtime_names(f.count, parameters) for f in spec.families if f.name in families)


def joint_overs(spec: Spec, contributions):
    """Index families of the contributions that join several sites, tracers left out."""
    tracers = {f.name for f in spec.families if f.tracer}
    return [c.over for c in contributions if len(c.slots) > 1 and not moves_tracers(c.over, c.slots, tracers)]


def reach(over) -> int:
    """How many sites apart the members of a one-dimensional bond are."""
    places = [[offset[0] * over.sites + sub for sub, offset in bond] for bond in over.bonds]
    return max(max(p) - min(p) for p in places)


def chain_band(overs, coupled) -> tuple:
    """(width, cyclic) when all coupling is along one-dimensional lattices of one family."""
    if len(coupled) != 1 or not overs or not all(isinstance(o, Lattice) and len(o.size) == 1 for o in overs):
        return 0, False
    return max(reach(o) for o in overs), any(o.periodic[0] for o in overs)


def choose(spec: Spec, method: str, solver: str, contributions=None) -> Plan:
    """The plan for a method and a requested solver ('auto', 'newton', 'rotation', 'plain'), from what methods ask and
    contributions offer (None: the effects of the spec)."""
    spec = by_bond(spec)
    contributions = contributions_of(spec, METHODS[method]) if contributions is None else contributions
    coupled = coupled_families(spec, contributions)
    local = tuple(f.name for f in spec.families if f.name not in coupled)
    check_space(spec, METHODS[method])
    require_of_method(contributions, METHODS[method])
    require_of_responses(spec, contributions, METHODS[method])
    if METHODS[method].splitting:
        from .splitting import require_splitting        # sympy is imported for those alone
        require_splitting(spec, METHODS[method])
    if not METHODS[method].of_midpoints:
        return Plan(method, (), (), *METHODS[method].how, colours=colours_of_rows(spec, METHODS[method], contributions))
    require([c for c in contributions if any(f in local for f, _ in c.slots)], ASKS["local"], "a site that is solved separately")
    if not coupled:
        return Plan(method, local, coupled, "local", "every site is solved separately, by Newton or in closed form", auto=solver == "auto")
    if solver not in METHODS[method].solvers:
        raise UsageError(f"method {method} has no solver '{solver}'; use {' or '.join(METHODS[method].solvers)}")
    return replace(swept_plan(spec, method, solver, local, coupled, contributions), colours=colours_of_rows(spec, METHODS[method], contributions))


def swept_plan(spec: Spec, method: str, solver: str, local, coupled, contributions) -> Plan:
    """Of a coupled part, by the solver that was asked for."""
    if solver in ("rotation", "plain"):
        require(contributions, ASKS[solver], f"solver {solver}")
        return Plan(method, local, coupled, solver, "as asked for", rotation=solver == "rotation")
    return replace(coupled_plan(spec, METHODS[method], solver, local, coupled, contributions), auto=solver == "auto")


def colours_of_rows(spec: Spec, method: Method, contributions):
    """On the lattice of all bonds, of these sizes; None where there is no such lattice, and of splittings, which are defined by the fewest colours."""
    names, parameters = [f.name for f in spec.families], {p.name: p for p in spec.parameters}
    overs = [together(c.over, names) for c in contributions if isinstance(c.over, Lattice)]
    if method.splitting or len({(o.size, o.sites) for o in overs}) != 1:
        return None
    if method.by_field:
        return field_colouring(overs)
    return row_colouring(overs, [constant_integer(n, parameters) for n in overs[0].size])


def coupled_plan(spec: Spec, method: Method, solver: str, local, coupled, contributions) -> Plan:
    """Newton where its factorisation fits, on chains and graphs after sweeps; else sweeps."""
    turns = "rotation" in method.solvers and all_offer(contributions, ASKS["rotation"])
    factored = all_offer(contributions, ASKS["newton"])
    plan = newton_plan(spec, method.name, local, coupled, joint_overs(spec, contributions)) if factored else None
    if plan is not None and plan.solver in ("band", "sparse") and solver == "auto" and method.onto_leaf and turns:
        return replace(plan, rotation=True, reason=f"{plan.coupling}: rotation sweeps while they converge fast, otherwise {plan.reason}")
    if plan is not None:
        return replace(plan, lanes=plan.solver == "dense" and solver == "auto" and method.onto_leaf, reason=f"{plan.coupling}: {plan.reason}")
    if solver == "newton":
        other = "rotation or plain" if turns else "plain"
        raise UsageError(f"solver newton supports chains with neighbours up to {BAND_LIMIT} sites away, graphs with "
                         f"a sparse factorisation, and models with few sites; use solver {other} here")
    lanes = solver == "auto" and method.onto_leaf
    if not turns:
        return Plan(method.name, local, coupled, "plain", lanes=lanes, reason="many sites that are not coupled as a chain: fixed-point iteration, then Newton with GMRES if it does not converge")
    return Plan(method.name, local, coupled, "rotation", lanes=lanes, reason=
                "many sites that are not coupled as a chain: rotation sweeps, one spin after the other, then Newton with GMRES if they do not converge", rotation=True)


def check_space(spec: Spec, method: Method) -> None:
    """Raises UsageError where a method does not serve a factor of the space."""
    strange = [f.name for f in spec.families if f.kind not in method.spaces]
    if strange:
        raise UsageError(f"method {method.name} does not support {KINDS[next(f.kind for f in spec.families if f.name == strange[0])]}, such as '{strange[0]}'; use {others(method.name)}")


def newton_plan(spec: Spec, method: str, local, coupled, overs):
    """Dense, band or sparse Newton, which its reason names; None when its factorisation would not fit."""
    n = site_count(spec, coupled)
    size = n * METHODS[method].unknowns
    width, wrap = chain_band(overs, coupled)
    small = size <= DENSE_SMALL
    if 0 < width <= BAND_LIMIT and n >= 2 * width + 1 and not (small and fixed_size(spec, coupled)):
        kind = "cyclic" if wrap else "open"
        return Plan(method, local, coupled, "band", f"Newton's method on a {kind} band of half-width {width}", coupling="chain",
                    band=width, wrap=wrap)
    if small:
        return Plan(method, local, coupled, "dense", "dense Newton")
    if any(isinstance(o, Graph) for o in overs) and len(coupled) == 1:
        plan = sparse_plan(method, local, coupled, n, overs)
        if plan is not None:
            return plan
    if size <= DENSE_UNKNOWNS and not any(isinstance(o, Lattice) for o in overs):
        return Plan(method, local, coupled, "dense", "dense Newton")
    return None


def sparse_plan(method, local, coupled, n, overs):
    """Newton with a compile-time elimination order, when the coupling is edges of fixed graphs."""
    from .ordering import TooMuchFill, symbolic
    if not all(isinstance(o, Graph) for o in overs):
        return None
    edges = joined(overs)
    try:
        pattern = symbolic(n, edges, limit=FILL_LIMIT)
    except TooMuchFill:
        return None
    blocks = pattern.blocks
    return Plan(method, local, coupled, "sparse", f"Newton on {blocks} blocks with fill", coupling="graph", pattern=pattern, tried=sweeps_tried(pattern, len(edges)))


def joined(overs):
    """The pairs of sites that the edges of some graphs join, each once, in order, as rows of an array."""
    import numpy as np                      # for those alone
    ends = np.sort(np.concatenate([o.ends for o in overs]), axis=1)
    high = 1 + int(ends.max(initial=0))
    keys = np.sort(ends[:, 0] * high + ends[:, 1])      # np.unique hashes first, which takes a hundred times as long
    keys = keys[np.diff(keys, prepend=-1) > 0]
    return np.stack([keys // high, keys % high], axis=1)


def sweeps_tried(pattern, edges: int) -> int:
    """Sweeps that cost as much as the three factorisations that Newton needs: 16 operations each of its products of blocks has, a spin in a field
    some hundred, an edge 30 from either end."""
    return min(max(3 * 16 * pattern.multiplications // (100 * pattern.size + 60 * edges), TRIED[0]), TRIED[1])


def require_free_body(spec: Spec, method: str) -> None:
    """A method of the free body needs one site alone, H a time-independent quadratic form."""
    from ..derive.derivatives import derive
    coupled = coupled_families(spec)
    if any(f.kind == "nambu" for f in spec.families):
        raise UsageError(f"method {method} needs a rigid body on a sphere or in R^3, not a Nambu factor")
    for effect in spec.energies:
        d = derive(effect)
        if coupled or any(isinstance(n, Time) for n in walk(effect.value)):
            raise UsageError(f"method {method} needs a single body whose energy does not depend on time")
        if d.parts:
            raise UsageError(f"method {method} needs a quadratic form in w, and the formula of '{effect.name}' is too long to be recognised as one; simplify it, or split it into several effects")
        for k, row in enumerate(d.gradient):
            for a in range(3):
                linear = sum(d.hessian[k, k][a, b] * d.vectors[k][b] for b in range(3)) if (k, k) in d.hessian else 0
                if (row[a] - linear).expand() != 0 or any(
                        v in d.hessian.get((k, k), row[a] * 0 + 0).free_symbols for v in d.vectors[k]):
                    raise UsageError(f"method {method} needs an energy that is a quadratic form in w")
