"""Newton where the step is large: every kind of site at once, still the witness's solution in few iterations."""
import numpy as np
import pytest
from support import texts
from support.systems import SPHERICAL, begin, model

from smidgen.witness import Witness

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("h", [0.2, 0.3, 0.4])
def test_sites_of_every_kind_at_a_large_step(h, tmp_path):
    """The correction of a midpoint takes its own direction: that of another site leads nowhere here."""
    case = begin(texts.read(texts.MIXED, tmp_path))
    one = model(case, SPHERICAL).start(case.w.copy(), h=h).step()
    assert one.report()["iterations"] <= 7
    assert np.allclose(one.w, Witness(case.spec, case.values).step(case.w, 0.0, h), rtol=0, atol=1e-12)


def newton_matrix(case, W, h):
    """J = 1 - (h/2) DX(m) DP in the planes across the midpoints m of w and W, P(y) = y/|y|: shape (2 sites, 2 sites)."""
    n, y = len(W), (case.w + W) / 2
    rho = np.linalg.norm(y, axis=1)
    m = y / rho[:, None]
    across = np.zeros((n, 3, n, 2))
    for i in range(n):
        across[i, :, i] = np.linalg.svd(m[i:i + 1])[2][1:].T
    T = across.reshape(3 * n, 2 * n)
    field = Witness(case.spec, case.values).jacobian(m.copy(), h / 2)[0]
    return np.eye(2 * n) - h / 2 * T.T @ np.asarray(field, float).reshape(3 * n, 3 * n) @ T / np.repeat(rho, 2)


def test_a_matrix_that_is_not_coercive_has_its_branch_followed(tmp_path):
    """Sites of a random graph: the step is accepted as it stands while x.J x >= x.x/4, and followed from h = 0 beyond."""
    case, seen = begin(texts.read(texts.GLASS, tmp_path)), set()
    for h in (0.9, 1.0, 1.1, 1.2):
        one = model(case, SPHERICAL, solver="newton").start(case.w.copy(), h=h).step()
        J = newton_matrix(case, one.w, h)
        least = np.linalg.eigvalsh((J + J.T) / 2).min()
        seen.add(coercive := bool(least > 0.25))
        assert abs(least - 0.25) > 0.01 and one.report()["reached"] == (0 if coercive else 1)
    assert seen == {True, False}
