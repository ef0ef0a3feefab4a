"""Generated integrators in programs of others: the page docs/linking.md, and what it promises."""
import math
import re
import shutil
from pathlib import Path

import pytest
from support.pages import blocks, python, sh

import smidgen
from smidgen.cli import main

HERE = Path(__file__).parent
PAGE = "linking.md"
STRICT = ("-O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wconversion "
          "-Wdouble-promotion -Wvla -Werror").split()
COMPILERS = [("gcc", "g++"), pytest.param(("clang", "clang++"), marks=pytest.mark.long)]
MODELS = ("heisenberg_chain", "free_rigid_body")
OBJECTS = {}        # C compiler -> folder; test_stop.py has a fixture of its own of the same name, and the same objects


@pytest.fixture
def folder(tmp_path):
    """A folder with the two programs, where the page is read."""
    for program in ("chain.c", "tops.cpp"):
        shutil.copy(HERE / program, tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def amalgamated(tmp_path_factory):
    """The folder of `smidgen gen NAME --amalgamate` for both models."""
    place = tmp_path_factory.mktemp("amalgamated")
    for name in MODELS:
        assert main(["gen", name, "--amalgamate", "--out", str(place)]) == 0
    return place


@pytest.fixture(scope="session")
def objects(tmp_path_factory, amalgamated):
    """objects(C compiler): the folder of NAME.o for both models, compiled once, every warning of the optimiser an error."""
    def of(compiler):
        if compiler not in OBJECTS:
            place = tmp_path_factory.mktemp("objects")
            for name in MODELS:
                sh(f"{compiler} -std=c11 {' '.join(STRICT)} -c {amalgamated}/{name}.c -o {name}.o", place)
            OBJECTS[compiler] = place
        return OBJECTS[compiler]
    return of


@pytest.fixture
def both(folder, amalgamated):
    """The programs beside both models."""
    shutil.copytree(amalgamated, folder, dirs_exist_ok=True)
    return folder


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """What `smidgen build free_rigid_body --out here` has put in `here`."""
    place = tmp_path_factory.mktemp("library") / "here"
    assert main(["build", "free_rigid_body", "--out", str(place)]) == 0
    return place


@pytest.fixture(params=COMPILERS, ids=lambda pair: pair[0])
def compilers(request):
    """A C and a C++ compiler of one make."""
    if not all(map(shutil.which, request.param)):
        pytest.skip(f"{request.param[0]} is not installed")
    return request.param


def test_the_page_shows_the_program():
    assert blocks(PAGE, "c")[0] == (HERE / "chain.c").read_text()


def test_the_two_files_of_the_page(folder):
    said = sh(blocks(PAGE, "sh")[0], folder)
    assert said.endswith(blocks(PAGE, "output")[0])


@pytest.mark.long
def test_the_library_of_the_page(folder):
    said = sh(blocks(PAGE, "sh")[1], folder).splitlines()[-1]
    energy, spin = map(float, re.findall(r"-?\d+\.\d+e[+-]\d+", said))
    assert said.startswith("t = 1000") and abs(energy) < 1e-6 and abs(spin) < 1e-12


@pytest.mark.long
def test_the_tangent_map_of_the_page(folder):
    """The rate of an unstable axis, known in closed form, from the program."""
    shutil.copy(HERE / "growth.c", folder)
    commands = next(b for b in blocks(PAGE, "sh") if "growth" in b)
    rate = 20 * math.atanh(0.05 * math.sqrt((1 - 1 / 2) * (1 / 2 - 1 / 4)))
    assert sh(commands, folder).splitlines()[-1] == f"|v| grows like exp({rate:.6f} t)"


def test_the_library_may_be_moved(folder, library):
    shutil.copytree(library, folder / "there")
    said = sh("c++ -std=c++17 tops.cpp $(pkg-config --cflags --libs free_rigid_body) -o t; ./t",
              folder, PKG_CONFIG_PATH=str(folder / "there/lib/pkgconfig"))
    assert said == blocks(PAGE, "output")[0]


def test_pkg_config_knows_the_version(folder, library):
    env = {"PKG_CONFIG_PATH": str(library / "lib/pkgconfig")}
    assert sh("pkg-config --modversion free_rigid_body", folder, **env).strip() == smidgen.__version__
    sh("pkg-config --validate free_rigid_body", folder, **env)


def test_both_programs_with_the_amalgamated_files(both, compilers, objects):
    c, cpp = compilers
    folder = both
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        ["chain.c", "tops.cpp", *(f"{m}.{e}" for m in MODELS for e in "ch")])
    flags, made = " ".join(STRICT), objects(c)
    sh(f"{c} -std=c11 {flags} chain.c {made}/heisenberg_chain.o -lm -o chain; ./chain", folder)
    sh(f"{cpp} -std=c++17 {flags} tops.cpp {made}/free_rigid_body.o -lm -o tops", folder)
    assert sh("./tops", folder) == blocks(PAGE, "output")[0]


def test_a_program_begins_with_the_start_of_a_spec(both, objects):
    """The same end as with the formulas written in C, to the round-off of these."""
    reading = next(b for b in blocks(PAGE, "c") if "fread" in b and "int main" not in b)
    python(next(b for b in blocks(PAGE, "python") if "start.bin" in b), both)
    text = (both / "chain.c").read_text()
    assert text.count("  start(w);\n") == 1
    (both / "chain.c").write_text("#define start unused_start\n" + text.replace("  start(w);\n", "  (void)unused_start;\n" + reading))
    flags = f"gcc -std=c11 {' '.join(STRICT)} -I. {objects('gcc')}/heisenberg_chain.o"
    said = sh(f"{flags} chain.c -lm -o chain; ./chain", both)
    wanted = sh(f"{flags} {HERE / 'chain.c'} -lm -o formulas; ./formulas", both)
    assert said.split()[:3] == wanted.split()[:3] and said.split()[0] == "t"


def test_the_sources_are_cpp_too(folder, compilers):
    """Everything through the C++ compiler alone."""
    _, cpp = compilers
    assert main(["gen", "free_rigid_body", "--out", str(folder)]) == 0
    sh(f"{cpp} -std=c++17 {' '.join(STRICT)} tops.cpp -x c++ free_rigid_body.c -lm -o tops", folder)
    assert sh("./tops", folder) == blocks(PAGE, "output")[0]


def test_two_models_in_one_program(both):
    """Amalgamated files share nothing but the guarded runtime."""
    (both / "both.c").write_text(
        '#include "heisenberg_chain.h"\n#include "free_rigid_body.h"\n'
        "int main(void) { heisenberg_chain_params a; free_rigid_body_params b;\n"
        "heisenberg_chain_model c; free_rigid_body_model d;\n"
        "heisenberg_chain_defaults(&a); free_rigid_body_defaults(&b);\n"
        "if (heisenberg_chain_model_init(&c, &a) || free_rigid_body_model_init(&d, &b)) return 1;\n"
        "return heisenberg_chain_sites(&c) == 100 && free_rigid_body_sites(&d) == 1 ? 0 : 1; }\n")
    flags = " ".join(STRICT).replace("-O2", "-O0")
    sh(f"gcc -std=c11 {flags} both.c heisenberg_chain.c free_rigid_body.c -lm -o both; ./both", both)


def test_what_is_linked_is_no_driver(objects):
    """No allocation, no output, no exit: the object needs nothing but the C library's mathematics."""
    made = objects("gcc")
    wanted = {line.split()[-1] for line in sh("nm -u heisenberg_chain.o", made).splitlines()}
    allowed = {"sqrt", "fabs", "memcpy", "memset", "memmove", "_GLOBAL_OFFSET_TABLE_",
               "__stack_chk_fail", "fmax", "fmin", "copysign"}
    assert wanted <= allowed, wanted - allowed
    writable = [line for line in sh("nm heisenberg_chain.o", made).splitlines()
                if re.search(r" [bBdD] ", line)]
    assert writable == []


def test_the_steps_are_those_of_smidgen_run(both):
    """The linked program and the command give the same bits."""
    folder = both
    (folder / "bits.c").write_text(
        '#include "free_rigid_body.h"\n#include <stdio.h>\n'
        "int main(void) { free_rigid_body_params p; free_rigid_body_model model; free_rigid_body_state s; smg_real mem[4096];\n"
        "smg_real w[3]; free_rigid_body_defaults(&p);\n"
        "if (free_rigid_body_model_init(&model, &p)) return 1;\n"
        'for (int k = 0; k < 3; k++) if (scanf("%lf", &w[k]) != 1) return 2;\n'
        "if (free_rigid_body_memsize(&model) > sizeof mem) return 3;\n"
        "free_rigid_body_init(&s, &model, mem, w, 0, 0.125); free_rigid_body_steps(&s, 80);\n"
        'printf("%a %a %a\\n", s.w[0], s.w[1], s.w[2]); return 0; }\n')
    sh("gcc -std=c11 -O3 -ffp-contract=off bits.c free_rigid_body.c -lm -o bits", folder)
    from smidgen.read.shipped import load_spec
    result = smidgen.run(load_spec("free_rigid_body"), "demo", steps=80)
    first, last = result.w["w"][0, 0], result.final[0]
    said = sh(f"printf '{first[0]:.17g} {first[1]:.17g} {first[2]:.17g}' | ./bits", folder)
    assert said.split() == [float(x).hex() for x in last] or [
        float.fromhex(x) for x in said.split()] == last.tolist()
