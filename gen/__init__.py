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

__version__ = "0.1.0"

from .analyse import lyapunov  # noqa: E402
from .analyse.spectrum import Spectrum, spectrum  # noqa: E402
from .analyse.spectrum_file import load_spectrum  # noqa: E402
from .errors import (BuildError, KeywordError, MissingTool, OutputError, ReadOnlyError,     # noqa: E402
                     RunError, SmidgenError, SpecError, UsageError, ValidationError)
from .run.step.integrator import Integrator, build  # noqa: E402
from .run.many.ensemble import Ensemble, ensemble  # noqa: E402
from .run.fields import lattice  # noqa: E402
from .run.fields.field import load_field  # noqa: E402
from .run.files.output import Result, load_result  # noqa: E402
from .run.fields.snapshot import snapshot  # noqa: E402
from .show.plot import plot  # noqa: E402
from .read import load_text  # noqa: E402
from .run.run import Interrupted, repeat, run  # noqa: E402
from .run.resume import resume  # noqa: E402
from .run.files.checkpoint import CheckpointError  # noqa: E402
from .read.shipped import load  # noqa: E402
from .language.spec import Spec  # noqa: E402
from .check.validate import validate  # noqa: E402
from .check.verify import verify  # noqa: E402
from .cost import Choice, Cost, choose, cost, load_cost  # noqa: E402

if TYPE_CHECKING:
    from .analyse.advice import advise
    from .analyse.symmetry import explain

__all__ = ["BuildError", "CheckpointError", "Choice", "Cost", "Ensemble", "Integrator", "Interrupted", "KeywordError", "MissingTool", "OutputError",
           "ReadOnlyError", "Result", "RunError", "SmidgenError", "Spec", "SpecError", "Spectrum", "UsageError", "ValidationError",
           "advise", "build", "choose", "cost", "ensemble", "explain", "lattice", "load", "load_cost", "load_field", "load_result", "load_spectrum", "load_text",
           "lyapunov", "plot", "repeat", "resume", "run", "snapshot", "spectrum", "validate", "verify"]


def __getattr__(name):
    """`explain` and `advise`, which need sympy, are imported when they are asked for."""
    if name == "explain":
        from .analyse.symmetry import explain
        return explain
    if name == "advise":
        from .analyse.advice import advise
        return advise
    raise AttributeError(f"module 'smidgen' has no attribute '{name}'")


def __dir__():
    """Those two are there before they are imported."""
    return sorted({*globals(), *__all__})
