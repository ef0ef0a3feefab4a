"""Bad steps: a sample of every model, and the cases in which a step was once wrong (docs/fuzzing.md)."""
import os

import pytest
from fuzz.bad_models import MODELS
from fuzz.bad_steps import build, run, shares

from smidgen.build.cache import lock

# what was wrong: another branch (top, nambu and its classical midpoint), a state between (r3_pair), abs(w) (field, cubic,
# chain6, r3_pair), the residual (vortices)
ONCE_WRONG = {"top": (13250, 10198), "nambu": (1647, 17875, 30578, 36807), "r3_pair": (26342, 2869, 1771, 504), "r3_field": (2636,),
              "field": (49458, 25549), "cubic": (724,), "forced": (44075, 25505, 38276), "chain6": (1548, 2355), "vortices_classical": (362, 990, 5100),
              "nambu_classical": (2756, 11073, 13515)}

LEVELS = {"cubic": "-O1"}       # of the others to compile is all that takes time


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """name -> the compiled judge of that model, which one test process makes for all."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "bad_steps"
    place.mkdir(exist_ok=True)

    def program(name):
        made = place / name / "done"
        with lock(place / name):
            if not made.exists():
                (place / name).mkdir()
                build(name, place / name, level=LEVELS.get(name, "-O0")).rename(made)      # the same bits
        return made
    return program


@pytest.mark.parametrize("name, steps", [*((name, 2_000) for name in MODELS if name in ONCE_WRONG),
                                         *(pytest.param(name, 20_000, marks=pytest.mark.long) for name in MODELS)])
def test_a_sample(name, steps, programs):
    """Thousands of steps of all models; every branch is followed, of large systems every eighth."""
    cases = max(150, shares(steps, list(MODELS))[name])
    found = run(name, programs(name), 1, 0, cases, 1 if cases > 200 else 8)
    assert found.status == 0 and found.violations == [] and found.numbers["steps"] > 10


@pytest.mark.parametrize("name, case", [(name, case) for name, cases in ONCE_WRONG.items() for case in cases])
def test_once_wrong(name, case, programs):
    found = run(name, programs(name), 1, case, 1, 1)
    assert found.status == 0 and found.violations == []
