"""The shipped specs, and how their first runs begin."""
from dataclasses import dataclass

import numpy as np
import pytest

import smidgen
from smidgen.errors import UsageError
from smidgen.methods import MIDPOINTS as METHODS
from smidgen.resources import folder, scenes
from smidgen.run.settings import settle
from smidgen.run.step.start import initial_state

SPECS = sorted(path.stem for path in folder("specs").glob("*.toml"))
SCENES = sorted(scenes())
SPHERICAL, CLASSICAL, VESELOV = METHODS
SHORT = {SPHERICAL: "SM", CLASSICAL: "CM", VESELOV: "DMV"}
QUICK = ("free_rigid_body", "forced_rigid_body", "nambu_a34")       # small C, a moment to compile
FEW = (*QUICK, "product", "two_bodies", "heisenberg_chain", "cubic_lattice", "point_vortices", "vortex_tracers")   # one a plan of the step
FREE_BODIES = ("free_rigid_body",)      # what Moser-Veselov accepts


@dataclass(frozen=True)
class Begin:
    """A spec with the values, the start w of shape (sites, 3) and the h of its first run."""
    spec: smidgen.Spec
    values: dict
    w: np.ndarray
    h: float


def load(name):
    """The shipped spec or scene of that name."""
    return smidgen.load(scenes().get(name) or folder("specs") / f"{name}.toml")


def begin(spec, **values):
    """The first run of a spec (or of a shipped one, by name), with some values replaced."""
    spec = load(spec) if isinstance(spec, str) else spec
    run = settle(spec, None, parameters=values)
    return Begin(spec, run.parameters, initial_state(spec, run.start, run.parameters), run.h)


def model(case, method=SPHERICAL, **more):
    """The compiled system of a Begin."""
    return smidgen.build(case.spec, method=method, parameters=case.values, **more)


def accepts(name, method):
    """Does the compiler take this method for this spec? A refusal must be a plain sentence."""
    try:
        model(begin(name), method)
    except UsageError as refusal:
        assert str(refusal).startswith("method")
        return False
    return True


def on_leaf(w, radius=1.0):
    """Vectors scaled to the length `radius` in their own precision."""
    return w * (radius / np.sqrt(np.sum(w * w, axis=1)))[:, None]


def tiers(names, quick=QUICK, few=FEW):
    """Parameters of a test: those in `quick` for `make quick` too, the others in `few` for `make test`, all for `make test-long`."""
    marks = {**dict.fromkeys(few, ()), **dict.fromkeys(quick, pytest.mark.quick)}
    return [pytest.param(n, marks=marks.get(n, pytest.mark.long)) for n in names]
