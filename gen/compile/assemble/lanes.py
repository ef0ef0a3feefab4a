"""Gradients of several states at once: the kernels of one state, and their sums, for the printer of lanes."""
from __future__ import annotations

from dataclasses import replace

from ..lower.code import Argument, Assign, Block, Call, For, Function, Member
from ..lower.integers import Index, Size, Whole
from .parameters import MODEL
from .part import Part
from .sums import gradient_body, sum_gradient, sums

FEW = 4      # sites of which a sweep gets a copy for their number, where that is known at run time alone
VECTORS = {"const smg_real *": "const smg_lanes *", "smg_real *": "smg_lanes *"}


def lane_functions(model) -> list:
    kernels = [in_lanes(f) for t in model.fields for f in t.functions if f.name == f"{t.prefix}_gradient"]
    body = sums(model, model.fields, lambda t: tuple(map(renamed, gradient_body(model, t))))
    if most_few(model):
        body = tuple(map(copied, body))
    return [*kernels, *assumed(model), in_lanes(sum_gradient("smg_lane_gradient", body), "smg_lane_gradient")]


def most_few(model) -> int:
    """The most sites of which a sweep has all in registers; 0 where there are more, or where their number is that of several families at run time."""
    return model.total.value if isinstance(model.total, Whole) and model.total.value <= FEW else FEW if isinstance(model.total, Size) else 0


def assumed(model) -> list:
    """A model of n sites, which the compiler may know."""
    if not isinstance(model.total, Size):
        return []
    return [Function("void", "smg_assume_sites", (MODEL, Argument("int64_t", "n")), (Assign(Member("model", model.total.name), Index("n")),), target="model", wanted=True)]


def copied(statement):
    """Loops with a copy of their body for each of few sites."""
    if not isinstance(statement, Block):
        return statement
    inner = replace(statement, body=tuple(map(copied, statement.body)))
    return replace(inner, few=True) if isinstance(inner, For) else inner


def in_lanes(f: Function, name: str = "") -> Function:
    """The same for vectors whose components are lanes."""
    arguments = tuple(replace(a, kind=VECTORS.get(a.kind, a.kind)) for a in f.arguments)
    return replace(f, name=name or named(f.name), arguments=arguments, target="lanes")


def renamed(statement):
    """A call of a kernel as one of its sibling in lanes."""
    return replace(statement, function=named(statement.function)) if isinstance(statement, Call) else statement


def named(kernel: str) -> str:
    return f"lane_{kernel}"


class GradientsInLanes(Part):
    """Gradients of several states at once, for the stages of Gauss collocation."""
    name = "lane_gradient"

    def made(self, model, low):
        """Where the method takes several gradients at once, and all states may share one time; where it goes by rows, it does not."""
        return True if model.in_rows is None and model.method.lanes > 1 and not low.is_timed() else None

    def functions(self, model):
        return lane_functions(model)

    def headers(self, model):
        return ["smg_lanes.h"]

    def settings(self, model):
        return {"SMG_FEW_STAGED": most_few(model), "SMG_ASSUMES_SITES": isinstance(model.total, Size)}

    def lanes(self, model):
        return model.method.lanes
