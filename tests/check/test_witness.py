"""The witness: its derivatives, instances, steps and flow, each against something else."""
import dataclasses
import itertools
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.numpy_systems import CASIMIRS, SYSTEMS, strengths, vector_field
from support.witness_models import (body, chord, nambu, one_term, op, precession, pulsed, sphere,
                            vortices)

import smidgen
from smidgen.effects.energy import Energy
from smidgen.errors import BuildError, MissingTool, RunError, UsageError
from smidgen.language.evaluate import evaluate
from smidgen.language.expr import SIGNATURES, Elem, Idx, Num, Op, Par, Spin, Weight, is_draw
from smidgen.resources import folder
from smidgen.language.spec import Each, Graph, Lattice, Once, Pairs, Parameter, Sites, Spec
from smidgen.run.step.start import initial_state
from smidgen.check.witness import Witness, native
from smidgen.language.instances import instances_of

SPECS = sorted(p.stem for p in folder("specs").glob("*.toml"))
W0 = np.array([[np.cos(1.1), 0, np.sin(1.1)]])


def points(count, seed=0):
    w = np.random.default_rng(seed).standard_normal((count, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]


# -- every system by a third hand -----------------------------------------------------------

@pytest.mark.parametrize("name", SPECS)
def test_energy_and_field_agree_with_plain_numpy(name):
    spec = smidgen.load(folder("specs") / f"{name}.toml")
    one = Witness(spec)
    for k in range(3):
        w, t = points(one.sites, k), 0.7 * k
        w = w * (1.3 if name in CASIMIRS or name == "two_bodies" else 1)
        energy, gradient = SYSTEMS[name](one.values, w, t)
        b = gradient / strengths(name, one.values)
        assert one.energy(w, t) == pytest.approx(energy, rel=1e-13, abs=1e-13 * len(w))
        assert np.abs(one.field(w, t) - b).max() <= 1e-13 * max(1, np.abs(b).max())
        x = spec.orientation * vector_field(name, one.values, w, t)
        assert np.abs(one.vector_field(w, t) - x).max() <= 1e-13 * max(1, np.abs(b).max())


# -- automatic differentiation --------------------------------------------------------------

CASES = [(name, kinds, result) for name, signatures in SIGNATURES.items() if not is_draw(Op(name, ()))
         for kinds, result in signatures]
A, B = Spin("w", 0), Spin("w", 1)


def scalar_of(name, kinds, result):
    """A term that uses the operator on what varies with the spins, inside every domain."""
    low = op("/", op("+", op("x", A), op("+", op("*", op("y", B), op("z", A)), 3)), 7)
    scalars = [low, op("+", 0.2, op("*", 0.1, op("dot", A, B))), op("z", B)]
    vectors = [op("*", op("x", B), A), op("-", A, B), op("cross", A, B)]
    truths = [op("<", op("x", A), 0.0), op(">=", op("y", B), 0.1)]
    pool = {"s": scalars, "v": vectors, "b": truths}
    value = op(name, *(pool[k][n] for n, k in enumerate(kinds)))
    if result == "b":
        return op("if", value, low, op("^", low, 2))
    return op("dot", value, value) if result == "v" else op("*", op("+", value, op("*", 2, low)), low)


@pytest.mark.parametrize("name, kinds, result", CASES)
def test_derivatives_of_every_operator(name, kinds, result):
    value = scalar_of(name, kinds, result)
    one, w, step = Witness(one_term(value, sphere(2))), points(2, 5), 1e-5
    assert one.energy(w) == pytest.approx(evaluate(value, {"spins": {"w": w}}), rel=1e-14)
    b, numeric = one.field(w).ravel(), np.empty(6)
    dx, numeric_dx = one.jacobian(w)[0], np.empty((6, 6))
    for k in range(6):
        shift = step * np.eye(6)[k].reshape(2, 3)
        up, down = ({"spins": {"w": w + s * shift}} for s in (1, -1))
        numeric[k] = (evaluate(value, up) - evaluate(value, down)) / (2 * step)
        numeric_dx[:, k] = (one.vector_field(w + shift) - one.vector_field(w - shift)).ravel()
    assert np.abs(b - numeric).max() <= 1e-8 * max(1, np.abs(b).max())
    assert np.abs(dx - numeric_dx / (2 * step)).max() <= 1e-7 * max(1, np.abs(dx).max())
    assert np.abs(b).max() > 1e-3


@pytest.mark.parametrize("exponent", [0, 1, 2, 3, -1, -2, 0.5])
def test_constant_powers_of_zero_and_negative_numbers(exponent):
    x = op("x", Spin("w", 0))
    one = Witness(one_term(op("^", x, exponent), sphere()))
    for value in (-0.6, 0.0, 0.6):
        w = np.array([[value, 0.8, 0.0]])
        if exponent < 1 and exponent != 0 and value == 0 or exponent == 0.5 and value < 0:
            with pytest.raises(RunError, match="not finite"):
                one.field(w)
            continue
        slope = exponent * value ** (exponent - 1) if exponent else 0.0
        assert one.field(w)[0, 0] == pytest.approx(slope, rel=1e-15)


def test_time_derivative_of_the_vector_field():
    one, w, t, step = Witness(pulsed()), points(1), 0.4, 1e-5
    numeric = (one.vector_field(w, t + step) - one.vector_field(w, t - step)) / (2 * step)
    assert np.abs(one.jacobian(w, t)[1] - numeric).max() < 1e-9


def test_elements_of_arrays_and_their_limits():
    gamma = Parameter("gamma", "array", (2.0, -3.0, 5.0), size=Num(3))
    value = op("*", Elem("gamma", op("mod", op("+", Idx("i"), 1), 3)), op("z", Spin("w", "i")))
    spec = dataclasses.replace(one_term(value, sphere(3), Sites("i", "w")), parameters=(gamma,))
    w = points(3)
    assert Witness(spec).energy(w) == pytest.approx(w[:, 2] @ [-3, 5, 2], rel=1e-15)
    beyond = op("*", Elem("gamma", op("+", Idx("i"), 1)), op("z", Spin("w", "i")))
    wrong = dataclasses.replace(spec, effects=(Energy("e", Sites("i", "w"), beyond),))
    with pytest.raises(RunError, match="no such entry"):
        Witness(wrong).energy(w)


# -- index families ---------------------------------------------------------------------------

PLACES = {"w": (0, 12), "p": (12, 3)}


def tuples(over):
    indices, _ = instances_of(over, {"n": 12}, PLACES)
    return sorted(zip(*(v.tolist() for v in indices.values())))


def test_sites_pairs_each():
    assert tuples(Sites("i", "w")) == [(i,) for i in range(12)]
    assert tuples(Pairs("i", "j", "w")) == list(itertools.combinations(range(12), 2))
    assert tuples(Each(("i", "j"), ("p", "w"))) == list(itertools.product(range(3), range(12)))
    assert instances_of(Once(), {}, PLACES) == ({}, {})


def test_chains():
    bond = (((0, (0,)), (0, (1,))),)
    ring, line = (Lattice(("i", "j"), (Par("n"),), (p,), 1, bond) for p in (True, False))
    assert tuples(ring) == sorted((i, (i + 1) % 12) for i in range(12))
    assert tuples(line) == [(i, i + 1) for i in range(11)]


@pytest.mark.parametrize("periodic", list(itertools.product([True, False], repeat=2)))
def test_lattices_with_two_sites_a_cell(periodic):
    """3 x 2 cells; a bond from sub 1 of a cell to sub 0 two cells on and one down."""
    over = Lattice(("i", "j"), (Num(3), Num(2)), periodic, 2, (((1, (0, 0)), (0, (2, -1))),))
    expected = []
    for x, y in itertools.product(range(3), range(2)):
        u, v = x + 2, y - 1
        if (periodic[0] or u < 3) and (periodic[1] or v >= 0):
            expected.append((2 * (x + 3 * y) + 1, 2 * (u % 3 + 3 * (v % 2))))
    assert tuples(over) == sorted(expected)


def test_graphs_with_weights():
    over = Graph("i", "j", ((0, 2), (1, 0)), (("K", (2.0, -5.0)),))
    value = op("*", Weight("K"), op("dot", Spin("w", "i"), Spin("w", "j")))
    w = points(3)
    expected = 2 * w[0] @ w[2] - 5 * w[1] @ w[0]
    assert Witness(one_term(value, sphere(3), over)).energy(w) == pytest.approx(expected)


def test_a_lattice_larger_than_its_family_is_refused():
    over = Lattice(("i", "j"), (Num(4),), (True,), 1, (((0, (0,)), (0, (1,))),))
    with pytest.raises(UsageError, match="has 3 sites"):
        Witness(one_term(op("dot", Spin("w", "i"), Spin("w", "j")), sphere(3), over))


def test_a_bond_of_a_site_with_itself():
    over = Lattice(("i", "j"), (Num(1),), (True,), 1, (((0, (0,)), (0, (1,))),))
    one = Witness(one_term(op("dot", Spin("w", "i"), Spin("w", "j")), sphere(), over))
    assert np.allclose(one.field(W0), 2 * W0)


# -- steps ---------------------------------------------------------------------------------------

TABLE = {   # max error on [0, 10]: moments, h -> spherical, classical midpoint, Moser-Veselov
    ((1, 2, 4), 3): (1.94914e-4, 4.06884e-4, 2.12155e-3),
    ((1, 2, 4), 5): (1.21860e-5, 2.54408e-5, 1.32471e-4),
    ((1, 4 / 3, 2), 3): (6.34156e-6, 2.12578e-4, 2.82471e-3),
    ((1, 4 / 3, 2), 5): (3.94463e-7, 1.32896e-5, 1.76037e-4),
}


@pytest.mark.parametrize("moments, power", TABLE)
def test_errors_of_the_free_body(moments, power):
    one, h, n = Witness(body(moments)), 2.0**-power, 10 * 2**power
    exact = one.flow(W0, 0, h * np.arange(n + 1))
    for method, expected in zip(("spherical-midpoint", "classical-midpoint", "moser-veselov"),
                                TABLE[moments, power]):
        errors = np.linalg.norm(one.steps(W0, 0, h, n, method) - exact, axis=-1)
        assert errors.max() == pytest.approx(expected, rel=2e-5)


def defining_equation(spec, w, after, t, h, method):
    """W - w - h X(m) in numpy, from the definitions of the paper."""
    one, middle = Witness(spec), (w + after) / 2
    if method == "spherical-midpoint":
        lengths = np.sqrt(np.linalg.norm(w, axis=1) * np.linalg.norm(after, axis=1))
        middle = middle * (lengths / np.linalg.norm(middle, axis=1))[:, None]
    x = one.vector_field(middle, t + h / 2)
    if method == "moser-veselov":
        root = np.sqrt(1 - h**2 * np.sum(one.field(middle, t + h / 2)**2, axis=1))
        x = x / ((1 + root) / 2)[:, None]
    return after - w - h * x


@pytest.mark.parametrize("method", ["spherical-midpoint", "classical-midpoint", "moser-veselov"])
@pytest.mark.parametrize("spec", [body((1, 2, 4)), pulsed(), vortices(4, orientation=-1)],
                         ids=["body", "pulsed", "vortices"])
def test_steps_solve_the_equation_of_the_method(spec, method):
    one = Witness(spec)
    w, t, h = points(one.sites, 2), 0.3, 0.2
    after = one.step(w, t, h, method)
    assert np.abs(defining_equation(spec, w, after, t, h, method)).max() < 1e-15
    assert one.residual(w, after, t, h, method) < 1e-15
    assert np.abs(after - w).max() > 1e-3
    assert np.abs(one.step(after, t + h, -h, method) - w).max() < 1e-15


def test_one_spin_in_a_perpendicular_field():
    """Angle acos(1 - (rate h)^2/2) up to rate h = 2; beyond, there is no solution."""
    w = np.array([[1.0, 0, 0]])
    for rate in (0.1, 1.0, 1.99):
        after = Witness(precession(rate)).step(w, 0, 1.0)
        assert np.arccos(after[0, 0]) == pytest.approx(np.arccos(1 - rate**2 / 2), rel=1e-13)
    with pytest.raises(RunError):
        Witness(precession(2.01)).step(w, 0, 1.0)


@pytest.mark.parametrize("r", [0.3, 0.7, 0.95])
@pytest.mark.parametrize("a", [0.5, 3.0, 30.0])
def test_one_spin_at_any_angle_to_its_field(r, a):
    """sin^2(phi/2) = ((4+a) - sqrt((4+a)^2 - 16 r^2 a))/(8 r^2), a = (rate h)^2, r the sine of
    the angle between spin and field; large a needs the continuation in h."""
    after = Witness(precession(np.sqrt(a))).step([[r, 0, np.sqrt(1 - r**2)]], 0, 1.0)
    turned = np.arctan2(after[0, 1], after[0, 0])
    expected = ((4 + a) - np.sqrt((4 + a)**2 - 16 * r**2 * a)) / (8 * r**2)
    assert np.sin(turned / 2)**2 == pytest.approx(expected, rel=1e-13)


def test_orientation_reverses_time():
    forward, backward = Witness(vortices(4)), Witness(vortices(4, orientation=-1))
    w = points(4)
    assert np.abs(forward.step(w, 0, 0.1) - backward.step(w, 0, -0.1)).max() < 1e-17


def test_invariants_of_vortices():
    one, w = Witness(vortices(5)), points(5, 1)
    path = one.steps(w, 0, 0.05, 100)
    assert np.abs(np.linalg.norm(path, axis=2) - 1).max() < 1e-15
    assert np.abs(path.sum(axis=1) - w.sum(axis=0)).max() < 1e-14
    assert abs(one.energy(path[-1]) - one.energy(w)) < 1e-4


def test_radius_strength_and_length():
    """w' = w x dH/dw / kappa: on radius r the free body of w/r turns r times as fast, and the
    extended method in R^3 is that map for the radius of the start."""
    w, r = points(1, 3), 2.5
    unit = Witness(body((1, 2, 4))).step(w, 0, 0.1)
    for family in (sphere(radius=Num(r), kappa=Num(r)), dataclasses.replace(
            sphere(kappa=Num(r)), kind="r3", radius=None)):
        big = Witness(body((1, 2, 4), family)).step(r * w, 0, 0.1)
        assert np.abs(big - r * unit).max() < 1e-15


def test_the_origin_of_r3_stays():
    family = dataclasses.replace(sphere(2), kind="r3", radius=None)
    one = Witness(one_term(op("dot", Spin("w", 0), Spin("w", 1)), family))
    w = np.array([[0, 0, 0], [0.5, 0, 1]])
    assert np.array_equal(one.step(w, 0, 0.1), w)


def test_lagrange_system_keeps_both_quadratics():
    w = Spin("w", 0)
    squares = [op("^", op(c, w), 2) for c in "xz"]
    one = Witness(one_term(op("/", op("-", *squares), 2), nambu([[1, 0, 0], [0, -1, 0], [0, 0, 0]])))
    path = one.steps([[1.0, 0.4, -0.6]], 0, 0.02, 100)[:, 0]
    x, y, z = path.T
    assert np.ptp(x**2 - y**2) < 1e-14 and np.ptp(x**2 - z**2) < 1e-14
    assert np.abs(one.vector_field(path[:1])[0] - [y[0] * z[0], z[0] * x[0], x[0] * y[0]]).max() == 0
    with pytest.raises(RunError, match="C = 0"):
        one.step([[1.0, 1.0, 0.3]], 0, 0.02)


def test_tracers_feel_and_do_not_act():
    tracer = sphere(2, name="p", tracer=True)
    alone = vortices(3)
    both = dataclasses.replace(alone, families=(*alone.families, tracer), effects=(
        *alone.effects, Energy("transport", Each(("i", "j"), ("p", "w")), chord("p", "i", "w", "j"))))
    w = points(5, 4)
    together = Witness(both).steps(w, 0, 0.1, 20)
    assert np.abs(together[:, :3] - Witness(alone).steps(w[:3], 0, 0.1, 20)).max() < 1e-16
    assert np.abs(together[-1, 3:] - w[3:]).min() > 1e-3
    pushed = sum(w[j] / (4 * np.pi * (1 - w[3] @ w[j])) for j in range(3))
    assert np.abs(Witness(both).field(w)[3] - pushed).max() < 1e-15


def test_every_kth_state():
    one = Witness(body((1, 2, 4)))
    assert np.array_equal(one.steps(W0, 0, 0.1, 10, every=3), one.steps(W0, 0, 0.1, 10)[::3])


def test_irreversible_body_drifts_under_the_classical_midpoint_alone():
    spec = smidgen.load(folder("specs") / "irreversible_rigid_body.toml")
    one, w = Witness(spec), initial_state(spec, "paper")
    assert one.energy(w) == pytest.approx(0.226892131797, abs=1e-12)
    drift = {m: np.array([one.energy(s) for s in one.steps(w, 0, 0.5, 4000, m, every=2)])
             - one.energy(w) for m in ("spherical-midpoint", "classical-midpoint")}
    assert drift["classical-midpoint"][1000] == pytest.approx(3.950e-3, rel=1e-3)
    assert drift["classical-midpoint"][2000] == pytest.approx(1.1979e-2, rel=1e-4)
    assert -2.45e-3 < drift["spherical-midpoint"].min() < drift["spherical-midpoint"].max() < 1.1e-3


# -- flow -----------------------------------------------------------------------------------------

def test_flow_of_the_free_body_is_the_elliptic_solution():
    one = Witness(body((1, 2, 4)))
    end = one.flow(W0, 0, [10.0, 1000.0])[:, 0]
    assert np.abs(end[0] - [-0.45036353307669270, -0.09362899305780026, 0.88792246268109532]).max() < 1e-13
    assert np.abs(end[1] - [-0.34374519086651949, -0.51260711601127982, 0.78681204132291874]).max() < 1e-10


@pytest.mark.parametrize("integrator, tol, within", [("bsimp", 1e-12, 1e-10), ("msbdf", 1e-10, 1e-6)])
def test_implicit_flows_agree(integrator, tol, within):
    one, w = Witness(pulsed()), points(1)
    a, b = one.flow(w, 0, [1.0, 2.0]), one.flow(w, 0, [1.0, 2.0], integrator, tol)
    assert np.abs(a - b).max() < within


def test_flow_runs_backward():
    one, w = Witness(pulsed()), points(1)
    end = one.flow(w, 0, [2.0])[0]
    assert np.abs(one.flow(end, 2.0, [1.0, 0.0])[-1] - w).max() < 1e-12


# -- errors ---------------------------------------------------------------------------------------

def test_wrong_names_and_shapes():
    one = Witness(body((1, 2, 4)))
    for call in (lambda: one.energy(np.zeros((2, 3))), lambda: one.step(W0, 0, 0.1, "euler"),
                 lambda: one.flow(W0, 0, [1.0], "rk4"), lambda: one.steps(W0, 0, 0.1, -1),
                 lambda: Witness(body((1, 2, 4)), effects=["x"])):
        with pytest.raises(UsageError):
            call()


def test_effects_are_left_out():
    a, b = Energy("a", Once(), op("x", Spin("w", 0))), Energy("b", Once(), op("z", Spin("w", 0)))
    spec = Spec("m", "m", (), (sphere(),), (a, b))
    assert Witness(spec, effects=["b"]).energies(W0) == {"b": W0[0, 2]}
    assert Witness(spec, effects=[]).energy(W0) == 0


def test_dense_newton_has_a_limit():
    one = Witness(one_term(op("z", Spin("w", "i")), sphere(1001), Sites("i", "w")))
    assert one.field(points(1001)).shape == (1001, 3)
    with pytest.raises(UsageError, match="at most 1000 sites"):
        one.step(points(1001), 0, 0.1)


@pytest.mark.parametrize("said, error", [
    ("x.c:1: fatal error: gsl/gsl_errno.h: No such file or directory", MissingTool),
    ("/usr/bin/ld: cannot find -lgsl", MissingTool), ("x.c:1: error: expected ;", BuildError)])
def test_missing_gsl_is_named(tmp_path, monkeypatch, said, error):
    script = tmp_path / "cc"
    script.write_text(f"#!/bin/sh\necho '{said}' >&2\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(error, match="libgsl-dev" if error is MissingTool else "expected"):
        native._built()
    with pytest.raises(MissingTool, match="no C compiler"):
        monkeypatch.setenv("CC", "no-such-compiler")
        native._built()


# -- the C and the page ----------------------------------------------------------------------------

@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_c_is_free_of_warnings(compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    sources = sorted(map(str, native.HERE.glob("*.c")))
    subprocess.run([compiler, "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow",
                    "-Wconversion", "-Wvla", "-Werror", "-c", *sources], cwd=tmp_path, check=True)


SANITIZED = """
import sys
from pathlib import Path
sys.path[:0] = {tests!r}
import test_witness as t
t.test_errors_of_the_free_body((1, 2, 4), 3)
t.test_tracers_feel_and_do_not_act()
t.test_lagrange_system_keeps_both_quadratics()
t.test_implicit_flows_agree("bsimp", 1e-12, 1e-10)
t.test_one_spin_in_a_perpendicular_field()
"""


def test_the_c_passes_sanitizers(monkeypatch, tmp_path, root):
    library = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True,
                             text=True, check=True).stdout.strip()
    code = "import smidgen.check.witness.native as n; n.FLAGS += ('-g', '-fsanitize=address,undefined'," \
           " '-fno-sanitize-recover=all')" + SANITIZED.format(tests=[str(root / "tests"), str(Path(__file__).parent)])
    monkeypatch.setenv("LD_PRELOAD", library)
    monkeypatch.setenv("ASAN_OPTIONS", "detect_leaks=0")
    monkeypatch.setenv("CC", "gcc")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]


def test_the_page_runs(root, monkeypatch):
    monkeypatch.chdir(root)
    page = (root / "docs" / "witness.md").read_text()
    names = {}
    for block in re.findall(r"```python\n(.*?)```", page, re.S):
        exec(block, names)
    assert names["one"].steps(names["w"], 0.0, 0.1, 1000, every=10).shape == (101, 20, 3)
