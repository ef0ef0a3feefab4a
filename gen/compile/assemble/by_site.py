"""Why the steps of a lattice go site by site, and not by rows (rows.py): the first reason that is found, as a sentence goes on behind
"because"; None where there is none.
"""
from __future__ import annotations

import sympy as sp

from ...language.spec import Lattice, Sites
from ..derive.derivatives import is_real, power, switched
from ..derive.written import over
from ..lower.code import mentions
from ..lower.lowering import index_names
from .bond_values import bond_partings, unlike_bonds
from .common_cell import lattices
from .row_bounds import bends
from .site_values import differs, partings

BOUNDED_DOMAIN = sp.log, sp.tan, sp.asin, sp.acos       # not finite for all numbers


def of_lattices(model) -> str | None:
    """The bonds: "" where there are none of a lattice, and nobody asks."""
    found = {(over.size, over.sites) for over in lattices(model)}
    return "" if not found else "its bonds belong to several lattices" if len(found) > 1 else None


def of_space(model) -> str | None:
    """The families."""
    return next(filter(None, (of_family(model, f) for f in model.families)), None)


def of_family(model, f) -> str | None:
    if len(model.families) > 1 and (f.tracer or not model.lattices(f.name)):
        return f"`{f.name}` is a family of tracers" if f.tracer else f"`{f.name}` has no bonds of the lattice"
    if f.kind != "sphere":
        return f"`{f.name}` is not a family of spheres"
    unlike = "kappa" if model.method.splitting == "pairs" and unlike_in(model, "kappa", f) else "radius" if unlike_in(model, "radius", f) and not (model.method.of_midpoints or model.method.by_field) else ""
    return f"the {unlike} of `{f.name}` differs from " + ("site to site" if several(getattr(f.family, unlike), getattr(f, unlike)) else "that of another family") if unlike else None


def unlike_in(model, what: str, *families) -> bool:
    """May kappa, or the radius, differ from site to site, or from that of the first family? families: of some, of all where there are none."""
    first = getattr(model.families[0].family, what)
    return any(getattr(f.family, what) != first or several(getattr(f.family, what), getattr(f, what)) for f in families or model.families)


def several(formula, kernel) -> bool:
    """May it differ from site to site?"""
    return bool(index_names(formula) or kernel.values)


def of_laws(model) -> str | None:
    """What sites do beside precession."""
    effects = [c.name for c in model.contributions if c.response is not None or c.push or c.bends or c.moves is not None]
    if model.torques and not model.method.pushed_by_rows:
        return f"the torque `{model.torques[0].derived.term.name}` has no closed form"
    if model.responses and not model.method.responds_by_rows:
        return f"{model.method.title} has no step by rows with `{effects[0]}`"
    return None


def of_term(low, t) -> str | None:
    """A term of the energy: it is in one piece, smooth, and the same in every cell, or one of single sites or of bonds of two."""
    name = t.called
    if not isinstance(t.over, (Lattice, Sites)):
        return f"{name} is a sum neither over the sites nor over the bonds of the lattice"
    if switched(t.derived):
        return f"{name} has branches"
    if t.weights():
        return f"{name} names both the vector and the number of a bond"
    if t.derived.parts:
        return f"{name} is a long formula that is differentiated in parts"
    gradient = next(f for f in t.functions if f.name == f"{t.prefix}_gradient")
    if not differs(t) and not unlike_bonds(t) and set(t.over.bound) & mentions(*gradient.body):
        return f"{name} differs from bond to bond"
    return None


def of_radii(model, terms) -> str | None:
    """Where radii differ: bounds of a Hessian that is not the same at all states are those of one radius of each family."""
    curved = next(((f, t) for t in terms for f in model.families if f.name in [name for name, _ in t.slots] and several(f.family.radius, f.radius) and bends(t)), None)
    return f"the radius of `{curved[0].name}` differs from site to site, and the energy of {curved[1].called} is not quadratic" if curved else None


def of_absent(t) -> str | None:
    """A term on bonds of a lattice with absent sites, which stand there as 0: then others must feel nothing of it."""
    if isinstance(t.over, Lattice) and not set(t.over.indices) <= {index for _, index in t.slots}:
        return f"the formula of {t.called} does not name all spins of its bonds, but some sites are absent"
    for k, row in enumerate(t.derived.gradient):
        for q, vector in enumerate(t.derived.vectors):
            if q != k and any(sp.expand(sp.sympify(x).subs({v: 0 for v in vector})) != 0 for x in row):
                return f"the field of {t.called} does not vanish where one of its spins is 0, but some sites are absent"
    return None


def of_zeros(low, t, lacking) -> str | None:
    """The same: where vectors of such sites, and the numbers of terms with them, are 0, the field is finite."""
    gradient, values = partings(low, t) if differs(t) else bond_partings(low, t) if unlike_bonds(t) else ([low.number_values(x) for row in t.derived.gradient for x in row], {})
    formulas = [sp.sympify(x) for x in (*gradient, *map(low.number_values, (x for block in t.derived.hessian.values() for x in block)))]
    for (family, _), vector in zip(t.slots, t.derived.vectors):
        if family in lacking and any(may_be_infinite(e, dict.fromkeys((*vector, *values.values()), sp.S.Zero)) for e in formulas):
            return f"the field of {t.called} may be infinite where one of its spins is 0, but some sites are absent"
    return None


def may_be_infinite(e, zero: dict) -> bool:
    """May it be, or have no real value, where these symbols are 0? A part of it with another symbol may, and sums and products do not."""
    parts = [x for x in (1 / y.args[1] if isinstance(y, over) else y for y in e.atoms(sp.Pow, power, over, *BOUNDED_DOMAIN)) if x.free_symbols & set(zero) and not (isinstance(x, sp.Pow) and x.exp.is_Integer and x.exp > 0)]
    values = [sp.N(x.replace(power, sp.Pow).xreplace(zero)) for x in parts]
    return not all(x.is_number and is_real(x) for x in values)
