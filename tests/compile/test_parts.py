"""Parts: what a model has beside its terms and its solver comes from a list, and from nothing else."""
import re
from pathlib import Path

import pytest
from smidgen.compile.assemble import model as models
from smidgen.compile.assemble.part import Part, buffer
from smidgen.compile.assemble.parts import PARTS
from smidgen.compile.emit.emit import generate
from smidgen.compile.lower.code import Argument, Function, Name, Return
from support.systems import load

pytestmark = pytest.mark.quick
ROOT = Path(__file__).parents[2]
SHARED = ["gen/compile/assemble/functions.py", "gen/compile/assemble/buffers.py", "gen/compile/assemble/parameters.py"]


@pytest.mark.parametrize("path", SHARED)
def test_what_all_parts_share_knows_none_by_its_name(path):
    named = {part.name for part in PARTS}
    assert not [word for word in re.findall(r"model\.(\w+)", (ROOT / path).read_text()) if word in named]


def test_every_part_has_a_name_of_its_own():
    names = [part.name for part in PARTS]
    assert len(set(names)) == len(names) and all(type(part).__doc__ for part in PARTS)


class Stub(Part):
    """One of each thing that a part may add."""
    name = "stub"

    def made(self, model, low):
        return model.total if model.spec.name == "two_bodies" else None

    def functions(self, model):
        return [Function("int64_t", "smg_stub", (Argument("int64_t", "k"),), (Return(Name("k")),), wanted=True)]

    def headers(self, model):
        return ["smg_vec.h"]

    def settings(self, model):
        return {"SMG_STUB": 7}

    def buffers(self, model):
        return [buffer("stub", 2 * model.stub, "room of the stub")]

    def members(self, model):
        return [("int stub_count", "how often")]


def test_a_part_adds_what_it_says_where_the_model_has_it(monkeypatch):
    before = {name: generate(load(name)) for name in ("two_bodies", "free_rigid_body")}
    monkeypatch.setattr(models, "PARTS", (*PARTS, Stub()))
    assert generate(load("free_rigid_body")) == before["free_rigid_body"]
    source, header = (generate(load("two_bodies"))[f"two_bodies.{x}"] for x in "ch")
    assert {"#define SMG_STUB 7", '#include "smg_vec.h"'} <= set(source.splitlines()) and "smg_stub(int64_t k)" in source
    assert "smg_place_array(&s->stub, mem, used, " in source
    assert "  int stub_count; /* how often */" in header and "  smg_real *stub; /* room of the stub */" in header
