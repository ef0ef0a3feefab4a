"""Newton where the step is large: every kind of site at once, still the witness's solution in few iterations."""
import math

import numpy as np
import pytest
from hard.vortices import STRENGTHS, fold_of_collapse, inward, vortices
from support import texts
from support.systems import SPHERICAL, begin, model

import smidgen
from smidgen.check.witness import Witness

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("h", [0.2, 0.3, 0.4])
def test_sites_of_every_kind_at_a_large_step(h, tmp_path):
    """The correction of a midpoint takes its own direction: that of another site leads nowhere here."""
    case = begin(texts.read(texts.MIXED, tmp_path))
    one = model(case, SPHERICAL).start(case.w.copy(), h=h).step()
    assert one.report()["iterations"] <= 7
    assert np.allclose(one.w, Witness(case.spec, case.values).step(case.w, 0.0, h), rtol=0, atol=1e-12)


def newton_matrix(case, W, h):
    """J = 1 - (h/2) DX(m) DP in the planes across the midpoints m of w and W, P(y) = r y/|y|: shape (2 sites, 2 sites)."""
    n, y = len(W), (case.w + W) / 2
    shrink = np.linalg.norm(W, axis=1) / np.linalg.norm(y, axis=1)
    m, across = y * shrink[:, None], np.zeros((n, 3, n, 2))
    for i in range(n):
        across[i, :, i] = np.linalg.svd(m[i:i + 1])[2][1:].T
    T = across.reshape(3 * n, 2 * n)
    field = Witness(case.spec, case.values).jacobian(m.copy(), h / 2)[0]
    return np.eye(2 * n) - h / 2 * T.T @ np.asarray(field, float).reshape(3 * n, 3 * n) @ T * np.repeat(shrink, 2)


def followed(case, h, **more):
    """Was the branch of the step followed from h = 0, and should it have been: is J not coercive?"""
    one = model(case, SPHERICAL, **more).start(case.w.copy(), h=h).step()
    J = newton_matrix(case, one.w, h)
    least = np.linalg.eigvalsh((J + J.T) / 2).min()
    assert abs(least - 0.25) > 0.01
    return one.report()["reached"] == 1, bool(least < 0.25)


def test_a_matrix_that_is_not_coercive_has_its_branch_followed(tmp_path):
    """Sites of a random graph: a step of which every iterate halves the residual is accepted as it stands while x.J x >= x.x/4, and followed from h = 0 beyond."""
    seen = [followed(begin(texts.read(texts.GLASS.replace("random = 3", "random = 7"), tmp_path)), h, solver="newton") for h in (0.6, 0.7, 1.1, 1.2)]
    assert all(was == should for was, should in seen) and {was for was, _ in seen} == {True, False}


@pytest.mark.parametrize("h", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("name", ["free_rigid_body", "irreversible_rigid_body", "forced_rigid_body"])
def test_steps_of_one_sphere_find_what_first_steps_find(name, h):
    """First steps are shown to be on the branch, by a contraction or by its whole curve; later ones are near what was foretold. They
    end where first steps end, and of a free body most take a few iterations."""
    spec, rng, iterations = smidgen.load(name), np.random.default_rng(5), []
    on, first = smidgen.build(spec), smidgen.build(spec)
    for w in rng.normal(size=(4, 1, 3)):
        on.start(w / np.linalg.norm(w), h=h)
        for _ in range(40):
            first.start(on.w.copy(), h=h, t0=on.t)
            found, wanted = went(on), went(first)
            assert found == wanted
            if not found:
                break
            assert np.abs(on.w - first.w).max() < 1e-10
            iterations.append(on.report()["iterations"])
    assert name != "free_rigid_body" or np.median(iterations) <= 5


def went(model) -> bool:
    """Did the step come off?"""
    try:
        model.step()
    except smidgen.RunError:
        return False
    return True


ANY = """
[starts.any]
random = 1
[runs.one]
start = "any"
h = 0.1
time = 1
"""

TOP = """
[model]
name = "far_top"
[space]
w = { sphere = 1, radius = 1.5 }
[effects.axis]
energy = "w.z^2/2"
""" + ANY


def test_a_site_alone_has_its_branch_followed_unless_its_step_contracts(tmp_path):
    """The row sums of J - 1 are within a factor of sqrt(2) of its norm, whatever the frame: 0.75 is between."""
    case, seen = begin(texts.read(TOP.replace("random = 1", "random = 3"), tmp_path)), set()
    for h in (0.1, 0.3, 2.0, 2.4):
        one = model(case, SPHERICAL).start(case.w.copy(), h=h).step()
        size = np.linalg.norm(newton_matrix(case, one.w, h) - np.eye(2), 2) / 0.75
        assert not 2 ** -0.5 < size < 2 ** 0.5 and (one.report()["reached"] == 1) == (size > 1)
        seen.add(size > 1)
    assert seen == {True, False}


def test_only_the_site_that_was_given_with_fewer_digits_is_put_on_its_sphere():
    """A step of 1e-30 moves nothing: what differs is what the start has put right."""
    case = begin("heisenberg_chain", n=6)
    near = case.w.copy()
    near[1] *= 1 + 5e-13
    one = model(case, SPHERICAL).start(near, h=1e-30).step()
    assert np.abs(np.delete(one.w - case.w, 1, axis=0)).max() < 1e-20
    assert abs(np.linalg.norm(one.w[1]) - 1) < 5e-16


def test_all_pairs_have_their_branch_followed():
    seen = [followed(begin("point_vortices"), h) for h in (3.0, 3.5, 4.0)]
    assert all(was == should for was, should in seen) and {was for was, _ in seen} == {True, False}


FIELD = """
[model]
name = "one_spin"
[space]
w = { sphere = 1 }
[parameters]
b = { vector = true, default = [0.0, 0.0, 1.0] }
[effects.field]
energy = "-dot(b, w)"
""" + ANY


@pytest.mark.parametrize("strength", [1.0, 1e3, 1e100, 1e149])
def test_a_spin_in_a_field_of_any_strength(strength, tmp_path):
    """W = 2 (w.m) m - w with the midpoint m; in a strong field m lies along it: W is w turned half round."""
    axis = np.array([0.6, 0.0, 0.8])
    case = begin(texts.read(FIELD, tmp_path), b=list(strength * axis))
    for h in (0.1, -1.5, 1e20):
        W, w = model(case, SPHERICAL).start(case.w.copy(), h=h).step().w[0], case.w[0]
        assert abs(W @ W - w @ w) < 1e-15
        assert abs(axis @ (W - w)) < 1e-15
        if strength >= 1e100:
            assert np.allclose(W, 2 * (w @ axis) * axis - w, rtol=0, atol=1e-15)


# -- next to a fold -------------------------------------------------------------------------------

@pytest.mark.parametrize("first", [0, 20, 40, 60])
def test_a_collapse_is_followed_up_to_its_fold_at_any_h(first):
    """The last steps before it have two vortices so near each other that the third's residual is the noise of their fields."""
    w, law = inward(0.05)
    model, last = vortices(STRENGTHS), fold_of_collapse(w, law.end)
    for total in 30.3 + 2.35 * np.arange(first, first + 20):
        if 0.03 < (total - last) % 1 < 0.97:
            model.start(w.copy(), h=law.end / total)
            assert model.advance(2 * int(total)) == math.ceil(total - last), total
