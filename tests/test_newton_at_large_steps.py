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
