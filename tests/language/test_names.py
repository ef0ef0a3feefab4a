"""What a spec calls things may be a macro, a header or a function of C: the C that is generated has names of its own there."""
import re
import subprocess

import numpy as np
import pytest
import smidgen
from support.strict import COMPILERS, compile_all

from smidgen.build.binary import write_files
from smidgen.build.export import export_library
from smidgen.compile.emit.emit import generate
from smidgen.language.c_names import in_c, index_in_c
from smidgen.errors import SpecError, UsageError
from smidgen.read import names
from smidgen.resources import folder

LANGUAGES = {"gcc": ("c", "c11", "gnu11", "gnu17"), "clang": ("c", "c11", "gnu11", "gnu17"),
             "g++": ("c++", "c++17", "gnu++17", "gnu++20"), "clang++": ("c++", "c++17", "gnu++17", "gnu++20")}
INCLUDE = re.compile(r"^\s*#\s*include <([\w.]+)>", re.MULTILINE)


def headers_included() -> list:
    """The system headers that generated C and the runtime include."""
    texts = [p.read_text() for place in ("runtime", "templates") for p in folder(place).rglob("*.*") if p.suffix in (".h", ".j2")]
    return sorted({name for text in texts for name in INCLUDE.findall(text)})


def preprocessed(compiler, standard, *words) -> str:
    """The output of the preprocessor over those headers that there are."""
    source = "".join(f"#if __has_include(<{h}>)\n#include <{h}>\n#endif\n" for h in headers_included())
    return subprocess.run([compiler, "-x", LANGUAGES[compiler][0], f"-std={standard}", "-march=native", *words, "-"], input=source,
                          capture_output=True, text=True, check=True).stdout


def macros_of(compiler) -> set:
    return {line.split()[1].split("(")[0] for standard in LANGUAGES[compiler][1:]
            for line in preprocessed(compiler, standard, "-dM", "-E").splitlines() if line.startswith("#define")}


@pytest.fixture(scope="module")
def macros():
    return set().union(*map(macros_of, COMPILERS))


def usable(name) -> bool:
    """May it name a parameter?"""
    refused = names.FUNCTIONS | names.CONSTANTS | names.GRAMMAR | names.C_WORDS | names.PYTHON_WORDS | {"i"}
    return bool(names.IDENTIFIER.match(name)) and "__" not in name and name[-1] != "_" and len(name) <= 40 and name not in refused \
        and not name.lower().startswith("smg_")


def test_no_member_and_no_index_is_a_macro(macros):
    words = sorted(filter(usable, macros))
    assert {"float.h", "math.h", "stddef.h", "stdint.h", "stdlib.h"} <= set(headers_included()) and len(words) > 200
    assert {"FP_ZERO", "FLT_MAX", "INT64_MAX", "M_LN2"} <= set(words)
    assert not {in_c(w) for w in words} & macros and not {index_in_c(w) for w in words} & macros


def test_ordinary_names_stay():
    for name in ("n", "J", "K", "I1", "I2", "B", "Bz", "B_z", "J1", "gamma", "nx", "kappa0", "alpha_2", "omega", "D", "Kx", "e1"):
        assert in_c(name) == name
    assert [index_in_c(i) for i in ("i", "j", "k", "row")] == ["i", "j", "k_", "row_"]


def test_no_macro_begins_or_ends_as_our_functions_do(macros):
    """What joins a spec's name to words of ours: functions of effects and observables, tables, and all that a model declares."""
    header = generate(smidgen.load("heisenberg_chain"), features=("tangent", "ensemble", "extended"))
    ends = {word for text in header.values() for word in re.findall(r"\bheisenberg_chain(_\w+)", text)}
    starts = ("effect_", "observe_", "default_", "weight_", "table_", "graph_", "lane_", "wide_")
    assert {"_params", "_steps", "_init"} <= ends
    assert not [m for m in macros if m.startswith(starts) or m.endswith(tuple(ends)) and names.IDENTIFIER.match(m)]


SPEC = """[model]
name = "worded"
[space]
{family} = {{ sphere = "{size}" }}
[parameters]
{size} = 3
{parameters}
{effects}
[effects.joint]
over = "bond({first}, {second}) of chain({size}, periodic)"
energy = "dot({family}[{first}], {family}[{second}])"
{observables}
[starts.a]
theta = "1 + 0.3*i"
phi = "0.2*i"
"""


def worded(words) -> str:
    """A spec in which everything that may have a name of its own has one of these words: numbers, arrays, indices, effects, observables, a family."""
    family, size, first, second, *others = words
    arrays = set(others[::7])
    parameters = "\n".join(f'{w} = {{ default = {k + 1}.5, size = "{size}" }}' if w in arrays else f"{w} = {k + 1}.5" for k, w in enumerate(others))
    effect = '[effects.{0}]\nover = "site({1}) of {2}"\nenergy = "{3}*{2}[{1}].z^2"\n'
    effects = "".join(effect.format(w, first, family, f"{w}[{first}]" if w in arrays else w) for w in others[:60])
    observables = "".join(f'[observables.{w}]\nvalue = "{w}[0]*{family}[0].x"\n' if w in arrays else f'[observables.{w}]\nvalue = "{w}*{family}[0].x"\n'
                          for w in others[60:120])
    return SPEC.format(family=family, size=size, first=first, second=second, parameters=parameters, effects=effects, observables=observables)


def check_compiles(text, where, compilers=("gcc", "clang++")):
    files = generate(smidgen.load_text(text), features=("ensemble",))
    write_files(files, where)
    for compiler in compilers:
        _, *standards = LANGUAGES[compiler]
        said = compile_all(where, ["worded.c", "worded_abi.c"], compiler, f"-std={standards[1]}")
        assert not said, f"{compiler}:\n{said[:2000]}"


def test_a_spec_of_macros_is_compiled(macros, tmp_path):
    """Those that C has in its own headers, before what compilers add for a processor."""
    words = sorted(filter(usable, macros), key=lambda w: (not w.startswith(("FP_", "FLT_", "INT", "M_", "SNAN", "linux")), w))
    check_compiles(worded(words[:120]), tmp_path)


@pytest.mark.long
def test_specs_of_all_macros_are_compiled(macros, tmp_path):
    words = sorted(filter(usable, macros))
    for begin in range(0, len(words), 100):
        check_compiles(worded(words[begin:begin + 100] + words[:4 if begin + 4 > len(words) else 0]), tmp_path, COMPILERS)


OURS = ("c", "p", "k", "site", "row", "colour", "finite", "sum", "lost", "edge", "all", "own", "pitch", "sub", "s0", "c0", "b0", "v0x", "g1", "weight_J", "params", "mem")


@pytest.mark.parametrize("turn", [pytest.param(k, marks=pytest.mark.long if k else ()) for k in range(len(OURS))])
def test_names_of_the_generated_code_s_own_variables_are_compiled(turn, tmp_path):
    check_compiles(worded([*OURS[turn:], *OURS[:turn]]), tmp_path)


def test_in_python_a_name_is_that_of_the_spec():
    """The same bits as with other names; values, observables and messages by the names of the spec."""
    plain = ["w", "n", "i", "j", *(f"x{k}" for k in range(12))]
    macro = ["INT8_MAX", "INT64_MAX", "FLT_MAX", "FP_ZERO", *(f"M_X{k}" for k in range(12))]
    states = []
    for words in (plain, macro):
        model = smidgen.build(smidgen.load_text(worded(words)), parameters={words[1]: 5, words[5]: 0.7})
        states.append(model.start("a", h=0.002).steps(20).w.copy())
        with pytest.raises(UsageError, match=words[6]):
            smidgen.build(smidgen.load_text(worded(words)), parameters={words[6]: "none"}).start("a", h=0.1)
    assert states[0].shape == (5, 3) and np.array_equal(states[0], states[1])


# -- models ---------------------------------------------------------------------------------------------

def model_named(name):
    return smidgen.load_text(f'[model]\nname = "{name}"\n[space]\nw = {{ sphere = 1 }}\n[effects.e]\nenergy = "w.z"\n')


@pytest.mark.parametrize("name", ["smidgen", "SMIDGEN", "math", "stdint", "stddef", "features", "Float", "omp", "smg", "sem", "pthread_mutex"])
def test_a_model_named_like_a_header_or_a_function_is_refused(name):
    with pytest.raises(SpecError, match="E207.*(header|functions)"):
        model_named(name)
    assert model_named(f"my_{name}").name == f"my_{name}"


def test_every_header_that_is_read_is_a_name_no_model_has():
    """What the compilers read for generated C, as far as `#include <name.h>` could find a model's file."""
    read = {path for compiler in COMPILERS for path in preprocessed(compiler, LANGUAGES[compiler][2], "-M").replace("\\\n", " ").split() if path.endswith(".h")}
    named = {path.rsplit("/", 1)[1].removesuffix(".h") for path in read if re.search(r"/include(/[a-z0-9_]+-linux-[a-z]+)?/[^/]+$", path)}
    assert len(named) > 5
    assert {name for name in named if names.IDENTIFIER.match(name) and "__" not in name} <= names.HEADERS


def test_no_function_of_a_model_is_one_of_the_c_library(tmp_path):
    """mtx_init, sem_init, ..: a program that links such a model would call it where it means the library's."""
    said = [subprocess.run(["nm", "-D", subprocess.run(["gcc", f"-print-file-name={name}"], capture_output=True, text=True).stdout.strip()],
                           capture_output=True, text=True, check=True).stdout for name in ("libc.so.6", "libm.so.6")]
    symbols = {line.split()[-1].split("@")[0] for text in said for line in text.splitlines()}
    ends = sorted({m for m in re.findall(r"\bplain(_\w+)\(", generate(model_named("plain"), features=("tangent", "ensemble"))["plain.h"])})
    clashes = {s.removesuffix(end) for s in symbols for end in ends if s.endswith(end)}
    clashes = {name for name in clashes if names.IDENTIFIER.match(name) and "__" not in name}
    assert "sem" in clashes and "_init" in ends
    for name in clashes:
        with pytest.raises(SpecError, match="E207"):
            model_named(name)


def test_a_library_is_not_named_like_one_of_the_system(tmp_path):
    with pytest.raises(UsageError, match="libm.a"):
        export_library(model_named("m"), tmp_path, "spherical-midpoint", "auto")
