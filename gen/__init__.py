"""smidgen compiles Hamiltonians, written as formulas, to structure-preserving integrators.

    import smidgen
    spec = smidgen.load("top.toml")         # or a name that `smidgen list` shows
    result = smidgen.run(spec, "demo", out="demo.h5")
    top = smidgen.build(spec).start("tilted", h=0.1)
    top.steps(100).w

Where a function and a package share a name (build, run), the attribute of `smidgen` is the
function, whatever is imported and when: each such package is imported here, and its name bound
to the function afterwards. `from smidgen.build.binary import ...` finds the package.
"""
from typing import TYPE_CHECKING

from .analyse.spectrum import Spectrum, spectrum
from .analyse.spectrum_file import load_spectrum
from .analyse.spin_waves import SpinWaves, spin_waves
from .errors import (BuildError, KeywordError, MissingTool, OutputError, ReadOnlyError,
                     RunError, SmidgenError, SpecError, UsageError, ValidationError)
from .run.step.integrator import Integrator, build
from .run.many.average import Average, Averages, average, load_averages
from .run.many.ensemble import Ensemble, ensemble
from .run.many.sweep import sweep
from .run.fields.field import load_field
from .run.files.output import Result, load_result
from .run.fields.snapshot import snapshot
from .show import notebook as _notebook      # tells the classes what notebooks show of them  # noqa: F401
from .show.plot import plot
from .read import load_text
from .run.run import Interrupted, repeat, run
from .run.resume import resume
from .run.files.checkpoint import CheckpointError
from .read.shipped import flat, load
from .language.spec import Spec
from .check.validate import validate
from .check.verify import verify
from .cost import Choice, Cost, choose, cost, load_cost
from .version import __version__  # noqa: F401
from . import lattice, lyapunov

if TYPE_CHECKING:
    from .analyse.advice import advise
    from .analyse.symmetry import explain
    from .model import Model

__all__ = ["Average", "Averages", "BuildError", "CheckpointError", "Choice", "Cost", "Ensemble", "Integrator", "Interrupted", "KeywordError", "MissingTool", "Model", "OutputError",
           "ReadOnlyError", "Result", "RunError", "SmidgenError", "Spec", "SpecError", "Spectrum", "SpinWaves", "UsageError", "ValidationError",
           "advise", "average", "build", "choose", "cost", "ensemble", "explain", "flat", "lattice", "load", "load_averages", "load_cost", "load_field", "load_result", "load_spectrum", "load_text",
           "lyapunov", "plot", "repeat", "resume", "run", "snapshot", "spectrum", "spin_waves", "sweep", "validate", "verify"]


def __getattr__(name):
    """`explain`, `advise` and `Model`, which need sympy, are imported when they are asked for."""
    if name == "explain":
        from .analyse.symmetry import explain
        return explain
    if name == "advise":
        from .analyse.advice import advise
        return advise
    if name == "Model":
        from .model import Model
        return Model
    raise AttributeError(f"module 'smidgen' has no attribute '{name}'")


def __dir__():
    """Those three are there before they are imported."""
    return sorted({*globals(), *__all__})
