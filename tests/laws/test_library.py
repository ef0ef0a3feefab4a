"""The pieces of the library: each does what its law says, by a formula of its own, in numbers."""
import numpy as np
import pytest

import smidgen
from smidgen.resources import pieces

pytestmark = pytest.mark.quick
RNG = np.random.default_rng(5)
Z, AXES = np.array([0.0, 0, 1]), {"x": 0, "y": 1, "z": 2}


def directions(count):
    w = RNG.standard_normal((count, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]


def spec_of(use, space="w = { sphere = 2, kappa = 1.7 }", orientation=1, parameters="", more="", **arguments):
    lines = "\n".join(f'{name} = {value if not isinstance(value, str) else chr(34) + value + chr(34)}' for name, value in arguments.items())
    return smidgen.load_text(f'[model]\nname = "m"\norientation = {orientation}\n[space]\n{space}\n[parameters]\n{parameters}\n[effects.e]\nuse = "{use}"\n{lines}\n{more}')


def moved(spec, w, time=1.5, method="gauss-12", steps=60):
    return smidgen.build(spec, method=method).start(w.copy(), h=time / steps).steps(steps).state()


def turned(w, axis, angle):
    """Rodrigues: w about the axis, counter-clockwise for positive angles."""
    k = axis / np.linalg.norm(axis)
    return w * np.cos(angle) + np.cross(k, w) * np.sin(angle) + k * (w @ k)[..., None] * (1 - np.cos(angle))


def energy_and_slopes(spec, w):
    model = smidgen.build(spec).start(w.copy(), h=0.1)
    return model.energy(), model.field()


def same(found, wanted, within=2e-12):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=within)


# Spins

@pytest.mark.parametrize("use, arguments, rate", [
    ("spins/exchange", {"J": 0.8}, lambda c: 0.8), ("spins/biquadratic", {"B": 0.6}, lambda c: 1.2 * c), ("bodies/coupling", {"g": 0.8}, lambda c: -0.8),
    ("spins/exchange_tensor", {"x": [0.8, 0, 0], "y": [0, 0.8, 0], "z": [0, 0, 0.8]}, lambda c: 0.8)])
def test_pairs_turn_about_their_sum(use, arguments, rate):
    w = directions(2)
    total = w.sum(0)
    angle = 1.5 * rate(w[0] @ w[1]) * np.linalg.norm(total) / 1.7
    same(moved(spec_of(use, bonds="chain(2, open)", **arguments), w), turned(w, total, angle))


def test_exchange_by_a_matrix():
    w, matrix = directions(2), RNG.standard_normal((3, 3))
    rows = dict(zip("xyz", matrix.tolist()))
    energy, b = energy_and_slopes(spec_of("spins/exchange_tensor", bonds="chain(2, open)", **rows), w)
    same(energy, -w[0] @ matrix @ w[1])
    same(b * 1.7, [-matrix @ w[1], -matrix.T @ w[0]])


def test_dmi_turns_neighbours_in_the_ground_state():
    n, J, D = 5, 1.1, 0.4
    angle = -np.arctan(D / J)
    spiral = np.array([[np.cos(k * angle), np.sin(k * angle), 0] for k in range(n)])
    spec = spec_of("spins/dmi", f"w = {{ sphere = {n} }}", D=[0, 0, D], bonds=f"chain({n}, open)",
                   more=f'[effects.f]\nuse = "spins/exchange"\nJ = {J}\nbonds = "chain({n}, open)"\n')
    same(moved(spec, spiral), spiral)
    assert energy_and_slopes(spec, spiral)[0] == pytest.approx(-(n - 1) * np.hypot(J, D), rel=1e-14)


@pytest.mark.parametrize("axis", AXES)
def test_kitaev_turns_both_about_the_axis(axis):
    w, k = directions(2), AXES[axis]
    found = moved(spec_of("spins/kitaev", K=-0.7, axis=axis, bonds="chain(2, open)"), w)
    same(found, [turned(w[a], np.eye(3)[k], 1.5 * 0.7 * w[1 - a][k] / 1.7) for a in (0, 1)])


def test_gamma_is_a_matrix_with_two_entries():
    w, matrix = directions(2), np.zeros((3, 3))
    matrix[0, 2] = matrix[2, 0] = 0.9
    energy, b = energy_and_slopes(spec_of("spins/gamma", G=0.9, a="x", b="z", bonds="chain(2, open)"), w)
    same(energy, w[0] @ matrix @ w[1])
    same(b * 1.7, [matrix @ w[1], matrix @ w[0]])


def test_ring_exchange():
    w = directions(4)
    spec = spec_of("spins/ring", "w = { sphere = 4 }", K=0.3, plaquettes="square.ring",
                   more='[lattices.square]\nsize = [1]\nsites = 4\nboundary = "open"\nbonds.ring = [{ at = [[0, 0], [1, 0], [2, 0], [3, 0]] }]\n')
    d = w @ w.T
    same(energy_and_slopes(spec, w)[0], 0.3 * (d[0, 1] * d[2, 3] + d[0, 3] * d[1, 2] - d[0, 2] * d[1, 3]))
    same(moved(spec, w).sum(0), w.sum(0))


@pytest.mark.parametrize("axis", [[0, 0, 1], [1, -2, 0.5]])
def test_uniaxial_anisotropy_turns_spins_about_the_axis(axis):
    w, a = directions(2), np.array(axis) / np.linalg.norm(axis)
    found = moved(spec_of("spins/uniaxial", K=0.6, axis=axis), w)
    same(found, [turned(v, a, 1.5 * 1.2 * (v @ a) / 1.7) for v in w])


def test_cubic_anisotropy_of_three_directions():
    w = np.array([[1.0, 0, 0], [1, 1, 0], [1, 1, 1]])
    w /= np.linalg.norm(w, axis=1)[:, None]
    spec = spec_of("spins/cubic", "w = { sphere = 1 }", K1=0.7, K2=-0.4)
    same([energy_and_slopes(spec, v[None])[0] for v in w], [0, 0.7 / 4, 0.7 / 3 - 0.4 / 27])


def test_a_field_turns_spins():
    w, B = directions(2), np.array([0.3, -0.5, 0.2])
    same(moved(spec_of("spins/zeeman", B=B.tolist(), mu=2), w), turned(w, B, 1.5 * 2 * np.linalg.norm(B) / 1.7))


def test_a_field_in_time_turns_spins_by_its_integral():
    w = directions(2)
    same(moved(spec_of("spins/zeeman", B="vec(0, 0, cos(2*t))"), w), turned(w, Z, np.sin(3.0) / 2 / 1.7))


@pytest.mark.parametrize("form, g", [("gilbert", 1 / (1 + 0.2 ** 2)), ("ll", 1)])
@pytest.mark.parametrize("use, more", [("spins/damping", {}), ("spins/bath", {"kT": 0})])
def test_damping_raises_spins_in_a_field(form, g, use, more):
    w = directions(2)
    spec = spec_of(use, alpha=0.2, form=form, more='[effects.f]\nuse = "spins/zeeman"\nB = [0, 0, 0.9]\n', **more)
    found = moved(spec, w, steps=400) if not more else moved(spec, w, method="spherical-midpoint", steps=4000)
    same(found[:, 2], np.tanh(g * 0.2 * 0.9 * 1.5 / 1.7 + np.arctanh(w[:, 2])), 2e-12 if not more else 1e-7)


# Bodies

INERTIA = np.array([[1.0, 0.1, -0.2], [0.1, 2.0, 0.3], [-0.2, 0.3, 3.0]])
ENTRIES = {"Ixx": 1.0, "Iyy": 2.0, "Izz": 3.0, "Ixy": 0.1, "Iyz": 0.3, "Izx": -0.2}


def test_rotation_has_the_full_tensor():
    w = RNG.standard_normal((1, 3))
    energy, b = energy_and_slopes(spec_of("bodies/rotation", "w = { r3 = 1 }", **ENTRIES), w)
    same(energy, w[0] @ np.linalg.solve(INERTIA, w[0]) / 2)
    same(b[0], np.linalg.solve(INERTIA, w[0]))


def test_a_symmetric_top_turns_about_its_axis():
    w = RNG.standard_normal((1, 3))
    found = moved(spec_of("bodies/rotation", "w = { r3 = 1 }", Ixx=1.0, Iyy=1.0, Izz=3.0), w)
    same(found, turned(w, Z, 1.5 * w[0, 2] * (1 - 1 / 3)))


def test_a_gyrostat_at_rest():
    omega = RNG.standard_normal(3)
    w = 1.3 * omega
    spec = spec_of("bodies/gyrostat", "w = { r3 = 1 }", rotor=(w - INERTIA @ omega).tolist(), **ENTRIES)
    same(moved(spec, w[None]), w[None])
    energy, b = energy_and_slopes(spec, (w + 0.1)[None])
    same(b[0], omega + np.linalg.solve(INERTIA, np.full(3, 0.1)))


def test_forcing_turns_by_its_integral():
    w = RNG.standard_normal((1, 3))
    spec = spec_of("bodies/forcing", "w = { r3 = 1, kappa = 1.7 }", strength=0.8, omega=2.0)
    same(moved(spec, w), turned(w, Z, -0.8 * (1 - np.cos(3.0)) / 2.0 / 1.7))


def test_damping_of_bodies_keeps_their_momentum():
    w, alpha = RNG.standard_normal((1, 3)), 0.3
    spec = spec_of("bodies/damping", "w = { r3 = 1 }", alpha=alpha, more='[effects.f]\nuse = "bodies/rotation"\nIxx = 1.0\nIyy = 2.0\nIzz = 3.0\n')
    h = 1e-4
    before, after = (smidgen.build(spec).start(v.copy(), h=0.1).energy() for v in (w, moved(spec, w, h, steps=1)))
    b = w[0] / [1, 2, 3]
    assert (after - before) / h == pytest.approx(-alpha * np.linalg.norm(np.cross(w[0], b)) ** 2, rel=1e-3)
    same(np.linalg.norm(moved(spec, w)), np.linalg.norm(w))


# Vortices

VORTICES = {"space": 'w = { sphere = 2, kappa = "gamma[i]" }', "parameters": "gamma = { default = [1.0, -0.4], size = 2 }"}


@pytest.mark.parametrize("orientation", [1, -1])
def test_two_vortices_turn_about_their_momentum(orientation):
    w, gamma = directions(2), np.array([1.0, -0.4])
    moment = gamma @ w
    rate = -orientation * np.linalg.norm(moment) / (4 * np.pi * (1 - w[0] @ w[1]))
    same(moved(spec_of("vortices/interaction", orientation=orientation, gamma="gamma", **VORTICES), w), turned(w, moment, 1.5 * rate))


@pytest.mark.parametrize("orientation", [1, -1])
def test_vortices_of_any_strength_turn_with_the_sphere(orientation):
    w = directions(2)
    spec = spec_of("vortices/rotation", orientation=orientation, Omega=0.9, gamma="gamma[i]", **VORTICES)
    same(moved(spec, w), turned(w, Z, orientation * 1.5 * 0.9))


def test_tracers_are_carried_and_do_not_act():
    w, gamma = directions(5), np.array([1.0, -0.4])
    carried = spec_of("vortices/transport", VORTICES["space"] + "\np = { sphere = 3, tracer = true }", parameters=VORTICES["parameters"], gamma="gamma",
                      more='[effects.f]\nuse = "vortices/interaction"\ngamma = "gamma"\n')
    _, b = energy_and_slopes(carried, w)
    wanted = [sum(gamma[j] * w[j] / (4 * np.pi * (1 - w[j] @ p)) for j in (0, 1)) for p in w[2:]]
    same(np.cross(w[2:], b[2:]), np.cross(w[2:], wanted))
    alone = moved(spec_of("vortices/interaction", gamma="gamma", **VORTICES), w[:2], method="spherical-midpoint")
    same(moved(carried, w, method="spherical-midpoint")[:2], alone, 1e-14)


def test_every_piece_has_a_law_that_is_tested():
    text = open(__file__, encoding="utf-8").read()
    assert [name for name in pieces() if f'"{name}"' not in text] == []
    for path in pieces().values():
        head = path.read_text()
        assert all(f"\n{key} = " in head for key in ("title", "source", "law"))
