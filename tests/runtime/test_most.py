"""What a header says that one step takes at most, against steps as hard as can be: counted evaluations, iterations, and a painted stack."""
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import smidgen
from smidgen.compile.assemble.effort import most
from smidgen.compile.assemble.model import Model
from smidgen.compile.emit.emit import generate
from smidgen.compile.plan.plan import choose
from smidgen.compile.select import select
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state

HERE = Path(__file__).parent
SIZES = [1e-3, 0.1, 0.5, 1.0, 1.9, 2.1, 3.0, 5.0, 10.0, 30.0, 1e3, 1e8]
# calls of the model by the method, each of all sites, of one, or of the sites of a vector
COUNTED = """
#define smg_gradient(c, w, g) (of_all(smg_sites(c), &gradients), smg_gradient(c, w, g))
#define smg_coupled_gradient(c, w, g) (of_all(smg_sites(c), &gradients), smg_coupled_gradient(c, w, g))
#define smg_gather(c, at, all, m, g) (of_all(1, &gradients), smg_gather(c, at, all, m, g))
#define smg_hessian_blocks(s) (of_all(smg_sites(&(s)->c), &hessians), smg_hessian_blocks(s))
#define smg_hessian_vector(s) (of_all(smg_sites(&(s)->c), &hessians), smg_hessian_vector(s))
#define smg_derivative(c, m, q) (of_all(1, &hessians), smg_derivative(c, m, q))
#define smg_few_field(c, m, p, i, g) (of_some(smg_sites(c), i, SMG_LANES), smg_few_field(c, m, p, i, g))
#define smg_few_norms(c, m, p, i, g) (of_some(smg_sites(c), i, SMG_LANES), smg_few_norms(c, m, p, i, g))
#define smg_slot_gradient(c, ...) (of_all(SMG_LANES, &gradients), smg_slot_gradient(c, __VA_ARGS__))
#define smg_lane_gradient(c, w, g) (of_all(SMG_LANES * smg_sites(c), &gradients), smg_lane_gradient(c, w, g))
#define smg_site_hessian_vector(...) (of_all(1, &columns), smg_site_hessian_vector(__VA_ARGS__))
"""
MOTION = "#define smg_motion(...) (of_all(1, &gradients), smg_motion(__VA_ARGS__))\n"


def counted(text: str) -> str:
    """The C of a model whose method calls are counted."""
    return text.replace("/* ---- its method", COUNTED + MOTION + "/* ---- its method", 1)


def run(folder, spec, values, method, solver, compiler=("gcc", "-O2"), sizes=SIZES, states=6):
    scene = select(spec, None, values)
    files = generate(scene, method, solver)
    for name, text in files.items():
        (folder / name).write_text(counted(text) if name == f"{spec.name}.c" else text)
    program = folder / "most"
    subprocess.run([*compiler, "-std=gnu11", "-ffp-contract=off", "-w", f"-DMODEL={spec.name}", f"-I{folder}", *include_flags(), str(HERE / "most.c"), "-o", str(program),
                    "-lm", "-lpthread", "-Wl,-z,now"], check=True)
    w = initial_state(spec, spec.starts[0].name, values)
    dice = np.random.default_rng(5)
    with open(folder / "h", "wb") as file:
        for h in sizes:
            for k in range(states):
                moved = w if k == 0 else scattered(dice, w)
                np.concatenate([[h], moved.ravel()]).tofile(file)
    said = subprocess.run([program, folder / "h"], check=True, capture_output=True, text=True).stdout.split()
    return list(map(float, said)), scene, files


def scattered(dice, w):
    """Random directions of the same lengths."""
    v = dice.normal(size=w.shape)
    return v / np.linalg.norm(v, axis=1, keepdims=True) * np.linalg.norm(w, axis=1, keepdims=True)


def check(found, scene, files):
    """Within what the header says; the memory as said, or less with narrower registers."""
    gradients, hessians, iterations, stack, memory, failed = found
    said = files.most
    named = {word: int(value) for word, value in re.findall(rf"{scene.name}_most_(\w+) = (\d+)", files[f"{scene.name}.h"])}
    assert {word: said[word] for word in ("gradients", "hessians", "iterations", "stack")} == {word: value for word, value in named.items() if word != "numbers"}
    assert gradients <= said["gradients"] and hessians <= said["hessians"] and iterations <= said["iterations"] and stack <= said["stack"]
    assert said["memory"] is None or memory <= said["memory"] <= 2 * memory
    assert "numbers" not in named or 8 * named["numbers"] == said["memory"]
    return failed


# (spec, integer parameters, method, solver, do some steps fail?): every layout, solver and kind of method
KERNELS = [
    ("free_rigid_body", {}, "spherical-midpoint", "auto", False), ("irreversible_rigid_body", {}, "spherical-midpoint", "auto", True),
    ("lagrange", {}, "spherical-midpoint", "auto", True), ("nambu_a34", {}, "spherical-midpoint", "auto", False),
    ("free_rigid_body", {}, "moser-veselov", "auto", True), ("point_vortices", {}, "spherical-midpoint", "auto", True),
    ("two_bodies", {}, "spherical-midpoint", "auto", True), ("product", {}, "spherical-midpoint", "auto", True),
    ("vortex_tracers", {}, "spherical-midpoint", "auto", True), ("heisenberg_chain", {"n": 16}, "spherical-midpoint", "auto", True),
    ("heisenberg_chain", {"n": 16}, "spherical-midpoint", "newton", True), ("heisenberg_chain", {"n": 16}, "spherical-midpoint", "rotation", True),
    ("heisenberg_chain", {"n": 16}, "spherical-midpoint", "plain", True), ("heisenberg_chain", {"n": 16}, "classical-midpoint", "auto", True),
    ("heisenberg_chain", {"n": 16}, "gauss-6", "auto", True), ("point_vortices", {}, "gauss-4", "auto", True), ("free_rigid_body", {}, "gauss-16", "auto", True),
    ("point_vortices", {}, "rattle", "auto", True), ("point_vortices", {}, "geodesic-midpoint", "auto", True), ("point_vortices", {}, "cf4", "auto", False),
    ("point_vortices", {}, "dop853", "auto", True), ("free_rigid_body", {}, "dop853", "auto", True), ("point_vortices", {}, "extrapolation-12", "auto", False),
    ("free_rigid_body", {}, "spherical-midpoint-4", "auto", False), ("point_vortices", {}, "spherical-midpoint-4", "auto", True),
    ("heisenberg_chain", {"n": 16}, "sublattice-rotations", "auto", False), ("heisenberg_chain", {"n": 16}, "pair-rotations", "auto", False)]
FIRST = ("irreversible_rigid_body", "point_vortices")


@pytest.mark.parametrize("name, values, method, solver, hostile", [
    pytest.param(*one, id="-".join((one[0], *one[2:4])), marks=pytest.mark.quick if one[0] in FIRST and one[2] == "spherical-midpoint" else ()) for one in KERNELS])
def test_a_step_takes_no_more_than_the_header_says(name, values, method, solver, hostile, tmp_path):
    """At steps from a thousandth to 1e8, from the start and from random states; where it says so some of them fail, which takes longest."""
    found, scene, files = run(tmp_path, smidgen.load(name), values, method, solver)
    assert (check(found, scene, files) > 0) == hostile


@pytest.mark.parametrize("compiler", [("gcc", "-O1"), ("gcc", "-O3", "-march=native"), pytest.param(("clang", "-O3", "-march=native"), marks=pytest.mark.long)], ids="-".join)
@pytest.mark.parametrize("name, values, method", [("irreversible_rigid_body", {}, "spherical-midpoint"), ("point_vortices", {}, "spherical-midpoint"),
                                                  ("cubic_lattice", {}, "spherical-midpoint"), ("heisenberg_chain", {"n": 16}, "gauss-16")])
def test_the_stack_is_large_enough_however_it_is_compiled(name, values, method, compiler, tmp_path):
    found, scene, files = run(tmp_path, smidgen.load(name), values, method, "auto", compiler, sizes=[0.1, 2.1, 10.0] if name != "cubic_lattice" else [0.1], states=2)
    check(found, scene, files)


PACKED = """
[model]
name = "packed"
[space]
w = {{ sphere = "{places}*n*n{more}" }}
[parameters]
n = 6
{lattice}
[effects.exchange]
over = "bond(i, j) of {over}"
energy = "-0.5*dot(w[i], w[j])"
[starts.s]
random = 1
"""
ALL_BOUND = ",\n".join(f"{{ from = {i}, to = {j}, offset = [0, 0] }}" for i in range(0, 30, 2) for j in range(1, 30, 2))
LARGE_CELL = f'[lattices.large]\nsize = ["n", "n"]\nboundary = "periodic"\nsites = 30\nbonds.all = [{ALL_BOUND},\n{{ from = 1, to = 0, offset = [1, 0] }}]\n'
LONGER = '[lattices.longer]\nsize = ["n", "n", "n"]\nboundary = "periodic"\nbonds.all = [{ offset = [1, 0, 0] }, { offset = [0, 3, 2] }, { offset = [0, 2, 3] }, { offset = [1, 3, 0] }, { offset = [1, 0, 3] }]\n'
MANY_KINDS = {"fcc": smidgen.load_text(PACKED.format(places=1, more="*n", lattice="", over="fcc(n, n, n, periodic)")),
              "longer bonds": smidgen.load_text(PACKED.format(places=1, more="*n", lattice=LONGER, over="longer")),
              "large cell": smidgen.load_text(PACKED.format(places=30, more="", lattice=LARGE_CELL, over="large"))}


@pytest.mark.parametrize("name, method", [pytest.param("fcc", "spherical-midpoint", marks=pytest.mark.long), ("fcc", "gauss-4"), pytest.param("longer bonds", "dop853", marks=pytest.mark.long),
                                          pytest.param("fcc", "sublattice-rotations", marks=pytest.mark.long), pytest.param("large cell", "spherical-midpoint", marks=pytest.mark.long)])
def test_the_table_of_many_neighbours_is_not_on_the_stack(name, method, tmp_path):
    """12 and 15 of each site: the table stands in the memory of the state."""
    found, scene, files = run(tmp_path, MANY_KINDS[name], {}, method, "auto", sizes=[0.1, 10.0], states=1)
    check(found, scene, files)
    assert "row_kinds" in files["packed.h"]


BATH = """
[model]
name = "heated"
[space]
w = { sphere = 2 }
[effects.exchange]
energy = "2*dot(w[0], w[1]) + w[0].z^2*w[1].x"
[effects.bath]
over = "site(i) of w"
damping = 0.3
kT = 0.5
[starts.s]
random = 1
"""


def test_with_noise_a_step_may_be_taken_anew_as_two_halves(tmp_path):
    found, scene, files = run(tmp_path, smidgen.load_text(BATH), {}, "spherical-midpoint", "auto")
    check(found, scene, files)
    calm = generate(select(smidgen.load_text(BATH).calm), "spherical-midpoint")
    assert files.most["gradients"] == 3 * calm.most["gradients"] and found[0] > calm.most["gradients"] // 30


def test_counted_calls_are_those_of_every_method():
    """The counter counts: a step of four stages takes four gradients, an extrapolation 37, of a sphere alone as of four vortices."""
    assert most(Model(select(smidgen.load("point_vortices")), choose(select(smidgen.load("point_vortices")), "cf4", "auto"))).gradients == 4


def test_a_counter_that_is_too_low_is_noticed(tmp_path):
    found, scene, files = run(tmp_path, smidgen.load("point_vortices"), {}, "cf4", "auto", sizes=[0.1], states=1)
    assert found[0] == 4
    files.most = {**files.most, "gradients": 3}
    with pytest.raises(AssertionError):
        check(found, scene, files)


@pytest.mark.parametrize("name, method, features", [("free_rigid_body", "spherical-midpoint", ()), ("irreversible_rigid_body", "spherical-midpoint", ("extended",)),
                                                    ("point_vortices", "spherical-midpoint-4", ("tangent",)), ("heisenberg_chain", "spherical-midpoint", ()),
                                                    ("forced_rigid_body", "dop853", ()), ("product", "spherical-midpoint", ("extended",))])
@pytest.mark.quick
def test_sizes_of_model_and_state_are_those_of_the_compiler(name, method, features, tmp_path):
    scene = select(smidgen.load(name))
    files = generate(scene, method, features=features)
    (tmp_path / "size.c").write_text(f'#include "{name}.h"\n_Static_assert(sizeof({name}_model) == {files.most["model"]}, "model");\n'
                                     f'_Static_assert(sizeof({name}_state) == {files.most["state"]}, "state");\n')
    (tmp_path / f"{name}.h").write_text(files[f"{name}.h"])
    subprocess.run(["gcc", "-std=c11", "-fsyntax-only", *include_flags(), f"-I{tmp_path}", str(tmp_path / "size.c")], check=True)


ASKED = """#include <stdio.h>
#include "{name}.h"
int main(void) {{
  {name}_params p;
  {name}_model model;
  {name}_defaults(&p);
  {name}_model_init(&model, &p);
  printf("%zu", {name}_memsize(&model));
  return 0;
}}
"""


@pytest.mark.parametrize("name, sizes, method, features", [
    ("cubic_lattice", {"nx": 5, "ny": 4, "nz": 3}, "spherical-midpoint", ()), ("cubic_lattice", {"nx": 70, "ny": 4, "nz": 2}, "sublattice-rotations", ()),
    ("heisenberg_chain", {"n": 150}, "gauss-4", ()), ("honeycomb", {"nx": 6, "ny": 4}, "pair-rotations", ()), ("j1j2_chain", {"n": 36}, "spherical-midpoint-4", ("tangent",))])
def test_the_memory_of_rows_is_that_of_memsize(name, sizes, method, features, tmp_path):
    """Compiled for any processor; blocks have their table whether there are blocks or not."""
    scene = select(smidgen.load(name), None, sizes)
    files = generate(scene, method, features=features)
    for file, text in {**files, "main.c": ASKED.format(name=name)}.items():
        (tmp_path / file).write_text(text)
    subprocess.run(["gcc", "-std=gnu11", "-w", "-O0", *include_flags(), str(tmp_path / "main.c"), str(tmp_path / f"{name}.c"), "-o", str(tmp_path / "asked"), "-lm"], check=True)
    memory = int(subprocess.run([tmp_path / "asked"], check=True, capture_output=True, text=True).stdout)
    assert memory <= files.most["memory"] <= 1.1 * memory
