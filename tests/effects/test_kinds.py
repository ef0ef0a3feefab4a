"""The registry of kinds of effects: a kind that a file adds goes through all stages, which know none by name."""
from dataclasses import dataclass, replace

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.effects import kinds
from smidgen.effects.damping import Damping
from smidgen.effects.motion import Contribution, Response, family_of
from smidgen.errors import SpecError, UsageError
from smidgen.language.expr import Expr, Idx, Num, Op, with_index
from smidgen.language.spec import Effect, Sites

pytestmark = pytest.mark.quick

SPEC = """
[model]
name = "slowed"
[space]
w = {{ sphere = 3 }}
[parameters]
a = {{ default = [0.1, 0.2, 0.3], size = 3 }}
[effects.field]
over = "site(k) of w"
energy = "-w[k].z - dot(w[k], vec(0.3, 0, 0))^2"
[effects.slowing]
over = "site(k) of w"
{key} = "a[k]"{more}
[starts.s]
random = 1
[runs.r]
start = "s"
method = "spherical-midpoint"
h = 0.1
steps = 20
"""


class SlowingReader:
    def __init__(self, terms):
        self.terms = terms

    def read(self, node):
        node.table("over", "slowing", "meaning")
        over = self.terms.over(node, "slowing")
        return Slowing(self.terms.name(node, "effect", ()), over, self.terms.formulas.free(node.get("slowing"), "a slowing", over.index), self.terms.text(node, "meaning"))


@dataclass(frozen=True)
class Slowing(Effect):
    """Damping of Landau and Lifshitz on unit spheres, by another key."""
    name: str
    over: Sites
    rate: Expr
    meaning: str = ""

    told_by = keys = ("slowing",)
    reader = SlowingReader
    moves = False
    not_negative = {"slowing": "it takes energy"}
    gives_up = {"by": "slowed sites", "as": "sites are slowed", "symplectic": "slowed sites lose area", "energy": "slowed sites lose energy"}

    @property
    def formulas(self):
        return {"slowing": self.rate}

    @property
    def families(self):
        return {self.over.family}

    @property
    def damps(self):
        return (self.over.family,)

    @property
    def untitled(self):
        return replace(self, meaning="")

    def mapped(self, over, formula):
        return replace(self, over=over(self.over), rate=formula(self.rate))

    def contribution(self, spec, method):
        side = Op("if", (Op(">", (family_of(spec, self.over.family).kappa, Num(0))), Num(spec.orientation), Num(-spec.orientation)))
        rate = with_index(self.rate, self.over.index, Idx("i"))
        q = Op("*", (Num(1), Op("*", (side, Op("/", (rate, Num(1)))))))
        return Contribution(self.name, ((self.over.family, self.over.index),), self.over, conservative=False, response=Response(Num(1), q))


@pytest.fixture
def registry(monkeypatch):
    """All modules that hold the registry have the new kind too."""
    from smidgen.read import merge, terms
    for module in (kinds, merge, terms):
        monkeypatch.setattr(module, "KINDS", (*kinds.KINDS, Slowing) if module is kinds else kinds.KINDS)


def test_a_new_kind_is_a_class_and_its_place_in_the_registry(registry):
    """It is read, selected, checked, compiled and run; the C is that of the damping that it stands for, but for its name in the banner."""
    spec, damped = smidgen.load_text(SPEC.format(key="slowing", more="")), smidgen.load_text(SPEC.format(key="damping", more='\nform = "ll"'))
    assert [type(e) for e in spec.effects] == [kinds.Energy, Slowing] and spec.of(Slowing)[0].formulas.keys() == {"slowing"}
    one, other = (generate(select(replace(s, digest=""))) for s in (spec, damped))
    assert one["slowed.c"] == other["slowed.c"] and one["slowed.h"] != other["slowed.h"]
    a, b = (smidgen.build(s).start("s", h=0.1) for s in (spec, damped))
    a.steps(20), b.steps(20)
    assert np.array_equal(a.w, b.w) and not spec.conservative and spec.damped == ("w",)


def test_left_out_it_leaves_nothing(registry):
    spec = smidgen.load_text(SPEC.format(key="slowing", more=""))
    assert select(spec, ["field"]).parameters == () and "SMG_RESPONDS" not in generate(select(spec, ["field"]))["slowed.c"]
    with pytest.raises(UsageError, match="moves nothing.*field"):
        select(spec, ["slowing"])


def test_its_values_are_checked_where_it_says_so(registry):
    with pytest.raises(SpecError, match=r"the slowing of `w\[1\]` is -0.2"):
        smidgen.load_text(SPEC.format(key="slowing", more="").replace("0.2,", "-0.2,"))
    with pytest.raises(UsageError, match="the slowing of"):
        select(smidgen.load_text(SPEC.format(key="slowing", more="")), None, {"a": [1.0, -1.0, 1.0]})


def test_a_table_is_of_the_kind_whose_keys_it_has():
    assert kinds.kind_of(("over", "energy")) is kinds.Energy and kinds.kind_of(("kT",)) is Damping and kinds.kind_of(()) is kinds.Energy
    keys = [key for kind in kinds.KINDS for key in kind.keys]
    assert len(keys) == len(set(keys)) and all(set(kind.told_by) <= set(kind.keys) for kind in kinds.KINDS)
