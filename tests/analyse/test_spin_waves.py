"""Lines of linear spin waves: closed forms, refusals, what is told."""
import numpy as np
import pytest
import smidgen
from smidgen.analyse.spectrum import fitting
from support.magnets import AXIS, DMI, FIELD, NEEL, RATE, TURNS, magnet, shaken

pytestmark = pytest.mark.quick
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


@pytest.mark.parametrize("lattice, sites, basis, cell, theta, phi, more", [
    ("triangular", 1, None, (3, 3), "pi/2", TURNS, ""), ("chain", 1, None, (8,), "pi/2", "2*pi*i/8", DMI),
    ("ladder", 2, [[0.1], [0.4]], (8,), "pi/2", "2*pi*(floor(i/2) + mod(i, 2))/8", DMI.replace("chain", "ladder"))])
def test_weights_of_a_turning_frame_are_those_of_the_magnetic_cell(lattice, sites, basis, cell, theta, phi, more):
    """Two ways to the same S: one cell and a rotation, or many cells."""
    n = 6 if lattice == "triangular" else 24
    spec = magnet(lattice, sites, n, theta=theta, phi=phi, J=0.8 if more else -0.8, more=more)
    one, other = (smidgen.spin_waves(spec, q=[[1 / 6] * len(cell), [5 / 24, 0.5][:len(cell)], [1.5, 0.25][:len(cell)]], basis=basis, cell=c) for c in (None, cell))
    assert one.meta["turns"] and one.omega.shape[1] < other.omega.shape[1]
    for k, line in enumerate(one.omega):
        for omega in line[line > 1e-6]:
            near = [np.abs(found.omega[k] - omega) < 1e-6 for found in (one, other)]
            sums = [found.weights[k, at].sum(axis=0) for found, at in zip((one, other), near)]
            np.testing.assert_allclose(*sums, rtol=1e-6, atol=1e-9)
        assert other.weights[k][other.omega[k] > 1e-6].sum() == pytest.approx(one.weights[k][line > 1e-6].sum(), rel=1e-6)


def test_lines_of_a_spiral_by_dzyaloshinskii_and_moriya():
    """Bonds of strength R = sqrt(J^2 + D^2) in the plane of the spiral, J across it: omega = 2 (r/kappa) sqrt(R (1 - cos k) (R - J cos k)) in the frame that turns."""
    found = smidgen.spin_waves(magnet("chain", n=24, theta="pi/2", phi="2*pi*i/8", more=DMI), q="0 1/2")
    k, whole = 2 * np.pi * found.q[:, 0], 0.8 / np.cos(2 * np.pi / 8)

    def wanted(k):
        return 1.5 * np.sqrt(whole * (1 - np.cos(k)) * (whole - 0.8 * np.cos(k)))
    assert found.meta["turns"] == pytest.approx([45]) and found.meta["cell"] == [1]
    lines = np.sort(np.stack([wanted(k + shift * np.pi / 4) for shift in (-1, 0, 1)], axis=1), axis=1)
    np.testing.assert_allclose(found.omega, lines, atol=1e-7)


def test_a_rotation_counts_only_if_the_hessian_turns_with_the_spins():
    """Axes that turn with a spiral leave it one cell; axes that stand still make four of a spiral of 90 degrees."""
    along = AXIS.replace("w[i].z^2", "(w[i].x*cos(pi*i/4) + w[i].y*sin(pi*i/4))^2")
    turning = smidgen.spin_waves(magnet("chain", n=16, theta="pi/2", phi="pi*i/4", more=DMI + along), q="0 1/2")
    assert turning.meta["turns"] == pytest.approx([45]) and turning.meta["cell"] == [1]
    still = smidgen.spin_waves(magnet("chain", n=16, theta="pi/2", phi="pi*i/2", more=DMI + AXIS.replace("z^2", "x^2")), q="0 1/2")
    assert still.meta["turns"] == [] and still.meta["cell"] == [4]


def test_waves_to_the_left_and_to_the_right():
    """Along the field omega(q) and omega(-q) differ by the odd part of the bonds; a line of the other way is at the q that it has."""
    found = smidgen.spin_waves(magnet("chain", n=16, more=DMI.replace("tan(2*pi/8)", "0.3") + FIELD.replace("0.2", "2")), q="all")
    k = 2 * np.pi * found.q[:, 0]
    even, odd = 1.5 * 2 * 0.8 * (1 - np.cos(k)) + 2, 1.5 * 2 * 0.8 * 0.3 * np.sin(k)
    one, other = ((even + sign * odd) / 2 for sign in (1, -1))
    assert min(np.abs(found.omega[:, 0] - one).max(), np.abs(found.omega[:, 0] - other).max()) < 1e-12


def test_bonds_half_way_around_the_lattice():
    """Both bonds of two cells join the same sites: each way has one."""
    found = smidgen.spin_waves(magnet("chain", n=2), q=[[0], [1 / 4], [1 / 2]])
    np.testing.assert_allclose(found.omega[:, 0], RATE * np.array([0, 2, 4]), atol=1e-12)


def test_weights_are_those_of_equipartition():
    """<|S_x|^2> = kT/A(q), A = 2 J (1 - cos q) + B/r, half of it at omega > 0."""
    found = smidgen.spin_waves(magnet("chain", more=FIELD), q="0 1/2")
    curvature = 1.6 * (1 - np.cos(2 * np.pi * found.q[:, 0])) + 0.2 / 1.5
    np.testing.assert_allclose(found.weights[:, 0], np.outer(1 / (2 * curvature), [1, 1, 0]), atol=1e-12)


# Refusals, and what is told

def test_what_has_no_lines():
    chain = magnet("chain", theta="0.1*i")
    with pytest.raises(smidgen.UsageError, match=r"not an equilibrium: \|n x g\| of some spin is 0\.\d+ of the largest field"):
        smidgen.spin_waves(chain)
    with pytest.raises(smidgen.UsageError, match="`field` depends on time"):
        smidgen.spin_waves(magnet("chain", more=FIELD.replace("w[i].z", "cos(t)*w[i].z")))
    with pytest.raises(smidgen.UsageError, match="a torque acts on 'w'"):
        smidgen.spin_waves(magnet("chain", more='[effects.push]\nover = "site(i) of w"\ntorque = "cross(w[i], vec(0, 0, 0.1))"\n'))
    for cell, said in (((4,), r"must divide its 6 cells"), ((1,), "does not repeat after 1 cells of direction 1: a spin differs by 2")):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spin_waves(magnet("chain", theta="pi*i", J=-0.8), cell=cell)
    for q, said in (([[0, 1]], "1 finite numbers"), ("0 1/5", "not a wave vector of 6 cells")):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spin_waves(magnet("chain"), q=q)
    with pytest.raises(smidgen.UsageError, match=r"shape \(6, 3\), not \(5, 3\)"):
        smidgen.spin_waves(magnet("chain"), start=np.ones((5, 3)))
    with pytest.raises(smidgen.UsageError, match="1156 sites, more than 1000"):
        smidgen.spin_waves(magnet("square", n=34, more=FIELD.replace("0.2*", "(1 + 0.1*normal(1, i))*")))


HELD = '[effects.held]\nover = "site(i) of w"\n{}\n'


def test_absent_sites_do_not_act_on_the_others():
    """Five of six sites of a ring are an open chain, omega = 2 J S (1 - cos(pi k/5))."""
    found = smidgen.spin_waves(magnet("chain", more=HELD.format('absent = "i == 3"')), q="0 1/2")
    np.testing.assert_allclose(found.omega, [RATE * (2 - 2 * np.cos(np.pi * np.arange(5) / 5))] * len(found.q), atol=1e-7)
    assert found.meta["energy"] == pytest.approx(-0.8 * 1.5 ** 2 * 4)


@pytest.mark.parametrize("more, said", [
    ('[effects.near]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-log(2*1.5^2 - 2*dot(w[i], w[j]))"\n', "the field of some spin is not finite"),
    ('[effects.kink]\nover = "site(i) of w"\nenergy = "abs(w[i].x)^1.5"\n', "second derivatives of the energy are not finite"),
    (HELD.format('pinned = "i >= 0"'), "no site moves")])
def test_states_without_a_linear_motion_are_refused(more, said):
    for relax in (False, True):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spin_waves(magnet("chain", more=more), relax=relax)


@pytest.mark.parametrize("given", [{"q": ["a"]}, {"q": np.zeros((0, 1))}, {"q": [[np.nan]]}, {"cell": "x"}, {"cell": 1.5}, {"cell": np.nan}, {"between": 0}, {"between": 1.5}])
def test_wave_vectors_and_cells_that_are_none_are_refused(given):
    with pytest.raises(smidgen.UsageError):
        smidgen.spin_waves(magnet("chain"), **{"q": "0 1/2", **given})


def test_lines_of_another_family_are_refused():
    found = smidgen.spin_waves(magnet("chain"), q="0 1/2")
    assert fitting(found, "w", found.q) is found
    with pytest.raises(smidgen.UsageError, match="seen in 'w', not in 'v'"):
        fitting(found, "v", found.q)


def test_spins_without_a_field_have_a_line_each():
    """omega = 0, without a weight."""
    free = smidgen.spin_waves(magnet("chain", J=0), q="0 1/2")
    assert free.omega.shape == (4, 1) and not free.omega.any() and np.isnan(free.weights).all()


def test_a_state_that_is_no_minimum():
    """A ferromagnet of antiferromagnetic bonds is a maximum, where nothing grows; with an axis across it modes grow."""
    quiet = smidgen.spin_waves(magnet("chain", J=-0.8), q="0 1/2")
    assert not quiet.meta["stable"] and "not a minimum" in quiet.meta["notes"][0] and quiet.omega[-1, 0] == pytest.approx(4 * RATE)
    assert np.isnan(quiet.weights).all() and quiet.seen.all()
    loud = smidgen.spin_waves(magnet("chain", more=AXIS.replace("0.1*w[i].z^2", "0.1*w[i].x^2 + 0.05*w[i].y^2")), q="0 1/2")
    assert "unstable: modes grow at 1 of 4 wave vectors, fastest at q = 0, at the rate" in loud.meta["notes"][0]
    assert loud.growth.max() == pytest.approx(1.5 / 2 * np.sqrt(0.2 * 0.1))


def test_relaxation_finds_the_order():
    w = shaken(smidgen.spin_waves(magnet("triangular", theta="pi/2", phi=TURNS, J=-0.8)).w, 0.3)
    found = smidgen.spin_waves(magnet("triangular", J=-0.8), start=w, relax=True)
    assert found.meta["turns"] == pytest.approx([120, 120]) and found.meta["torque"] < 1e-9 and found.meta["moved"] > 5
    assert found.meta["energy"] == pytest.approx(-36 * 1.5 * 0.8 * 1.5 ** 2)
