"""Generated C is C11 and C++17 without a warning, and clean under the sanitizers."""
import re
import subprocess
import sys

import pytest
from support import texts
from support.strict import COMPILERS, REALS, WARNINGS, compile_all, driver, run_sanitized
from support.systems import (CLASSICAL, FREE_BODIES, SCENES, SPECS, SPHERICAL, VESELOV, begin, load,
                             model, tiers)

from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.methods import SOLVERS
from smidgen.compile.lower.code import Call, Function, Return, needed
from smidgen.compile.lower.integers import ONE, ZERO
from smidgen.resources import include_flags
from smidgen.compile.select import select
from smidgen.run.step.evaluated import parameter_values

TEXTS = {"mixed": texts.MIXED, "pulse": texts.PULSE, "corners": texts.CORNERS, "field": texts.FIELD,
         "glass": texts.GLASS, "open": texts.OPEN_CHAIN}
CLEAN = {SPHERICAL: ("forced_rigid_body", "product", "heisenberg_chain", "cubic_lattice", "vortex_tracers"), CLASSICAL: ("nambu_a34",)}      # compiled in `make test`; the others in `make test-long`
SOLVED = (("heisenberg_chain", "rotation"), ("product", "newton"))     # likewise
COUPLED = ("heisenberg_chain", "j1j2_chain", "cubic_lattice", "honeycomb", "point_vortices",
           "vortex_tracers", "two_bodies", "product")


def written(where, spec, method, solver="auto"):
    """The files of a model in `where`; the names of its sources."""
    files = generate(select(spec), method=method, solver=solver)
    write_files(files, where)
    return sorted(name for name in files if name.endswith(".c"))


def refuses(spec, method, solver):
    """Combinations that do not exist: each must be refused in a sentence."""
    if method == VESELOV:
        return spec.name not in FREE_BODIES
    if solver == "newton":
        return spec.name in ("cubic_lattice", "honeycomb")
    return solver == "rotation" and method != SPHERICAL


def check_combination(where, spec, method, solver):
    """Clean C, or a refusal in a sentence where there is no such combination."""
    if refuses(spec, method, solver):
        with pytest.raises(UsageError):
            generate(select(spec), method=method, solver=solver)
    else:
        check_clean(where, written(where, spec, method, solver))


ALL = [(compiler, real) for real in REALS for compiler in COMPILERS]
BOTH = ("gcc", "clang++")       # languages and makers
FEW = [(compiler, real) for compiler, real in ALL if compiler in BOTH]


@pytest.fixture(autouse=True)
def few_pairs(request, monkeypatch):
    """Outside the long tier two compilers look, one of each maker and language; all four at plain doubles of the spec that has the most kinds of terms."""
    if not request.node.get_closest_marker("long"):
        monkeypatch.setattr(sys.modules[__name__], "ALL", [p for p in ALL if p in FEW or (p[1] == "double" and "corners" in request.node.name)])


def check_clean(where, sources):
    """Every compiler, both precisions; gcc with its optimiser as well, since some of its warnings need the flow of data."""
    for compiler, real in ALL:
        said = compile_all(where, sources, compiler, real=real)
        assert not said, f"{compiler} {real}:\n{said[:3000]}"
    words = ["gcc", "-std=c11", *WARNINGS, "-O1", "-I.", "-c", "-o", "/dev/null"]
    for source in sources:
        said = subprocess.run([*words, *include_flags(), source], cwd=where, capture_output=True, text=True)
        assert said.returncode == 0, said.stderr[:3000]


def test_all_four_compilers_are_here():
    """One that is missing would pass in silence."""
    assert sorted(COMPILERS) == ["clang", "clang++", "g++", "gcc"]


def test_a_warning_is_an_error(tmp_path):
    for bad in ("double f(float x) { return x * 2.0; }", "int g(long x) { return x; }",
                "int h(int n) { int a[n]; return a[0]; }", "int k(int x) { int y; return x; }"):
        (tmp_path / "bad.c").write_text(bad + "\n")
        assert all(compile_all(tmp_path, ["bad.c"], compiler) for compiler in COMPILERS)


def solved(names):
    """(name, solver) of the spherical midpoint, of which few are compiled in `make test`."""
    return [pytest.param(n, s, marks=() if (n, s) in SOLVED else pytest.mark.long) for n in names for s in SOLVERS[1:]]


@pytest.mark.parametrize("name, method", [pytest.param(n, m, marks=() if n in CLEAN[m] else pytest.mark.long)
                                          for n in (*SPECS, *SCENES) for m in (SPHERICAL, CLASSICAL)])
def test_every_spec_compiles_clean(name, method, tmp_path):
    check_clean(tmp_path, written(tmp_path, load(name), method))


def test_moser_veselov_compiles_clean(tmp_path):
    check_clean(tmp_path, written(tmp_path, load("free_rigid_body"), VESELOV))


@pytest.mark.parametrize("name, solver", solved(COUPLED))
def test_every_solver_compiles_clean(name, solver, tmp_path):
    check_combination(tmp_path, load(name), SPHERICAL, solver)


@pytest.mark.parametrize("name", tiers(TEXTS, (), ("corners", "glass")))
def test_unusual_specs_compile_clean(name, tmp_path):
    check_clean(tmp_path, written(tmp_path, texts.read(TEXTS[name], tmp_path), SPHERICAL))


@pytest.mark.long
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", COUPLED)
def test_every_solver_of_the_classical_midpoint_compiles_clean(name, solver, tmp_path):
    check_combination(tmp_path, load(name), CLASSICAL, solver)


FLAT = """[model]
name = "flat"
[space]
u = { sphere = 2 }
w = { r3 = 3 }
[parameters]
r = 1.3
D = { default = [0.2, 0.7, -0.4], vector = true, fixed = true }
[effects.cancels]
over = "each(k of u, i of w)"
energy = "0.7*dot(w[i], u[k]) + sin(t)*cross(u[k], u[k]).x + triple(if(u[k].x < 0.247, u[k], D), 0.3*w[i] - D, u[k])"
[effects.constant]
over = "bond(i, j) of chain(3, open) on w"
energy = "w[j].z/(3 + dot(cross(w[i], w[i]), w[i])^2)"
[effects.straight]
over = "site(k) of w"
energy = "dot(0.3*w[k] - D, if(r < 1.299, w[k], D))"
"""


@pytest.mark.quick
@pytest.mark.parametrize("solver", ["plain", "newton"])
def test_what_cancels_out_leaves_no_variable(solver, tmp_path):
    """Nor an index or an argument that nothing reads: a term may have no gradient or no curvature."""
    sources = written(tmp_path, texts.read(FLAT), SPHERICAL, solver)
    assert [compile_all(tmp_path, sources, compiler) for compiler in COMPILERS] == [""] * len(COMPILERS)


ALONE = """[model]
name = "alone"
[space]
x = {{ sphere = "n" }}
[parameters]
n = {{ default = 1, fixed = {fixed} }}
a = 0.3
B = {{ default = [0.3, -0.5, 0.8], vector = true }}
[effects.one]
over = "site(i) of x"
energy = "{energy}"
[starts.any]
random = 1
"""
EMPTY = {"no vector": "a^2", "no motion": "abs(dot(x[i], x[i]))", "a field alone": "dot(B, x[i])",
         "a condition of numbers": "if(min(0, -0.213)^3 < 0.643 and x[i].z > a, x[i].x^2, x[i].y)",
         "a piece free of the state": "if(triple(x[i], B, B) < 1.1, if(B.y < 0.8, B.x, B.z), 0.7)*dot(x[i], x[i])"}


@pytest.mark.parametrize("fixed", ["true", pytest.param("false", marks=pytest.mark.long)])
@pytest.mark.parametrize("energy", EMPTY)
def test_energies_that_move_little_or_nothing_compile_clean(energy, fixed, tmp_path):
    """On one sphere, where the step has a form of its own, and on spheres of any number."""
    sources = written(tmp_path, texts.read(ALONE.format(energy=EMPTY[energy], fixed=fixed)), SPHERICAL)
    assert {said for compiler, real in ALL if real == "double" for said in [compile_all(tmp_path, sources, compiler)]} == {""}


def test_a_graph_on_a_number_of_sites_known_at_run_time(tmp_path):
    """The elimination is compiled in for 30 of them."""
    text = texts.GLASS.replace("sphere = 30", 'sphere = "n"') + "[parameters]\nn = 30\n"
    sources = written(tmp_path, texts.read(text, tmp_path), SPHERICAL, "newton")
    assert [compile_all(tmp_path, sources, compiler) for compiler in COMPILERS] == [""] * len(COMPILERS)


@pytest.mark.quick
def test_functions_of_time_stay_whole():
    """A pulse exp(-(t - 3)^2/w^2) whose square is multiplied out loses its digits, and in time overflows."""
    text = ALONE.format(energy="exp(-((t - 3)/a)^2)*x[i].x + x[i].z^2", fixed="true")
    source = generate(select(texts.read(text)))["alone.c"]
    assert source.count("(exp)(") >= 2 and not re.search(r"exp\)\([^;]*c->t\*c->t", source)


def test_what_nothing_calls_is_left_out():
    """By name, whether a function that stays calls it or the rest does."""
    def function(name, value, wanted=False):
        return Function("int", name, (), (Return(value),), wanted=wanted)
    chain = [function("a", ZERO), function("unused", Call("a", ())), function("b", Call("a", ())), function("wanted", ONE, True)]
    assert [f.name for f in needed(chain, {"b"})] == ["a", "b", "wanted"]
    assert [f.name for f in needed(chain, ())] == ["wanted"]


# -- sanitizers -----------------------------------------------------------------------------------

def sanitized(where, case, method, solver="auto", real="double", compiler="gcc"):
    """50 steps of a program under ASan and UBSan; their numbers are those of the library."""
    sources = written(where, case.spec, method, solver)
    integrator = model(case, method, solver=solver, real=real)
    values = parameter_values(integrator.scene, integrator.parameters)
    free = [p for p in integrator.scene.parameters if not p.fixed]
    scalars = {p.name: values[p.name] for p in free if p.kind != "array"}
    arrays = {p.name: values[p.name] for p in free if p.kind == "array"}
    (where / "main.c").write_text(driver(integrator, case.h, case.w, scalars, arrays))
    status, said = run_sanitized(where, [*sources, "main.c"], compiler, real)
    assert status == 0, said[:3000]
    integrator.start(case.w.astype(integrator.real), t0=0.25, h=case.h).steps(50)
    energy, first = (float(x) for x in said.split())
    assert first == float(integrator.w[0, 0])
    assert energy == float(integrator.energy(t=0.5))


@pytest.mark.parametrize("name", tiers(SPECS, (), ("forced_rigid_body", "nambu_a34", "heisenberg_chain", "cubic_lattice", "vortex_tracers")))
def test_spherical_midpoint_runs_clean(name, tmp_path):
    sanitized(tmp_path, begin(name), SPHERICAL)


@pytest.mark.parametrize("name", tiers(["irreversible_rigid_body", "nambu_a38", "two_bodies", "vortex_tracers", "heisenberg_chain"],
                                       (), ("two_bodies",)))
def test_classical_midpoint_runs_clean(name, tmp_path):
    sanitized(tmp_path, begin(name), CLASSICAL)


def test_moser_veselov_runs_clean(tmp_path):
    sanitized(tmp_path, begin("free_rigid_body"), VESELOV, compiler="clang" if "clang" in COMPILERS else "gcc")


@pytest.mark.parametrize("name, solver", solved(["heisenberg_chain", "product", "point_vortices"]))
def test_every_solver_runs_clean(name, solver, tmp_path):
    sanitized(tmp_path, begin(name), SPHERICAL, solver)


@pytest.mark.parametrize("name", tiers(TEXTS, (), ("corners", "glass")))
def test_unusual_specs_run_clean(name, tmp_path):
    sanitized(tmp_path, begin(texts.read(TEXTS[name], tmp_path)), SPHERICAL)


def test_extended_precision_runs_clean(tmp_path):
    sanitized(tmp_path, begin("product"), SPHERICAL, real="long double")


def test_the_sanitizers_see(tmp_path):
    """A read past the end and an overflow stop the program."""
    for bad in ("double a[3] = {1}; int main(int n, char **v) { (void)v; return a[n + 2] > 0; }",
                "int main(void) { volatile int n = 2147483647; volatile int m = n + 1; return m == 5; }"):
        (tmp_path / "bad.c").write_text(bad + "\n")
        assert run_sanitized(tmp_path, ["bad.c"])[0] != 0


@pytest.mark.quick
@pytest.mark.parametrize("name, most", [("heisenberg_chain", 220), ("cubic_lattice", 400), ("point_vortices", 260), ("free_rigid_body", 180)])
def test_a_model_is_no_longer_than_this(name, most):
    """Lines of NAME.c, comments included: what grows here grows in every model."""
    assert len(generate(select(load(name)))[f"{name}.c"].splitlines()) <= most
