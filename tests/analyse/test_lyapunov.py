"""Lyapunov exponents: two methods that must agree, laws that they must obey, and what regular orbits show."""
import numpy as np
import pytest
from support.systems import CLASSICAL, SPHERICAL, begin

import smidgen
from smidgen.errors import UsageError
from smidgen.analyse.lyapunov import Exponents, _exponents, exponents, nearby, on_leaves, tangent_vectors
from smidgen.analyse.sections import exponent, growth, stroboscope

PERIOD = 2 * np.pi
H = PERIOD / 20
EPS = 0.07          # of the loading, where the separatrix is a chaotic band (docs/sections.md)
BLOCK = 100         # five periods
REGULAR = (0.2, 0.4, 0.8)       # angles from the unstable axis, outside the band
quick = pytest.mark.quick


def body(eps=EPS):
    return smidgen.build(begin("forced_rigid_body").spec, parameters={"eps": eps}, features=("tangent",))


def beside_the_saddle(off, up=0.0):
    """A point at these angles from the unstable second axis."""
    theta, phi = np.pi / 2 + up, np.pi / 2 - off
    return np.array([[np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]])


def band(count, seed):
    """Random starts in the chaotic band."""
    dice = np.random.default_rng(seed)
    return [beside_the_saddle(0.02 * dice.uniform(0.5, 1.5), 0.02 * dice.uniform(-1, 1)) for _ in range(count)]


def power(found, periods):
    """p where vectors have grown like T^p in T periods: 1 on a regular orbit."""
    return found.values[0] * periods * PERIOD / np.log(periods)


# -- laws ---------------------------------------------------------------------------------------

@quick
def test_at_an_unstable_equilibrium():
    """At rest on the second axis: e^(lambda h) of the flow becomes (1 + z)/(1 - z), z = lambda h/2, in the step."""
    case, h = begin("free_rigid_body"), 0.3
    i1, i2, i3 = (next(p.default for p in case.spec.parameters if p.name == n) for n in ("I1", "I2", "I3"))
    rate = np.sqrt((1 / i1 - 1 / i2) * (1 / i2 - 1 / i3))
    model = smidgen.build(case.spec, features=("tangent",))
    found = exponents(model, np.array([[0.0, 1.0, 0.0]]), h, 3000, every=10)
    expected = 2 / h * np.arctanh(rate * h / 2)
    late = found.growth[100:].mean(axis=0) / (10 * h)       # the first blocks turn into the directions
    assert late == pytest.approx([expected, -expected], rel=1e-12)
    assert abs(expected - rate) > 1e-4


def test_areas_are_kept_by_the_spherical_midpoint_alone():
    """On one sphere the sum of both exponents is the growth of areas; the classical midpoint shrinks and swells them."""
    case, sums = begin("irreversible_rigid_body"), {}
    for method in (SPHERICAL, CLASSICAL):
        model = smidgen.build(case.spec, method=method, features=("tangent",))
        sums[method] = np.abs(exponents(model, case.w.copy(), 0.5, 20_000, every=20).growth.sum(axis=1)).max()
    assert sums[SPHERICAL] < 1e-12
    assert sums[CLASSICAL] > 1e-4


@pytest.mark.parametrize("steps", [2000, 20_000])
def test_the_spectrum_pairs_up(steps):
    """lambda_i + lambda_(n+1-i) -> 0 like 1/t: growth is known up to a factor. The sum of all is 0 to round-off.

    Six spins with second neighbours: chaotic, with lambda_1 t several hundred at the end.
    """
    case = begin("j1j2_chain", n=6)
    w = np.random.default_rng(3).standard_normal((6, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    model = smidgen.build(case.spec, parameters=case.values, features=("tangent",))
    found = exponents(model, w, 0.1, steps, every=20)
    t = found.times[-1]
    pairs = (found.values + found.values[::-1]) * t
    print(f"t = {t:g}: lambda {found.values.round(4)}, pairs times t {pairs.round(2)}")
    assert abs(found.growth.sum()) < 1e-10
    assert np.abs(pairs).max() < 5 and found.values[0] * t > 10
    assert len(found.values) == 12 and (np.diff(found.values) <= 0).all()


def test_an_integrable_chain_has_none():
    """The ring of four spins is integrable: every exponent falls like ln t/t."""
    case = begin("heisenberg_chain", n=4)
    w = np.random.default_rng(3).standard_normal((4, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    model = smidgen.build(case.spec, parameters=case.values, features=("tangent",))
    early, late = (exponents(model, w.copy(), 0.1, steps, every=20) for steps in (2000, 20_000))
    assert np.abs(late.values).max() < 2 * np.log(late.times[-1]) / late.times[-1]
    assert np.abs(late.values).max() < np.abs(early.values).max() / 5


# -- two methods --------------------------------------------------------------------------------

def test_both_methods_measure_the_same_growth_block_by_block():
    """As long as round-off has not driven their orbits apart, the growth is that of one orbit and one direction."""
    model, w = body(), beside_the_saddle(0.02)
    a, b = (method(model, w.copy(), H, 10 * BLOCK, every=BLOCK, **more)
            for method, more in ((exponents, {"columns": 1}), (nearby, {})))
    print(np.hstack([a.growth, b.growth, a.growth - b.growth]))
    assert np.abs(a.growth - b.growth).max() < 1e-5
    assert a.growth.sum() > 5


@pytest.mark.usefixtures("optimised_here")
def test_both_methods_agree_in_the_chaotic_band():
    """Independent starts for each method: the means of 24 estimates agree within four standard errors.

    The errors come from the scatter among starts, since one orbit may stick to the edge of the band for long.
    """
    model, steps, samples = body(), 2000 * 20, []
    for method, seed in ((exponents, 1), (nearby, 2)):
        samples.append([method(model, w, H, steps, every=BLOCK).values[0] for w in band(24, seed)])
    means, errors = np.mean(samples, axis=1), np.std(samples, axis=1, ddof=1) / np.sqrt(24)
    print("tangent map %.4f +- %.4f, nearby orbits %.4f +- %.4f" % (*np.ravel([means[:1], errors[:1]]), means[1], errors[1]))
    assert (errors < 0.1 * means).all()         # sharp enough to tell them from 0, and a factor 2 apart
    assert abs(means[0] - means[1]) < 4 * np.hypot(*errors)


@pytest.mark.parametrize("off", REGULAR)
def test_both_go_to_zero_on_regular_orbits_beside(off):
    """Vectors grow like T there: lambda T/ln T stays near 1 while T grows tenfold, and lambda falls as ln T/T."""
    model, w = body(), beside_the_saddle(off)
    values = []
    for periods in (300, 3000):
        a, b = (method(model, w.copy(), H, periods * 20, every=BLOCK) for method in (exponents, nearby))
        assert 0 < power(a, periods) < 2 and 0 < power(b, periods) < 2
        assert a.values[0] == pytest.approx(b.values[0], rel=0.01)
        values.append(a.values[0])
    assert values[1] < values[0] / 4
    print(f"{off}: {values}")


def test_the_estimate_of_sections_is_the_same():
    """gen/analyse/sections.py measures by the period, with code of its own."""
    model, w, periods = body(), beside_the_saddle(REGULAR[0]), 500
    orbit = stroboscope(model, PERIOD, 20)
    theirs = exponent(growth(orbit, orbit(w[0], periods))) / PERIOD
    ours = nearby(model, w.copy(), H, periods * 20, every=BLOCK).values[0]
    assert abs(theirs - ours) * periods * PERIOD < 2        # begun along another direction


def test_chaos_is_far_from_what_regular_orbits_show():
    model, periods = body(), 2000
    assert power(exponents(model, beside_the_saddle(0.02), H, periods * 20, every=BLOCK), periods) > 10


# -- the interface ------------------------------------------------------------------------------

@quick
def test_running_estimates_and_errors():
    model = body()
    found = exponents(model, "saddle", H, 2000, columns=1, every=BLOCK)
    assert found.running.shape == found.growth.shape == (20, 1) and found.times[-1] == pytest.approx(2000 * H)
    assert found.running[4, 0] == pytest.approx(found.growth[:5].sum() / found.times[4])
    assert found.values[0] == found.running[-1, 0]
    with pytest.raises(UsageError, match="batches"):
        found.error(21)
    for wrong in ({"columns": 3}, {"columns": 0}, {"every": 0}, {"every": 2001}):
        with pytest.raises(UsageError):
            exponents(model, "saddle", H, 2000, **wrong)


@quick
def test_the_standard_error_is_that_of_independent_blocks():
    noise = np.random.default_rng(5).standard_normal((40_000, 1))
    times = 0.5 * np.arange(1, len(noise) + 1)
    found = Exponents(noise.mean(axis=0) / 0.5, None, times, noise)
    assert found.error(100)[0] == pytest.approx(1 / 0.5 / np.sqrt(40_000), rel=0.3)     # 4 of its own errors


@quick
def test_vectors_are_tangent_to_the_leaves():
    case = begin("product")
    model = smidgen.build(case.spec, parameters=case.values, features=("tangent",)).start(case.w.copy(), h=case.h)
    v = tangent_vectors(model, 4)
    assert np.abs(v.reshape(4, -1) @ v.reshape(4, -1).T - np.eye(4)).max() < 1e-14
    assert np.abs(on_leaves(model, v) - v).max() < 1e-15
    across = np.einsum("csa,sa->cs", v, model.w * [[1, 1, 1], [2, 2, 0]])    # grad C of both factors
    assert np.abs(across).max() < 1e-14


PAIR = """[model]
name = "pair"
[space]
w = {{ sphere = 2 }}
[effects.exchange]
energy = "-dot(w[0], w[1])"
[effects.bath]
over = "site(i) of w"
damping = 0.5{}
[effects.held]
over = "site(i) of w"
pinned = "i == 0"
[starts.near]
vectors = [[0, 0, 1], [0.6, 0, 0.8]]
"""


@quick
def test_sites_that_do_not_move_have_no_exponents():
    """A damped spin beside a pinned one approaches it at the rate alpha/(1 + alpha^2), as fast along both directions."""
    model = smidgen.build(smidgen.load_text(PAIR.format("")), features=("tangent",))
    found = exponents(model, "near", 0.02, 4000, every=10)
    assert found.values == pytest.approx([-0.4, -0.4], rel=0.03)
    assert nearby(model, "near", 0.02, 400, every=10).values[0] == pytest.approx(-0.4, rel=0.1)
    with pytest.raises(UsageError, match="from 1 to 2, twice the sites of pair that move; not 3"):
        exponents(model, "near", 0.02, 40, columns=3)


@quick
def test_nearby_orbits_under_noise_are_refused():
    model = smidgen.build(smidgen.load_text(PAIR.format("\nkT = 0.1")))
    with pytest.raises(UsageError, match="thermal noise"):
        nearby(model, "near", 0.02, 40, every=10)


@quick
def test_nearby_orbits_at_temperature_zero_have_no_noise():
    text = PAIR.replace("[effects", "[parameters]\nT = 0.1\n[effects", 1)
    model, calm = (smidgen.build(smidgen.load_text(text.format(kT)), parameters={"T": 0.0}) for kT in ("\nkT = \"T\"", ""))
    found = nearby(model, "near", 0.02, 400, every=10).values[0]
    assert found == pytest.approx(nearby(calm, "near", 0.02, 400, every=10).values[0], abs=1e-6)


@quick
def test_columns_are_in_the_order_of_their_values():
    """Errors and running estimates are those of the value in the same place."""
    growth = np.random.default_rng(6).standard_normal((100, 3)) * [1, 10, 0.1] + [0, 200, 1]
    found = _exponents(growth, 0.5)
    assert (np.diff(found.values) < 0).all() and np.array_equal(found.values, found.running[-1])
    assert found.error() == pytest.approx([10 * 2 / 10, 0.1 * 2 / 10, 1 * 2 / 10], rel=0.5)
    for batches in (0, 1, -3):
        with pytest.raises(UsageError, match="batches"):
            found.error(batches)
