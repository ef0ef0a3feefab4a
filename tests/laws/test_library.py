"""The pieces of the library: each does what its law says, by a formula of its own, in numbers."""
import re
import tomllib

import numpy as np
import pytest

import smidgen
from smidgen.check.laws import OPTIONS, moving, verdicts, written
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.language import draws
from smidgen.read.catalogue import piece
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


@pytest.mark.parametrize("form, g", [("gilbert", 1 / (1 + 0.2 ** 2)), ("ll", 1)])
@pytest.mark.parametrize("part", [0.7, 1, 1.4])
def test_slonczewskis_torque_and_its_threshold(form, g, part):
    """tau = alpha lam balances damping."""
    w, lam = directions(2), 0.9 / 1.7
    spec = spec_of("spins/slonczewski", tau=part * 0.2 * lam, p=[0, 0, 1],
                   more=f'[effects.f]\nuse = "spins/zeeman"\nB = [0, 0, 0.9]\n[effects.d]\nuse = "spins/damping"\nalpha = 0.2\nform = "{form}"\n')
    same(moved(spec, w)[:, 2], np.tanh(g * 0.2 * lam * (1 - part) * 1.5 + np.arctanh(w[:, 2])))


@pytest.mark.parametrize("orientation", [1, -1])
def test_spin_orbit_torque_drives_and_turns_about_its_direction(orientation):
    w, p = directions(2), np.array([2, -1, 2]) / 3
    found = moved(spec_of("spins/spin_orbit", orientation=orientation, tau=0.15, eta=0.4, p=p.tolist()), w)
    still = moved(spec_of("spins/spin_orbit", tau=0.15, p=p.tolist()), w)
    same(found @ p, np.tanh(np.arctanh(w @ p) - 0.15 * 1.5))
    same(found, turned(still, p, -0.4 * 1.5))


LINE = '[lattices.line]\nsize = ["n"]\nboundary = "open"\nbonds.next = [{ offset = [1] }]\nbonds.three = [{ at = [[0, -1], [0, 0], [0, 1]] }]\n'
WALL = """[effects.exchange]
use = "spins/exchange"
J = 1
bonds = "line.next"
[effects.axis]
use = "spins/uniaxial"
K = 0.0625
[effects.damping]
use = "spins/damping"
alpha = 0.1
[starts.wall]
theta = "2*atan(exp((i - 30)/sqrt(8)))"
phi = 0.3
"""


@pytest.mark.parametrize("beta, speed, rate", [(0.1, 0.979, 0), (0.0, 0.969, -1.741e-3), (0.2, 0.988, 1.741e-3)])
def test_a_wall_under_zhang_lis_torque(beta, speed, rate):
    """A wall of width sqrt(J/(2K)): its azimuth turns at (beta - alpha) u/(d (1 + alpha^2)), 1.750e-3 of a wall in the continuum."""
    spec = spec_of("spins/zhang_li", 'w = { sphere = "n" }', parameters="n = 80", u=0.05, beta=beta, bonds="line.three", more=LINE + WALL)
    one, found = smidgen.build(spec).start("wall", h=0.2).steps(200), []
    for _ in range(2):
        w, z = one.w, one.w[:, 2]
        k = np.flatnonzero((z[:-1] > 0) & (z[1:] <= 0))[0]
        found.append((k + z[k] / (z[k] - z[k + 1]), np.arctan2(w[:, 1].sum(), w[:, 0].sum())))
        one.steps(600)
    place, azimuth = np.subtract(found[1], found[0]) / 120
    assert abs(place / 0.05 - speed) < 2e-3 and abs(azimuth - rate) < 1e-5


def test_random_bonds_and_axes_are_those_of_their_seed():
    w, i, a = directions(6), np.arange(5), np.arange(6)
    J = 0.3 + 0.8 * draws.normal(5, i, i + 1)
    energy, b = energy_and_slopes(spec_of("spins/random_bonds", "w = { sphere = 6 }", bonds="chain(6, open)", mean=0.3, spread=0.8, seed=5), w)
    same(energy, -np.sum(J * np.sum(w[:-1] * w[1:], axis=1)))
    same(b[2], -J[1] * w[1] - J[2] * w[3])
    n = np.stack([draws.normal(4 + k, a) for k in range(3)], axis=1)
    n /= np.linalg.norm(n, axis=1)[:, None]
    energy, b = energy_and_slopes(spec_of("spins/random_anisotropy", "w = { sphere = 6 }", K=0.6, seed=4), w)
    same(energy, -0.6 * np.sum(np.sum(w * n, axis=1) ** 2))
    same(b, -1.2 * np.sum(w * n, axis=1)[:, None] * n)


def test_pinned_edges_stay_and_vacancies_leave_a_chain():
    more = '[effects.f]\nuse = "spins/exchange"\nJ = 1.1\nbonds = "chain(6, open)"\n'
    w, there = directions(6), draws.uniform(3, np.arange(6)) >= 0.3
    assert np.array_equal(moved(spec_of("spins/pinned_edge", "w = { sphere = 6 }", where="i < 2", more=more), w)[:2], w[:2])
    energy, b = energy_and_slopes(spec_of("spins/vacancies", "w = { sphere = 6 }", part=0.3, seed=3, more=more), w)
    bonds = there[:-1] & there[1:]
    assert bonds.any() and not bonds.all()
    same(energy, -1.1 * np.sum(bonds * np.sum(w[:-1] * w[1:], axis=1)))
    part = np.mean(draws.uniform(3, np.arange(100_000)) < 0.3)
    assert abs(part - 0.3) < 3 * np.sqrt(0.21 / 100_000)


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


@pytest.mark.parametrize("orientation", [1, -1])
def test_gravity_turns_a_fast_body_about_the_normal_of_its_orbit(orientation):
    w, normal = 1.7 * directions(1), np.array([2, -1, 2]) / 3
    spec = spec_of("bodies/gravity_gradient", "w = { r3 = 1 }", orientation=orientation, n=0.9, CA=0.7, normal=normal.tolist())
    same(moved(spec, w), turned(w, normal, orientation * 1.5 * 1.5 * 0.9 ** 2 * 0.7 * (w[0] @ normal) / 1.7 ** 2))


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


@pytest.mark.parametrize("Omega", [0.0, 0.6])
def test_a_ring_of_vortices_turns_at_one_rate_with_the_sphere_or_without(Omega):
    """N of strength gamma at the height z: (N - 1) gamma z / (4 pi (1 - z^2)), and Omega."""
    n, gamma, z, phi = 5, 0.8, 0.6, 2 * np.pi * np.arange(5) / 5
    ring = np.stack([0.8 * np.cos(phi), 0.8 * np.sin(phi), np.full(n, z)], -1)
    spec = spec_of("vortices/interaction", 'w = { sphere = 5, kappa = "gamma[i]" }', orientation=-1, parameters="gamma = { default = 0.8, size = 5 }",
                   gamma="gamma", more=f'[effects.f]\nuse = "vortices/rotation"\nOmega = {-Omega}\ngamma = "gamma[i]"\n')
    same(moved(spec, ring), turned(ring, Z, 1.5 * ((n - 1) * gamma * z / (4 * np.pi * (1 - z * z)) + Omega)))


def test_a_stream_function_of_latitude_turns_sites_about_the_axis():
    w = directions(3)
    found = moved(spec_of("vortices/stream_function", "p = { sphere = 3 }", psi="0.3*p[i].z^2*cos(t)"), w)
    same(found, [turned(v, Z, -0.6 * v[2] * np.sin(1.5)) for v in w])


def test_a_stream_function_by_its_coefficients_turns_sites_about_its_axis():
    """l = 1 is a turn about (a_11, a_1-1, a_10); l = 0 does nothing."""
    w, a = directions(3), np.array([0.7, 0.2, 0.5, -0.3])
    found = moved(spec_of("vortices/stream_coefficients", "p = { sphere = 3 }", parameters=f"psi = {{ default = {a.tolist()}, size = 4 }}", a="psi"), w)
    axis = np.array([a[3], a[1], a[2]])
    same(found, [turned(v, axis / np.linalg.norm(axis), -np.sqrt(3 / (4 * np.pi)) * np.linalg.norm(axis) * 1.5) for v in w])


@pytest.mark.parametrize("method", ["spherical-midpoint", "dop853"])
def test_tracers_of_a_rossby_haurwitz_wave_keep_its_stream_function_in_the_frame_of_the_wave(method):
    """It turns at c = omega - 2 (omega + Omega)/(l (l + 1)), l = 5."""
    A, omega, Omega, time, w = 0.9, 0.2, 1.3, 10.0, directions(50)
    c = omega - 2 * (omega + Omega) / 30
    spec = spec_of("vortices/rossby_haurwitz", "v = { sphere = 1 }\np = { sphere = 50, tracer = true }", A=A, omega=omega, Omega=Omega, more='[effects.f]\nenergy = "v.z"\n')
    found = moved(spec, np.vstack([Z, w]), time, method, 1000)[1:]

    def stream(v):
        return (c - omega) * v[:, 2] + A * v[:, 2] * ((v[:, 0] + 1j * v[:, 1]) ** 4).real
    assert np.linalg.norm(found - w, axis=1).min() > 0.01
    same(stream(turned(found, Z, -c * time)), stream(w), 1e-10 if method == "dop853" else 1e-4)


# The laws that pieces carry themselves

@pytest.mark.parametrize("name", pieces())
def test_the_law_of_a_piece_holds_and_a_wrong_sign_is_seen(name, tmp_path):
    """Its energy, torque or damping with another sign or size is another law, as is the opposite condition."""
    laws = verdicts(piece(name))
    assert laws and all(law.passed for law in laws), laws
    tables = tomllib.loads(pieces()[name].read_text())
    effect = tables["effect"]
    key = next(key for key in ("kT", "damping", "torque", "energy", "pinned", "absent") if key in effect)
    other = {"kT": "2*", "damping": "2*", "pinned": "not ", "absent": "not "}.get(key, "-1*")
    effect[key] = f"{other}({effect[key]})"
    (tmp_path / "wrong.toml").write_text(written(tables))
    assert not all(law.passed for law in verdicts(piece("wrong", [tmp_path]), [tmp_path]))


def test_every_piece_says_what_it_is_and_what_its_arguments_mean():
    text = open(__file__, encoding="utf-8").read()
    assert [name for name in pieces() if f'"{name}"' not in text] == []
    for one in map(piece, pieces()):
        assert one.title and one.source and one.law and all(says.get("meaning") for says in one.arguments.values()), one.name
        assert len(open(one.path).read().partition("[test]")[0].partition("[effect]")[2].splitlines()) < 10


def test_a_piece_without_a_test_and_one_whose_test_is_no_spec(tmp_path):
    text = pieces()["spins/zeeman"].read_text()
    (tmp_path / "plain.toml").write_text(text.partition("[test]")[0])
    assert verdicts(piece("plain", [tmp_path]), [tmp_path]) == []
    for old, new, said in (
            ("law = [", 'law = ["w[0] = w0[0]", ', "left == right"), ("B = [0.3", "C = [0.3", "does not give `B`"), ("mu = 2 }", 'mu = 2 }\nwithin = "much"', "`within` is a number"),
            ("mu = 2 }", "mu = 2 }\nsteps = 0", "`steps` must be at least 1"), ("law = [", "law = [3, ", "as text")):
        (tmp_path / "wrong.toml").write_text(text[:text.index("[test]")] + text[text.index("[test]"):].replace(old, new))
        with pytest.raises(smidgen.SmidgenError, match=said):
            verdicts(piece("wrong", [tmp_path]), [tmp_path])
    (tmp_path / "none.toml").write_text(text[:text.index("[test]")] + "[test]\narguments = { B = [0, 0, 1] }\n")
    with pytest.raises(smidgen.UsageError, match="at least one law"):
        verdicts(piece("none", [tmp_path]), [tmp_path])


# A scene without a piece, and with it

def with_and_without(name):
    """The spec of the test of a piece with an energy more for each family, the names of those energies and of others, and the spec that never had the piece."""
    one = piece(name)
    tables = tomllib.loads(moving(one, {**OPTIONS, **one.test}))
    tables["observables"], tables["effects"] = {}, {"it": tables["effects"]["it"]}
    rest = {f"rest_{family}": {"over": f"site(i) of {family}", "energy": f"0.25*{family}[i].z"} for family in tables["space"]}
    never = {**tables, "effects": rest}
    return smidgen.load_text(written({**tables, "effects": {**tables["effects"], **rest}})), [*rest], smidgen.load_text(written(never))


def plain(files):
    """The texts without the digest of the spec."""
    return {name: re.sub(r"from spec \w+", "", text) for name, text in files.items()}


@pytest.mark.parametrize("name", pieces())
def test_a_scene_without_a_piece_has_the_c_of_one_that_never_had_it(name):
    both, rest, never = with_and_without(name)
    found, wanted = plain(generate(select(both, rest))), plain(generate(select(never)))
    assert found == wanted and plain(generate(select(both))) != wanted
    assert not any(re.search(r"\bit_|_it_|effect_it", text) for text in found.values())


@pytest.mark.long
@pytest.mark.parametrize("name", pieces())
def test_the_witness_agrees_on_every_piece(name):
    both, _, _ = with_and_without(name)
    smidgen.validate(both, start="a", h=0.05, steps=5).check()
