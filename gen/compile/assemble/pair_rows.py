"""Bonds of a lattice in lanes: what runtime/method/explicit/smg_pair_rows.h asks of a model."""
from __future__ import annotations

from dataclasses import replace

from ..lower.code import Argument, Call, Function, If, Name, Ordered, Return, Table
from ..lower.integers import ZERO, Index, compare, whole
from ..lower.kernels import COEFFICIENTS
from ..plan.splitting import bond_classes
from .lanes import named
from .pairs import PRODUCT
from .part import Part
from .rows import neighbours, seen

LANES = Argument("smg_lanes", PRODUCT.name)


def pair_row_functions(model) -> list:
    kernels = [slope_in_lanes(f) for f in model.pairs.values()]
    return [model.in_rows.slopes, *kernels, lane_slope(model), class_table(model)]


def pair_row_settings(model) -> dict:
    last = len(model.in_rows.over.size) - 1
    return {"SMG_ROW_CLASSES": len(bond_classes(model.spec)), "SMG_LAYERED": last if last > 1 else 0}


def slope_in_lanes(f: Function) -> Function:
    """f' of bonds in lanes; a number less zero has the bits of the number, and is lanes where f' is the same for all."""
    *values, last = f.body
    arguments = tuple(LANES if a.name == PRODUCT.name else a for a in f.arguments)
    value = Ordered("-", last.value, Call("smg_lane_of", (ZERO,)))
    return replace(f, kind="smg_lanes", name=named(f.name), arguments=arguments, body=(*values, Return(value)), target="lanes", inlined="always")


def lane_slope(model) -> Function:
    """That of the term-th effect of bonds."""
    *first, last = [Return(Call(named(f"{t.prefix}_slope"), (Name("c"), *[ZERO] * len(t.over.bound), Name(PRODUCT.name)))) for t in joint(model)]
    tests = [If((compare(Index("term"), "==", whole(k)),), (value,)) for k, value in enumerate(first)]
    return Function("smg_lanes", "smg_lane_bond_slope", (COEFFICIENTS, Argument("int64_t", "term"), LANES), (*tests, last), wanted=True, inlined="always")


def joint(model) -> list:
    return [t for t in model.energies if t.slots]


def class_table(model) -> Table:
    rows = tuple(class_row(model, one) for one in bond_classes(model.spec))
    return Table("smg_row_classes", "int64_t", rows, columns=len(rows[0]), wanted=True)


def class_row(model, one) -> tuple:
    """What SMG_CLASS_COLOUR, .. of smg_pair_rows.h name."""
    number, t = next((k, t) for k, t in enumerate(joint(model)) if t.derived.term.name == one.effect)
    (sub, _), (_, offset) = one.bond[one.first], one.bond[1 - one.first]
    there = neighbours(model, sub).index(seen(t, one.bond[one.first], one.bond[1 - one.first]))
    away = offset[-1] if len(offset) > 2 else 0
    return one.colour, model.in_rows.rank(sub), there, int(t.over.periodic[0]), away, number


class PairsByRows(Part):
    """The same by rows of a lattice, a class of bonds after the other."""
    name = "pair_rows"

    def made(self, model, low):
        return True if model.in_rows and model.pairs else None

    def functions(self, model):
        return pair_row_functions(model)

    def settings(self, model):
        return pair_row_settings(model)
