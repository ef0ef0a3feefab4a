"""Every C function around a model has its signature in one place, from which header, ABI and types for ctypes are made."""
import ctypes
import re
from pathlib import Path

import pytest
from smidgen.compile.emit import signatures
from smidgen.compile.emit.signatures import flat, of
from smidgen.run.step.library import TYPES, functions, type_of

from support.systems import load

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.quick


def test_templates_write_no_signature_out():
    """But of what there is for each effect and observable, and of what the ABI has for itself alone."""
    found = [line for path in sorted((ROOT / "templates").glob("*.j2")) for line in path.read_text().splitlines()
             if re.match(r"(?!static|return|\s)[\w *]+\{\{ M \}\}_\w+\(.*\)( \{.*|;)$", line)]
    assert found == []


def test_a_signature_is_printed():
    one = of("void *", "new", arrays="const double *const *", h="double", p="const {M}_params *")
    assert one.declared("top", "_abi_") == "void *top_abi_new(const double *const *arrays, double h, const top_params *p)"
    assert of("int", "lanes").declared("top") == "int top_lanes(void)"


def test_ctypes_knows_the_types_of_all():
    kinds = {kind for one in flat({part for parts in signatures.FLAT for part in parts}) for kind in (one.result, *(kind for _, kind in one.arguments))}
    assert {kind for kind in kinds if not kind.endswith("*")} <= TYPES.keys()
    assert (type_of("const smg_real *"), type_of("double"), type_of("void")) == (ctypes.c_void_p, ctypes.c_double, None)


def test_a_library_shows_what_is_listed():
    """One with all features has all functions but those of noise, one with noise has these, one without either those that are always there."""
    import smidgen
    spec = load("free_rigid_body")
    plain, all_ = smidgen.build(spec), smidgen.build(spec, features=("tangent", "ensemble"))
    assert set(vars(plain._c)) == {one.word for one in flat(())} and set(vars(all_._c)) == {one.word for one in flat(("tangent", "ensemble"))}
    warm = smidgen.load_text('[model]\nname = "warm"\n[space]\nw = { sphere = 1 }\n[effects.body]\nenergy = "w.x^2"\n'
                             '[effects.bath]\nover = "site(i) of w"\ndamping = 1\nkT = 1\n')
    heated = smidgen.build(warm, features=("ensemble",))
    assert set(vars(heated._c)) == {one.word for one in flat(("thermal", "ensemble"))}
    assert vars(functions(plain._library, plain.name)).keys() == vars(plain._c).keys()
    assert plain._c.report.argtypes == [ctypes.c_void_p] * 6 and plain._c.time.restype is ctypes.c_double
