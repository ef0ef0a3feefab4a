"""Specs as users write them from the page of the language alone: they read, run and validate.

What the compiler makes of them is compared with equations of motion written by hand in the
words of each field, so that the sense of the motion is tested too.
"""
from pathlib import Path

import numpy as np
import pytest
from support.systems import tiers

import smidgen
from smidgen.check.validate import validate

USER = Path(__file__).parents[1] / "user"
SPECS = ["coupled_tops", "j1j2_chain", "kicked_spin", "kitaev_honeycomb", "mixed_families", "signed_vortices",
         "spin_glass", "triangular_chirality"]
STEPS = 20


def path(name: str) -> str:
    return str(USER / f"{name}.toml")


each = pytest.mark.parametrize("name", SPECS)
few = pytest.mark.parametrize("name", tiers(SPECS, (), ("kicked_spin", "signed_vortices", "spin_glass")))


def test_none_is_left_out():
    assert sorted(p.stem for p in USER.glob("*.toml")) == SPECS


@each
def test_check(command, name):
    said = command("check", path(name))
    assert said.returncode == 0 and ": good." in said.stdout, said.stderr


@few
def test_twenty_steps(name):
    """Every output comes, finite, and every site stays on its sphere."""
    spec = smidgen.load(path(name))
    observables = [o.name for o in spec.observables]
    result = smidgen.run(spec, steps=STEPS, every=5,
                         what=["states", "energy", "momentum", "casimirs", *observables])
    assert list(result.step) == [0, 5, 10, 15, 20] and sorted(result.w) == sorted(f.name for f in spec.families)
    assert observables and all(np.isfinite(result.values[o]).all() for o in observables)
    casimirs = result.values["casimirs"]
    assert np.ptp(casimirs, axis=0).max() <= 1e-14 * casimirs.max()


@few
def test_validate(name):
    report = validate(smidgen.load(path(name)), steps=STEPS, points=2)
    assert report.passed, report.text()


# Equations of motion by hand

def runge_kutta(f, w, time, steps):
    """The classical fourth-order method; its error is far below the midpoint's here."""
    h = time / steps
    for k in range(steps):
        t = k * h
        a = f(t, w)
        b = f(t + h / 2, w + h / 2 * a)
        c = f(t + h / 2, w + h / 2 * b)
        w = w + h / 6 * (a + 2 * b + 2 * c + f(t + h, w + h * c))
    return w


def tops(t, w):
    """Euler's equations, the momentum of each top crossed with its angular velocity."""
    turning = w / np.array([[1, 2, 3], [1.5, 1.5, 0.8]])
    turning[:, 2] += 0.4 * w[::-1, 2]
    return np.cross(w, turning)


def kicked(t, w):
    """m' = -m x B with B = -dH/dm, pulses of area 1.3 at multiples of 2."""
    since = (t + 1) % 2 - 1
    pulse = 1.3 * np.exp(-(since / 0.1)**2 / 2) / (0.1 * np.sqrt(2 * np.pi))
    x, y, z = w.T
    field = np.stack([pulse - 0.4 * x, 0.4 * y, 2 * z], axis=-1)
    return -np.cross(w, field)


def vortices(t, w):
    """Fluid mechanics: x_j' = sum_k G_k x_k cross x_j / (4 pi (1 - x_j.x_k))."""
    g, rate = [1.0, 1.0, -0.6], np.zeros((3, 3))
    for j in range(3):
        for k in {0, 1, 2} - {j}:
            rate[j] += g[k] * np.cross(w[k], w[j]) / (4 * np.pi * (1 - w[j] @ w[k]))
    return rate


def kitaev(t, w):
    """Angular momenta, {S_x, S_y} = S_z: S' = dH/dS cross S; 4 x 3 cells, sites a and b of each."""
    a, b = (w.reshape(3, 4, 2, 3)[:, :, k] for k in (0, 1))
    gradient = np.full((3, 4, 2, 3), -0.2 / np.sqrt(3))
    for axis, strength, turn in ((0, -1.0, None), (1, -1.0, 1), (2, -1.2, 0)):
        other = b if turn is None else np.roll(b, 1, axis=turn)
        back = a if turn is None else np.roll(a, -1, axis=turn)
        for site, vector in ((0, other), (1, back)):
            gradient[:, :, site] += 0.1 * vector
            gradient[:, :, site, axis] += strength * vector[:, :, axis]
    return np.cross(gradient.reshape(-1, 3), w)


def glass(t, w):
    """S' = S x dH/dS on the edges of the file."""
    gradient = np.tile([0, 0, -0.05], (24, 1))
    for i, j, c in np.loadtxt(USER / "spin_glass_edges.csv", delimiter=",", skiprows=2):
        gradient[int(i)] -= c * w[int(j)]
        gradient[int(j)] -= c * w[int(i)]
    return np.cross(w, gradient)


def chain(t, w):
    """S' = S x dH/dS with neighbours, next neighbours, an easy axis and a modulated field."""
    near, far = (np.roll(w, k, axis=0) + np.roll(w, -k, axis=0) for k in (1, 2))
    gradient = -near + 0.4 * far
    gradient[:, 2] -= 0.3 * w[:, 2] + 0.3 * np.cos(2 * np.pi * np.arange(20) / 20)
    return np.cross(w, gradient)


@pytest.mark.parametrize("name, motion", [
    ("kicked_spin", kicked), ("signed_vortices", vortices), ("spin_glass", glass), *(pytest.param(name, motion, marks=pytest.mark.long) for name, motion in (
        ("coupled_tops", tops), ("j1j2_chain", chain), ("kitaev_honeycomb", kitaev)))])
def test_the_motion_is_that_of_the_field(name, motion):
    """The distance from the flow of the equations by hand falls by four when h is halved."""
    spec = smidgen.load(path(name))
    model = smidgen.build(spec)
    start = model.start(spec.runs[0].start, h=0.02).w.copy()
    exact = runge_kutta(motion, start, 0.8, 800)
    coarse, fine = (np.abs(model.start(start.copy(), h=h).steps(round(0.8 / h)).w - exact).max() for h in (0.02, 0.01))
    assert np.abs(exact - start).max() > 0.05 and coarse < 1e-2 and 3.8 < coarse / fine < 4.2


# What a user gives beside the spec

TRIANGLE = "0,0,1\n0,1,0\n1,0,0\n"


@pytest.mark.parametrize("head", ["", "x,y,z\n", "# by hand\n\nx, y, z\n"])
def test_a_start_from_a_file(command, tmp_path, head):
    (tmp_path / "here.csv").write_text(head + TRIANGLE)
    said = command("run", path("signed_vortices"), "--start", "here.csv", "--steps", 1, "--out", "a.npz")
    assert said.returncode == 0, said.stderr
    np.testing.assert_array_equal(smidgen.load_result(tmp_path / "a.npz").w["x"][0], [[0, 0, 1], [0, 1, 0], [1, 0, 0]])


def test_a_start_off_its_sphere_is_named(command, tmp_path):
    (tmp_path / "here.csv").write_text(TRIANGLE.replace("0,1,0", "0,0.9,0"))
    said = command("run", path("signed_vortices"), "--start", "here.csv")
    assert said.returncode == 4 and "site 1: |w| = 0.9, but its sphere has radius 1" in said.stderr


@pytest.mark.parametrize("words, told", [
    (["signed_vortices", "--seed", 4], "nothing in start 'triangle' is random"),
    (["kitaev_honeycomb", "--set", "nx=2,ny=2"], "use a separate --set for each"),
    (["kitaev_honeycomb", "--solver", "newton"], "use solver rotation or plain"),
    (["kicked_spin", "--h", "0.03"], "the nearest are 19.98 (666 steps) and 20.01 (667 steps)")])
def test_what_a_run_refuses(command, words, told):
    said = command("run", path(words[0]), *words[1:])
    assert said.returncode == 2 and told in said.stderr and "Traceback" not in said.stderr


def test_nested_pieces_stay_small():
    """The least of eight numbers is a line of C, not all the orders in which they can lie."""
    inner = "w[0].x"
    for k in range(1, 8):
        inner = f"{('min', 'max')[k % 2]}(w[{k % 3}].{'xyz'[k % 3]} + {k / 16}, {inner})"
    text = "\n".join(['[model]', 'name = "pieces"', '[space]', 'w = { sphere = 3 }', '[effects.e]',
                      f'energy = "w[0].z*w[1].x + w[2].y + 0.1*({inner})^2"', '[starts.s]', 'random = 1'])
    spec = smidgen.load_text(text)
    model = smidgen.build(spec)
    w = model.start("s", h=0.1).w.copy()
    least = w[0, 0]
    for k in range(1, 8):
        least = (min, max)[k % 2](w[k % 3, k % 3] + k / 16, least)
    assert model.energy(w) == pytest.approx(w[0, 2] * w[1, 0] + w[2, 1] + 0.1 * least**2, rel=1e-14)
