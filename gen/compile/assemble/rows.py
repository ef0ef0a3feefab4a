"""Rows of a lattice for vectors of lanes: where sites stand, and the gradient of some slots (runtime/lattice/smg_rows.h).

They serve families of spheres on one lattice, whose energy has terms that are the same in every cell, or differ by numbers that stand in arrays by slots; several families are places
of one cell (common_cell.py). They may depend on time where a bound is known that holds at all times: a state goes by
rows or it does not, whatever the time is.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product

from ...language.held import lacking
from ...language.spec import Lattice, Sites
from ...resources import runtime_numbers
from ..lower.code import Argument, Assign, Braces, Call, For, Function, If, Let, Name, Return, Scope, Variable, Zeros, where
from ..lower.integers import ZERO, Index, Pointed, compare, total, whole
from ..lower.kernels import COEFFICIENTS, field_kernels
from ..plan.colouring import Colouring, colouring, even, keeps_apart, kinds_of_rows, serves
from ..plan.contributions import fields_of, laws_of
from ..plan.splitting import bond_classes, sublattices
from .bond_values import Bonded, End, Role, bonded, number_functions, number_name, numbers_of, unlike_bonds
from .by_site import of_absent, of_lattices, of_laws, of_radii, of_space, of_term, of_zeros, unlike_in
from .common_cell import firsts, free, homes_of, in_cells, lattices, place_of, roles
from .families import SITE, by_family
from .lanes import in_lanes, named
from .norms import row_sums
from .pairs import slope_bound
from .row_bounds import bounds_of_terms
from .response import response_kernel
from .site_factors import factors, multiplied, radius_settings, radius_values, rate_function, rated
from .site_laws import differing, law_functions, law_settings, law_values
from .site_values import count, differs, names, sited, taken as taken_values, value_function, with_sites, zero_if_absent, zeros
from .same_bonds import energy_kernels
from .slots import Slots


@dataclass(frozen=True)
class Rows:
    """The lattice, its colouring, and bounds of a row, for each family: of the field of no spins; of the Hessian, at all times; and a bound of the slopes of bonds.

    sited: {prefix: `Sited`} of terms that differ from site to site, for which `rest` and `norm` leave room; whole: {prefix: the term in its
    place} of terms without absent sites, which stand there as 0; held: are there sites that do not move? rated: have sites strengths of their own? law: the kernel of the response of the others; differing: which of its numbers differ from site to site; radii: do radii? timely: do bounds hold at the time of a step alone?
    norms: what beside_norms.py has found; changes: what row_changes.py has, for the tangent map; meet: do bonds join sites of one colour?
    """
    over: Lattice
    colours: Colouring
    rest: object
    norm: object = None
    slopes: object = None
    sited: dict = field(default_factory=dict, compare=False)
    whole: dict = field(default_factory=dict, compare=False)
    held: bool = False
    rated: bool = False
    law: object = field(default=None, compare=False)
    differing: tuple = ()
    radii: bool = False
    norms: object = field(default=None, compare=False)
    timely: bool = False
    changes: dict = field(default_factory=dict, compare=False)
    meet: bool = False

    @property
    def step(self) -> int:
        """Sites of a colour follow each other along direction 0 at this distance."""
        return self.colours.step

    @property
    def ranks(self) -> int:
        """Places of a cell that a row of the lattice has in each colour."""
        return self.over.sites if self.step > 1 else self.over.sites // self.colours.colours

    def places(self, colour: int) -> list:
        return [sub for sub in range(self.over.sites) if self.step > 1 or self.colours.shift[sub] == colour]

    def rank(self, sub: int) -> int:
        return self.places(self.colours.shift[sub]).index(sub)


def rows(model, low):
    """`Rows`, or why they do not serve."""
    laws, over = laws_of(model.contributions), one_lattice(lattices(model))
    why_not = of_lattices(model)
    why_not = why_not if why_not is not None else of_space(model) or of_laws(model)
    if why_not is None and not (model.method.takes_fields or turned(model) or paired(model) or midpoint_rows(model)):
        why_not = f"{model.method.title} has no step by rows" + (f" with {' and '.join(model.features)}" if model.features else "")
    if why_not is not None:
        return why_not
    if paired(model):
        return pair_rows(model, low, over) or "the derivatives of its bond energies have no bound, or differ from bond to bond"
    return held_rows(rows_of(model, low, over, whole_terms(model, low), differing(model, laws)), model, low, next(iter(laws.values()), None))


def rows_of(model, low, over, some, laws):
    """The same, by the terms; some: {prefix: the term} of those that are others where some sites are absent; laws: which numbers of a response differ from site to site."""
    whole, bounded, rated, radii = in_cells(model, some, over), not model.method.takes_fields, unlike_in(model, "kappa"), unlike_in(model, "radius") and not model.method.by_field
    terms = [whole.get(t.prefix, t) for t in model.fields]
    why_not = next(filter(None, (of_term(low, t) for t in terms)), None) or next(filter(None, (t not in model.fields and of_absent(t) or of_zeros(low, t, lacking(model.whole)) for t in some.values())), None)
    if why_not:
        return why_not
    apart = [t for t in terms if differs(t)]
    joined = {t.prefix: roles_of(model, t, over.sites, whole) for t in terms if unlike_bonds(t)}
    first = firsts(model, [*((t, count(low, t)) for t in apart), *((t, numbers_of(low, t, joined[t.prefix])) for t in terms if t.prefix in joined)])
    why_not = of_radii(model, terms) if bounded else None
    if why_not:
        return why_not
    bounds, timely = bounds_of_terms(low, terms, radii_of(model), turned(model) or (model.method.midpoint and model.method.onto_leaf)) if bounded else ({(t.prefix, k): (None, None) for t in terms for k in range(len(t.slots))}, False)
    unbounded = next((t for t in terms for k in range(len(t.slots)) if bounded and None in bounds[t.prefix, k]), None)
    if unbounded:
        return f"the field of {unbounded.called} has no bound that holds at all times"
    colours = model.plan.colours or colouring(lattices(model))
    found = Rows(over, colours, *(alike(model, low, whole, bounds, which) if bounded else None for which in (0, 1)), whole=whole, rated=rated, differing=laws, radii=radii, timely=timely, meet=not keeps_apart(colours, lattices(model)))
    if not even(colours):
        return "its colours have different numbers of sites"
    if not fits(found, lattices(model)):
        return f"{longest(model)} reaches too far"
    alone = sited(low, apart, first, lambda t: homes_of(model, t), lambda t: bounds[t.prefix, 0])
    overs = {whole.get(t.prefix, t).prefix: t.over for t in model.fields}
    return replace(found, sited={**alone, **bonds_of_terms(model, low, [t for t in terms if t.prefix in joined], overs, joined, first, bounds)})


def radii_of(model) -> dict:
    """Of each family."""
    return {f.name: f.family.radius for f in model.families}


def roles_of(model, t, places: int, whole) -> tuple:
    """How the sites of each place feel a term on bonds that differ."""
    def of(sub):
        beside_it = neighbours(model, sub, whole)
        return tuple(role(model, t, k, bond, beside_it) for k in range(len(t.slots)) if k not in model.unfelt(t) for bond in bonds_of(t, k, sub))
    return tuple(map(of, range(places)))


def role(model, t, k: int, bond, beside_it: list) -> Role:
    slots, gone = [[index for _, index in t.slots].index(i) for i in t.over.indices], lacking(model.whole)
    ends = tuple(End(None if q == k else beside_it.index(beside(t, bond, k, q)), model.by_name[t.slots[q][0]].first, t.slots[q][0] in gone) for q in slots)
    number = number_name(t, t.over.bonds.index(bond)) if t.over.number else ""
    return Role(k, bond, ends, number, next(n for n, (_, offset) in enumerate(bond) if not any(offset)))


def bonds_of_terms(model, low, terms, overs, roles, first: dict, bounds) -> dict:
    """{prefix: `Bonded`}; overs: the bonds of each as families number their sites; first: the number of its first value."""
    found = {}
    for t in terms:
        numbers, place = number_functions(model.loops, t, overs[t.prefix]), place_of(model, t.over.sites)
        found[t.prefix] = bonded(low, t, first[t.prefix], homes_of(model, t), roles[t.prefix], place, lambda k: bounds[t.prefix, k], numbers)
    return found


def whole_terms(model, low) -> dict:
    """{prefix: the term as it is where all its sites are there}, of a lattice that lacks some; or as it is, with factors 0 and 1 among the numbers of its bonds, where others would feel the vector 0 of an absent site."""
    if not lacking(model.whole):
        return {}
    energies = energy_kernels(low, model.whole.energies, "row", model.method, like=model.spec.energies)[0]
    torques = [field_kernels(low, t, t.slots, field, "row") for t, field in fields_of(model.whole, model.contributions, model.method)]
    return {t.prefix: t if of_absent(one) and of_term(low, t) is None and unlike_bonds(t) else one for t, one in zip(model.fields, (*energies, *torques), strict=True)}


def held_rows(found, model, low, law):
    """With what is asked for where some sites do not move: which they are, and the law of the others."""
    return replace(found, held=True, law=response_kernel(low, law) if law and not found.differing else None) if isinstance(found, Rows) and model.moving else found


def one_lattice(overs):
    """The lattice that all bonds agree on, or None."""
    return overs[0] if len({(o.size, o.sites) for o in overs}) == 1 else None


def turned(model) -> bool:
    """Does an explicit method turn the sites of a colour in the field of the others?"""
    return model.method.splitting == "sublattices" and not model.features and sublattices(model.spec) is not None


def paired(model) -> bool:
    """Does an explicit method turn bonds, class after class of those of which no two meet?"""
    return model.method.splitting == "pairs" and not model.features and bool(bond_classes(model.spec))


def pair_rows(model, low, over):
    """Where all bonds have two ends, and slopes f'(w_i.w_j) that are the same in every cell and have a bound."""
    found = Rows(over, colouring(lattices(model)), None, slopes=slope_bound(model, low))
    same = found.colours == sublattices(model.spec).colours and all(len(t.over.indices) == 2 for t in model.energies if t.slots)
    return found if same and found.slopes is not None and fits(found, lattices(model)) else None


def midpoint_rows(model) -> bool:
    """May midpoints be swept by rows, under a bound that tells for which h sweeps converge?"""
    plan, method = model.plan, model.method
    swept = plan.rotation if method.onto_leaf else plan.auto and plan.solver != "dense" and not method.divided
    return (plan.auto and free(model) or swept and not plan.local) and "extended" not in model.features


def longest(model) -> str:
    """The term whose bonds reach farthest."""
    reaches = {t.called: max(sum(abs(a - b) for a, b in zip(one, other)) for bond in t.over.bonds for (_, one), (_, other) in product(bond, bond))
               for t, _ in roles(model) if isinstance(t.over, Lattice)}
    return max(reaches, key=reaches.get)


def kinds_size(model) -> int:
    """Numbers in memory of the table of what stands beside rows of each kind, where it is too large for the stack (SMG_MANY_KINDS); else 0."""
    entries = kinds_of_rows(model.in_rows.colours, lattices(model)) * besides(model)
    norms = model.in_rows.over.sites * (besides(model) + 1) if model.in_rows.norms is not None else 0
    return 5 * entries + norms if entries > runtime_numbers()["SMG_AT_HAND"][0] else 0


def fits(found: Rows, lattices) -> bool:
    """Rows of such colours, and bonds that begin in the cell of a member."""
    return serves(found.colours, lattices) and all(any(not any(offset) for _, offset in bond) for over in lattices for bond in over.bonds)


def alike(model, low, whole, bounds, which: int) -> tuple:
    """Of each family, the sum of a bound over the terms that all sites have alike."""
    def norm(t, k):
        t = whole.get(t.prefix, t)
        return 0 if differs(t) or unlike_bonds(t) else bounds[t.prefix, k][which]
    return tuple(row_sums(model, low, f, norm) for f in model.families)


# What the model says of them

def row_functions(model) -> list:
    """What runtime/lattice/smg_rows.h and smg_row_state.h ask of a model."""
    found = model.in_rows
    places = range(found.over.sites)
    size = [model.low.size(n) for n in found.over.size]
    apart = [f for one in found.sited.values() for f in one.functions]
    kernels = [replace(in_lanes(f), inlined="always") for t in row_terms(model) if t.prefix not in found.sited for f in t.functions if f.name == f"{t.prefix}_gradient"]
    gradient = [] if model.pairs else [*kernels, row_gradient(model)]
    return [*apart, *rate_function(found), *law_functions(found), *value_function(found.sited.values(), factors(found), law_values(found) + radius_values(found), zeros(found, number_of_values(found)) if lacking(model.whole) else ()), looked_up("smg_cells", (COEFFICIENTS, Argument("int", "d")), "d", size, whole(1)),
            looked_up("smg_shift", (Argument("int64_t", "sub"),), "sub", [total(found.colours.shift[k]) for k in places]),
            looked_up("smg_rank", (Argument("int64_t", "sub"),), "sub", [total(found.rank(k)) for k in places]),
            place_function(found), *bounds_of_a_row(model), offsets(model), *gradient]


def bounds_of_a_row(model) -> list:
    """Those that midpoints and turns ask for: of the field of no spins; of the Hessian, where sweeps from site to site have another one or none."""
    found = model.in_rows
    said = (("smg_rest_field_norm", found.rest, "rest"), ("smg_row_hessian_norm" if bounded_apart(model) else "smg_hessian_row_norm", found.norm, "norm"))

    def at_site(f, bounds, which):
        apart = [one.bound(getattr(one, which)) for one in found.sited.values() if getattr(one, which) and one.moves(f.name)]
        absent = zero_if_absent(Index("k")) if apart and f.name in lacking(model.whole) else ()
        return (*absent, Return(rated(found, with_sites(bounds[model.families.index(f)], apart))),)
    return [by_family("smg_real", name, SITE, lambda f, b=bounds, w=which: at_site(f, b, w), model.families, wanted=True)
            for name, bounds, which in said if bounds is not None and (name, bounds) != swept(model)]


def swept(model) -> tuple:
    """The bounds that sweeps from site to site have, at the time of their step."""
    return "smg_hessian_row_norm", tuple((model.reach or {}).get(f.name) for f in model.families)


def bounded_apart(model) -> bool:
    """Do those sweeps have others?"""
    return model.reach is not None and (model.in_rows.rated or model.in_rows.norm not in (None, swept(model)[1]))


def looked_up(name: str, arguments, index: str, values, beyond=None) -> Function:
    """The index-th of some integers."""
    *first, last = [*values, *([beyond] if beyond is not None else [])]
    tests = [If((compare(Index(index), "==", total(k)),), (Return(value),)) for k, value in enumerate(first) if value != last]
    return Function("int64_t", name, arguments, (*tests, Return(last)), wanted=True)


def place_function(found: Rows) -> Function:
    """The place with a rank in a colour."""
    arguments = (Argument("int64_t", "colour"), Argument("int64_t", "rank"))
    if found.step > 1:
        return Function("int64_t", "smg_place", arguments, (Return(Index("rank")),), wanted=True)
    tests = [If((compare(Index("colour"), "==", total(c)), compare(Index("rank"), "==", total(r))), (Return(total(sub)),))
             for c in range(found.colours.colours) for r, sub in enumerate(found.places(c))]
    return Function("int64_t", "smg_place", arguments, (*tests, Return(ZERO)), wanted=True)


def width(found: Rows) -> int:
    """Numbers that a site has of terms."""
    return max((one.first + one.width for one in found.sited.values()), default=0)


def number_of_values(found: Rows) -> int:
    """All that differ from site to site."""
    return width(found) + len(factors(found)) + len(found.differing) + found.radii


def row_settings(model) -> dict:
    """The macros of smg_rows.h."""
    found = model.in_rows
    weights = (*found.colours.weights, 0, 0, 0, 0)[:4]
    back = pow(weights[0], -1, found.colours.colours) if found.step > 1 else 0
    return {"SMG_ROW_STAGES" if model.method.stage_rows else "SMG_ROW_FIELDS" if model.method.by_field else "SMG_BY_ROWS": 1, **law_settings(found, number_of_values(found) - found.radii - len(found.differing)), **radius_settings(found, number_of_values(found) - 1), **({"SMG_ROWS_IN_TIME": 1} if found.timely else {}), **({"SMG_ROW_TURNS": 1} if turned(model) or model.pairs else {}), "SMG_TANGENT": int("tangent" in model.features), "SMG_ROW_HESSIAN": int(bounded_apart(model)), "SMG_SITE_VALUES": site_values(model), "SMG_BESIDE_NORMS": int(found.norms is not None), "SMG_COLOURS": found.colours.colours, "SMG_PLACES": found.over.sites, "SMG_RANKS": found.ranks,
            "SMG_COLOURS_MEET": int(found.meet), "SMG_ROW_STEP": found.step, "SMG_TURN_0": back, "SMG_RINGS": rings(model), "SMG_BLOCKS": int(in_blocks(model)), "SMG_OWN_FIELD": int(not all(model.is_linear(f.name) for f in model.families)), "SMG_BESIDES": besides(model),
            **{f"SMG_REACH_{d}": reach_of(model, d) for d in (1, 2, 3)}, **{f"SMG_WEIGHT_{d}": w for d, w in enumerate(weights)}}


def in_blocks(model) -> bool:
    """May the lattice stand in blocks? Where all bonds close around it, sites of a colour do not feel each other, and turn alone."""
    closed = all(closes for over in lattices(model) for closes in over.periodic)
    return closed and not model.in_rows.meet and not model.pairs and not model.method.takes_fields


# The gradient of some slots

SLOTS = (COEFFICIENTS, Argument("const smg_run *", "run"), Argument("int", "blocks"), Argument("const smg_real *", "all"), Argument("int64_t", "pitch"), Argument("int64_t", "j"), Argument("int64_t", "p"), Argument("smg_lanes *", "sum"))


@dataclass(frozen=True)
class Beside:
    """Sites at one distance from those of a row: their place, the offset of their cell, and which directions close (as bits)."""
    sub: int
    offset: tuple
    ring: int


def row_terms(model) -> list:
    """Those that move sites, as rows have them."""
    return [model.in_rows.whole.get(t.prefix, t) for t in model.fields]


def row_roles(model, whole=None) -> list:
    """The effects and slots through which a site feels something."""
    whole = model.in_rows.whole if whole is None else whole
    return [(whole.get(t.prefix, t), k) for t, k in roles(model)]


def neighbours(model, sub: int, whole=None) -> list:
    """What stands beside the sites of a place, each once."""
    found = [one for t, k in row_roles(model, whole) for bond in bonds_of(t, k, sub) for _, one in joined(t, bond, k)]
    return list(dict.fromkeys(found))


def offsets(model) -> Function:
    """beside = what stands beside the sites of a place; how many that are."""
    def body(sub: int):
        found = tuple(Braces((total(one.sub), Braces(tuple(map(total, one.offset))), total(one.ring))) for one in neighbours(model, sub))
        if not found:
            return (Return(ZERO),)
        copies = For("n", ZERO, whole(len(found)), (Assign(Name("beside[n]"), Name("all[n]")),), over="entries")
        return (Let("all[]", Braces(found), "const smg_offset"), copies, Return(whole(len(found))))
    *first, last = [body(sub) for sub in range(model.in_rows.over.sites)]
    tests = [If((compare(Index("sub"), "==", total(sub)),), lines) for sub, lines in enumerate(first)]
    return Function("int64_t", "smg_offsets", (Argument("int64_t", "sub"), Argument("smg_offset *", "beside")), (*tests, *last), wanted=True)


def by_place(model, body_of) -> tuple:
    """What is done in the rows of each place."""
    bodies, place = [body_of(sub) for sub in range(model.in_rows.over.sites)], Pointed("run", "sub")
    return bodies[0] if len(bodies) == 1 else tuple(If((compare(place, "==", total(sub)),), body) for sub, body in enumerate(bodies))


def row_gradient(model) -> Function:
    """sum += dH/dw of the slots of one vector of a run of rows: those from the j-th on, which is the p-th of its row."""
    return Function("void", "smg_slot_gradient", SLOTS, by_place(model, lambda sub: row_part(model, sub)), target="lanes", wanted=True, inlined="always")


def row_part(model, sub: int) -> tuple:
    """The terms of the sites of a place, times their factors."""
    return (*terms_of_place(model, sub), *multiplied(model.in_rows, width(model.in_rows)))


def terms_of_place(model, sub: int) -> tuple:
    """Neighbours that occur in several terms are loaded once, the others where their term needs them."""
    known, shared = neighbours(model, sub), shared_neighbours(model, sub)
    own = (Variable("smg_lanes", "own[3]"), Call("smg_take_slots", (*ALL, Pointed("run", "start") + Index("j"), Name("own"))))
    loads = (line for one in shared for n in (known.index(one),) for line in (Variable("smg_lanes", f"b{n}[3]"), taken(one, n, f"b{n}")))
    terms = ((t, k, bond) for t, k in row_roles(model) for bond in bonds_of(t, k, sub))
    return (*own, *loads, *(line for term in terms for line in one_term(model, *term, known, sub, shared)))


def shared_neighbours(model, sub: int) -> list:
    """The neighbours that all sites of a place have and that occur in several terms."""
    found = [one for t, k in row_roles(model) for bond in bonds_of(t, k, sub) for _, one in vectors_beside(t, bond, k)]
    return [one for one in dict.fromkeys(found) if not may_end(one) and found.count(one) > 1]


def one_term(model, t, k: int, bond, known: list, sub: int, shared=()) -> list:
    """Of a term that differs from site to site, with its values."""
    one = numbers_in(model, t, k, bond, sub)
    lines = term_of_row(t, k, bond, known, names(one) if one else (), shared)
    return lines if one is None else [Scope((*taken_values(one), *lines))]


def numbers_in(model, t, k: int, bond, sub: int):
    """The `Sited` of a term through a bond, None where it is the same everywhere."""
    one = model.in_rows.sited.get(t.prefix)
    return one.at(sub, k, bond) if isinstance(one, Bonded) else one


ALL = (Name("all"), Index("pitch"))


def bonds_of(t, k: int, sub: int) -> list:
    """The bonds through which a site of this place feels a term by slot k; of a term of single sites none, once."""
    if isinstance(t.over, Sites):
        return [None]
    position = t.over.indices.index(t.slots[k][1])
    return [bond for bond in t.over.bonds if bond[position][0] == sub]


def term_of_row(t, k: int, bond, known: list, values=(), shared=()) -> list:
    """The statements that add the gradient of one term; values: names of what differs from site to site;
    shared: neighbours that are loaded already."""
    found = vectors_beside(t, bond, k)
    at = {q: f"b{known.index(one)}" if one in shared else f"v{q}" for q, one in found} | {k: "own"}
    points = [Name(at[q]) for q in range(len(t.slots))]
    outputs = [Name("sum" if q == k else f"o{q}") for q in range(len(t.slots))]
    lines = [line for q, one in found for line in taken_neighbour(one, known.index(one), q, one in shared)]
    lines.append(Call(named(f"{t.prefix}_gradient"), (Name("c"), *[ZERO] * len(t.over.bound), *points, *outputs, *map(Name, values))))
    return where_there(joined(t, bond, k), known, lines)


def taken_neighbour(one: Beside, n: int, q: int, shared: bool) -> tuple:
    """Loads the neighbour in slot q of a term, unless it is loaded already, and declares its own gradient, which is not used."""
    rest = Zeros(f"o{q}", 3)
    return (rest,) if shared else (Variable("smg_lanes", f"v{q}[3]"), rest, taken(one, n, f"v{q}"))


def where_there(found, known: list, lines) -> list:
    """The statements of a term, where all that it joins is there."""
    there = tuple(Pointed("run", f"b[{known.index(one)}].there") for _, one in found if any(o and not one.ring >> d & 1 for d, o in enumerate(one.offset) if d))
    return [where(there, (*kept_beyond(found, known, lines),))] if found else lines


def kept_beyond(found, known: list, lines) -> list:
    """The same, but for sites whose neighbour is beyond an open end of the row."""
    ends = [known.index(one) for _, one in found if one.offset[0] and not one.ring & 1]
    before = Let("before[3]", Braces(tuple(Name(f"sum[{a}]") for a in range(3))), "const smg_lanes")
    return [before, *lines, *(Call("smg_only_within", (Name("run"), whole(n), Index("p"), Name("before"), Name("sum"))) for n in ends)] if ends else lines


def taken(one: Beside, n: int, v: str, all=ALL) -> Call:
    """v = the vectors there."""
    around = one.offset[0] != 0 and bool(one.ring & 1)
    return Call("smg_take_beside", (Name("run"), Name("blocks"), whole(n), whole(int(around)), Index("p"), *all, Index("j"), Name(v)))


def vectors_beside(t, bond, k: int) -> list:
    """The other slots of a term as slot k sees them: (slot, `Beside`)."""
    return [(q, beside(t, bond, k, q)) for q in range(len(t.slots)) if q != k]


def joined(t, bond, k: int) -> list:
    """Those, and as slot None the ends of the bond that the formula does not name: beyond an open end there is no bond."""
    unnamed = [] if bond is None else [seen(t, member(t, bond, k), end) for end, index in zip(bond, t.over.indices) if index not in [i for _, i in t.slots]]
    return [*vectors_beside(t, bond, k), *((None, one) for one in unnamed if may_end(one))]


def may_end(one: Beside) -> bool:
    """Are there sites that have none such beside them?"""
    return any(o and not one.ring >> d & 1 for d, o in enumerate(one.offset))


def member(t, bond, q: int) -> tuple:
    return bond[t.over.indices.index(t.slots[q][1])]


def beside(t, bond, k: int, q: int) -> Beside:
    """Slot q of a term as slot k sees it."""
    return seen(t, member(t, bond, k), member(t, bond, q))


def seen(t, this, other) -> Beside:
    """One end of a bond from another one."""
    (_, own), (sub, offset) = this, other
    ring = sum(1 << d for d, closes in enumerate(t.over.periodic) if closes)
    return Beside(sub, (*(b - a for a, b in zip(own, offset)), 0, 0, 0, 0)[:4], ring)


def rings(model) -> int:
    """The directions that close for some bond, as bits."""
    over = lattices(model)
    return sum(1 << d for d in range(len(over[0].size)) if any(one.periodic[d] for one in over))


def reach_of(model, d: int) -> int:
    """How far the farthest stands in direction d."""
    return max([abs(one.offset[d]) for sub in range(model.in_rows.over.sites) for one in neighbours(model, sub)], default=0)


def slots_of(model, value) -> Slots:
    return Slots(model.in_rows, lattices(model), model.low.size, value)


def site_values(model) -> int:
    """The numbers that stand in arrays by slots."""
    return number_of_values(model.in_rows)


def besides(model) -> int:
    """The most sites that stand beside one."""
    return max([1, *(len(neighbours(model, sub)) for sub in range(model.in_rows.over.sites))])
