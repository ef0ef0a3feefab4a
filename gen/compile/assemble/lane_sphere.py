"""A single sphere's kernels for several states at once, one a lane: those of solo.py for another printer, and their coefficients."""
from __future__ import annotations

from dataclasses import replace

from ..lower.code import Argument, Call, Component, Constant, Entry, Function, Held, Local, Member, Name, Parameter, Real, Struct, Unary, Variable, real_of, walk
from ..lower.integers import Whole
from .part import MOST_LANES, Part
from .solo import rows_kept

KINDS = {"smg_vec": "smg_lane_vec", "smg_slope": "smg_lane_slope", "smg_real": "smg_lanes", "const smg_coefficients *": "const smg_lane_coefficients *"}
IN_LANES = {f"smg_{name}": f"smg_lane_{name}" for name in (
    "vec", "slope", "motion", "radial", "derivative", "slope_times", "slope_minors", "slope_sums", "slope_trace", "abs", "vec_of", "vec_cross", "vec_scale")}
TO = Argument("smg_lane_coefficients *", "to")
ONE_STATE = Argument("const smg_coefficients *", "c")


def lane_sphere(model, low):
    """The definitions that the method's `lane_header` asks for, or None where the members of an ensemble step one by one: those at times of their
    own too, where what depends on time takes longer than all else."""
    own_times = model.method.controlled
    kernels = model.solo or ((model.motion,) if model.motion and not (own_times and low.is_timed()) else ())
    if not kernels or not model.method.lane_header or model.thermal or "extended" in model.features:
        return None
    read = coefficients_of(kernels)
    if read is None:
        return None
    struct = Struct("smg_lane_coefficients", tuple(read) or ("none",), target=TARGET)
    spread_too = () if own_times else (taken(read, "smg_lane_spread", (TO, ONE_STATE), spread),)
    return (struct, taken(read, "smg_lane_fill", (TO, Argument("int", "l"), ONE_STATE), fill), *spread_too, *map(in_lanes, kernels))


TARGET = "lanes by value"


def coefficients_of(kernels):
    """name -> leaf of the coefficients that differ between states; None where a kernel reads what has no place among them."""
    leaves = dict.fromkeys(leaf for f in kernels for node in walk(f) if isinstance(node, Real) for leaf in node.leaves.values())
    if not all(map(is_known, leaves)):
        return None
    return {named(leaf): leaf for leaf in leaves if isinstance(leaf, (Held, Parameter))}


def is_known(leaf) -> bool:
    """A component, a value under way, a constant, or a coefficient whose place is fixed."""
    if isinstance(leaf, (Parameter, Entry)):
        return leaf.place is None or isinstance(leaf.place, Whole)
    return isinstance(leaf, (Component, Local, Constant, Held))


def named(leaf) -> str:
    if isinstance(leaf, Held):
        return leaf.name
    return f"p_{leaf.name}" if leaf.place is None else f"p_{leaf.name}_{leaf.place.value}"


def taken(read: dict, name: str, arguments, statement) -> Function:
    return Function("void", name, arguments, tuple(statement(member, real_of(leaf)) for member, leaf in read.items()), wanted=True, inlined="lanes")


def fill(member: str, value: Real) -> Call:
    """Lane l of a coefficient, from one state."""
    return Call("smg_lane_set", (Unary("&", Member("to", member)), Name("l"), value))


def spread(member: str, value: Real) -> Call:
    """All of its lanes."""
    return Call("smg_lane_put_all", (Unary("&", Member("to", member)), value))


def in_lanes(d):
    """A kernel or the type of a slope for several states at once."""
    if isinstance(d, Struct):
        return replace(d, name=KINDS[d.name], target=TARGET)
    arguments = tuple(replace(a, kind=KINDS[a.kind]) for a in d.arguments)
    body = tuple(replace(s, kind=KINDS[s.kind]) if isinstance(s, Variable) else s for s in d.body)
    return replace(d, kind=KINDS[d.kind], name=IN_LANES[d.name], arguments=arguments, body=body, target=TARGET)


class MembersInLanes(Part):
    """Members of an ensemble of single spheres, one in each lane."""
    name, layout = "lane_sphere", "members"

    def made(self, model, low):
        return lane_sphere(model, low) if "ensemble" in model.features and not model.moving else None

    def functions(self, model):
        return [*model.lane_sphere]

    def headers(self, model):
        return ["smg_lane_vec.h"]

    def settings(self, model):
        return {"SMG_LANE_SPHERE": 1, **({"SMG_ROWS": rows_kept(model)} if model.solo else {})}

    def behind(self, model):
        return [model.method.lane_header]

    def most(self, model, step):
        """In lanes, then, where that does not settle, alone."""
        return step * 2

    def lanes(self, model):
        return MOST_LANES
