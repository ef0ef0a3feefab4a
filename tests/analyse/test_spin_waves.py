"""Lines of linear spin waves: closed forms, the derivative of the compiled motion, the maxima of S(q, omega) of runs, refusals, files, the command."""
import json

import numpy as np
import pytest
import smidgen
from support.lattices import random_spins

pytestmark = pytest.mark.quick
MAGNET = """[model]
name = "magnet"
orientation = {orientation}
[space]
w = {{ sphere = "{count}", kappa = 2, radius = 1.5 }}
[parameters]
n = {n}
J = {J}
[effects.exchange]
over = "bond(i, j) of {lattice}(n{more_n}, periodic)"
energy = "-J*dot(w[i], w[j])"
{more}
[starts.order]
theta = "{theta}"
phi = "{phi}"
[runs.demo]
start = "order"
h = 0.05
time = 120
output = {{ every = 4, what = ["states"] }}
"""
RATE = 0.8 * 1.5 / 2        # J r/kappa
NEEL, TURNS = "pi*mod(i + floor(i/n), 2)", "2*pi/3*(mod(i, n) + floor(i/n))"
FIELD = '[effects.field]\nover = "site(i) of w"\nenergy = "-0.2*w[i].z"\n'
AXIS = '[effects.axis]\nover = "site(i) of w"\nenergy = "-0.1*w[i].z^2"\n'
DMI = '[effects.dmi]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-J*tan(2*pi/8)*cross(w[i], w[j]).z"\n'


def magnet(lattice, sites=1, n=6, theta="0", phi="0", J=0.8, more="", orientation=1):
    dimension = 1 if lattice == "chain" else 2
    return smidgen.load_text(MAGNET.format(lattice=lattice, count="*".join([str(sites)] + ["n"] * dimension), more_n=", n" * (dimension - 1), n=n, theta=theta,
                                           phi=phi, J=J, more=more, orientation=orientation))


def triangular_gamma(q):
    """The mean of cos(q.d) over the six neighbours."""
    return (np.cos(2 * np.pi * q).sum(axis=1) + np.cos(2 * np.pi * (q[:, 0] + q[:, 1]))) / 3


# Closed forms

@pytest.mark.parametrize("lattice, sites, q, wanted", [
    ("chain", 1, "0 1/2", lambda q: [2 - 2 * np.cos(2 * np.pi * q[:, 0])]),
    ("square", 1, "0,0 1/2,0 1/2,1/2 0,0", lambda q: [4 - 2 * np.cos(2 * np.pi * q).sum(axis=1)]),
    ("honeycomb", 2, "Gamma K M Gamma", lambda q: [3 - root(q), 3 + root(q)]),
    ("kagome", 3, "Gamma K M Gamma", lambda q: [3 - root_of_kagome(q), 3 + root_of_kagome(q), 6 + 0 * q[:, 0]])])
@pytest.mark.parametrize("orientation", [1, -1])
def test_lines_of_ferromagnets(lattice, sites, q, wanted, orientation):
    """The flat line of kagome lies at 6: D. L. Bergman, C. Wu, L. Balents, Phys. Rev. B 78 (2008) 125104."""
    found = smidgen.spin_waves(magnet(lattice, sites, orientation=orientation), q=q)
    lines = np.sort(np.stack(wanted(found.q), axis=1), axis=1)
    np.testing.assert_allclose(found.omega, RATE * lines, atol=1e-7)
    assert found.meta["stable"] and not found.growth.any() and set(found.meta["cell"]) == {1}


def root(q):
    """|1 + exp(i q.a_1) + exp(i q.a_2)|, with the vectors of neighbours of `honeycomb`."""
    a, b = 2 * np.pi * q.T
    return np.abs(1 + np.exp(1j * a) + np.exp(1j * (a + b)))


def root_of_kagome(q):
    a, b = np.pi * q.T
    return np.sqrt(np.maximum(1 + 8 * np.cos(a) * np.cos(b) * np.cos(a + b), 0))


def test_lines_of_neel_order_in_a_field_along_its_easy_axis():
    """omega kappa = sqrt((4 J r + 2 K r)^2 - (4 J r gamma)^2) +- B; F. Keffer, C. Kittel, Phys. Rev. 85 (1952) 329."""
    found = smidgen.spin_waves(magnet("square", n=4, theta=NEEL, J=-0.8, more=FIELD + AXIS), q="0,0 1/2,0 1/2,1/2 0,0")
    whole, part = 1.5 * (4 * 0.8 + 0.2), 1.5 * 4 * 0.8 * np.cos(2 * np.pi * found.q).mean(axis=1)
    middle = np.sqrt(whole ** 2 - part ** 2)
    assert found.meta["cell"] == [2, 2] and found.meta["stable"]
    for sign in (1, -1):
        wanted = (middle + sign * 0.2) / 2
        assert np.abs(found.omega - wanted[:, None]).min(axis=1).max() < 1e-9
        seen = np.where(found.seen, found.omega, np.inf)
        assert np.abs(seen - wanted[:, None]).min(axis=1).max() < 1e-9
    assert found.omega.shape[1] == 4


@pytest.mark.parametrize("cell, lines", [(None, 3), ((3, 3), 9)])
def test_lines_of_the_order_of_120_degrees(cell, lines):
    """omega = 3 J S sqrt((1 - gamma)(1 + 2 gamma)) at q for the component across the plane, at q + Q and q - Q for those in it: Th. Jolicoeur,
    J. C. Le Guillou, Phys. Rev. B 40 (1989) 2727."""
    spec = magnet("triangular", theta="pi/2", phi=TURNS, J=-0.8)
    found = smidgen.spin_waves(spec, q=[[1 / 6, 0], [1 / 6, 1 / 3], [1 / 2, 0], [0.21, 0.33], [1 / 2, 1 / 6]], cell=cell)
    assert found.omega.shape == (5, lines) and found.meta["turns"] == ([] if cell else pytest.approx([120, 120]))

    def wanted(shift):
        gamma = triangular_gamma(found.q + shift * np.array([1 / 3, 1 / 3]))
        return 3 * RATE * np.sqrt((1 - gamma) * (1 + 2 * gamma))
    for shift in (-1, 0, 1):
        seen = np.where(found.seen & (found.weights[..., 2 if shift == 0 else 0] > 1e-9), found.omega, np.inf)
        assert np.abs(seen - wanted(shift)[:, None])[[0, 1, 2, 4]].min(axis=1).max() < 1e-7
    if cell is None:
        np.testing.assert_allclose(np.sort([wanted(shift)[3] for shift in (-1, 0, 1)]), found.omega[3], atol=1e-7)


def test_lines_of_a_spiral_by_dzyaloshinskii_and_moriya():
    """Bonds of strength R = sqrt(J^2 + D^2) in the plane of the spiral, J across it: omega = 2 (r/kappa) sqrt(R (1 - cos k) (R - J cos k)) in the frame that turns."""
    found = smidgen.spin_waves(magnet("chain", n=24, theta="pi/2", phi="2*pi*i/8", more=DMI), q="0 1/2")
    k, whole = 2 * np.pi * found.q[:, 0], 0.8 / np.cos(2 * np.pi / 8)

    def wanted(k):
        return 1.5 * np.sqrt(whole * (1 - np.cos(k)) * (whole - 0.8 * np.cos(k)))
    assert found.meta["turns"] == pytest.approx([45]) and found.meta["cell"] == [1]
    lines = np.sort(np.stack([wanted(k + shift * np.pi / 4) for shift in (-1, 0, 1)], axis=1), axis=1)
    np.testing.assert_allclose(found.omega, lines, atol=1e-7)


def test_waves_to_the_left_and_to_the_right():
    """Along the field omega(q) and omega(-q) differ by the odd part of the bonds; a line of the other way is at the q that it has."""
    found = smidgen.spin_waves(magnet("chain", n=16, more=DMI.replace("tan(2*pi/8)", "0.3") + FIELD.replace("0.2", "2")), q="all")
    k = 2 * np.pi * found.q[:, 0]
    even, odd = 1.5 * 2 * 0.8 * (1 - np.cos(k)) + 2, 1.5 * 2 * 0.8 * 0.3 * np.sin(k)
    one, other = ((even + sign * odd) / 2 for sign in (1, -1))
    assert min(np.abs(found.omega[:, 0] - one).max(), np.abs(found.omega[:, 0] - other).max()) < 1e-12
    back = smidgen.spectrum(magnet("chain", n=16, more=DMI.replace("tan(2*pi/8)", "0.3") + FIELD.replace("0.2", "2")), q=[[3 / 16], [-3 / 16]], start=shaken(np.tile([0, 0, 1.5], (16, 1))),
                            theory="order", window="hann")
    assert peaks(back) == pytest.approx(back.theory.omega[:, 0], abs=back.resolution)
    assert abs(np.diff(back.theory.omega[:, 0])[0]) > 5 * back.resolution


def test_weights_are_those_of_equipartition():
    """<|S_x|^2> = kT/A(q), A = 2 J (1 - cos q) + B/r, half of it at omega > 0."""
    found = smidgen.spin_waves(magnet("chain", more=FIELD), q="0 1/2")
    curvature = 1.6 * (1 - np.cos(2 * np.pi * found.q[:, 0])) + 0.2 / 1.5
    np.testing.assert_allclose(found.weights[:, 0], np.outer(1 / (2 * curvature), [1, 1, 0]), atol=1e-12)


# The motion itself

@pytest.mark.parametrize("more, held", [("", 0), ('[effects.edge]\nover = "site(i) of w"\npinned = "i == 0"\n', 1)], ids=["free", "pinned"])
def test_frequencies_are_those_of_the_derivative_of_the_compiled_motion(more, held):
    """A disordered chain with open ends, for which there is no formula: eigenvalues of the derivative of w x b, by differences of the compiled field."""
    text = magnet("chain", n=7).sources[0][1].replace("chain(n, periodic)", "chain(n, open)").replace("-J*dot(w[i], w[j])", "-J*(1 + 0.3*normal(2, i, j))*dot(w[i], w[j]) - 0.3*w[i].x*w[j].z")
    spec = smidgen.load_text(text.replace("[starts.order]", FIELD + AXIS + more + "[starts.order]"))
    found = smidgen.spin_waves(spec, relax=True, start=shaken(1.5 * random_spins(7), 0.01), q=[[0.0]])
    assert found.meta["cell"] == [7] and found.meta["torque"] < 1e-9
    model = smidgen.build(spec).start(found.w, h=0.1)

    def rate(w):
        return (np.cross(w, model.field(w)) * (np.arange(7) >= held)[:, None]).ravel()
    moves = 1e-5 * np.eye(21).reshape(21, 7, 3)
    slope = np.stack([(rate(found.w + d) - rate(found.w - d)) / 2e-5 for d in moves], axis=1)
    values = np.linalg.eigvals(slope).imag
    assert found.omega.shape == (1, 7 - held)
    np.testing.assert_allclose(found.omega[0], np.sort(values)[-(7 - held):], atol=1e-6)


# Runs

def shaken(w, size=0.02, seed=5):
    """Near w: waves of every q at once, small enough not to meet."""
    moved = w + size * np.random.default_rng(seed).standard_normal(w.shape)
    return moved * (np.linalg.norm(w, axis=1) / np.linalg.norm(moved, axis=1))[:, None]


def peaks(found):
    up = found.omega >= 0
    return found.omega[up][found.mean[:, up].argmax(axis=1)]


@pytest.mark.parametrize("spec, path", [
    (magnet("honeycomb", 2, 6), "Gamma K M Gamma"), (magnet("square", n=12, theta=NEEL, J=-0.8), "0,0 1/2,0 1/2,1/2 0,0"),
    (magnet("triangular", n=12, theta="pi/2", phi=TURNS, J=-0.8), "Gamma K M Gamma")], ids=["ferromagnet", "neel", "120 degrees"])
def test_maxima_of_runs_lie_on_the_lines(spec, path):
    """Within one frequency: the strongest of each q on a line; and on each line that stands apart from the others a maximum."""
    w = smidgen.spin_waves(spec, q=path).w
    found = smidgen.spectrum(spec, q=path, start=shaken(w), window="hann", theory=True)
    lines = [omega[seen] for omega, seen in zip(found.theory.omega[::8], found.theory.seen[::8])]
    moving = [k for k, line in enumerate(lines) if line.max() > 4 * found.resolution]
    assert len(moving) > 4
    off = [np.abs(lines[k] - peaks(found)[k]).min() for k in moving]
    assert max(off) < found.resolution
    tested = 0
    for k in moving:
        apart = np.unique(np.round(lines[k], 6))
        for line in apart:
            if line > 4 * found.resolution and sum(np.abs(apart - line) < 5 * found.resolution) == 1:
                near = np.abs(found.omega - line) < 1.01 * found.resolution
                row, inner = found.mean[k], np.flatnonzero(near)
                assert any(row[m] > row[m - 1] and row[m] > row[m + 1] for m in inner), (found.q[k], line)
                tested += 1
    assert tested > 5


def test_what_neutrons_see():
    """S = sum S_aa for q along z across a ferromagnet of z: of a chain along x the component x falls away."""
    spec = magnet("chain", n=8)
    found = smidgen.spectrum(spec, q="0 1/2", start=shaken(np.tile([0, 0, 1.5], (8, 1))), neutron=True, parts=2)
    np.testing.assert_allclose(found.neutron[1:], found.s[1:, :, 1:].sum(axis=2), rtol=1e-9, atol=1e-15)
    assert np.all(found.neutron > -1e-12)
    plain = smidgen.load_text(magnet("chain", n=8).sources[0][1].replace("bond(i, j) of chain(n, periodic)", "bond(i, j) of ring.a") + '[lattices.ring]\nsize = ["n"]\n'
                              'boundary = "periodic"\nbonds.a = [{ from = 0, to = 0, offset = [1] }]\n')
    with pytest.raises(smidgen.UsageError, match="direction of q in space"):
        smidgen.spectrum(plain, neutron=True)
    assert smidgen.spin_waves(plain).omega.max() == pytest.approx(4 * RATE)


# Refusals, and what is told

def test_what_has_no_lines():
    chain = magnet("chain", theta="0.1*i")
    with pytest.raises(smidgen.UsageError, match=r"no equilibrium: \|n x g\| of a spin is up to 0\.\d+ of the largest field"):
        smidgen.spin_waves(chain)
    with pytest.raises(smidgen.UsageError, match="`field` depends on time"):
        smidgen.spin_waves(magnet("chain", more=FIELD.replace("w[i].z", "cos(t)*w[i].z")))
    with pytest.raises(smidgen.UsageError, match="a torque moves 'w'"):
        smidgen.spin_waves(magnet("chain", more='[effects.push]\nover = "site(i) of w"\ntorque = "cross(w[i], vec(0, 0, 0.1))"\n'))
    for cell, said in (((4,), r"divides its 6 cells"), ((1,), "does not repeat after 1 cells of direction 1: a spin differs by 2")):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spin_waves(magnet("chain", theta="pi*i", J=-0.8), cell=cell)
    for q, said in (([[0, 1]], "1 finite numbers"), ("0 1/5", "no wave of 6 cells")):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spin_waves(magnet("chain"), q=q)
    with pytest.raises(smidgen.UsageError, match=r"shape \(6, 3\), not \(5, 3\)"):
        smidgen.spin_waves(magnet("chain"), start=np.ones((5, 3)))
    with pytest.raises(smidgen.UsageError, match="1156 sites, more than 1000"):
        smidgen.spin_waves(magnet("square", n=34, more=FIELD.replace("0.2*", "(1 + 0.1*normal(1, i))*")))


def test_a_state_that_is_no_minimum():
    """A ferromagnet of antiferromagnetic bonds is a maximum, where nothing grows; with an axis across it modes grow."""
    quiet = smidgen.spin_waves(magnet("chain", J=-0.8), q="0 1/2")
    assert not quiet.meta["stable"] and "no minimum" in quiet.meta["notes"][0] and quiet.omega[-1, 0] == pytest.approx(4 * RATE)
    loud = smidgen.spin_waves(magnet("chain", more=AXIS.replace("0.1*w[i].z^2", "0.1*w[i].x^2 + 0.05*w[i].y^2")), q="0 1/2")
    assert "unstable: modes grow at 1 of 4 wave vectors, fastest at q = 0, at the rate" in loud.meta["notes"][0]
    assert loud.growth.max() == pytest.approx(1.5 / 2 * np.sqrt(0.2 * 0.1))


def test_relaxation_finds_the_order():
    w = shaken(smidgen.spin_waves(magnet("triangular", theta="pi/2", phi=TURNS, J=-0.8)).w, 0.3)
    found = smidgen.spin_waves(magnet("triangular", J=-0.8), start=w, relax=True)
    assert found.meta["turns"] == pytest.approx([120, 120]) and found.meta["torque"] < 1e-9 and found.meta["moved"] > 5
    assert found.meta["energy"] == pytest.approx(-36 * 1.5 * 0.8 * 1.5 ** 2)


# Files, the command

def test_files_keep_the_lines(tmp_path):
    from smidgen.show.plot.spectrum import draw_spectrum
    found = smidgen.spectrum(magnet("chain", n=8), q="0 1/2", time=20, theory=True, neutron=True)
    again = smidgen.load_spectrum(found.save(tmp_path / "a.npz"))
    assert again.theory.meta == found.theory.meta and again.save(tmp_path / "b.npz").read_bytes() == (tmp_path / "a.npz").read_bytes()
    for name in ("q", "omega", "weights", "growth", "w"):
        np.testing.assert_array_equal(getattr(again.theory, name), getattr(found.theory, name))
    np.testing.assert_array_equal(again.neutron, found.neutron)
    assert draw_spectrum(again, tmp_path / "a.png").stat().st_size > 1000
    assert smidgen.load_spectrum(found.save(tmp_path / "a.csv")).theory is None
    data = dict(np.load(tmp_path / "a.npz"))
    for broken in ({"theory_q": data["theory_q"][1:]}, {"theory_w": data["theory_w"][:, :2]}, {"theory_meta": np.array("{}")}, {"neutron": data["neutron"][1:]}):
        np.savez(tmp_path / "c.npz", **{**data, **broken})
        with pytest.raises(smidgen.UsageError, match="is not a file of a smidgen run"):
            smidgen.load_spectrum(tmp_path / "c.npz")


def test_the_command(command, tmp_path):
    (tmp_path / "m.toml").write_text(magnet("chain", n=8).sources[0][1])
    said = command("spectrum", "m.toml", "--q", "0 1/2", "--time", "20", "--neutron", "--out", "a.npz", "--plot", "a.png", "--theory")
    assert said.returncode == 0 and "linear spin waves: magnetic cell 1; |n x g| is 0 of the field" in said.stdout, said.stdout + said.stderr
    assert said.stdout.splitlines()[6].split()[-1] == "2.4"
    facts = json.loads(command("spectrum", "m.toml", "--q", "1/2", "--time", "20", "--theory=order", "--json").stdout)
    assert facts["theory"]["lines"] == [[pytest.approx(2.4)]] and facts["theory"]["stable"] is True
    refused = command("spectrum", "m.toml", "--theory=other", "--time", "20")
    assert refused.returncode == 2 and "no start 'other'" in refused.stderr
